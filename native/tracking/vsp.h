// SPDX-License-Identifier: GPL-3.0-or-later
// The volume scattering probability (VSP) of a segment: the probability that a path scatters in its volumes
// instead of passing to what is behind (Xu, Herholz, Manzi, Papas, Gross, SIGGRAPH Asia 2024, "Volume
// Scattering Probability Guiding"). Here is what was learned about it, and how a path decides by it.
#pragma once

#include <algorithm>
#include <cmath>

#include "math/vec.h"
#include "settings_table.h"

namespace nephele {

/// What a pixel has learned. Radiances are per unit of weight: of the volume's candidates, of what passes.
/// Without knowledge, delta tracking's probabilities come out.
struct VspGuide {
    float volume_radiance = 1;   ///< mean or root mean square, by the criterion; > 0
    float surface_radiance = 1;  ///< the same of what is behind; > 0
    float target = 0.5f;         ///< wanted probability of exact control, in [0.001, 0.999]
    float transmittance = 0.5f;  ///< mean along the pixel's rays
    float majorant_depth = 0;    ///< mean optical depth of the majorants; 0: unknown
    float surface_noise = 0;     ///< variance of the radiance behind, relative to its square
    float walk_share = 1;        ///< of the segments: to walk to their ends and resample; the others fly
};

inline constexpr float kLowestVsp = 0.001f, kHighestVsp = 0.999f;

/// Whether a guide that was read from a file keeps to what its members say.
inline bool sound(const VspGuide& g) {
    return g.volume_radiance >= 0 && std::isfinite(g.volume_radiance) && g.surface_radiance >= 0 &&
           std::isfinite(g.surface_radiance) && g.target >= kLowestVsp && g.target <= kHighestVsp &&
           std::isfinite(g.transmittance) && g.majorant_depth >= 0 && std::isfinite(g.majorant_depth) &&
           !std::isnan(g.surface_noise) && g.walk_share >= 0 && g.walk_share <= 1;
}

/// The sums that a decision is made by, of one segment.
struct VspWeights {
    float volume = 0;         ///< of the candidates' weights
    float surface = 0;        ///< mean over RGB of the throughput that passes
    float passing_share = 1;  ///< transmittance of this stream, in [0, 1]
    float empty = 0;          ///< probability that the stream has no candidate
};

/// Probability of scattering in the volume, design of both controls:
/// exact: target / (1 - empty), so that empty streams, which have to pass, are made up for; with
/// 1 - vsp_defensive of delta tracking's probability mixed in (Xu et al., section 5.2).
/// conditional: in proportion to what either branch brings by the learned radiances. Where the nested
/// estimates are free of noise the decision then adds no variance at all.
inline float volume_probability(const Settings& settings, const VspGuide& guide, const VspWeights& w) {
    if (!(w.volume > 0))
        return 0;
    if (!(w.surface > 0))
        return 1;
    if (settings.vsp_control == Settings::VspControl::exact) {
        const float guided = std::min(guide.target / (1 - w.empty), 1.0f);
        return std::clamp(
            settings.vsp_defensive * guided + (1 - settings.vsp_defensive) * (1 - w.passing_share), 0.0f,
            1.0f);
    }
    const double volume = double{guide.volume_radiance} * double{w.volume};
    const double surface = double{guide.surface_radiance} * double{w.surface};
    // Below 1, so that what passes keeps a chance.
    return std::min(static_cast<float>(volume / (volume + surface)), kOneMinusEpsilon);
}

/// Optical depth of candidates that lets a stream reach `target`: the probability of an empty stream becomes
/// (1 - target) / 2. At (1 - target) every stream with candidates would have to take the volume, and what
/// passes such a stream would be lost.
inline float depth_to_reach(float target) {
    return -std::log((1 - target) / 2);
}

/// Optical depth of candidates that conditional control raises the majorants to at most: more cost more
/// lookups than they save noise.
inline constexpr float kMostDepth = 4;

/// The least factor on majorants under conditional control. Tight majorants leave nothing to resample: either
/// a candidate takes all, or all passes. What matters behind is worth more candidates, which make the
/// transmittance less noisy, unless what is behind is noisier itself.
inline float least_scale(const VspGuide& guide) {
    constexpr float kRoom = 4;
    return 1 + kRoom * (1 - guide.target) / (1 + kRoom * guide.surface_noise);
}

/// What the majorants are multiplied by. depth: their optical depth along the segment.
inline float rate_scale(const Settings& settings, const VspGuide& guide, float depth) {
    if (settings.vsp_control == Settings::VspControl::exact) {
        // At twice the majorant no candidate is met for sure: there is always something that passes.
        constexpr float kRoom = 2;
        // Where there is next to nothing, as denormal densities are, no factor helps.
        constexpr float kLeastDepth = 1e-30f;
        return depth < kLeastDepth ? kRoom : std::max(kRoom, depth_to_reach(guide.target) / depth);
    }
    if (!(depth > 0))
        return 1;
    constexpr float kLargest = 1e6f;
    const float wanted = std::min(depth_to_reach(guide.target), kMostDepth) / depth;
    return std::min(std::max(wanted, least_scale(guide)), kLargest);
}

}  // namespace nephele
