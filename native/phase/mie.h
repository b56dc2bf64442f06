// SPDX-License-Identifier: GPL-3.0-or-later
// Approximate Mie scattering by water droplets (Jendersie and d'Eon 2023, "An Approximate Mie Scattering
// Function for Fog and Cloud Rendering"): a mixture of Henyey-Greenstein and Draine's phase function, whose
// four parameters are fits in the droplets' diameter.
#pragma once

#include "phase/draine.h"
#include "phase/henyey_greenstein.h"

namespace nephele {

struct Mie {
    HenyeyGreenstein narrow;
    Draine wide;
    float wide_share = 0;  ///< of the mixture, in [0, 1]

    /// diameter: micrometres, >= 0. The fits end at 50 and go on smoothly.
    static Mie make(double diameter);

    /// Density of scattering from wo to wi, 1/sr.
    float eval(Vec3f wo, Vec3f wi) const { return lerp(narrow.eval(wo, wi), wide.eval(wo, wi), wide_share); }

    Vec3f sample(Vec3f wo, Vec2f u) const {
        // u.x chooses the part and is stretched over it.
        const float s = wide_share;
        if (u.x < s)
            return wide.sample(wo, {std::min(u.x / s, kOneMinusEpsilon), u.y});
        return narrow.sample(wo, {std::min((u.x - s) / (1 - s), kOneMinusEpsilon), u.y});
    }

    float mean_cosine() const { return lerp(narrow.g, wide.mean_cosine(), wide_share); }
};

/// The fits, by equation number of the paper and its supplement.
inline Mie Mie::make(double d) {
    double g_narrow, g_wide, alpha = 250, share;
    const double l = std::log(d);
    if (d <= 0.1) {  // (11) to (14)
        g_narrow = 13.8 * d * d;
        g_wide = 1.1456 * d * std::sin(9.29044 * d);
        share = 0.252977 - 312.983 * std::pow(d, 4.3);
    } else if (d < 1.5) {  // (15) to (18)
        const double bend = std::cos((l - 0.238604) * (l + 1.00667) / (0.507522 - 0.15677 * l));
        g_narrow = 0.862 - 0.143 * l * l;
        g_wide = 0.379685 * std::cos(1.19692 * bend + 1.37932 * l + 0.0625835) + 0.344213;
        share = 0.146209 * std::cos(3.38707 * l + 2.11193) + 0.316072 + 0.0778917 * l;
    } else if (d < 5) {  // (19) to (22)
        const double ll = std::log(l);
        g_narrow = 0.0604931 * ll + 0.940256;
        g_wide = 0.500411 - 0.081287 / (-2 * l + std::tan(l) + 1.27551);
        alpha = 7.30354 * l + 6.31675;
        share = 0.026914 * (l - std::cos(5.68947 * (ll - 0.0292149))) + 0.376475;
    } else {  // (7) to (10)
        g_narrow = std::exp(-0.0990567 / (d - 1.67154));
        g_wide = std::exp(-2.20679 / (d + 3.91029) - 0.428934);
        alpha = std::exp(3.62489 - 8.29288 / (d + 5.52825));
        share = std::exp(-0.599085 / (d - 0.641583) - 0.665888);
    }
    const auto g = [](double x) { return static_cast<float>(std::clamp(x, -0.999, 0.999)); };
    return {{g(g_narrow)}, {g(g_wide), static_cast<float>(alpha)}, static_cast<float>(share)};
}

}  // namespace nephele
