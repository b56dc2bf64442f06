// SPDX-License-Identifier: GPL-3.0-or-later
// How many branches go on from a vertex: Russian roulette below one, splitting above, so that the image's
// relative error falls fastest for the work (Rath, Grittmann, Herholz, Weier, Slusallek, SIGGRAPH 2022,
// "EARS: Efficiency-Aware Russian Roulette and Splitting", equation 12): a branch is worth its throughput
// times the root of (second moment of what it brings / its work), relative to the root of (variance / work)
// of the whole pixel; where it splits, the variance takes the second moment's place.
#pragma once

#include <optional>

#include "integrators/integrator.h"

namespace nephele {

/// Expected number of branches; nothing where too little is known. beta: mean throughput at the vertex.
inline std::optional<float> expected_branches(const SampleRequest& request, const FieldRegion* region,
                                              float beta) {
    constexpr float kFewest = 0.25f, kMost = 4;
    constexpr float kPatience = 1.25f;  // ending paths as soon as it pays on average costs some scenes much
    if (!request.use.roulette || !region || !(request.worth > 0))
        return std::nullopt;
    if (!(region->worth > 0))
        return std::nullopt;
    const float ended = kPatience * beta * region->worth / request.worth;
    const float split = beta * region->split_worth / request.worth;
    return std::clamp(ended, kFewest, std::clamp(split, 1.0f, kMost));
}

}  // namespace nephele
