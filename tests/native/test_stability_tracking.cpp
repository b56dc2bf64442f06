// SPDX-License-Identifier: GPL-3.0-or-later
// Transmittance, free flights and the choice between volume and surface.
#include "media_fixtures.h"
#include "stability.h"
#include "tracking/constant_piece.h"
#include "tracking/nds.h"
#include "tracking/ray_marching.h"
#include "tracking/stream.h"

namespace nephele::stability {
namespace {

Exact exact(float x) {
    return static_cast<Exact>(x);
}

/// Extinctions and lengths whose product, the depth, goes from 1e-30 to 100.
template <class Visit>
void for_each_depth(Visit&& visit) {
    for (const float sigma : logarithmic(1e-15, 1e6, 22)) {
        for (const float depth : logarithmic(1e-30, 100, 200)) {
            const float length = depth / sigma;
            if (length > 1e-30f && length < 1e30f)
                visit(sigma, length);
        }
    }
}

TEST(StabilityTracking, Transmittance) {
    Worst worst({"tracking", "candidates.h", "transmittance exp(-sigma_t l)", "0 times an infinite length",
                 "channels of no extinction are 1", "depths 1e-30 to 80",
                 "the transmittance, per unit of 1 + depth", 1e-7});
    for_each_depth([&](float sigma, float length) {
        const Exact depth = exact(sigma) * exact(length);
        if (depth > 80)
            return;
        const Rgb T = homogeneous_transmittance(Rgb(sigma, 0, 1e-45f), length);
        worst.error((exact(T.x) / std::exp(-depth) - 1) / (1 + depth), {sigma, length});
        EXPECT_EQ(T.y, 1);
    });
    EXPECT_EQ(homogeneous_transmittance(Rgb(0, 1e-45f, 1), kInfinity), Rgb(1, 0, 0));
}

TEST(StabilityTracking, TransmittedLength) {
    Worst worst({"tracking", "constant_piece.h", "(1 - exp(-sigma_t l)) / sigma_t, and sigma_s times that",
                 "1 - exp(-x) cancels in thin media; 0 / 0", "expm1; below a depth of 1e-6 the series",
                 "depths 0 and 1e-30 to 100, infinite lengths, denormal sigma_t", "the value", 2e-7});
    for_each_depth([&](float sigma, float length) {
        const Exact s = exact(sigma), want = -std::expm1(-s * exact(length)) / s;
        worst.relative(double{transmitted_length(sigma, length)}, want, {sigma, length});
        worst.relative(double{scattered_share(sigma * 0.5f, sigma, length)}, exact(sigma * 0.5f) * want,
                       {sigma, length});
    });
    EXPECT_EQ(transmitted_length(0, 3), 3);
    EXPECT_EQ(scattered_share(1e-40f, 1e-40f, kInfinity), 1);
}

TEST(StabilityTracking, SampleConstant) {
    Worst worst({"tracking", "constant_piece.h", "distance in a piece of constant media, inverted",
                 "log(1 - u (1 - exp(-x))) has no digits in thin media",
                 "log1p and expm1; below 1e-6 uniform", "depths 1e-30 to 100, u from 0 to 1 - 2^-24",
                 "1, of the fraction within the distance", 3e-7});
    for_each_depth([&](float sigma, float length) {
        for (const float u : {0.0f, 1e-6f, 0.3f, 0.7f, 1 - 1e-5f, kOneMinusEpsilon}) {
            const float s = sample_constant(Rgb(sigma), length, Rgb(1), 0.2f, u);
            EXPECT_TRUE(s >= 0 && s <= length) << sigma << ' ' << length;
            const Exact k = exact(sigma);
            worst.error(std::expm1(-k * exact(s)) / std::expm1(-k * exact(length)) - exact(u),
                        {sigma, length, u});
        }
    });
}

/// A number of optical depth after another that has no pattern, but is the same each time.
class Depths {
  public:
    explicit Depths(float mean) : mean_(mean) {}
    float operator()() { return mean_ * rng_.next_exponential(); }

