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
    out.depth = scene.camera().to_camera(point.p).z;
    out.normal = point.ns;
    out.albedo = bsdf.albedo(point.wo);
}

/// Transmittance of the volumes on the primary ray, by its own estimate.
inline void record_transmittance(const Scene& scene, const Settings& settings, const SampleRequest& request,
                                 const Ray& ray, PathSampler& sampler, Workspace& ws, PixelSample& out) {
    if (!request.transmittance || !scene.features().media)
        return;
    scene.find_media(ray, kCameraRay, ws.shadow);
    Rng rng = sampler.aside();  // so that asking for this pass does not change the others
    out.transmittance = estimate_transmittance(ws.shadow, settings, rng, ws.counters);
}

}  // namespace nephele
