// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/learned_guide.h"

#include <algorithm>
#include <cmath>
#include <iterator>

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

void add_means(RayMeans& means, const VspRecord& record, float share) {
    constexpr float kLargest = 1e6f;
    means.samples += share;
    means.transmittance += share * record.transmittance;
    means.volume_weight += share * record.volume_weight;
    means.surface_weight += share * record.surface_weight;
    if (!record.walked)
        return;
    means.depths += share;
    means.majorant_depth += share * std::min(record.majorant_depth, kLargest);
    if (record.weighed)
        return;
    means.walks += share;
    means.volume_square += share * std::min(record.volume_square, kLargest);
    means.surface_square += share * std::min(record.surface_square, kLargest);
    means.both += share * std::min(record.both, kLargest);
    means.extra_work += share * record.extra_work;
}

namespace {

constexpr float RayMeans::*kMeans[] = {
    &RayMeans::samples,        &RayMeans::transmittance, &RayMeans::majorant_depth, &RayMeans::volume_weight,
    &RayMeans::surface_weight, &RayMeans::walks,         &RayMeans::volume_square,  &RayMeans::surface_square,
    &RayMeans::both,           &RayMeans::extra_work,    &RayMeans::depths};

}  // namespace

bool sound(const RayMeans& means) {
    return std::all_of(std::begin(kMeans), std::end(kMeans), [&](float RayMeans::*member) {
        return std::isfinite(means.*member) && (means.*member >= 0 || member == &RayMeans::extra_work);
    });
}

void add_means(RayMeans& means, const RayMeans& others) {
    for (float RayMeans::*member : kMeans)
        means.*member += others.*member;
}

RayMeans thinned(RayMeans means, float share) {
    for (float RayMeans::*member : kMeans)
        means.*member *= share;
    return means;
}

float walk_share(const RayMeans& near, const Pooled& volume, const Pooled& surface, float trial) {
    constexpr float kEnough = 16;  // walks, that tell enough
    if (near.walks < kEnough || !(volume.known > 0.5f) || !(surface.known > 0.5f))
        return trial;
    const double n = double{near.samples}, walks = double{near.walks};
    const double V = double{near.volume_weight} / n, T = double{near.surface_weight} / n;
    const double v2 = double{volume.light} * double{volume.light} * (1 + double{volume.noise});
    const double s2 = double{surface.light} * double{surface.light} * (1 + double{surface.noise});
    const double mean = V * double{volume.light} + T * double{surface.light};
    const double decided = (v2 * double{near.volume_square} + s2 * double{near.surface_square} +
                            2 * std::sqrt(v2 * s2) * double{near.both}) /
                           walks;
    const double walk_variance = std::max(decided - mean * mean, 0.0);
    const double plain_variance = V * v2 + T * s2 - mean * mean;
    const double towards_volume = V * std::sqrt(v2), towards_surface = T * std::sqrt(s2);
    const double share = towards_volume / std::max(towards_volume + towards_surface, 1e-300);
    const double walk_work = share * double{volume.cost} + (1 - share) * double{surface.cost};
    const double plain_work =
        (1 - T) * double{volume.cost} + T * double{surface.cost} - double{near.extra_work} / walks;
    return walk_variance * walk_work < plain_variance * std::max(plain_work, 0.0) ? 1 : 0;
}

VspGuide learned_guide(const Settings& settings, const RayMeans& near, const Pooled& volume,
                       const Pooled& surface, float trial) {
    VspGuide guide;
    if (!(near.samples > 0))
        return guide;
    guide.transmittance = near.transmittance / near.samples;
    if (near.depths > 0)
        guide.majorant_depth = near.majorant_depth / near.depths;
    guide.surface_noise = surface.noise;
    guide.walk_share = walk_share(near, volume, surface, trial);
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
    // What was not seen yet may be there all the same. But where it passes for nearly certain, as behind thin
    // media, no more than half of the paths go there for that.
    constexpr float kFloor = 0.02f;
    const auto even = [](float others_weight, float weight) {
        return std::clamp(weight > 0 ? others_weight / weight : 1.0f, 1e-20f, 1.0f);
    };
    const auto least = [&](float other, float others_weight, float weight) {
        return other * std::min(even(others_weight, weight), kFloor);
    };
    if (!(v + s > 0)) {
        // Black so far: what is known to be gives way to what was not seen enough.
        if (surface.known > volume.known)
            guide.surface_radiance = even(near.volume_weight, near.surface_weight);
        if (volume.known > surface.known)
            guide.volume_radiance = even(near.surface_weight, near.volume_weight);
        return guide;
    }
    guide.volume_radiance = std::max(v, least(s, near.surface_weight, near.volume_weight)) / (v + s);
    guide.surface_radiance = std::max(s, least(v, near.volume_weight, near.surface_weight)) / (v + s);
    const float towards_volume = guide.volume_radiance * near.volume_weight;
    const float towards_surface = guide.surface_radiance * near.surface_weight;
    if (towards_volume + towards_surface > 0) {
        guide.target =
            std::clamp(towards_volume / (towards_volume + towards_surface), kLowestVsp, kHighestVsp);
    }
    return guide;
}

}  // namespace nephele
