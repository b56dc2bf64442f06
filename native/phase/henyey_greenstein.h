// SPDX-License-Identifier: GPL-3.0-or-later
// Henyey-Greenstein phase function (Henyey and Greenstein 1941), isotropic at g = 0. wo and wi both point
// away from the scattering point, so forward scattering is wi = -wo. Sampling is exact: pdf == eval.
#pragma once

#include "math/transform.h"
#include "math/warp.h"

namespace nephele {

struct HenyeyGreenstein {
    float g = 0;  ///< mean cosine of the scattering angle, in (-1, 1)

    /// Density of scattering from wo to wi, 1/sr.
    float eval(Vec3f wo, Vec3f wi) const {
        // 1 + g^2 - 2 |g| c in terms of the chord, 1 - c = |chord|^2 / 2: nothing cancels at a narrow peak.
        const float k = std::fabs(g);
        const Vec3f chord = g > 0 ? wo + wi : wo - wi;
        const float d = sqr(1 - k) + k * dot(chord, chord);
        return kInv4Pi * (1 - k) * (1 + k) / (d * std::sqrt(d));
    }

    Vec3f sample(Vec3f wo, Vec2f u) const {
        // The usual inversion, solved for 1 - c, c the cosine to the peak: exact at g = 0 and at narrow
        // peaks.
        const float k = std::fabs(g), v = (1 - k) + 2 * k * u.x;
        const float one_minus_c = sqr(1 - k) * (1 - u.x) * ((1 + k) / v + 1) / v;
        return Frame(g < 0 ? wo : -wo).to_world(sample_cone({1, u.y}, std::min(one_minus_c, 2.0f)));
    }
};

}  // namespace nephele
