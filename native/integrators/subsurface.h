// SPDX-License-Identifier: GPL-3.0-or-later
// Subsurface scattering: a random walk through the homogeneous medium that a Subsurface lobe stands for,
// inside the closed mesh where light entered. The walk ends where it meets the mesh from within; there the
// light leaves as from a white diffuse surface, so that the rest of the path is like any other.
#pragma once

#include "integrators/integrator.h"
#include "surfaces/lobes.h"

namespace nephele {

/// The medium: extinction, 1/m, and the albedo that lets a flat half-space return the lobe's colour.
struct SubsurfaceMedium {
    Rgb sigma_t, albedo;
    float g = 0;

    explicit SubsurfaceMedium(const Subsurface& lobe);
};

/// Where light comes back. point: seen from outside. weight: share that is not absorbed, over the probability
/// of the walk.
struct Emergence {
    ShadingPoint point;
    Rgb weight;
};
/// Follows light that enters at `point` along wi. Returns nothing where it is absorbed.
std::optional<Emergence> walk_below(const Scene& scene, const ShadingPoint& point, const Subsurface& lobe,
                                    Vec3f wi, Rng& rng, Counters& counters);

}  // namespace nephele
