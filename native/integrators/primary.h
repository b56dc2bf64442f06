// SPDX-License-Identifier: GPL-3.0-or-later
// What the passes want to know of a camera ray besides its radiance.
#pragma once

#include "integrators/integrator.h"
#include "tracking/transmittance.h"

namespace nephele {

/// (u, v, 1) of the mesh's first UV map, which is its active one; 0 where it has none.
inline Vec3f uv_of(const ShadingPoint& point) {
    if (point.mesh->uvs.empty() || point.mesh->uvs[0].empty())
        return {0, 0, 1};
    const float* uv = point.mesh->uvs[0].data() + 6 * std::size_t{point.triangle};
    const Vec3f& w = point.barycentric;
    return {uv[0] * w.x + uv[2] * w.y + uv[4] * w.z, uv[1] * w.x + uv[3] * w.y + uv[5] * w.z, 1};
}

/// A surface that a camera ray meets: its share of the mist and, of the first that is opaque enough, depth
/// and the like. clear: what transparent surfaces before it let through.
inline void record_surface(const Scene& scene, const SampleRequest& request, const ShadingPoint& point,
                           float clear, PixelSample& out, bool& recorded) {
    if (recorded && !request.mist)
        return;
    const Bsdf bsdf = make_bsdf(scene.program_of(point), point, scene.textures());
    const float alpha = clamp01(1 - mean(bsdf.transparency));
    const Vec3f seen = scene.camera().to_camera(point.p);
    if (request.mist)
        out.mist -=
            (1 - request.mist->at(scene.camera().orthographic() ? seen.z : length(seen))) * alpha * clear;
    if (recorded || alpha == 0 || alpha < request.opaque_alpha)
        return;
    recorded = true;
    out.depth = scene.camera().depth(point.p);
    out.position = point.p + scene.textures().origin;
    out.normal = point.ns;
    out.albedo = bsdf.albedo(point.wo);
    out.uv = uv_of(point);
    if (request.vector)
        out.vector = scene.motion_vector(point, request.film_size);
    out.object_index = point.instance->pass_index;
    out.material_index = scene.material_index(point);
}

/// Integral of the majorants of all media along the segment, at most kMostMajorantDepth: media without end
/// would make it infinite, which no image file should hold. Looks nothing up.
inline float majorant_optical_depth(const Segment& segment, bool global) {
    constexpr double kMostMajorantDepth = 1e6;
    double depth = 0;
    for (const Interval& interval : segment.intervals) {
        MajorantTrack track(interval, segment, global);
        for (float t = interval.t0; track.advance(); t = track.piece_end()) {
            if (track.majorant() > 0)  // 0 over an infinite length is 0
                depth += double{track.majorant()} * (double{track.piece_end()} - double{t});
        }
    }
    return static_cast<float>(std::min(depth, kMostMajorantDepth));
}

/// Transmittance of the volumes on the primary ray, by its own estimate, and their majorants' optical depth.
inline void record_transmittance(const Scene& scene, const Settings& settings, const SampleRequest& request,
                                 const Ray& ray, PathSampler& sampler, Workspace& ws, PixelSample& out) {
    if (!(request.transmittance || request.majorant_depth) || !scene.features().media)
        return;
    scene.find_media(ray, kCameraRay, ws.shadow);
    if (request.majorant_depth)
        out.majorant_depth =
            majorant_optical_depth(ws.shadow, settings.majorant == Settings::Majorant::global);
    if (!request.transmittance)
        return;
    Rng rng = sampler.aside();  // so that asking for this pass does not change the others
    out.transmittance = estimate_transmittance(ws.shadow, settings, rng, ws.counters);
}

}  // namespace nephele
