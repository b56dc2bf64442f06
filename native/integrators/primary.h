// SPDX-License-Identifier: GPL-3.0-or-later
// What the passes want to know of a camera ray besides its radiance.
#pragma once

#include "integrators/integrator.h"
#include "tracking/transmittance.h"

namespace nephele {

/// Distance along the view axis, surface normal and albedo of the first surface that is not wholly
/// transparent.
inline void record_surface(const Scene& scene, const ShadingPoint& point, PixelSample& out, bool& recorded) {
    if (recorded)
        return;
    const Bsdf bsdf = make_bsdf(scene.program_of(point), point, scene.textures());
    if (min_component(bsdf.transparency) >= 1)
        return;
    recorded = true;
    out.depth = scene.camera().depth(point.p);
    out.normal = point.ns;
    out.albedo = bsdf.albedo(point.wo);
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
