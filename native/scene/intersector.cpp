// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/intersector.h"

#include <algorithm>
#include <deque>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>

#include "scene/embree_faces.h"
#include "scene/mesh_hierarchy.h"
#include "scene/reach.h"

namespace nephele {

using namespace embree;

namespace {

void run_filter(const RTCFilterFunctionNArguments* args) {
    if (args->valid[0] == 0)
        return;
    const auto& query = *reinterpret_cast<const Query*>(args->context);
    const auto& ray = *reinterpret_cast<const RTCRay*>(args->ray);
    const auto& hit = *reinterpret_cast<const RTCHit*>(args->hit);
    const Hit found = hit_of(ray, hit);
    const bool front = ray.dir_x * hit.Ng_x + ray.dir_y * hit.Ng_y + ray.dir_z * hit.Ng_z < 0;
    if (!query.filter->accept(found, front != (*query.flipped)[found.instance]))
        args->valid[0] = 0;
}

RTCRay rtc_ray(const Ray& r) {
    RTCRay ray{};
    ray.org_x = r.o.x, ray.org_y = r.o.y, ray.org_z = r.o.z;
    ray.dir_x = r.d.x, ray.dir_y = r.d.y, ray.dir_z = r.d.z;
    ray.tnear = r.t_min;
    ray.tfar = r.t_max;
    ray.time = r.time;
    ray.mask = ~0u;
    return ray;
}

/// Embree may end the process over rays that are not. They meet nothing.
bool is_sound(const Ray& r) {
    const auto near = [](Vec3f v) {
        constexpr float kFarthest = Intersector::kFarthest;
        return std::fabs(v.x) < kFarthest && std::fabs(v.y) < kFarthest && std::fabs(v.z) < kFarthest;
    };
    return near(r.o) && near(r.d) && r.t_min <= r.t_max;
}

Query query_of(HitFilter* filter, const std::vector<bool>& flipped) {
    Query query{};
#if NEPHELE_EMBREE_MAJOR >= 4
    rtcInitRayQueryContext(&query.context);
#else
    rtcInitIntersectContext(&query.context);
    query.context.filter = filter != nullptr ? run_filter : nullptr;
#endif
    query.filter = filter;
    query.flipped = &flipped;
    return query;
}
#if NEPHELE_EMBREE_MAJOR >= 4
/// Of rtcIntersect1 or rtcOccluded1.
template <typename Arguments>
void pass(Query& query, Arguments& args) {
    args.context = &query.context;
    args.filter = query.filter != nullptr ? run_filter : nullptr;
}
#endif

}  // namespace

struct Intersector::Impl {
    std::shared_ptr<const Device> device;
    SceneHandle top;
    std::vector<std::shared_ptr<const MeshHierarchy>> shared;
    std::deque<std::vector<float>> placed;        ///< world-space vertices of meshes used once
    std::vector<Buffer<std::int32_t>> triangles;  ///< of these meshes
    std::deque<OwnFaces> own;                     ///< of these meshes, where faces are watertight
    std::vector<bool>
        flipped;  ///< by instance: placing it in the world mirrored it, which turns its faces over
    std::ptrdiff_t bytes = 0;

    explicit Impl(std::shared_ptr<const Device> d) : device(std::move(d)), top(device->new_scene()) {}

