// SPDX-License-Identifier: GPL-3.0-or-later
// An integrator answers one question: what does one random path through this pixel bring home? Two answer it
// here: `path` (path.cpp) with light sampling and multiple importance sampling, and its plain twin
// (plain.cpp), which the tests hold it against.
#pragma once

#include "film/film.h"
#include "scene/scene.h"
#include "tracking/free_flight.h"
#include "tracking/vsp.h"

namespace nephele {

/// Memory and counts of one render thread.
struct Workspace {
    TrackingScratch tracking;
    Segment segment, shadow;
    Counters counters;
    std::uint64_t nonfinite_samples = 0;
};

/// What a sample computes besides the radiance: only what some pass asks for.
struct SampleRequest {
    bool transmittance = false;
    bool majorant_depth = false;
    bool features = false;  ///< depth, normal, albedo, mist
    bool transparent_film = false;
    const VspGuide* guide = nullptr;  ///< of the pixel; none: camera rays are not guided
};

/// Traces one path from the camera.
using SampleFunction = PixelSample (*)(const Scene&, const Settings&, const SampleRequest&,
                                       const Ray& camera_ray, PathSampler&, Workspace&);

/// The kernel for these settings and what the scene holds.
SampleFunction choose_kernel(const Settings& settings, const SceneFeatures& features);

}  // namespace nephele
