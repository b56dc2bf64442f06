// SPDX-License-Identifier: GPL-3.0-or-later
// Fitting of mixtures: known ones are found again, fireflies and useless samples do no harm, and long runs
// stay sound.
#include "guiding/mixture_fit.h"

#include <gtest/gtest.h>

#include <limits>

#include "math/sampler.h"
#include "math/warp.h"

namespace nephele::test {
namespace {

struct Lobe {
    float weight;
    Vec3f towards;
    float kappa;
};

VmfMixture mixture_of(const std::vector<Lobe>& lobes) {
    VmfMixture out;
    int k = 0;
    for (const Lobe& lobe : lobes)
        out.set(k++, lobe.weight, {normalize(lobe.towards), lobe.kappa}, 0);
    return out;
}
int lobes_of(const VmfMixture& m) {
    int n = 0;
    for (const float w : m.weight)
        n += w > 0 ? 1 : 0;
    return n;
}
double total(const VmfMixture& m) {
    double sum = 0;
    for (const float w : m.weight)
        sum += double{w};
    return sum;
}
bool is_sound(const VmfMixture& m) {
    bool finite = true;
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        for (const float v :
             {m.weight[k], m.kappa[k], m.peak[k], m.inverse_distance[k], m.mu_x[k], m.mu_y[k], m.mu_z[k]})
            finite = finite && std::isfinite(v);
        finite = finite && m.weight[k] >= 0 && m.kappa[k] >= 0 && m.kappa[k] <= kLargestKappa;
    }
    return finite && std::fabs(total(m) - 1) < 1e-5;
}
bool same(const VmfMixture& a, const VmfMixture& b) {
    return a.weight == b.weight && a.mu_x == b.mu_x && a.mu_y == b.mu_y && a.mu_z == b.mu_z &&
           a.kappa == b.kappa && a.inverse_distance == b.inverse_distance;
}

/// Kullback-Leibler divergence of a fit from the light, in nats, by quadrature.
double divergence(const VmfMixture& light, const VmfMixture& fit) {
    constexpr int kRows = 200;
    double sum = 0;
    for (int i = 0; i < kRows; ++i) {
        for (int j = 0; j < 2 * kRows; ++j) {
            const Vec3f w = spherical(static_cast<float>((i + 0.5) / kRows * 2 - 1),
                                      static_cast<float>((j + 0.5) / kRows / 2));
            const double p = double{light.pdf(w)}, q = double{fit.pdf(w)};
            if (p > 1e-12)
                sum += p * std::log(p / std::max(q, 1e-30));
        }
    }
    return sum * 2 * M_PI / kRows / kRows;
}

/// Samples of this light that are drawn uniformly over the sphere.
std::vector<MixtureSample> samples_of(const VmfMixture& light, int n, Rng& rng, float scale = 1) {
    std::vector<MixtureSample> out;
    for (int i = 0; i < n; ++i) {
        const Vec3f w = sample_sphere(rng.next2());
        out.push_back({w, light.pdf(w) * scale, 0});
    }
    return out;
}
VmfMixture fitted(const VmfMixture& light, int batches, int n, std::uint64_t seed, float scale = 1) {
    Rng rng(seed);
    VmfMixture mixture;
    MixtureFit fit;
    for (int i = 0; i < batches; ++i) {
        auto samples = samples_of(light, n, rng, scale);
        fit.update(mixture, samples);
    }
    return mixture;
}

const VmfMixture kOneWide = mixture_of({{1, {1, 2, 3}, 2}}),
                 kOneNarrow = mixture_of({{1, {1, -2, 0.4f}, 100}});
const VmfMixture kTwo = mixture_of({{0.6f, {1, 0, 0}, 60}, {0.4f, {-1, 0.5f, 0}, 3}});
const VmfMixture kFour = mixture_of(
    {{0.3f, {1, 0, 0.2f}, 80}, {0.3f, {0, 1, 0}, 8}, {0.2f, {0, 0, -1}, 30}, {0.2f, {-1, -1, 1}, 1}});

// Over 10 other seeds the divergences stay below half of these bounds: false alarms well below 1 in 100. A
// narrow light that samples find by chance alone is found blurred: ten samples of a batch bring all of it,
// and no sample may bring more than a fiftieth.
TEST(MixtureFit, FindsKnownMixtures) {
    struct Case {
        const VmfMixture& light;
        double one, many;  // batches
    };
    for (const Case& c : {Case{kOneWide, 0.005, 0.005}, Case{kOneNarrow, 0.04, 0.8}, Case{kTwo, 0.02, 0.06},
                          Case{kFour, 0.02, 0.02}}) {
        EXPECT_LT(divergence(c.light, fitted(c.light, 1, 20000, 859)), c.one);
        EXPECT_LT(divergence(c.light, fitted(c.light, 10, 2000, 859)), c.many);
    }
}

// False alarms: as above.
TEST(MixtureFit, FindsNarrowLightsByItsOwnSamples) {
    for (const VmfMixture* light : {&kOneWide, &kOneNarrow, &kTwo, &kFour}) {
        Rng rng(857);
        VmfMixture mixture;
        MixtureFit fit;
        for (int i = 0; i < 10; ++i) {
            std::vector<MixtureSample> samples;
            for (int j = 0; j < 2000; ++j) {
                const bool guided = i > 0 && rng.next() < 0.5f;
                const float choice = rng.next();
                const Vec3f w = guided ? mixture.sample(choice, rng.next2()) : sample_sphere(rng.next2());
                samples.push_back(
                    {w, light->pdf(w) / (i > 0 ? 0.5f * (mixture.pdf(w) + kInv4Pi) : kInv4Pi), 0});
            }
            fit.update(mixture, samples);
        }
        EXPECT_LT(divergence(*light, mixture), 0.04);
    }
}

TEST(MixtureFit, ScaleOfTheLightDoesNotMatter) {
    const VmfMixture mixture = fitted(kTwo, 10, 2000, 863);
    for (const float scale : {0x1p-60f, 0x1p40f})
        EXPECT_LT(divergence(mixture, fitted(kTwo, 10, 2000, 863, scale)), 1e-6) << scale;
}

TEST(MixtureFit, LightTooFaintToInvertIsFitted) {
    // The mean of these weights is so small that its inverse is no float.
    const VmfMixture mixture = fitted(kTwo, 10, 2000, 863, 0x1p-140f);
    ASSERT_TRUE(is_sound(mixture));
    EXPECT_LT(divergence(kTwo, mixture), 0.06);
}

TEST(MixtureFit, LobesThatSayTheSameBecomeOne) {
    // Eight lobes start, at the corners of a cube; few are left of light that comes in a single lobe.
    EXPECT_LE(lobes_of(fitted(kOneNarrow, 10, 4000, 877)), 4);
    EXPECT_LE(lobes_of(fitted(mixture_of({{1, {0, 0, 1}, 50}}), 10, 4000, 877)), 4);
}

TEST(MixtureFit, LobesArePartedAndThatHelps) {
    // First a narrow light, so that most lobes are merged away; then two beside each other.
    const VmfMixture one = mixture_of({{1, {0, 0, 1}, 50}});
    const VmfMixture two = mixture_of({{0.5f, {0.5f, 0, 1}, 60}, {0.5f, {-0.5f, 0, 1}, 60}});
    Rng rng(881);
    VmfMixture mixture;
    MixtureFit fit;
    for (int i = 0; i < 4; ++i) {
        auto samples = samples_of(one, 4000, rng);
        fit.update(mixture, samples);
    }
    const int before = lobes_of(mixture);
    const double far = divergence(two, mixture);
    int most = before;
    for (int i = 0; i < 30; ++i) {
        auto samples = samples_of(two, 4000, rng);
        fit.update(mixture, samples);
        most = std::max(most, lobes_of(mixture));
    }
    EXPECT_GT(most, before);
    EXPECT_LT(divergence(two, mixture), 0.05 * far);
}

TEST(MixtureFit, AFireflyDoesNotRuinTheFit) {
    Rng rng(883);
    VmfMixture mixture;
    MixtureFit fit;
    for (int i = 0; i < 10; ++i) {
        auto samples = samples_of(kTwo, 2000, rng);
        if (i == 4 || i == 9)
            samples[1000] = {{0, 0, -1}, 1e6f, 0};
        fit.update(mixture, samples);
    }
    EXPECT_LT(divergence(kTwo, mixture), 0.06);
}

TEST(MixtureFit, WithoutLightNothingChanges) {
    const VmfMixture before = fitted(kTwo, 1, 2000, 887);
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    for (const bool fresh : {false, true}) {
        VmfMixture mixture;
        MixtureFit fit;
        if (!fresh) {
            Rng rng(887);
            auto samples = samples_of(kTwo, 2000, rng);
            fit.update(mixture, samples);
        }
        const VmfMixture expected = mixture;
        const float known = fit.samples();
        fit.update(mixture, {});
        for (const MixtureSample& useless :
             {MixtureSample{{0, 0, 1}, 0, 0}, MixtureSample{{0, 0, 1}, kNan, 0},
              MixtureSample{{0, 0, 1}, kInfinity, 0}, MixtureSample{{0, 0, 1}, -1, 0},
              MixtureSample{{kNan, 0, 1}, 1, 0}}) {
            std::vector<MixtureSample> samples(10, useless);
            fit.update(mixture, samples);
            EXPECT_TRUE(same(mixture, expected));
            EXPECT_EQ(fit.samples(), known);
        }
    }
    EXPECT_TRUE(is_sound(before));
}

TEST(MixtureFit, UselessSamplesAmongOthersDoNoHarm) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    Rng rng(907);
    VmfMixture mixture;
    MixtureFit fit;
    for (int i = 0; i < 10; ++i) {
        auto samples = samples_of(kTwo, 2000, rng);
        samples[3].weight = kNan;
        samples[30].weight = kInfinity;
        samples[300].weight = -1e6f;
        samples[400].wi = {kNan, 0, 0};
        samples[500].wi = {kInfinity, 0, 0};
        samples[600] = {{0, 0, 1}, 1e-42f, 0};
        fit.update(mixture, samples);
        ASSERT_TRUE(is_sound(mixture));
    }
    EXPECT_LT(divergence(kTwo, mixture), 0.06);
}

