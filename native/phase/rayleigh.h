// SPDX-License-Identifier: GPL-3.0-or-later
// Rayleigh phase function, 3 / (16 pi) (1 + cos^2): particles much smaller than the wavelength. Sampling
// inverts its cubic distribution (Frisvad 2011, "Importance sampling the Rayleigh phase function").
#pragma once

#include "math/transform.h"
#include "math/warp.h"

namespace nephele {

struct Rayleigh {
    /// Density of scattering from wo to wi, 1/sr.
    static float eval(Vec3f wo, Vec3f wi) { return 3 * kInv4Pi / 4 * (1 + sqr(dot(wo, wi))); }

    static Vec3f sample(Vec3f wo, Vec2f u) {
        // c^3 + 3 c = 2 q is solved by c = a - 1 / a, a^3 = q + sqrt(q^2 + 1); for |q|, so that nothing
        // cancels.
        const float q = 4 * u.x - 2, a = std::cbrt(std::fabs(q) + std::sqrt(q * q + 1));
        const float c = std::copysign(std::min(a - 1 / a, 1.0f), q);
        return Frame(-wo).to_world(spherical(c, u.y));
    }
};

}  // namespace nephele
