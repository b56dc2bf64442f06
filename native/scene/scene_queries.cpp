// SPDX-License-Identifier: GPL-3.0-or-later
// Queries of the scene while rendering: nearest surface, shadow transmittance, media along a ray.
#include <algorithm>

#include "film/matte.h"
#include "lights/lamp_point.h"
#include "scene/nesting.h"
#include "scene/reach.h"
#include "scene/scene.h"

namespace nephele {

/// Lets rays see only surfaces, and those only of instances that are visible to the ray's kind.
struct Scene::SurfaceFilter final : HitFilter {
    const Scene& scene;
    std::uint32_t ray_kind;

    SurfaceFilter(const Scene& s, std::uint32_t kind) : scene(s), ray_kind(kind) {}
    bool accept(const Hit& hit, bool) override { return scene.is_surface(hit, ray_kind); }
};

/// Lets rays see one instance.
struct Scene::InstanceFilter final : HitFilter {
    std::uint32_t instance;

    explicit InstanceFilter(std::uint32_t i) : instance(i) {}
    bool accept(const Hit& hit, bool) override { return hit.instance == instance; }
};

/// Multiplies the transparencies of all that a shadow ray meets, and stops at what is opaque. Products
/// commute, so the order in which hits come does not matter.
struct Scene::TransmittanceFilter final : HitFilter {
    const Scene& scene;
    const Ray& ray;
    std::uint64_t blockers;
    Rgb transmittance{1};