    /// A mesh used once that stands still: its vertices are placed in the world, which makes queries cheaper
    /// than an instance would.
    RTCGeometry place(const Mesh& mesh, const Transform& world_from_object, std::optional<float> slack) {
        const std::size_t count = mesh.positions.size() / 3;
        std::vector<float>& out = placed.emplace_back(3 * count + 1);  // one of padding, see triangles()
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const float* p = mesh.positions.data() + 3 * i;
                const Vec3f w = world_from_object.point({p[0], p[1], p[2]});
                out[3 * i] = w.x, out[3 * i + 1] = w.y, out[3 * i + 2] = w.z;
            }
        });
        triangles.push_back(mesh.triangles);
        const Vertices vertices{out.data(), 1, 3 * count};
        OwnFaces* faces =
            slack ? &own.emplace_back(OwnFaces{vertices, mesh.triangles.data(), *slack}) : nullptr;
        return embree::triangles(device->handle(), mesh, vertices, faces);
    }

    RTCGeometry instance(RTCScene scene, const Instance& placed_mesh) {
        RTCGeometry geometry = rtcNewGeometry(device->handle(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, scene);
        const std::vector<Transform>& steps = placed_mesh.motion.steps();
        rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(std::max<std::size_t>(steps.size(), 1)));
        if (!placed_mesh.motion.moves())
            set_transform(geometry, 0, placed_mesh.world_from_object);
        for (std::size_t i = 0; i < steps.size(); ++i)
            set_transform(geometry, static_cast<unsigned>(i), steps[i]);
        return geometry;
    }

    static void set_transform(RTCGeometry geometry, unsigned step, const Transform& m) {
        const float rows[12] = {m.row[0].x, m.row[0].y, m.row[0].z, m.translation.x,
                                m.row[1].x, m.row[1].y, m.row[1].z, m.translation.y,
                                m.row[2].x, m.row[2].y, m.row[2].z, m.translation.z};
        rtcSetGeometryTransform(geometry, step, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
    }
};

namespace {

std::shared_ptr<const Device> device_of(PartScope& parts) {
    return parts.share<Device>(PartKey(), [] { return std::make_shared<Device>(); });
}

/// Whether every mesh is placed in the world, so that none has a hierarchy of its own.
bool all_alone(std::span<const Mesh> meshes, std::span<const Instance> instances,
               std::span<const std::uint32_t> used, Intersector::Layout layout) {
    std::set<std::uint32_t> seen;
    return layout == Intersector::Layout::whole &&
           std::all_of(used.begin(), used.end(), [&](std::uint32_t i) {
               const Instance& instance = instances[i];
               return seen.insert(instance.mesh).second && !instance.motion.moves() &&
                      !meshes[instance.mesh].deforms();
           });
}

}  // namespace

Intersector::Intersector(std::span<const Mesh> meshes, std::span<const Instance> instances,
                         std::span<const std::uint32_t> used, Faces faces, Layout layout, PartScope* parts)
    : empty_(used.empty()) {
    PartCache own_cache;
    PartScope own_parts(own_cache);
    PartScope& known = parts != nullptr ? *parts : own_parts;
    impl_ = std::make_unique<Impl>(device_of(known));
    std::map<std::uint32_t, int> uses;
    for (const std::uint32_t i : used)
        ++uses[instances[i].mesh];
    if (faces == Faces::watertight)
        reach_ = reach_of(meshes, instances, used);
    constexpr float kRounding =
        1e-6f;  // of a vertex as a ray sees it that starts no further away than a few reaches
    const auto slack = [&](float scale) {
        return faces == Faces::watertight ? std::optional(kRounding * reach_ * scale) : std::nullopt;
    };
    std::map<std::uint32_t, std::shared_ptr<const MeshHierarchy>> shared;
    impl_->flipped.resize(instances.size());
    for (const std::uint32_t i : used) {
        const Instance& instance = instances[i];
        const Mesh& mesh = meshes[instance.mesh];
        const bool alone = uses[instance.mesh] == 1 && !instance.motion.moves() && !mesh.deforms();
        if (layout == Layout::whole && alone) {
            impl_->flipped[i] = instance.mirrored();
            attach(impl_->top.get(), impl_->place(mesh, instance.world_from_object, slack(1)), i);
            continue;
        }
        std::shared_ptr<const MeshHierarchy>& hierarchy = shared[instance.mesh];
        if (hierarchy == nullptr) {
            const float scale =
                faces == Faces::watertight ? object_scale(instances, used, instance.mesh) : 1.0f;
            hierarchy = MeshHierarchy::shared(known, impl_->device, mesh, slack(scale));
            impl_->shared.push_back(hierarchy);
            impl_->bytes += hierarchy->bytes();
        }
        attach(impl_->top.get(), impl_->instance(hierarchy->scene(), instance), i);
    }
    impl_->bytes += impl_->device->commit(impl_->top.get());
}