TEST(MixtureFit, FewSamplesGiveWideLobes) {
    for (const int n : {1, 2, 3}) {
        VmfMixture mixture;
        MixtureFit fit;
        std::vector<MixtureSample> samples(static_cast<std::size_t>(n), {{0, 0, 1}, 5, 0});
        fit.update(mixture, samples);
        ASSERT_TRUE(is_sound(mixture));
        EXPECT_GT(mixture.pdf({0, 0, 1}), mixture.pdf({0, 0, -1}));
        EXPECT_GT(mixture.pdf({0, 0, -1}), 0.01f * kInv4Pi) << "nothing is ruled out yet";
        for (const float kappa : mixture.kappa)
            EXPECT_LT(kappa, 10);
    }
}

TEST(MixtureFit, AlwaysTheSame) {
    EXPECT_TRUE(same(fitted(kFour, 10, 2000, 911), fitted(kFour, 10, 2000, 911)));
}

TEST(MixtureFit, DoesNotDrift) {
    Rng rng(919);
    VmfMixture mixture;
    MixtureFit fit;
    double early = 0;
    for (int i = 0; i < 1000; ++i) {
        auto samples = samples_of(kFour, 500, rng);  // of which few find the narrow lobe
        fit.update(mixture, samples);
        ASSERT_TRUE(is_sound(mixture)) << i;
        ASSERT_LE(fit.samples(), 16384 + 500);
        if (i == 100)
            early = divergence(kFour, mixture);
    }
    EXPECT_LT(divergence(kFour, mixture), 1.5 * early + 0.005);
}

