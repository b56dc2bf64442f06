// SPDX-License-Identifier: GPL-3.0-or-later
// Phase functions. References use the angle between the very directions that the code is given, in long
// double; Fournier-Forand's, which cancels twice, 50 decimal digits.
#include <boost/multiprecision/cpp_bin_float.hpp>

#include "phase/phase_function.h"
#include "stability.h"

namespace nephele::stability {
namespace {

using Big = boost::multiprecision::cpp_bin_float_50;

/// Mean cosines from 1e-10 to 0.999 on either side, and 0.
std::vector<float> mean_cosines() {
    std::vector<float> out{0};
    for (const float g : joined(logarithmic(1e-10, 0.5, 20), {0.9f, 0.99f, 0.998f, 0.999f})) {
        out.push_back(g);
        out.push_back(-g);
    }
    return out;
}
/// Scattering angles from 1e-7 to pi.
std::vector<float> angles() {
    std::vector<float> out = logarithmic(1e-7, 1, 80);
    for (const float theta : logarithmic(1e-7, 2.2, 80))
        out.push_back(kPi - theta);
    return out;
}
/// 1 - cosine of the scattering angle (of forward scattering), of directions as they are.
Exact one_minus_cosine(Vec3f wo, Vec3f wi) {
    const Exact half = angle(Exact3(-wo), Exact3(wi)) / 2;
    return 2 * std::sin(half) * std::sin(half);
}

/// Henyey-Greenstein of the peak, k = |g|: density in terms of m = 1 - cosine to the peak, per unit of m.
Exact hg_density(Exact k, Exact m) {
    const Exact d = (1 - k) * (1 - k) + 2 * k * m;
    return (1 - k) * (1 + k) / (2 * d * std::sqrt(d));
}
/// Fraction scattered within m, and the m of a fraction.
Exact hg_fraction(Exact k, Exact m) {
    const Exact s = std::sqrt((1 - k) * (1 - k) + 2 * k * m);
    return (1 + k) * m / (s * (s + 1 - k));
}
Exact hg_inverse(Exact k, Exact t) {
    const Exact v = (1 + k) - 2 * k * t, e = 2 * t * (1 - k) / v;
    return e * (1 - k + k * e / 2);
}
Exact draine_norm(Exact k, Exact alpha) {
    return 1 + alpha * (1 + 2 * k * k) / 3;
}
/// Fraction that Draine's function scatters within m, by Simpson's rule in log(1 + 2 k m / (1 - k)^2), in
/// which the peak is wide; for k near 0 in m itself.
Exact draine_fraction(Exact k, Exact alpha, Exact m) {
    const bool peaked = k > 0.01L;
    const Exact scale = 2 * k / ((1 - k) * (1 - k)), end = peaked ? std::log1p(scale * m) : m;
    constexpr int kSteps = 1000;
    Exact sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const Exact y = end * i / kSteps, here = peaked ? std::expm1(y) / scale : y, c = 1 - here;
        const Exact weight = i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2;
        sum += weight * hg_density(k, here) * (1 + alpha * c * c) * (peaked ? std::exp(y) / scale : 1);
    }
    return sum * end / (3 * kSteps) / draine_norm(k, alpha);
}

/// All u that a sampler may be given, sparse in the middle.
std::vector<float> numbers() {
    std::vector<float> out{0, 0.5f, kOneMinusEpsilon};
    for (int i = 1; i < 64; ++i)
        out.push_back(static_cast<float>(i) / 64);
    for (int i = 1; i < 24; ++i) {
        out.push_back(std::ldexp(1.0f, -i));
        out.push_back(1 - std::ldexp(1.0f, -i));
    }
    return out;
}

const Vec3f kAxes[] = {{0, 0, 1}, {0, 0, -1}};

TEST(StabilityPhase, HenyeyGreenstein) {
    Worst worst({"phase", "henyey_greenstein.h", "Henyey-Greenstein, density",
                 "1 + g^2 - 2 g cos cancels at a narrow peak", "(1 - g)^2 + g |chord|^2",
                 "g from 0 and 1e-10 to 0.999, either sign; angles from 1e-7 to pi", "the density", 5e-7});
    for (const float g : mean_cosines()) {
        for (const float theta : angles()) {
            const Vec3f wo(0, 0, -1), wi = at_angle(double{theta}, 0.7);
            const Exact forward = one_minus_cosine(wo, wi), k = std::fabs(static_cast<Exact>(g));
            const Exact m = g < 0 ? 2 - forward : forward;
            worst.relative(double{HenyeyGreenstein{g}.eval(wo, wi)}, hg_density(k, m) / (2 * kExactPi),
                           {g, theta});
        }
    }
}

TEST(StabilityPhase, HenyeyGreensteinSample) {
    Worst worst({"phase", "henyey_greenstein.h", "Henyey-Greenstein, inverted",
                 "the usual inversion divides by g and squares a difference near |g| = 1",
                 "solved for 1 - cosine to the peak", "the same g; u from 0 to 1 - 2^-24",
                 "1, of the fraction scattered within the angle", 3e-7});
    for (const float g : mean_cosines()) {
        for (const float u : numbers()) {
            for (const Vec3f wo : kAxes) {
                const Vec3f wi = HenyeyGreenstein{g}.sample(wo, {u, 0.3f});
                const Exact forward = one_minus_cosine(wo, wi), k = std::fabs(static_cast<Exact>(g));
                const Exact m = g < 0 ? one_minus_cosine(-wo, wi) : forward;
                worst.error(hg_fraction(k, m) - (1 - static_cast<Exact>(u)), {g, u});
            }
        }
    }
}

TEST(StabilityPhase, Draine) {
    Worst worst({"phase", "draine.h", "Draine, density", "as Henyey-Greenstein", "the same",
                 "the same, alpha from 0 and 1e-10 to 1e4", "the density", 7e-7});
    for (const float alpha : joined({0}, logarithmic(1e-10, 1e4, 8))) {
        for (const float g : mean_cosines()) {
            for (const float theta : angles()) {
                const Vec3f wo(0, 0, -1), wi = at_angle(double{theta}, 0.7);
                const Exact forward = one_minus_cosine(wo, wi), k = std::fabs(static_cast<Exact>(g));
                const Exact m = g < 0 ? 2 - forward : forward, c = 1 - m, a = static_cast<Exact>(alpha);
                const Exact want = hg_density(k, m) * (1 + a * c * c) / draine_norm(k, a) / (2 * kExactPi);
                // At right angles cos^2 has only the digits that the directions have.
                const Exact directions = 1e-7L * a * std::fabs(c) / (1 + a * c * c);
                worst.error(
                    std::fmax(0.0L, std::fabs(static_cast<Exact>(Draine{g, alpha}.eval(wo, wi)) / want - 1) -
                                        directions),
                    {g, alpha, theta});
            }
        }
    }
}

TEST(StabilityPhase, DraineSample) {
    Worst worst({"phase", "draine.h", "Draine, inverted",
                 "the quartic's closed form has no digits near g = 0, alpha = 0 and |g| = 1",
                 "Newton's method in Henyey-Greenstein's fraction, where the density has no peak; in double",
                 "the same; u from 0 to 1 - 2^-24", "1, of the fraction", 1.5e-7});
    for (const float alpha : {0.0f, 1e-8f, 1e-3f, 1.0f, 250.0f, 1e4f}) {
        for (const float g : mean_cosines()) {
            for (const float u :
                 {0.0f, 1e-6f, 0.01f, 0.25f, 0.5f, 0.77f, 0.99f, 1 - 1e-6f, kOneMinusEpsilon}) {
                const Vec3f wo(0, 0, 1), wi = Draine{g, alpha}.sample(wo, {u, 0.3f});
                const Exact m = g < 0 ? one_minus_cosine(-wo, wi) : one_minus_cosine(wo, wi);
                const Exact k = std::fabs(static_cast<Exact>(g)), a = static_cast<Exact>(alpha);
                worst.error(draine_fraction(k, a, m) - (1 - static_cast<Exact>(u)), {g, alpha, u});
            }
        }
    }
}

TEST(StabilityPhase, Rayleigh) {
    Worst worst({"phase", "rayleigh.h", "Rayleigh, inverted", "Cardano's two cube roots cancel at cos = 0",
                 "one root a of |q|, the other is -1 / a", "u from 0 to 1 - 2^-24", "1, of the fraction",
                 2e-7});
    for (const float u : numbers()) {
        for (const Vec3f wo : kAxes) {
            const Vec3f wi = Rayleigh::sample(wo, {u, 0.3f});
            const Exact m = one_minus_cosine(wo, wi), c = 1 - m;
            worst.error((c * c * c + 3 * c + 4) / 8 - static_cast<Exact>(u), {u});
        }
    }
}

/// Fournier-Forand as its header states it, and the fraction within h, of the object's own parameters.
Big big(float x) {
    return Big(static_cast<double>(x));
}
Big fournier_forand(const FournierForand& f, Big h) {
    const Big d = big(f.scale) * h, v = big(f.v), power = pow(d, v), one(1), c = 1 - 2 * h;
    return (v * (one - d) - (one - power) + (d * (one - power) - v * (one - d)) / h) /
               ((one - d) * (one - d) * power) +
           big(f.back) / 4 * (3 * c * c - 1);
}
Big fournier_forand_fraction(const FournierForand& f, Big h) {
    const Big d = big(f.scale) * h, v = big(f.v), power = pow(d, v), c = 1 - 2 * h;
    return ((1 - power) * (1 - h) / (1 - d) + power) / power + big(f.back) / 8 * c * 4 * h * (1 - h);
}

/// Indices and backscatter fractions at the ends of their ranges and at those of real waters.
std::vector<FournierForand> waters() {
    std::vector<FournierForand> out;
    for (const double ior : {1.001, 1.01, 1.1, 1.2, 1.7, 2.1547005, 2.6329932, 4.0, 10.0}) {
        for (const double back : {1e-6, 1e-3, 0.0183, 0.2, 0.499})
            out.push_back(FournierForand::make(ior, back));
    }
    return out;
}

TEST(StabilityPhase, FournierForand) {
    Worst worst({"phase", "fournier_forand.h", "Fournier-Forand, density",
                 "(1 - delta)^2 in the denominator vanishes with the numerator",
                 "a series within 1e-3 of delta = 1; double",
                 "ior 1.001 to 10, backscatter 1e-6 to 0.499; angles from 3e-4 to pi", "the density", 5e-7});
    for (const FournierForand& f : waters()) {
        std::vector<float> thetas = logarithmic(3e-4, kPi, 100);
        for (const double near : {-0.1, -1.1e-3, -0.9e-3, -1e-6, 1e-7, 1e-4, 0.99e-3, 1.01e-3, 0.1}) {
            const double h = (1 + near) / double{f.scale};
            if (h > 1e-7 && h < 1)
                thetas.push_back(static_cast<float>(2 * std::asin(std::sqrt(h))));
        }
        for (const float theta : thetas) {
            const Vec3f wo(0, 0, -1), wi = at_angle(double{theta}, 0.7);
            const Big h = Big(one_minus_cosine(wo, wi)) / 2,
                      want = fournier_forand(f, h) / (4 * Big(kExactPi));
            worst.relative(double{f.eval(wo, wi)}, want.convert_to<Exact>(), {f.scale, f.v, theta});
        }
    }
}

TEST(StabilityPhase, FournierForandSample) {
    Worst worst({"phase", "fournier_forand.h", "Fournier-Forand, inverted",
                 "the forward peak is without bound; h there is no float beside 1",
                 "Newton's method in log h, in double; within 0.01 degrees the mean",
                 "the same; u from 1e-6 to 1 - 2^-24", "1, of the fraction", 1.5e-7});
    for (const FournierForand& f : waters()) {
        for (const float u : {1e-6f, 0.01f, 0.25f, 0.5f, 0.77f, 0.99f, 1 - 1e-6f, kOneMinusEpsilon}) {
            const Vec3f wo(0, 0, -1), wi = f.sample(wo, {u, 0.3f});
            const Big h = Big(one_minus_cosine(wo, wi)) / 2;
            const Big cap(FournierForand::kCapH);
            const Big fraction =
                h < cap ? h / cap * fournier_forand_fraction(f, cap) : fournier_forand_fraction(f, h);
            worst.error(fraction.convert_to<Exact>() - (1 - static_cast<Exact>(u)), {f.scale, f.v, u});
        }
    }
}

TEST(StabilityPhase, Mie) {
    Worst worst({"phase", "mie.h",
                 "Mie's fits: share of the wide part in [0, 1], |g| < 1, density that integrates to 1",
                 "logarithms of the diameter at 0; poles between the fits", "the fits end at 0.1 um; double",
                 "diameters 0 and 1e-30 to 1e9 um", "1, of the integral", 5e-5});
    for (const float d : joined({0, 0.1f, 1.5f, 4.8104f, 4.8105f, 5, 50}, logarithmic(1e-30, 1e9, 300))) {
        const Mie m = Mie::make(double{d});
        EXPECT_TRUE(m.wide_share >= 0 && m.wide_share <= 1) << d;
        EXPECT_TRUE(std::fabs(m.narrow.g) < 1 && std::fabs(m.wide.g) < 1 && m.wide.alpha >= 0) << d;
        // In the fraction of the narrow part the rest is smooth.
        Exact sum = 0;
        constexpr int kSteps = 4000;
        const Exact k = std::fabs(static_cast<Exact>(m.narrow.g)),
                    w = std::fabs(static_cast<Exact>(m.wide.g));
        const auto share = static_cast<Exact>(m.wide_share);
        for (int i = 0; i < kSteps; ++i) {
            // Both parts by strata of their own fractions.
            const Exact t = (i + 0.5L) / kSteps;
            for (const Exact forward : {hg_inverse(k, t), hg_inverse(w, t)}) {
                const bool narrow = forward == hg_inverse(k, t);
                const double theta =
                    static_cast<double>(2 * std::asin(std::sqrt(std::fmin(forward / 2, 1.0L))));
                const bool back = narrow ? m.narrow.g < 0 : m.wide.g < 0;
                const Vec3f wo(0, 0, -1), wi = at_angle(back ? M_PI - theta : theta, 0.7);
                const Exact f = one_minus_cosine(wo, wi), fn = m.narrow.g < 0 ? 2 - f : f,
                            fw = m.wide.g < 0 ? 2 - f : f;
                const Exact one = hg_density(k, fn), other = hg_density(w, fw);
                // Balance heuristic: each draws half of the points.
                sum += 2 * kExactPi * static_cast<Exact>(m.eval(wo, wi)) / (one + other) / kSteps;
            }
        }
        worst.error(sum - 1, {d, double(share)});
    }
}

}  // namespace
}  // namespace nephele::stability