std::shared_ptr<const Intersector> Intersector::shared(PartScope& parts, std::string_view role,
                                                       std::span<const Mesh> meshes,
                                                       std::span<const Instance> instances,
                                                       std::span<const std::uint32_t> used, Faces faces,
                                                       Layout layout) {
    PartKey key;
    key.add(role).add(faces).add(layout).add(instances.size()).add(used);
    for (const std::uint32_t i : used) {
        const Instance& instance = instances[i];
        const Mesh& mesh = meshes[instance.mesh];
        key.add(instance.mesh).add(mesh.positions).add(mesh.triangles);
        key.add(mesh.motion_positions).add(mesh.motion_steps);
        key.add(instance.world_from_object).add(instance.motion.steps().size());
        for (const Transform& step : instance.motion.steps())
            key.add(step);
    }
    return parts.share<Intersector>(key, [&] {
        if (all_alone(meshes, instances, used, layout))  // else the new one takes over hierarchies of meshes
            parts.let_go<Intersector>(PartKey().add(role));
        return std::make_shared<Intersector>(meshes, instances, used, faces, layout, &parts);
    });
}

Intersector::~Intersector() = default;

std::size_t Intersector::bytes() const {
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(impl_->bytes, 0));
}

Hit Intersector::intersect(const Ray& ray, HitFilter* filter) const {
    if (!is_sound(ray))
        return {};
    Query query = query_of(filter, impl_->flipped);
    RTCRayHit rh;
    rh.ray = rtc_ray(ray);
    rh.hit.geomID = rh.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if NEPHELE_EMBREE_MAJOR >= 4
    RTCIntersectArguments args;
    rtcInitIntersectArguments(&args);
    pass(query, args);
    rtcIntersect1(impl_->top.get(), &rh, &args);
#else
    rtcIntersect1(impl_->top.get(), &query.context, &rh);
#endif
    return rh.hit.geomID == RTC_INVALID_GEOMETRY_ID ? Hit{} : hit_of(rh.ray, rh.hit);
}

bool Intersector::occluded(const Ray& ray, HitFilter* filter) const {
    if (!is_sound(ray))
        return false;
    Query query = query_of(filter, impl_->flipped);
    RTCRay r = rtc_ray(ray);
#if NEPHELE_EMBREE_MAJOR >= 4
    RTCOccludedArguments args;
    rtcInitOccludedArguments(&args);
    pass(query, args);
    rtcOccluded1(impl_->top.get(), &r, &args);
#else
    rtcOccluded1(impl_->top.get(), &query.context, &r);
#endif
    return r.tfar < 0;
}

void Intersector::self_test() {
    const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};
    Mesh mesh;
    mesh.positions = Buffer<float>(corners);
    mesh.triangles = Buffer<std::int32_t>(std::vector<std::int32_t>{0, 1, 2});
    Instance instance;
    const std::uint32_t used = 0;
    const Intersector scene({&mesh, 1}, {&instance, 1}, {&used, 1});
    const auto version = rtcGetDeviceProperty(scene.impl_->device->handle(), RTC_DEVICE_PROPERTY_VERSION);
    const Hit hit = scene.intersect({{0.25f, 0.25f, 1}, {0, 0, -1}});
    if (version / 10000 != RTC_VERSION_MAJOR || !hit.valid() || std::fabs(hit.t - 1) > 1e-5f) {
        throw std::runtime_error("the Embree library loaded by this process (version " +
                                 std::to_string(version) +
                                 ") is not the one this module was built with (" RTC_VERSION_STRING
                                 "); install the build of Nephele made for this Blender");
    }
    if (rtcGetDeviceProperty(scene.impl_->device->handle(), RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) ==
        0) {
        throw std::runtime_error(
            "this Embree library was built without filter functions; install one that has them");
    }
}

}  // namespace nephele
