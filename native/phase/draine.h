// SPDX-License-Identifier: GPL-3.0-or-later
// Draine's phase function (2003, "Scattering by Interstellar Dust Grains. I"): Henyey-Greenstein times
// 1 + alpha cos^2, normalised. alpha = 0 is Henyey-Greenstein, g = 0 with alpha = 1 Rayleigh, alpha = 1
// Cornette-Shanks.
//
// Its distribution is a quartic (Jendersie and d'Eon 2023 invert it in closed form, which in single precision
// breaks down near g = 0, alpha = 0 and |g| = 1). Here it is written without any cancellation, in
// e in [0, 2] with sqrt(1 + g^2 - 2 g cos) = 1 - g + g e, and inverted by Newton's method.
#pragma once

#include "math/transform.h"
#include "math/warp.h"

namespace nephele {

struct Draine {
    float g = 0;      ///< that of the Henyey-Greenstein factor, in (-1, 1)
    float alpha = 0;  ///< weight of cos^2, >= 0

    /// Density of scattering from wo to wi, 1/sr.
    float eval(Vec3f wo, Vec3f wi) const {
        const float k = std::fabs(g);
        const Vec3f chord = g > 0 ? wo + wi : wo - wi;
        const float d = sqr(1 - k) + k * dot(chord, chord);
        const float norm = 1 + alpha * (1 + 2 * k * k) / 3;
        return kInv4Pi * (1 - k) * (1 + k) / (d * std::sqrt(d)) * (1 + alpha * sqr(dot(wo, wi))) / norm;
    }

    Vec3f sample(Vec3f wo, Vec2f u) const {
        const float one_minus_c = invert(1 - double{u.x});
        return Frame(g < 0 ? wo : -wo).to_world(sample_cone({1, u.y}, std::min(one_minus_c, 2.0f)));
    }

    float mean_cosine() const {
        return g * (1 + alpha * (3 + 2 * g * g) / 5) / (1 + alpha * (1 + 2 * g * g) / 3);
    }

  private:
    /// 1 - cosine to the peak within which the fraction u scatters.
    float invert(double u) const {
        // t: the fraction of Henyey-Greenstein alone. In it the density is (1 + alpha c^2) / norm, which has
        // no narrow peak, whatever g is.
        const double k = std::fabs(double{g}), a = alpha, norm = 1 + a * (1 + 2 * k * k) / 3;
        double t = u, low = 0, high = 1, one_minus_c = 0;
        for (int step = 0; step < 60; ++step) {
            const double e = 2 * t * (1 - k) / ((1 + k) - 2 * t * k);
            one_minus_c = e * (1 - k + 0.5 * k * e);
            const double half = 1 - 0.5 * (1 - k) * e, c = 1 - one_minus_c;
            const double fraction = (t * (1 + a * half * half) + a * (1 - k * k) * e * e * e / 24) / norm;
            (fraction < u ? low : high) = t;
            double next = t - (fraction - u) * norm / (1 + a * c * c);
            if (!(next > low && next < high))
                next = 0.5 * (low + high);
            if (std::fabs(next - t) <= 1e-8 * t)
                break;
            t = next;
        }
        return static_cast<float>(one_minus_c);
    }
};

}  // namespace nephele