    TransmittanceFilter(const Scene& s, const Ray& r, std::uint64_t b) : scene(s), ray(r), blockers(b) {}
    bool accept(const Hit& hit, bool) override {
        if (!scene.is_surface(hit, kShadowRay) ||
            !blocks(blockers, scene.source_.instances[hit.instance].blocker_set))
            return false;
        transmittance *= scene.transparency(hit, ray);
        return is_zero(transmittance);
    }
};

/// Light that a surface lets straight through along a shadow ray.
Rgb Scene::transparency(const Hit& hit, const Ray& ray) const {
    const auto material = material_of(hit);
    if (material < 0 || !traits_[static_cast<std::size_t>(material)].may_transmit_straight)
        return Rgb(0);
    const Program& program = *source_.materials[static_cast<std::size_t>(material)].surface;
    return evaluate_transparency(program, shading_point(hit, ray, kShadowRay), textures_);
}

std::int32_t Scene::material_of(const Hit& hit) const {
    const Instance& instance = source_.instances[hit.instance];
    return instance.material_of(source_.meshes[instance.mesh], hit.triangle);
}

bool Scene::is_surface(const Hit& hit, std::uint32_t ray_kind) const {
    if ((source_.instances[hit.instance].visibility & ray_kind) == 0)
        return false;
    const auto material = material_of(hit);
    return material < 0 || source_.materials[static_cast<std::size_t>(material)].surface.has_value();
}

Hit Scene::intersect(const Ray& ray, std::uint32_t ray_kind) const {
    Hit hit;
    if (!surfaces_->empty() && !features_.hidden_surfaces) {
        hit = surfaces_->intersect(ray);
    } else if (!surfaces_->empty()) {
        SurfaceFilter filter(*this, ray_kind);
        hit = surfaces_->intersect(ray, &filter);
    }
    return features_.nested_dielectrics ? nearest_interface(ray, ray_kind, hit) : hit;
}

Hit Scene::intersect_within(const Ray& ray, std::uint32_t instance) const {
    InstanceFilter filter(instance);
    const bool nested = source_.instances[instance].dielectric_priority > 0;
    return (nested ? dielectrics_ : surfaces_)->intersect(ray, &filter);
}

Rgb Scene::surface_transmittance(const Ray& ray, std::uint64_t blockers) const {
    Rgb T(1);
    if (!surfaces_->empty() && !features_.hidden_surfaces && !features_.transparent_surfaces &&
        blockers == Linking::kAll) {
        T = Rgb(surfaces_->occluded(ray) ? 0.0f : 1.0f);
    } else if (!surfaces_->empty()) {
        TransmittanceFilter filter(*this, ray, blockers);
        T = surfaces_->occluded(ray, &filter) ? Rgb(0) : filter.transmittance;
    }
    return features_.nested_dielectrics && !is_zero(T) ? T * interface_transmittance(ray) : T;
}

void Scene::find_media(const Ray& ray, std::uint32_t ray_kind, Segment& out, std::uint64_t blockers) const {
    out.ray = ray;
    out.ray_kind = ray_kind;
    out.intervals.clear();
    out.rests.clear();
    const auto media_of = [&](const Region& r) {
        return std::pair(&media_[r.media_begin], &media_[r.media_begin] + (r.media_end - r.media_begin));
    };
    const Instance* mover = nullptr;  // of the last rest ray: an object's regions follow each other
    const auto rest_of = [&](const Region& r) {
        if (!compiled::motion || !r.mover)
            return kStandsStill;
        if (r.mover != mover)
            out.rests.emplace_back(*(mover = r.mover), ray);
        return static_cast<std::uint32_t>(out.rests.size() - 1);
    };
    for (const Region& region : regions_) {
        if ((region.visibility & ray_kind) == 0 || region.kind == Region::Kind::mesh ||
            !blocks(blockers, region.blocker_set))
            continue;
        Vec2f span{ray.t_min, ray.t_max};
        const std::uint32_t rest = rest_of(region);
        if (region.kind == Region::Kind::box) {
            const auto inside = region.intersect_box(rest == kStandsStill ? ray : out.rests[rest].ray);
            if (!inside)
                continue;
            span = *inside;
        }
        const auto [begin, end] = media_of(region);
        for (const Medium* m = begin; m != end; ++m)
            out.intervals.push_back({m, span.x, span.y, rest});
    }
    if (!features_.mesh_media)
        return;
    find_crossings(*boundaries_, source_.instances, ray, ray_kind, out.crossings);
    std::optional<NestedRay> nested;
    if (features_.nested_dielectrics && !out.crossings.empty())
        nested.emplace(*dielectrics_, source_.instances, ray, ray_kind);
    const Crossing* const end = out.crossings.data() + out.crossings.size();
    for (const Crossing* first = out.crossings.data(); first != end;) {
        const Crossing* const last =
            std::find_if(first, end, [&](const Crossing& c) { return c.instance != first->instance; });
        const Region& region = regions_[region_of_instance_[first->instance]];
        if (!blocks(blockers, region.blocker_set)) {
            first = last;
            continue;
        }
        const auto media = media_of(region);
        const std::uint32_t rest = rest_of(region);
        const int priority = source_.instances[first->instance].dielectric_priority;
        for_each_stay(first, last, [&](const Crossing* entry, const Crossing* exit) {
            const float t0 = entry ? entry->t : ray.t_min, t1 = exit ? exit->t : kInfinity;
            const auto add = [&](float a, float b) {
                add_intervals(media.first, media.second, a, b, out, rest);
            };
            if (nested && priority > 0) {
                nested->visit_outside_above(priority, t0, t1, add);
            } else {
                add(t0, t1);
            }
        });
        first = last;
    }
}

namespace {

/// kMoves: whether anything of the scene may move.
template <bool kMoves>
ShadingPoint point_on(const Instance& instance, const Mesh& mesh, const Hit& hit, const Ray& ray) {
    ShadingPoint point;
    point.instance = &instance;
    point.mesh = &mesh;
    point.triangle = hit.triangle;
    point.outside_ior = hit.outside_ior;
    point.wo = -ray.d;
    point.history.length = hit.t;
    point.time = ray.time;
    point.barycentric = {1 - hit.u - hit.v, hit.u, hit.v};
    const auto vertex = [&](int corner) {
        return kMoves ? mesh.vertex(hit.triangle, corner, ray.time) : mesh.vertex(hit.triangle, corner);
    };
    const Vec3f a = vertex(0), b = vertex(1), c = vertex(2);
    const Vec3f& w = point.barycentric;
    point.object_p = a * w.x + b * w.y + c * w.z;
    const auto place = [&](const Transform& world_from_object) {
        point.p = world_from_object.point(point.object_p);
        // The least step off the surface is then some 70 times the rounding of p.
        constexpr float kShare = 1.0f / 16;
        const Vec3f largest = max(max(a, -a), max(max(b, -b), max(c, -c)));
        point.reach = kShare * reach_of(world_from_object, max_component(largest));
    };
    const Transform* object_from_world = &instance.object_from_world;
    Transform moved;
    if (kMoves && instance.motion.moves()) {
        const Transform world_from_object = instance.motion.at(ray.time);
        moved = inverse_of(world_from_object);
        object_from_world = &moved;
        place(world_from_object);
    } else {
        place(instance.world_from_object);
    }
    const auto world_normal = [&](Vec3f n) {
        return safe_normalize(object_from_world->transposed_vector(n));
    };
    point.ng = world_normal(cross(b - a, c - a));
    point.ns = point.ng;
    if (!mesh.corner_normals.empty()) {
        const auto normal = [&](int corner) {
            return kMoves ? mesh.corner_normal(hit.triangle, corner, ray.time)
                          : mesh.corner_normal(hit.triangle, corner);
        };
        const Vec3f smooth = normal(0) * w.x + normal(1) * w.y + normal(2) * w.z;
        const float largest = max_component(max(smooth, -smooth));
        if (largest > 0)  // of length 1 or so, whatever it came as: its square has to be a float
            point.ns = world_normal(smooth / largest);
    }
    point.backfacing = dot(point.ng, point.wo) < 0;
    if (point.backfacing) {
        point.ng = -point.ng;
        point.ns = -point.ns;
    }
    return point;
}

}  // namespace

ShadingPoint Scene::shading_point(const Hit& hit, const Ray& ray, std::uint32_t ray_kind) const {
    const Instance& instance = source_.instances[hit.instance];
    const Mesh& mesh = source_.meshes[instance.mesh];
    ShadingPoint point = compiled::motion && features_.motion ? point_on<true>(instance, mesh, hit, ray)
                                                              : point_on<false>(instance, mesh, hit, ray);
    point.ray_kind = ray_kind;
    return point;
}

const Program* Scene::program_of(const ShadingPoint& point) const {
    const auto material = point.instance->material_of(*point.mesh, point.triangle);
    return material < 0 ? nullptr : &*source_.materials[static_cast<std::size_t>(material)].surface;
}

float Scene::material_index(const ShadingPoint& point) const {
    const auto material = point.instance->material_of(*point.mesh, point.triangle);
    return material < 0 ? 0 : source_.materials[static_cast<std::size_t>(material)].pass_index;
}

std::array<float, 4> Scene::motion_vector(const ShadingPoint& point, Vec2f film_size) const {
    const Vec3f& w = point.barycentric;
    const Vec2f here = camera_->project(point.p, film_size);
    const auto beside = [&](std::size_t which) {
        const auto corner = [&](int c) { return point.mesh->neighbour(point.triangle, c, which); };
        const Vec3f p = corner(0) * w.x + corner(1) * w.y + corner(2) * w.z;
        return camera_->project_at_neighbour(point.instance->neighbour(which).point(p), film_size, which);
    };
    const Vec2f before = beside(0), after = beside(1);
    return {before.x - here.x, before.y - here.y, here.x - after.x, here.y - after.y};
}

Matte Scene::matte(const ShadingPoint& point, float weight) const {
    static const std::uint32_t kDefault = matte_id("default_surface");  // as Cycles calls it
    const auto material = point.instance->material_of(*point.mesh, point.triangle);
    return {point.instance->object_matte, point.instance->asset_matte,
            material < 0 ? kDefault : source_.materials[static_cast<std::size_t>(material)].matte, weight};
}

Rgb Scene::background(Vec3f d, std::uint32_t ray_kind, const RayHistory& history) const {
    if (!source_.world.background || (source_.world.visibility & ray_kind) == 0)
        return Rgb(0);
    ShadingPoint point;
    point.p = point.object_p = point.ng = point.ns = d;
    point.wo = -d;
    point.ray_kind = ray_kind;
    point.history = history;
    return evaluate_emission(*source_.world.background, point, textures_);
}

std::uint8_t Scene::receiver_set_at(const Segment& segment, float t) const {
    for (const Interval& i : segment.intervals) {
        if (i.t0 <= t && t <= i.t1)
            return regions_[i.medium->region].receiver_set;
    }
    return 0;
}

Rgb Scene::lamp_tint(std::uint32_t lamp, const Ray& ray, float distance, std::uint32_t ray_kind,
                     const RayHistory& history) const {
    const LampShader* shader = lamp_shaders_[lamp].get();
    if (shader == nullptr)
        return Rgb(1);
    const LampMotion& motion = lights_.lamp(lamp).motion;
    Vec3f o = ray.o, d = ray.d;
    if (motion.moves()) {
        const LampMotion::Moment now = motion.at(ray.time);
        o = now.point_to_rest(o);
        d = now.to_rest(d);
    }
    const LampPoint on = lamp_point(lights_.lamp(lamp).light, o, d, distance);
    ShadingPoint point;
    point.p = on.p;
    point.ng = point.ns = on.n;
    point.wo = -d;
    point.object_p = shader->instance.object_from_world.point(on.p);
    point.barycentric = {on.uv.x, on.uv.y, 1 - on.uv.x - on.uv.y};
    point.instance = &shader->instance;
    point.mesh = &shader->mesh;
    point.ray_kind = ray_kind;
    point.history = history;
    point.history.length = std::min(distance, 1e18f);
    return max(evaluate_emission(shader->program, point, textures_), Rgb(0));
}

float Scene::shutter_time(float u) const {
    const std::vector<float>& curve = source_.shutter_curve;
    if (curve.empty())
        return u;
    const MotionPlace at(u, curve.size());
    return curve[at.step] + (curve[at.step + 1] - curve[at.step]) * at.fraction;
}

std::size_t Scene::hierarchy_bytes() const {
    return surfaces_->bytes() + boundaries_->bytes() + dielectrics_->bytes();
}

}  // namespace nephele
