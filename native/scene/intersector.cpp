// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/intersector.h"

#include <atomic>
#include <deque>
#include <map>
#include <stdexcept>
#include <string>

#include "scene/embree_faces.h"
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

void check(RTCDevice device, const char* what) {
    const RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE) {
        throw std::runtime_error(std::string("Embree failed to ") + what + " (error " +
                                 std::to_string(static_cast<int>(error)) + ", 4 is out of memory)");
    }
}

}  // namespace

struct Intersector::Impl {
    RTCDevice device = nullptr;
    RTCScene top = nullptr;
    std::vector<RTCScene> shared;  ///< one per mesh that moves or that several instances use
    std::atomic<std::ptrdiff_t> memory{0};
    std::vector<std::vector<float>> placed;  ///< world-space vertices of meshes used once
    Faces faces;
    std::deque<OwnFaces> own;  ///< by geometry, where faces are watertight
    std::vector<bool>
        flipped;  ///< by instance: placing it in the world mirrored it, which turns its faces over

    explicit Impl(Faces f) : device(rtcNewDevice(nullptr)), faces(f) {
        if (device == nullptr)
            throw std::runtime_error("Embree could not be started");
        const auto monitor = [](void* self, ssize_t bytes, bool) {
            static_cast<Impl*>(self)->memory += bytes;
            return true;
        };
        rtcSetDeviceMemoryMonitorFunction(device, monitor, this);
        top = new_scene();
    }
    ~Impl() {
        for (RTCScene s : shared)
            rtcReleaseScene(s);
        if (top != nullptr)
            rtcReleaseScene(top);
        rtcReleaseDevice(device);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    RTCScene new_scene() {
        RTCScene scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST
#if NEPHELE_EMBREE_MAJOR < 4
                                    | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION
#endif
        );
        return scene;
    }

    RTCGeometry watertight_triangles(const Mesh& mesh, const Vertices& vertices, float slack) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(vertices.steps));
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(mesh.triangle_count()));
        rtcSetGeometryUserData(geometry, &own.emplace_back(OwnFaces{vertices, mesh.triangles.data(), slack}));
        rtcSetGeometryBoundsFunction(geometry, bound_face, nullptr);
        rtcSetGeometryIntersectFunction(geometry, intersect_face);
        return geometry;
    }

    /// own_space: the vertices are the mesh's own, not placed in the world.
    RTCGeometry triangles(const Mesh& mesh, const Vertices& vertices, bool own_space, float slack) {
        if (faces == Faces::watertight)
            return watertight_triangles(mesh, vertices, slack);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(vertices.steps));
        for (std::size_t i = 0; i < vertices.steps; ++i) {
            const float* step = vertices.data + i * vertices.floats;
            const auto slot = static_cast<unsigned>(i);
            if (own_space) {
                // Embree may read 16 bytes at the last vertex, which is past the end of somebody else's
                // array: copy.
                void* copy = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, slot,
                                                     RTC_FORMAT_FLOAT3, 12, vertices.floats / 3);
                if (copy != nullptr)
                    std::copy(step, step + vertices.floats, static_cast<float*>(copy));
            } else {
                rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, slot, RTC_FORMAT_FLOAT3, step, 0,
                                           12, vertices.floats / 3);
            }
        }
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   mesh.triangles.data(), 0, 12, mesh.triangle_count());
#if NEPHELE_EMBREE_MAJOR >= 4
        rtcSetGeometryEnableFilterFunctionFromArguments(geometry, true);
#endif
        return geometry;
    }

    /// A mesh used once that stands still: its vertices are placed in the world, which makes queries cheaper
    /// than an instance would.
    RTCGeometry place(const Mesh& mesh, const Transform& world_from_object, float slack) {
        const std::size_t count = mesh.positions.size() / 3;
        std::vector<float>& out =
            placed.emplace_back(3 * count + 1);  // one float of padding, see triangles()
        for (std::size_t i = 0; i < count; ++i) {
            const float* p = mesh.positions.data() + 3 * i;
            const Vec3f w = world_from_object.point({p[0], p[1], p[2]});
            out[3 * i] = w.x, out[3 * i + 1] = w.y, out[3 * i + 2] = w.z;
        }
        return triangles(mesh, {out.data(), 1, 3 * count}, false, slack);
    }

    RTCGeometry instance(RTCScene scene, const Instance& placed_mesh) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
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

    static void attach(RTCScene scene, RTCGeometry geometry, std::uint32_t id) {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
    }
};

Intersector::Intersector(std::span<const Mesh> meshes, std::span<const Instance> instances,
                         std::span<const std::uint32_t> used, Faces faces)
    : impl_(std::make_unique<Impl>(faces)), empty_(used.empty()) {
    std::map<std::uint32_t, int> uses;
    for (const std::uint32_t i : used)
        ++uses[instances[i].mesh];
    if (faces == Faces::watertight)
        reach_ = reach_of(meshes, instances, used);
    constexpr float kRounding =
        1e-6f;  // of a vertex as a ray sees it that starts no further away than a few reaches
    const float slack = kRounding * reach_;
    std::map<std::uint32_t, RTCScene> shared;
    impl_->flipped.resize(instances.size());
    for (const std::uint32_t i : used) {
        const Instance& instance = instances[i];
        const Mesh& mesh = meshes[instance.mesh];
        if (uses[instance.mesh] == 1 && !instance.motion.moves() && !mesh.deforms()) {
            impl_->flipped[i] = instance.mirrored();
            Impl::attach(impl_->top, impl_->place(mesh, instance.world_from_object, slack), i);
            continue;
        }
        RTCScene& scene = shared[instance.mesh];
        if (scene == nullptr) {
            scene = impl_->shared.emplace_back(impl_->new_scene());
            Impl::attach(scene,
                         impl_->triangles(mesh, own_vertices(mesh), true,
                                          slack * object_scale(instances, used, instance.mesh)),
                         0);
            rtcCommitScene(scene);
        }
        Impl::attach(impl_->top, impl_->instance(scene, instance), i);
    }
    rtcCommitScene(impl_->top);
    check(impl_->device, "build the ray tracing hierarchy");
}

Intersector::~Intersector() = default;

std::size_t Intersector::bytes() const {
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(impl_->memory, 0));
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
    rtcIntersect1(impl_->top, &rh, &args);
#else
    rtcIntersect1(impl_->top, &query.context, &rh);
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
    rtcOccluded1(impl_->top, &r, &args);
#else
    rtcOccluded1(impl_->top, &query.context, &r);
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
    const auto version = rtcGetDeviceProperty(scene.impl_->device, RTC_DEVICE_PROPERTY_VERSION);
    const Hit hit = scene.intersect({{0.25f, 0.25f, 1}, {0, 0, -1}});
    if (version / 10000 != RTC_VERSION_MAJOR || !hit.valid() || std::fabs(hit.t - 1) > 1e-5f) {
        throw std::runtime_error("the Embree library loaded by this process (version " +
                                 std::to_string(version) +
                                 ") is not the one this module was built with (" RTC_VERSION_STRING
                                 "); install the build of Nephele made for this Blender");
    }
    if (rtcGetDeviceProperty(scene.impl_->device, RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) == 0) {
        throw std::runtime_error(
            "this Embree library was built without filter functions; install one that has them");
    }
}

}  // namespace nephele