TEST(MixtureFit, LobesKnowHowFarTheirLightIs) {
    // Near light from one side, far light from the other, none of it exact.
    Rng rng(937);
    VmfMixture mixture;
    MixtureFit fit;
    for (int i = 0; i < 10; ++i) {
        auto samples = samples_of(kTwo, 2000, rng);
        for (MixtureSample& s : samples)
            s.inverse_distance = kTwo.responsibilities(s.wi)[0] > rng.next() ? 0.4f + 0.2f * rng.next() : 0;
        fit.update(mixture, samples);
    }
    const LobeValues near = mixture.responsibilities(kTwo.mu(0)), far = mixture.responsibilities(kTwo.mu(1));
    double at_near = 0, at_far = 0;
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        at_near += double{near[k]} * double{mixture.inverse_distance[k]};
        at_far += double{far[k]} * double{mixture.inverse_distance[k]};
    }
    EXPECT_NEAR(at_near, 0.5, 0.05);
    EXPECT_LT(at_far, 0.05);
}

TEST(MixtureFit, HalvesLearnFaster) {
    Rng rng(941);
    VmfMixture mixture;
    MixtureFit fit;
    auto samples = samples_of(kTwo, 8000, rng);
    fit.update(mixture, samples);
    VmfMixture other = mixture;
    MixtureFit half = fit;
    half.halve();
    EXPECT_EQ(half.samples(), 4000);
    samples = samples_of(kOneWide, 4000, rng);
    auto again = samples;
    fit.update(mixture, samples);
    half.update(other, again);
    EXPECT_LT(divergence(kOneWide, other), divergence(kOneWide, mixture));
}

}  // namespace
}  // namespace nephele::test
