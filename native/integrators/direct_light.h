// SPDX-License-Identifier: GPL-3.0-or-later
// Next-event estimation: aims at one light from a point on a surface or in a volume.
//
// MIS weights use the solid-angle densities of direction and light alone. Transmittance and free-flight
// densities do not enter them: both techniques carry the transmittance as a factor of the estimate, so the
// weights are one fixed function of the direction and add up to 1.
#pragma once

#include "integrators/integrator.h"
#include "math/transform.h"
#include "tracking/transmittance.h"

namespace nephele {

/// A light seen from a point, before visibility.
struct DirectSample {
    LightSample light;  ///< pdf includes the probability of choosing the light
    Vec3f target;  ///< where a shadow ray has to end, off the emitter's surface; unused where the distance is
                   ///< infinite
    bool cast_shadow = true;
    std::uint32_t kinds = ~0u;  ///< of scattered rays that see it
    std::uint64_t blockers = Linking::kAll;
    bool alone = false;  ///< no other technique finds it: its MIS weight is 1
};

/// Kinds of rays that light sampling stands for at the vertex which rays of kind `scattered` leave.
constexpr std::uint32_t sampling_kinds(std::uint32_t scattered) {
    return scattered == kVolumeRay ? kVolumeRay : kDiffuseRay | kGlossyRay | kTransmissionRay;
}

/// Kinds of rays that see a light when they hit it.
inline std::uint32_t light_visibility(const Scene& scene, std::uint32_t number) {
    const LightSet& lights = scene.lights();
    switch (lights.kind(number)) {
        case LightSet::Kind::lamp:
            return lights.lamp(number).visibility;
        case LightSet::Kind::mesh:
            return lights.mesh(number).instance().visibility;
        case LightSet::Kind::world:
            break;
    }
    return scene.world_visibility();
}

/// Draws a light and a direction towards it. ray_kind: kVolumeRay from a volume, kDiffuseRay from a surface.
/// history: of the ray that came here.
inline std::optional<DirectSample> sample_direct(const Scene& scene, const Receiver& at,
                                                 std::uint32_t ray_kind, const RayHistory& history,
                                                 PathSampler& sampler) {
    const Vec3f p = at.p;
    const LightSet& lights = scene.lights();
    if (lights.empty())
        return std::nullopt;
    const Vec2d choice = sampler.next_pair().fine();
    const RandomPair pair = sampler.next_pair();
    const Vec2f u = pair.coarse();
    float probability = 0;
    const auto number = lights.select(at, choice.x, probability);
    if (!number || (light_visibility(scene, *number) & sampling_kinds(ray_kind)) == 0)
        return std::nullopt;
    DirectSample out;
    if (lights.kind(*number) == LightSet::Kind::lamp) {
        const Lamp& lamp = lights.lamp(*number);
        if (history.depth > lamp.max_bounces)
            return std::nullopt;
        const auto s = lamp.sample(at, u);
        if (!s)
            return std::nullopt;
        out.light = *s;
        if (scene.features().lamp_shaders) {
            out.light.Li *= scene.lamp_tint(*number, {p, s->wi, 0, kInfinity, at.time}, s->distance, ray_kind,
                                            history.after(ray_kind, false));
        }
        out.cast_shadow = lamp.cast_shadow;
        out.target = p + s->wi * s->distance;
    } else if (lights.kind(*number) == LightSet::Kind::mesh) {
        const MeshLight& mesh = lights.mesh(*number);
        const auto s = mesh.sample(p, choice.y, u);
        if (!s)
            return std::nullopt;
        out.light = s->light;
        Hit hit{s->light.distance, scene.number_of(mesh.instance()), s->triangle, s->barycentric.y,
                s->barycentric.z};
        ShadingPoint point = scene.shading_point(hit, {p, s->light.wi}, ray_kind);
        point.history = history.after(ray_kind, false);
        point.history.length = hit.t;
        out.light.Li = evaluate_emission(*scene.program_of(point), point, scene.textures());
        out.target = point.off(point.ng);
    } else {
        const EnvironmentLight::Sample s = lights.world()->sample(pair.fine());
        out.light = {s.wi, kInfinity, scene.background(s.wi, ray_kind, history.after(ray_kind, false)), s.pdf,
                     false};
    }
    if (!(out.light.pdf > 0) || is_zero(out.light.Li))
        return std::nullopt;
    out.light.pdf *= probability;
    out.kinds = light_visibility(scene, *number);
    if (lights.linked()) {
        out.blockers = lights.linking(*number).blockers;
        out.alone = out.blockers != Linking::kAll;
    }
    return out;
}

/// The ray from p, already off its surface, to the light, at a time of the shutter. It is aimed anew: with
/// the direction found at the surface itself, a ray that starts a little off it would end in an emitter close
/// by before it arrives.
inline Ray shadow_ray(Vec3f p, float time, const DirectSample& direct) {
    if (direct.light.distance == kInfinity)
        return {p, direct.light.wi, 0, kInfinity, time};
    const Vec3f to_light = direct.target - p;
    const float distance = length(to_light);
    return {p, distance > 0 ? to_light / distance : direct.light.wi, 0, distance, time};
}

/// Transmittance from p (already off its surface) to the light: surfaces, then media.
template <KernelTraits k = kEverything>
Rgb shadow_transmittance(const Scene& scene, const Settings& settings, Vec3f p, float time,
                         const DirectSample& direct, PathSampler& sampler, Workspace& ws) {
    if (!direct.cast_shadow)
        return Rgb(1);
    const Ray ray = shadow_ray(p, time, direct);
    ++ws.counters.rays;
    Rgb T = scene.surface_transmittance(ray, direct.blockers);
    if (!k.media || is_zero(T) || !scene.features().media)
        return T;
    scene.find_media(ray, kShadowRay, ws.shadow, direct.blockers);
    return T * estimate_transmittance<k>(ws.shadow, settings, sampler.rng(), ws.counters);
}

}  // namespace nephele
