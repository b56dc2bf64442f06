// SPDX-License-Identifier: GPL-3.0-or-later
// Queries of scenes with nested dielectrics: the walls that count, and what surrounds them.
#include "scene/nesting.h"
#include "scene/scene.h"

namespace nephele {

namespace {

Hit hit_of(const Crossing& c) {
    return {c.t, c.instance, c.triangle, c.u, c.v};
}

}  // namespace

/// Index of refraction inside the object whose wall this is.
float Scene::interior_ior(const Crossing& wall, const Ray& ray, std::uint32_t ray_kind) const {
    const Hit hit = hit_of(wall);
    const auto material = material_of(hit);
    if (material < 0)
        return 1;
    const auto index = static_cast<std::size_t>(material);
    if (!source_.materials[index].surface)
        return 1;
    if (traits_[index].interior_ior)
        return *traits_[index].interior_ior;
    return evaluate_interior_ior(*source_.materials[index].surface, shading_point(hit, ray, ray_kind),
                                 textures_);
}

/// The nearer of `hit` and the first wall that counts.
Hit Scene::nearest_interface(const Ray& ray, std::uint32_t ray_kind, const Hit& hit) const {
    const NestedRay nested(*dielectrics_, source_.instances, ray, ray_kind);
    for (const Interface& i : nested.interfaces(std::min(hit.t, ray.t_max))) {
        Hit wall = hit_of(*i.wall);
        if (!is_surface(wall, ray_kind))
            continue;
        if (i.around != nullptr)
            wall.outside_ior = interior_ior(*i.around, ray, ray_kind);
        return wall;
    }
    return hit;
}

Rgb Scene::interface_transmittance(const Ray& ray) const {
    const NestedRay nested(*dielectrics_, source_.instances, ray, kShadowRay);
    Rgb T(1);
    for (const Interface& i : nested.interfaces(ray.t_max)) {
        const Hit wall = hit_of(*i.wall);
        if (is_surface(wall, kShadowRay))
            T *= transparency(wall, ray);
        if (is_zero(T))
            break;
    }
    return T;
}

/// Light sampling aims at the whole of an emissive mesh, walls that would not count included.
void Scene::drop_priority_of_emitter(Instance& instance) {
    const bool emits = std::any_of(instance.materials.begin(), instance.materials.end(), [&](std::int32_t m) {
        return m >= 0 && traits_[static_cast<std::size_t>(m)].emissive;
    });
    if (instance.dielectric_priority > 0 && emits) {
        warnings_.push_back("object '" + instance.name +
                            "' emits light; its dielectric priority is left out");
        instance.dielectric_priority = 0;
    }
}

}  // namespace nephele
