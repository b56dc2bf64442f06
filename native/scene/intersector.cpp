// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/intersector.h"

#if NEPHELE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <atomic>
#include <deque>
#include <map>
#include <stdexcept>
#include <string>

#include "scene/watertight.h"

namespace nephele {

namespace {

#if NEPHELE_EMBREE_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

/// What the callbacks need; the Embree context comes first, so that its address is ours.
struct Query {
    QueryContext context;
    HitFilter* filter;
    const std::vector<bool>* flipped;
};

Hit hit_of(const RTCRay& ray, const RTCHit& hit) {
    const bool instanced = hit.instID[0] != RTC_INVALID_GEOMETRY_ID;
    return {ray.tfar, instanced ? hit.instID[0] : hit.geomID, hit.primID, hit.u, hit.v};
}

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

/// Triangles that Embree asks us about.
struct OwnFaces {
    const float* vertices;
    const std::int32_t* triangles;
    float slack;  ///< of boxes, for the rounding of vertices as the ray sees them

    Vec3f corner(unsigned face, unsigned i) const {
        const float* p = vertices + 3 * static_cast<std::size_t>(triangles[3 * std::size_t{face} + i]);
        return {p[0], p[1], p[2]};
    }
};

void bound_face(const RTCBoundsFunctionArguments* args) {
    const auto& faces = *static_cast<const OwnFaces*>(args->geometryUserPtr);
    const Vec3f a = faces.corner(args->primID, 0), b = faces.corner(args->primID, 1),
                c = faces.corner(args->primID, 2);
    const Vec3f lo = min(a, min(b, c)) - Vec3f(faces.slack), hi = max(a, max(b, c)) + Vec3f(faces.slack);
    RTCBounds& out = *args->bounds_o;
    out.lower_x = lo.x, out.lower_y = lo.y, out.lower_z = lo.z;
    out.upper_x = hi.x, out.upper_y = hi.y, out.upper_z = hi.z;
}

void intersect_face(const RTCIntersectFunctionNArguments* args) {
    if (args->valid[0] == 0)
        return;
    const auto& faces = *static_cast<const OwnFaces*>(args->geometryUserPtr);
    const auto& query = *reinterpret_cast<const Query*>(args->context);
    auto& [ray, hit] = *reinterpret_cast<RTCRayHit*>(args->rayhit);
    const WatertightRay line({ray.org_x, ray.org_y, ray.org_z}, {ray.dir_x, ray.dir_y, ray.dir_z});
    const auto met = line.meet(faces.corner(args->primID, 0), faces.corner(args->primID, 1),
                               faces.corner(args->primID, 2));
    if (!met || !(met->t >= ray.tnear && met->t <= ray.tfar))
        return;
    const unsigned instance = query.context.instID[0];
    const Hit found{met->t, instance == RTC_INVALID_GEOMETRY_ID ? args->geomID : instance, args->primID,
                    met->u, met->v};
    if (query.filter != nullptr &&
        !query.filter->accept(found, met->front != (*query.flipped)[found.instance]))
        return;
    ray.tfar = met->t;
    hit.u = met->u, hit.v = met->v;
    hit.primID = args->primID, hit.geomID = args->geomID, hit.instID[0] = instance;
}

RTCRay rtc_ray(const Ray& r) {
    RTCRay ray{};
    ray.org_x = r.o.x, ray.org_y = r.o.y, ray.org_z = r.o.z;
    ray.dir_x = r.d.x, ray.dir_y = r.d.y, ray.dir_z = r.d.z;
    ray.tnear = r.t_min;
    ray.tfar = r.t_max;
    ray.mask = ~0u;
    return ray;
}

Query query_of(HitFilter* filter, const std::vector<bool>& flipped) {
    Query query{};
#if NEPHELE_EMBREE_MAJOR >= 4
    rtcInitRayQueryContext(&query.context);
#else
    rtcInitIntersectContext(&query.context);
#endif
    query.filter = filter;
    query.flipped = &flipped;
    return query;
}

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
    std::vector<RTCScene> shared;  ///< one per mesh that several instances use
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

    RTCGeometry watertight_triangles(const Mesh& mesh, const float* vertices, float slack) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(mesh.triangle_count()));
        rtcSetGeometryUserData(geometry, &own.emplace_back(OwnFaces{vertices, mesh.triangles.data(), slack}));
        rtcSetGeometryBoundsFunction(geometry, bound_face, nullptr);
        rtcSetGeometryIntersectFunction(geometry, intersect_face);
        return geometry;
    }

    RTCGeometry triangles(const Mesh& mesh, const float* vertices, std::size_t vertex_count, float slack) {
        if (faces == Faces::watertight)
            return watertight_triangles(mesh, vertices, slack);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        if (vertices == mesh.positions.data()) {
            // Embree may read 16 bytes at the last vertex, which is past the end of somebody else's array:
            // copy.
            void* copy = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                                 vertex_count);
            if (copy != nullptr)
                std::copy(vertices, vertices + 3 * vertex_count, static_cast<float*>(copy));
        } else {
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0,
                                       12, vertex_count);
        }
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   mesh.triangles.data(), 0, 12, mesh.triangle_count());
#if NEPHELE_EMBREE_MAJOR >= 4
        rtcSetGeometryEnableFilterFunctionFromArguments(geometry, true);