  private:
    float mean_;
    Rng rng_{5};
};

TEST(StabilityTracking, CandidatePlaces) {
    Worst worst({"tracking", "candidates.h", "place of the candidate after thousands of others",
                 "steps added to t are lost where they are shorter than its last place: too many candidates",
                 "depth counts from the piece's start, in double",
                 "t to 1e5 m, extinction to 1e7 / m, 20000 candidates",
                 "the distance gone, beyond one last place of t", 1e-6});
    for (const float start : {0.0f, 1.0f, 100.0f, 1e4f, 1e5f}) {
        for (const float sigma : logarithmic(1e-3, 1e7, 11)) {
            Depths ours(1), theirs(1);
            Exact gone = 0;
            float at = start;
            CandidateSteps steps(start, kInfinity, sigma, ours());
            for (int i = 0; i < 20000; ++i) {
                ASSERT_TRUE(steps.more());
                at = static_cast<float>(steps.at());
                steps.advance(ours());
                gone += exact(theirs()) / exact(sigma);
            }
            const Exact last_place = exact(std::nextafter(at, kInfinity)) - exact(at);
            const Exact off = std::fabs(exact(at) - exact(start) - gone);
            worst.error(std::fmax(0.0L, off - last_place) / gone, {start, sigma});
        }
    }
}

TEST(StabilityTracking, RatioProduct) {
    Worst worst({"tracking", "ratio.h", "product of 1 - sigma_t / majorant over a long walk",
                 "each factor rounds the same way: the errors add up",
                 "nothing; walks are as long as the majorants are deep",
                 "walks of 10000 candidates, sigma_t / majorant of 1e-7 to 1e-3", "the product", 7e-4});
    for (const float share : logarithmic(1e-7, 1e-3, 200)) {
        Rgb T(1);
        for (int i = 0; i < 10000; ++i)
            T *= max(Rgb(1) - Rgb(share), Rgb(0));
        worst.relative(double{T.x}, std::exp(10000 * std::log1p(-exact(share))), {share});
    }
}

TEST(StabilityTracking, TruncatedDepths) {
    Worst worst({"tracking", "nds.h", "truncated exponential of NDS, inverted",
                 "1 - exp(-x) of thin media; log(0)", "expm1 and log1p", "depths 1e-30 to 80",
                 "1, of the fraction within the depth", 1.5e-7});
    for (const float end : logarithmic(1e-30, 80, 2000)) {
        Rng rng(7), same(7);
        detail::TruncatedDepths depths(end, end * 0.5f, rng);
        const Exact u = exact(same.next()), tau = exact(depths());
        worst.error(std::expm1(-tau) / std::expm1(-exact(end)) - u, {end});
        EXPECT_TRUE(std::isfinite(depths.passing_weight())) << end;
    }
}

/// The mean over pivots of the truncated series, as its header states it, in long double.
Exact series_of(const double* x, int terms) {
    Exact sum = 0;
    for (int pivot = 0; pivot <= terms; ++pivot) {
        std::vector<Exact> e(static_cast<std::size_t>(terms) + 1, 0);
        e[0] = 1;
        for (int i = 0; i <= terms; ++i) {
            for (std::size_t k = static_cast<std::size_t>(terms); i != pivot && k > 0; --k)
                e[k] += e[k - 1] * (static_cast<Exact>(x[i]) - static_cast<Exact>(x[pivot]));
        }
        Exact series = 1, weight = 10, share = 1;
        for (int k = 1; k <= terms; ++k) {
            share /= terms - k + 1;
            weight /= k > 2 ? std::fmin(1.0L, 2.0L / static_cast<Exact>(k)) : 1;
            series += weight * share * e[static_cast<std::size_t>(k)];
        }
        sum += std::exp(static_cast<Exact>(x[pivot])) * series;
    }
    return sum / (terms + 1);
}

TEST(StabilityTracking, PowerSeries) {
    Worst worst(
        {"tracking", "ray_marching.h", "power series of unbiased ray marching",
         "sums of products of either sign", "elementary symmetric sums of differences, in double",
         "depths 1e-3 to 60, 2 to 12 terms (more have a chance below 4e-7), estimates 0.3 to 3 % apart",
         "the largest exp(X)", 1e-6});
    Rng rng(8);
    for (const float depth : logarithmic(1e-3, 60, 40)) {
        for (const int terms : {2, 3, 5, 9, 12}) {
            for (const double apart : {0.003, 0.01, 0.03}) {
                double x[detail::kMaxTerms + 1];
                double largest = -1e9;
                for (int i = 0; i <= terms; ++i) {
                    x[i] = -double{depth} * (1 + apart * (2 * double{rng.next()} - 1));
                    largest = std::max(largest, x[i]);
                }
                worst.scaled(detail::power_series(x, terms), series_of(x, terms),
                             std::exp(static_cast<Exact>(largest)), {depth, double(terms), apart});
            }
        }
    }
}

TEST(StabilityTracking, Equiangular) {
    Worst worst({"tracking", "light_estimate.h", "angle under which a light sees a part of the ray",
                 "a difference of arc tangents has no digits far from the light",
                 "the arc tangent of the difference's tangent, in double",
                 "lights 1e-6 to 1e4 m off the ray and 1e6 m along it, parts of 1e-3 to 1e5 m, infinite ones",
                 "the angle", 2e-7});
    Rng rng(9);
    for (int i = 0; i < 50000; ++i) {
        const LightView view{(2 * rng.next() - 1) * 1e6f * std::pow(10.0f, -6 * rng.next()),
                             std::pow(10.0f, 10 * rng.next() - 6)};
        const float a = 1e5f * rng.next(), b = a + std::pow(10.0f, 8 * rng.next() - 3);
        const Exact x = (exact(a) - exact(view.t)) / exact(view.distance),
                    across = (exact(b) - exact(a)) / exact(view.distance);
        const Exact y = x + across;
        if (b > a)
            worst.relative(double{view.between(a, b)}, std::atan2(across, 1 + x * y),
                           {view.t, view.distance, a, b});
        worst.relative(double{view.between(a, kInfinity)}, std::atan2(1.0L, x), {view.t, view.distance, a});
    }
}

TEST(StabilityTracking, EquiangularInverted) {
    Worst worst({"tracking", "light_estimate.h", "point whose direction is turned by an angle",
                 "the tangent of a sum of angles cancels far from the light",
                 "the addition theorem around the start, in double", "the same",
                 "1, of the angle between, beyond the last place of t", 2e-8});
    Rng rng(10);
    for (int i = 0; i < 50000; ++i) {
        const LightView view{(2 * rng.next() - 1) * 1e6f * std::pow(10.0f, -6 * rng.next()),
                             std::pow(10.0f, 10 * rng.next() - 6)};
        const float a = 1e5f * rng.next(), all = view.between(a, kInfinity),
                    turn = all * (0.01f + 0.98f * rng.next());
        const float t = view.turned(a, turn);
        if (!(t < 1e30f))
            continue;
        const auto direction = [&](Exact s) { return std::atan2(s - exact(view.t), exact(view.distance)); };
        const Exact x = (exact(a) - exact(view.t)) / exact(view.distance),
                    y = (exact(t) - exact(view.t)) / exact(view.distance);
        const Exact angle = std::atan2((exact(t) - exact(a)) / exact(view.distance), 1 + x * y);
        const Exact last_place =
            direction(exact(std::nextafter(t, kInfinity))) - direction(exact(std::nextafter(t, -kInfinity)));
        worst.error(std::fmax(0.0L, std::fabs(angle - exact(turn)) - last_place) / exact(all),
                    {view.t, view.distance, a, turn});
    }
}

TEST(StabilityTracking, VolumeProbability) {
    Worst worst({"tracking", "vsp.h", "probability of scattering, v V / (v V + s S)",
                 "products that are no floats; 0 / 0; a certainty that leaves no chance to what passes",
                 "in double, and below 1 where something passes", "radiances and weights 1e-38 to 1e38", "1",
                 1e-7});
    Settings settings;
    settings.vsp_control = Settings::VspControl::conditional;
    for (const float v : logarithmic(1e-38, 1e38, 25)) {
        for (const float V : logarithmic(1e-38, 1e38, 25)) {
            for (const float s : logarithmic(1e-38, 1e38, 25)) {
                VspGuide guide;
                guide.volume_radiance = v;
                guide.surface_radiance = s;
                for (const float S : {1e-38f, 1e-10f, 1.0f, 1e38f}) {
                    const float p = volume_probability(settings, guide, {V, S, 0.5f, 0});
                    const Exact volume = exact(v) * exact(V), surface = exact(s) * exact(S);
                    worst.error(exact(p) - volume / (volume + surface), {v, V, s, S});
                    EXPECT_TRUE(p >= 0 && p < 1);
                }
            }
        }
    }
    EXPECT_EQ(volume_probability(settings, {}, {0, 1, 1, 0}), 0);
    EXPECT_EQ(volume_probability(settings, {}, {1, 0, 0, 0}), 1);
}

TEST(StabilityTracking, RateScale) {
    Worst worst({"tracking", "vsp.h", "factor on the majorants that lets a stream reach its target",
                 "division by a vanishing depth",
                 "no factor helps below a depth of 1e-30; conditional control: at most 1e6",
                 "depths 0 and 1e-45 to 1e30, targets 0.001 to 0.999",
                 "the probability of an empty stream beyond (1 - target) / 2", 7e-8});
    for (const bool exactly : {true, false}) {
        Settings settings;
        settings.vsp_control = exactly ? Settings::VspControl::exact : Settings::VspControl::conditional;
        for (const float depth : joined({0, 1e-45f}, logarithmic(1e-38, 1e30, 200))) {
            for (const float target : {kLowestVsp, 0.3f, 0.9f, kHighestVsp}) {
                VspGuide guide;
                guide.target = target;
                const float scale = rate_scale(settings, guide, depth);
                EXPECT_TRUE(std::isfinite(scale) && scale >= 1) << depth << ' ' << target;
                if (exactly && depth >= 1e-30f) {
                    const Exact empty = std::exp(-exact(scale) * exact(depth));
                    worst.error(std::fmax(0.0L, empty - (1 - exact(target)) / 2), {depth, target});
                }
            }
        }
    }
}

TEST(StabilityTracking, ReservoirSum) {
    Worst worst({"tracking", "stream.h", "sum of a stream's weights", "small weights are lost beside the sum",
                 "the sum of a decaying series: what is lost is as small",
                 "10000 candidates, decays 1e-5 to 0.5 a candidate", "the sum", 3e-5});
    for (const float decay : logarithmic(1e-5, 0.5, 100)) {
        VspWeights weights;
        Exact want = 0;
        float T = 1;
        for (int i = 0; i < 10000; ++i) {
            const float weight = T * decay;
            weights.volume += weight;
            want += exact(weight);
            T *= 1 - decay;
        }
        worst.relative(double{weights.volume}, want, {decay});
    }
}

TEST(StabilityTracking, Chance) {
    Worst worst({"math", "sampler.h", "frequency of an event of probability p",
                 "a number of 24 bits is 0, and below any p, once in 2^24, and then weighs 1 / p",
                 "32 bits, and 24 more where they tie", "p from 1e-4 to 1 - 1e-4, 2^22 draws each",
                 "1, beyond 5.5 standard errors", 1e-9});
    for (const float p : {0.5f, 0.1f, 1e-3f, 1e-4f, 1 - 1e-4f}) {
        Rng rng(11);
        constexpr int kDraws = 1 << 22;
        int hits = 0;
        for (int i = 0; i < kDraws; ++i)
            hits += rng.chance(p);
        const double expected = kDraws * double{p}, error = std::sqrt(expected * (1 - double{p}));
        worst.error(std::max(0.0, std::fabs(hits - expected) - 5.5 * error) / kDraws, {p});
    }
    Rng rng(12);
    int tiny = 0;
    for (int i = 0; i < 20000000; ++i) {
        tiny += rng.chance(1e-12f);
        EXPECT_FALSE(rng.chance(0));
        EXPECT_TRUE(rng.chance(1));
    }
    EXPECT_EQ(tiny, 0);  // by 24 bits one would be expected
}

}  // namespace
}  // namespace nephele::stability
