// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/learned_guide.h"

#include <algorithm>
#include <cmath>

namespace nephele {

void add_branch(BranchSums& sums, float weight, bool taken, const VspRecord& record) {
    sums.weight += weight;
    if (!taken)
        return;
    sums.taken += 1;
    sums.cost += record.cost;
    if (weight > 0)
        add_light(sums, record.light, record.light * record.light * record.probability / weight);
}

VspGuide learned_guide(const Settings& settings, const RayMeans& near, const Pooled& volume,
                       const Pooled& surface) {
    VspGuide guide;
    if (!(near.samples > 0))
        return guide;
    guide.transmittance = near.transmittance / near.samples;
    guide.majorant_depth = near.majorant_depth / near.samples;
    guide.surface_noise = surface.noise;
    constexpr float kLargest = 1e30f;  // per tiny weights
    float v = std::min(volume.light, kLargest), s = std::min(surface.light, kLargest);
    if (settings.vsp_criterion == Settings::VspCriterion::variance) {
        v *= std::sqrt(1 + std::min(volume.noise, 1e6f));
        s *= std::sqrt(1 + std::min(surface.noise, 1e6f));
    }
    if (settings.vsp_cost && volume.cost > 0 && surface.cost > 0) {
        // The least variance times time: sqrt(M / c).
        v /= std::sqrt(volume.cost);
        s /= std::sqrt(surface.cost);
    }
    // What too few samples stand for is taken to be as the other branch: so paths part by transmittance, as
    // in delta tracking, until both are known.
    const float known_v = std::lerp(s, v, volume.known), known_s = std::lerp(v, s, surface.known);
    v = known_v;
    s = known_s;
    if (!(v + s > 0))
        return guide;  // black so far
    // What was not seen yet may be there all the same.
    constexpr float kFloor = 0.02f;
    const float least = kFloor * std::max(v, s);
    guide.volume_radiance = std::max(v, least) / (v + s);
    guide.surface_radiance = std::max(s, least) / (v + s);
    const float towards_volume = guide.volume_radiance * near.volume_weight;
    const float towards_surface = guide.surface_radiance * near.surface_weight;
    if (towards_volume + towards_surface > 0) {
        guide.target =
            std::clamp(towards_volume / (towards_volume + towards_surface), kLowestVsp, kHighestVsp);
    }
    return guide;
}

}  // namespace nephele
