// SPDX-License-Identifier: GPL-3.0-or-later
// The guiding field: von Mises-Fisher lobes, their mixtures and fits, and what is learned from samples.
#include "guiding/bounded.h"
#include "guiding/learned_guide.h"
#include "guiding/mixture_fit.h"
#include "guiding/vmf_mixture.h"
#include "stability.h"

namespace nephele::stability {
namespace {

std::vector<float> kappas() {
    return joined({0, 1e-40f, 0.9999e-6f, 1.0001e-6f, 0.0499f, 0.0501f}, logarithmic(1e-30, 1e5, 150));
}
Exact exact(float x) {
    return static_cast<Exact>(x);
}
Exact peak_of(Exact kappa) {
    return kappa == 0 ? 1 / (4 * kExactPi) : kappa / (2 * kExactPi * -std::expm1(-2 * kappa));
}
/// 1 - cosine, of the directions as they are.
Exact apart(Vec3f a, Vec3f b) {
    const Exact half = angle(Exact3(a), Exact3(b)) / 2;
    return 2 * std::sin(half) * std::sin(half);
}

TEST(StabilityGuiding, VmfPeak) {
    Worst worst({"guiding", "vmf.h", "von Mises-Fisher density on the axis",
                 "0 / 0 at kappa = 0, overflow of sinh(kappa)", "expm1; below 1e-6 the series",
                 "kappa 0 and 1e-40 to 1e5", "the density", 2e-7});
    for (const float kappa : kappas())
        worst.relative(double{vmf_peak(kappa)}, peak_of(exact(kappa)), {kappa});
}

TEST(StabilityGuiding, VmfDensity) {
    Worst worst({"guiding", "vmf.h", "von Mises-Fisher density",
                 "kappa (cos - 1) has no digits in a narrow lobe", "cos - 1 as half of the squared chord",
                 "kappa to 1e5; angles from 1e-7 to pi, densities to exp(-60)",
                 "the density, per unit of its exponent", 3e-7});
    for (const float kappa : kappas()) {
        for (const float theta : logarithmic(1e-7, kPi, 100)) {
            const Vec3f mu(0, 0, 1), w = at_angle(double{theta}, 0.7);
            const Exact exponent = exact(kappa) * apart(mu, w);
            if (exponent > 60)
                continue;
            const Exact want = peak_of(exact(kappa)) * std::exp(-exponent);
            worst.error((exact(vmf_pdf({mu, kappa}, w)) / want - 1) / (1 + exponent), {kappa, theta});
        }
    }
}

TEST(StabilityGuiding, VmfSample) {
    Worst worst({"guiding", "vmf.h", "von Mises-Fisher, inverted",
                 "log(u + (1 - u) exp(-2 kappa)) underflows; 1 - cos of narrow lobes",
                 "log1p and expm1 of cos - 1", "kappa to 1e5; u from 0 to 1 - 2^-24", "1, of the fraction",
                 5e-7});
    for (const float kappa : kappas()) {
        for (const float u : towards_both_ends(0x1p-24, 60)) {
            const Vec3f mu(0, 0, 1), w = vmf_sample({mu, kappa}, {u, 0.3f});
            const Exact k = exact(kappa), m = apart(mu, w);
            // u = 0 is on the axis; in the limit of kappa = 0 the fraction is m / 2.
            const Exact fraction = k < 1e-12L ? m / 2 : std::expm1(-k * m) / std::expm1(-2 * k);
            worst.error(fraction - exact(u), {kappa, u});
        }
    }
}

TEST(StabilityGuiding, VmfMeanCosine) {
    Worst worst({"guiding", "vmf.h", "mean cosine coth(kappa) - 1 / kappa",
                 "both terms are without bound at 0", "a series below 0.05, else in double",
                 "kappa 1e-30 to 1e5", "the cosine", 2e-7});
    for (const float kappa : joined({0.0499f, 0.0501f}, logarithmic(1e-30, 1e5, 2000))) {
        const Exact k = exact(kappa);
        const Exact want = k < 1e-3L ? k / 3 - k * k * k / 45 : 1 / std::tanh(k) - 1 / k;
        worst.relative(double{vmf_mean_cosine(kappa)}, want, {kappa});
    }
}

TEST(StabilityGuiding, VmfKappa) {
    Worst worst({"guiding", "vmf.h", "kappa of a mean cosine r", "the fit divides by 1 - r^2",
                 "two steps of Newton's method in double; 1 / (1 - r) from 50 on; at most 1e5",
                 "r from 1e-20 to 1 - 2^-16", "kappa", 3e-5});
    for (const float r : joined(logarithmic(1e-20, 0.5, 300), towards_both_ends(0x1p-16, 300))) {
        const Exact k = exact(vmf_kappa(r));
        // Newton's step from the answer: what kappa is off by.
        const Exact mean = k < 1e-3L ? k / 3 - k * k * k / 45 : 1 / std::tanh(k) - 1 / k;
        const Exact slope = k < 1e-3L ? 1.0L / 3 : 1 / (k * k) - 1 / (std::sinh(k) * std::sinh(k));
        worst.error((mean - exact(r)) / slope / k, {r});
    }
    EXPECT_EQ(vmf_kappa(1), kLargestKappa);
    EXPECT_EQ(vmf_kappa(0), 0);
}

TEST(StabilityGuiding, Exponential) {
    Worst worst({"guiding", "vmf_mixture.h", "exp(x) for x <= 0, in vector instructions",
                 "a denormal costs a hundred cycles", "halves of powers of two and a polynomial; 0 below -87",
                 "x from -87 to 0", "the value, per unit of 1 - x", 3e-7});
    for (const float x : joined({0, 1e-40f}, logarithmic(1e-30, 87, 20000)))
        worst.error((exact(exp_of_negative(-x)) / std::exp(-exact(x)) - 1) / (1 + exact(x)), {x});
    EXPECT_LT(exp_of_negative(-1e30f), 1e-37f);
    EXPECT_LT(exp_of_negative(-kInfinity), 1e-37f);
}

TEST(StabilityGuiding, Product) {
    Worst worst({"guiding", "vmf_mixture.cpp", "product of two lobes: its integral",
                 "|k1 mu1 + k2 mu2| - k1 - k2 cancels; overflow of exp(kappa)",
                 "the difference by the chord between the axes",
                 "kappas 1e-6 to 1e5, angles 1e-6 to pi, integrals to exp(-60)",
                 "the integral, per unit of its exponent", 1e-6});
    for (const float k1 : logarithmic(1e-6, 1e5, 12)) {
        for (const float k2 : logarithmic(1e-6, 1e5, 12)) {
            for (const float theta : logarithmic(1e-6, kPi, 40)) {
                const Vec3f a(0, 0, 1), b = at_angle(double{theta}, 0.7);
                VmfMixture one;
                one.set(3, 1, {a, k1}, 0);
                const auto product = one.times({b, k2});
                const Exact c = -2 * apart(a, b) * exact(k1) * exact(k2), sum = exact(k1) + exact(k2);
                const Exact k = std::sqrt(std::fmax(0.0L, sum * sum + c)), exponent = c / (k + sum);
                if (exponent < -60)
                    continue;
                const Exact want = peak_of(exact(k1)) * peak_of(exact(k2)) / peak_of(k) * std::exp(exponent);
                worst.error((exact(product.integral) / want - 1) / (1 - exponent), {k1, k2, theta});
            }
        }
    }
}

TEST(StabilityGuiding, MixtureIntegral) {
    Worst worst({"guiding", "vmf_mixture.h", "shares of the lobes in a density",
                 "all densities are 0 far from narrow lobes", "then the weights themselves",
                 "lobes of kappa 1 to 1e5, 20000 directions", "1, of the sum", 3e-7});
    Rng rng(1);
    for (int i = 0; i < 20000; ++i) {
        VmfMixture m;
        float total = 0;
        for (int k = 0; k < kMostLobes; ++k) {
            m.set(k, rng.next() + 1e-4f, {random_direction(rng), std::pow(10.0f, 5 * rng.next())}, 0);
            total += m.weight[static_cast<std::size_t>(k)];
        }
        for (float& w : m.weight)
            w /= total;
        Exact sum = 0;
        for (const float g : m.responsibilities(random_direction(rng)))
            sum += exact(g);
        worst.error(sum - 1, {double(i)});
    }
}

TEST(StabilityGuiding, Fit) {
    Worst worst({"guiding", "mixture_fit.cpp", "sum of a fitted mixture's weights, all finite",
                 "sums of heavy-tailed weights; one lobe takes all",
                 "single weights bounded and scaled to mean 1; priors for each lobe",
                 "64 to 4096 samples of weights 1e-30 to 1e30, all from one direction or all around", "1",
                 2e-7});
    Rng rng(2);
    for (const float scale : logarithmic(1e-30, 1e30, 13)) {
        for (const std::size_t n : {64u, 4096u}) {
            for (const bool narrow : {false, true}) {
                MixtureFit fit;
                VmfMixture mixture;
                for (int batch = 0; batch < 4; ++batch) {
                    std::vector<MixtureSample> samples;
                    for (std::size_t i = 0; i < n; ++i) {
                        const float heavy = scale / (rng.next() + 1e-6f);
                        samples.push_back({narrow ? Vec3f(0, 0, 1) : random_direction(rng), heavy, 0.1f});
                    }
                    fit.update(mixture, samples);
                    Exact sum = 0;
                    for (std::size_t k = 0; k < kMostLobes; ++k) {
                        EXPECT_TRUE(std::isfinite(mixture.kappa[k]) && std::isfinite(mixture.peak[k]))
                            << scale;
                        sum += exact(mixture.weight[k]);
                    }
                    worst.error(sum - 1, {scale, double(n), double(batch)});
                }
            }
        }
    }
}

TEST(StabilityGuiding, BoundedShares) {
    Worst worst({"guiding", "bounded.h", "largest share of a bounded sum",
                 "a firefly, infinity or NaN decides for all",
                 "what is not finite counts as 0; the sum in double",
                 "2 to 16384 values of 1e-38 to 1e38, some not finite",
                 "how far it exceeds a fiftieth, or two mean shares", 3e-2});
    Rng rng(3);
    for (const std::size_t n : {2u, 10u, 100u, 1000u, 16384u}) {
        for (int round = 0; round < 20; ++round) {
            std::vector<float> values;
            for (std::size_t i = 0; i < n; ++i)
                values.push_back(std::pow(10.0f, 76 * rng.next() - 38));
            values[0] = NAN;
            if (n > 2)
                values[1] = kInfinity;
            const double sum = bound_shares(values);
            Exact exactly = 0;
            for (const float v : values) {
                EXPECT_TRUE(std::isfinite(v));
                exactly += exact(v);
            }
            EXPECT_NEAR(static_cast<double>(exactly / static_cast<Exact>(sum)), 1, 1e-12);
            const double most = std::max(0.02, 2.0 / static_cast<double>(n));
            const double largest = double{*std::max_element(values.begin(), values.end())} / sum;
            worst.error(std::max(0.0, largest / most - 1), {double(n), double(round)});
        }
    }
}

TEST(StabilityGuiding, Moments) {
    Worst worst({"guiding", "pool.cpp", "relative variance of light (pooled_alone)",
                 "squares of dim or bright light are no floats; E x^2 - (E x)^2",
                 "samples bounded by 1e15, ratios in double; the sums are floats, since they only steer",
                 "radiance 1e-15 to 1e14, 65536 samples, relative variance 0.01 to 100",
                 "the second moment over the squared mean", 3e-3});
    Rng rng(4);
    for (const float scale : logarithmic(1e-15, 1e14, 16)) {
        for (const float spread : {0.1f, 1.0f, 10.0f}) {
            BranchSums sums;
            Exact first = 0, second = 0;
            for (int i = 0; i < 65536; ++i) {
                // Two values, whose variance is spread^2 of the squared mean.
                const float p = 1 / (1 + spread * spread), x = rng.next() < p ? scale : 0;
                sums.weight += 1;
                sums.taken += 1;
                add_light(sums, x, x * x);
                first += exact(x);
                second += exact(std::min(x, 1e15f)) * exact(x);
            }
            const float square = scale * scale;
            if (!(square < 1e15f) || square < 1e-30f)
                continue;
            const Exact want = second * 65536 / (first * first);
            worst.error((1 + exact(pooled_alone(sums).noise)) / want - 1, {scale, spread});
        }
    }
}

TEST(StabilityGuiding, LearnedGuide) {
    Worst worst({"guiding", "learned_guide.cpp", "radiances and target of a learned guide",
                 "0 / 0 where all is black, infinity per tiny weight",
                 "bounded by 1e30, divided by their sum, target in [0.001, 0.999]",
                 "lights 0 and 1e-38 to 1e38, noise to 1e30", "1, of their sum beyond the floor of 2 %",
                 5e-8});
    const Settings settings;
    for (const float v : joined({0}, logarithmic(1e-38, 1e38, 40))) {
        for (const float s : joined({0}, logarithmic(1e-38, 1e38, 40))) {
            for (const float noise : {0.0f, 1.0f, 1e30f}) {
                RayMeans means;
                means.samples = 4;
                means.transmittance = 2;
                means.volume_weight = means.surface_weight = 2;
                const VspGuide g = learned_guide(settings, means, {v, 1, 1, noise}, {s, 1, 1, noise}, 1);
                EXPECT_TRUE(g.target >= kLowestVsp && g.target <= kHighestVsp) << v << ' ' << s;
                EXPECT_TRUE(g.volume_radiance > 0 && g.surface_radiance > 0) << v << ' ' << s;
                const bool floored = std::min(g.volume_radiance, g.surface_radiance) <= 0.0201f;
                const double sum = double{g.volume_radiance} + double{g.surface_radiance};
                if (v > 0 || s > 0)
                    worst.error(floored ? std::max(0.0, sum - 1.02) : sum - 1, {v, s, noise});
            }
        }
    }
}

}  // namespace
}  // namespace nephele::stability
