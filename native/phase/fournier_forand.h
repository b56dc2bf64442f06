// SPDX-License-Identifier: GPL-3.0-or-later
// Fournier-Forand phase function (1994, in the form of Fournier and Jonasz 1999): particles in water, of
// sizes that follow a power law. With h = sin^2(theta / 2), delta = 4 h / (3 (n - 1)^2) and v = (3 - mu) / 2:
//   4 pi p = (v (1 - delta) - (1 - delta^v) + (delta (1 - delta^v) - v (1 - delta)) / h)
//            / ((1 - delta)^2 delta^v)  +  (delta_180^-v - 1) / (4 (delta_180 - 1)) (3 cos^2 - 1)
// As in Blender the parameters are n and the fraction B that is scattered backwards, which fixes v (Mobley,
// Sundman and Boss 2002): delta_90^-v = 1 + 2 B (delta_90 - 1).
//
// p grows without bound, as h^(-v - 1), in the forward direction. Within kCapH (0.01 degrees) it is replaced
// by its mean there. The distribution is inverted numerically; the density of samples is eval().
#pragma once

#include "math/transform.h"
#include "math/warp.h"

namespace nephele {

struct FournierForand {
    float scale = 0;  ///< delta / h
    float v = 0;      ///< in (-1, 0)
    float back = 0;   ///< (delta_180^-v - 1) / (delta_180 - 1)
    float cap = 0;    ///< fraction scattered within the cap

    static constexpr double kCapH = 1e-8;  ///< h of the cap's rim, 2e-4 rad

    /// ior > 1; backscatter in (0, 0.5).
    static FournierForand make(double ior, double backscatter) {
        const double k = 4 / (3 * (ior - 1) * (ior - 1)), d90 = 0.5 * k;
        // log(1 + 2 B x) / log(1 + x) and (k^-v - 1) / (k - 1) have limits where their denominators vanish.
        const double v = std::fabs(d90 - 1) < 1e-9 ? -2 * backscatter
                                                   : -std::log1p(2 * backscatter * (d90 - 1)) / std::log(d90);
        const double back = std::fabs(k - 1) < 1e-9 ? -v : std::expm1(-v * std::log(k)) / (k - 1);
        FournierForand out{static_cast<float>(k), static_cast<float>(v), static_cast<float>(back), 0};
        out.cap = static_cast<float>(out.at(kCapH).fraction);
        return out;
    }

    /// Density of scattering from wo to wi, 1/sr.
    float eval(Vec3f wo, Vec3f wi) const {
        const Vec3f chord = wo + wi;
        const double h = std::min(0.25 * double{dot(chord, chord)}, 1.0);
        return static_cast<float>((h < kCapH ? cap / kCapH : at(h).density) * double{kInv4Pi});
    }

    Vec3f sample(Vec3f wo, Vec2f u) const {
        const double h = invert(1 - double{u.x});
        return Frame(-wo).to_world(sample_cone({1, u.y}, static_cast<float>(std::min(2 * h, 2.0))));
    }

  private:
    struct Values {
        double density;   ///< 4 pi p, which is per unit of h
        double fraction;  ///< scattered within h
    };

    Values at(double h) const {
        const double delta = scale * h, x = delta - 1;
        // a, b: (v (1 - delta) - 1 + delta^v) and (delta (1 - delta^v) - v (1 - delta)), over (1 - delta)^2
        // c: (1 - delta^v) / (1 - delta)
        const double w = v, power_less_one = std::expm1(w * std::log(delta)), power = 1 + power_less_one;
        double a, b, c;
        if (std::fabs(x) < 1e-3) {
            c = w * (1 + (w - 1) / 2 * x * (1 + (w - 2) / 3 * x * (1 + (w - 3) / 4 * x)));
            a = w * (w - 1) / 2 * (1 + (w - 2) / 3 * x * (1 + (w - 3) / 4 * x));
            b = -w * (w + 1) / 2 * (1 + (w - 1) / 3 * x * (1 + (w - 2) / 4 * x));
        } else {
            c = power_less_one / x;
            a = (c - w) / x;
            b = -((1 + x) * c - w) / x;
        }
        const double cosine = 1 - 2 * h, sin2 = 4 * h * (1 - h);
        return {(a + b / h) / power + 0.25 * back * (3 * cosine * cosine - 1),
                (c * (1 - h) + power) / power + 0.125 * back * cosine * sin2};
    }

    /// h within which the fraction u scatters: Newton's method in log h, within a bracket.
    double invert(double u) const {
        if (u <= cap)
            return u / cap * kCapH;
        double low = std::log(kCapH), high = 0;
        // Near the forward direction the fraction is delta^-v.
        double x = std::clamp(-std::log(u) / v - std::log(double{scale}), low, high);
        for (int step = 0; step < 100; ++step) {
            const double h = std::exp(x);
            const Values values = at(h);
            (values.fraction < u ? low : high) = x;
            double next = x - (values.fraction - u) / (h * values.density);
            if (!(next > low && next < high))
                next = 0.5 * (low + high);
            if (std::fabs(next - x) <= 1e-9)
                break;
            x = next;
        }
        return std::exp(x);
    }
};

}  // namespace nephele