#endif
        return geometry;
    }

    /// A mesh used once: its vertices are placed in the world, which makes queries cheaper than an instance
    /// would.
    RTCGeometry place(const Mesh& mesh, const Transform& world_from_object, float slack) {
        const std::size_t count = mesh.positions.size() / 3;
        std::vector<float>& out =
            placed.emplace_back(3 * count + 1);  // one float of padding, see triangles()
        for (std::size_t i = 0; i < count; ++i) {
            const float* p = mesh.positions.data() + 3 * i;
            const Vec3f w = world_from_object.point({p[0], p[1], p[2]});
            out[3 * i] = w.x, out[3 * i + 1] = w.y, out[3 * i + 2] = w.z;
        }
        return triangles(mesh, out.data(), count, slack);
    }

    RTCGeometry instance(RTCScene scene, const Transform& m) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, scene);
        const float rows[12] = {m.row[0].x, m.row[0].y, m.row[0].z, m.translation.x,
                                m.row[1].x, m.row[1].y, m.row[1].z, m.translation.y,
                                m.row[2].x, m.row[2].y, m.row[2].z, m.translation.z};
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
        return geometry;
    }

    static void attach(RTCScene scene, RTCGeometry geometry, std::uint32_t id) {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
    }
};

namespace {

/// Largest coordinate of the instances in the world.
float reach_of(std::span<const Mesh> meshes, std::span<const Instance> instances,
               std::span<const std::uint32_t> used) {
    std::vector<float> of_mesh(meshes.size(), -1);
    float reach = 0;
    for (const std::uint32_t i : used) {
        float& own = of_mesh[instances[i].mesh];
        if (own < 0) {
            own = 0;
            for (const float x : meshes[instances[i].mesh].positions)
                own = std::max(own, std::fabs(x));
        }
        const Transform& m = instances[i].world_from_object;
        for (int a = 0; a < 3; ++a) {
            const Vec3f row = m.row[static_cast<std::size_t>(a)];
            reach = std::max(reach, std::fabs(m.translation[a]) +
                                        own * (std::fabs(row.x) + std::fabs(row.y) + std::fabs(row.z)));
        }
    }
    return reach;
}

/// The most that a metre of the world measures in a mesh's own space, among its instances.
float object_scale(std::span<const Instance> instances, std::span<const std::uint32_t> used,
                   std::uint32_t mesh) {
    float scale = 0;
    for (const std::uint32_t i : used) {
        if (instances[i].mesh != mesh)
            continue;
        for (const Vec3f row : instances[i].object_from_world.row)
            scale = std::max(scale, length(row));
    }
    return scale;
}

}  // namespace

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
        if (uses[instance.mesh] == 1) {
            impl_->flipped[i] = instance.mirrored();
            Impl::attach(impl_->top, impl_->place(mesh, instance.world_from_object, slack), i);
            continue;
        }
        RTCScene& scene = shared[instance.mesh];
        if (scene == nullptr) {
            scene = impl_->shared.emplace_back(impl_->new_scene());
            Impl::attach(scene,
                         impl_->triangles(mesh, mesh.positions.data(), mesh.positions.size() / 3,
                                          slack * object_scale(instances, used, instance.mesh)),
                         0);
            rtcCommitScene(scene);
        }
        Impl::attach(impl_->top, impl_->instance(scene, instance.world_from_object), i);
    }
    rtcCommitScene(impl_->top);
    check(impl_->device, "build the ray tracing hierarchy");
}

Intersector::~Intersector() = default;

std::size_t Intersector::bytes() const {
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(impl_->memory, 0));
}

Hit Intersector::intersect(const Ray& ray, HitFilter* filter) const {
    Query query = query_of(filter, impl_->flipped);
    RTCRayHit rh;
    rh.ray = rtc_ray(ray);
    rh.hit.geomID = rh.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if NEPHELE_EMBREE_MAJOR >= 4
    RTCIntersectArguments args;
    rtcInitIntersectArguments(&args);
    args.context = &query.context;
    args.filter = filter != nullptr ? run_filter : nullptr;
    rtcIntersect1(impl_->top, &rh, &args);
#else
    query.context.filter = filter != nullptr ? run_filter : nullptr;
    rtcIntersect1(impl_->top, &query.context, &rh);
#endif
    return rh.hit.geomID == RTC_INVALID_GEOMETRY_ID ? Hit{} : hit_of(rh.ray, rh.hit);
}

bool Intersector::occluded(const Ray& ray, HitFilter* filter) const {
    Query query = query_of(filter, impl_->flipped);
    RTCRay r = rtc_ray(ray);
#if NEPHELE_EMBREE_MAJOR >= 4
    RTCOccludedArguments args;
    rtcInitOccludedArguments(&args);
    args.context = &query.context;
    args.filter = filter != nullptr ? run_filter : nullptr;
    rtcOccluded1(impl_->top, &r, &args);
#else
    query.context.filter = filter != nullptr ? run_filter : nullptr;
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
