// SPDX-License-Identifier: GPL-3.0-or-later
// An integrator answers one question: what does one random path through this pixel bring home? Two answer it
// here: `path` (path.cpp) with light sampling and multiple importance sampling, and its plain twin
// (plain.cpp), which the tests hold it against.
#pragma once

#include "base/field_sample.h"
#include "base/kernel_traits.h"
#include "film/film.h"
#include "film/mist.h"
#include "guiding/field.h"
#include "guiding/techniques.h"
#include "scene/scene.h"
#include "tracking/free_flight.h"
#include "tracking/vsp.h"

namespace nephele {

struct OpenSegment;  // integrators/path_state.h

/// Memory and counts of one render thread.
struct Workspace {
    TrackingScratch tracking;
    Segment segment, shadow;
    std::vector<OpenSegment> open;     ///< segments of the path so far; see PathRecord
    std::vector<FieldSample> lessons;  ///< what paths taught the field
    Trial trial{};
    Counters counters;
    SampleParts parts;  ///< of the last sample, where it was asked for
    std::uint64_t nonfinite_samples = 0;

    Workspace();
    ~Workspace();
};

/// What a sample computes besides the radiance: only what some pass asks for.
struct SampleRequest {
    bool transmittance = false;
    bool majorant_depth = false;
    bool features = false;      ///< depth, normal, albedo and the like of the first surface
    float opaque_alpha = 0.5f;  ///< a surface of less is not the first one
    bool vector = false;
    Vec2f film_size;  ///< of the whole frame, pixels
    const Mist* mist = nullptr;
    bool transparent_film = false;
    const VspGuide* guide = nullptr;      ///< of the pixel; none: camera rays are not guided
    const GuidingField* field = nullptr;  ///< of all later segments; none: they are not guided
    Techniques use;                       ///< of the field
    int set = 0;                          ///< number of `use` among those on trial
    bool teaches = false;                 ///< the path's vertices are lessons for the field
    std::uint64_t key = 0;                ///< number of the path among all, for lessons
    float worth = 0;  ///< mean radiance of the pixel times the image's relative noise per root of work: what
                      ///< a branch has to bring per root of its work (roulette.h); 0: unknown
};

/// Traces one path from the camera.
using SampleFunction = PixelSample (*)(const Scene&, const Settings&, const SampleRequest&,
                                       const Ray& camera_ray, PathSampler&, Workspace&);

/// An integrator's code, compiled for what it has to be able to do.
struct Kernel {
    SampleFunction sample;
    std::optional<KernelTraits> traits;  ///< none: the plain integrator

    /// What it can do, in words.
    std::vector<std::string> list() const;
};

/// The kernel for these settings and what the scene holds. learning: whether samples teach, or are guided.
/// parts: whether passes ask for SampleParts.
Kernel choose_kernel(const Settings& settings, const SceneFeatures& features, bool learning = true,
                     bool parts = false);

}  // namespace nephele
