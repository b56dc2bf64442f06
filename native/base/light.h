// SPDX-License-Identifier: GPL-3.0-or-later
// What a light is to the integrator. A light is anything that light sampling can aim at: lamps, emissive
// meshes, the world. Densities are per solid angle as seen from the receiving point.
#pragma once

#include <cstdint>

#include "math/vec.h"

namespace nephele {

/// Where light arrives: a point, when, and the number of the set of receivers that its object belongs to.
struct Receiver {
    Vec3f p;
    float time = 0;        ///< of the shutter, in [0, 1]
    std::uint8_t set = 0;  ///< see Linking

    Receiver(Vec3f point = {}, float at_time = 0, std::uint8_t of_set = 0)  // NOLINT: a point will do
        : p(point), time(at_time), set(of_set) {}
};

/// The sets of objects, as bits, that a light shines on and whose shadows it casts. Objects are in one set of
/// receivers and one of blockers; those that no light tells apart are in set 0.
struct Linking {
    static constexpr std::uint64_t kAll = ~std::uint64_t{0};
    std::uint64_t receivers = kAll, blockers = kAll;

    bool lights(std::uint8_t set) const { return ((receivers >> set) & 1) != 0; }
    bool plain() const { return receivers == kAll && blockers == kAll; }
};

/// Whether an object of this set of blockers is among `blockers`.
constexpr bool blocks(std::uint64_t blockers, std::uint8_t set) {
    return ((blockers >> set) & 1) != 0;
}

/// A direction towards a light, drawn at a receiving point.
struct LightSample {
    Vec3f wi;                    ///< unit, from the receiving point to the light
    float distance = kInfinity;  ///< m; infinity for sun and world
    Rgb Li;  ///< radiance (delta lights: radiance already multiplied so that Li / pdf is the irradiance's
             ///< integrand)
    float pdf = 0;       ///< solid angle, of this light alone (1 for delta lights)
    bool delta = false;  ///< no other technique can hit it: its MIS weight is 1
};

}  // namespace nephele
