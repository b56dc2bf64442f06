// SPDX-License-Identifier: GPL-3.0-or-later
// The film: sums, means and variances of samples, and nothing for passes that nobody asked for.
#include "film/film.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "math/sampler.h"

namespace nephele {
namespace {

constexpr PassId kSome[] = {PassId::combined,   PassId::volume,       PassId::surface,
                            PassId::variance,   PassId::depth,        PassId::normal,
                            PassId::cost,       PassId::sample_count, PassId::surface_variance,
                            PassId::vsp_target, PassId::vsp_achieved, PassId::majorant_optical_depth};

PixelSample sample_of(float light) {
    PixelSample s;
    s.volume = Rgb(light, 2 * light, 0);
    s.surface = Rgb(0, 1, light);
    s.depth = 10 * light;
    s.normal = {0, 0, 1};
    s.cost = light;
    s.alpha = 0.5f;
    s.vsp_target = light / 4;
    s.vsp_achieved = light > 2;
    s.majorant_depth = 100 * light;
    return s;
}

TEST(Film, GivesMeansPerPixelAndTheFirstSamplesDepth) {
    Film film(3, 2, kSome);
    film.add(2, 1, sample_of(1), 1);
    film.add(2, 1, sample_of(3), 1);
    const auto combined = film.read(PassId::combined);
    ASSERT_EQ(combined.size(), 3u * 2 * 4);
    const float* pixel = combined.data() + 4 * 5;
    EXPECT_EQ(pixel[0], 2);
    EXPECT_EQ(pixel[1], 5);
    EXPECT_EQ(pixel[2], 2);
    EXPECT_EQ(pixel[3], 0.5f);
    for (std::size_t i = 0; i < 4 * 5; ++i)
        EXPECT_EQ(combined[i], 0);
    EXPECT_EQ(film.read(PassId::depth)[5], 10);
    EXPECT_EQ(film.read(PassId::cost)[5], 2);
    EXPECT_EQ(film.read(PassId::sample_count), (std::vector<float>{0, 0, 0, 0, 0, 2}));
    EXPECT_EQ(film.count(2, 1), 2u);
    EXPECT_EQ(film.count(1, 1), 0u);
}

TEST(Film, ExposureScalesLightAlone) {
    Film film(1, 1, kSome);
    film.add(0, 0, sample_of(1), 4);
    EXPECT_EQ(film.read(PassId::combined), (std::vector<float>{4, 12, 4, 0.5f}));
    EXPECT_EQ(film.read(PassId::volume), (std::vector<float>{4, 8, 0}));
    EXPECT_EQ(film.read(PassId::depth)[0], 10);
    EXPECT_EQ(film.read(PassId::normal)[2], 1);
}

TEST(Film, AveragesWhatGuidingSays) {
    constexpr PassId passes[] = {PassId::vsp_target, PassId::vsp_achieved, PassId::majorant_optical_depth};
    Film film(1, 1, passes);
    film.add(0, 0, sample_of(1), 4);
    film.add(0, 0, sample_of(3), 4);
    EXPECT_EQ(film.read(PassId::vsp_target)[0], 0.5f);
    EXPECT_EQ(film.read(PassId::vsp_achieved)[0], 0.5f);
    EXPECT_EQ(film.read(PassId::majorant_optical_depth)[0], 200);
}

/// Estimated variance of the mean of each channel, averaged over the channels, in two passes over the values.
double variance_of_mean(const std::vector<Rgb>& values) {
    const auto n = static_cast<double>(values.size());
    double result = 0;
    for (int c = 0; c < 3; ++c) {
        double mean = 0, sum = 0;
        for (const Rgb& x : values)
            mean += double{x[c]} / n;
        for (const Rgb& x : values)
            sum += (double{x[c]} - mean) * (double{x[c]} - mean);
        result += sum / (n - 1) / n / 3;
    }
    return result;
}

TEST(Film, VariancesAreThoseOfTheMeansAveragedOverChannels) {
    constexpr PassId passes[] = {PassId::combined, PassId::variance, PassId::volume_variance,
                                 PassId::surface_variance};
    Film film(1, 1, passes);
    Rng rng(2);
    std::vector<Rgb> light, volume, surface;
    for (int n = 0; n < 50; ++n) {
        PixelSample s;
        s.volume = {rng.next(), 2 * rng.next(), 1000 + rng.next()};
        s.surface = {3 * rng.next(), 0, 100 + 10 * rng.next()};
        film.add(0, 0, s, 2);
        volume.push_back(2 * s.volume);
        surface.push_back(2 * s.surface);
        light.push_back(2 * (s.volume + s.surface));
        if (n == 0) {
            EXPECT_EQ(film.read(PassId::variance)[0], 0);
            EXPECT_EQ(film.read(PassId::volume_variance)[0], 0);
        }
    }
    const auto expect = [&](PassId pass, double expected) {
        EXPECT_NEAR(film.read(pass)[0], expected, 1e-5 * expected);
    };
    expect(PassId::variance, variance_of_mean(light));
    expect(PassId::volume_variance, variance_of_mean(volume));
    expect(PassId::surface_variance, variance_of_mean(surface));
}

TEST(Film, SumsInDoublePrecision) {
    Film film(1, 1, kSome);
    for (int n = 0; n < 3000000; ++n) {
        PixelSample s;
        s.surface = Rgb(0.1f);
        film.add(0, 0, s, 1);
    }
    EXPECT_FLOAT_EQ(film.read(PassId::combined)[0], 0.1f);
}

TEST(Film, HoldsOnlyWhatWasAskedFor) {
    const PassId one[] = {PassId::depth};
    Film film(4, 4, one);
    film.add(0, 0, sample_of(1), 1);
    for (int p = 0; p < kPassCount; ++p) {
        const auto pass = static_cast<PassId>(p);
        const bool asked = pass == PassId::depth || pass == PassId::sample_count;
        EXPECT_EQ(film.has(pass), asked);
        if (asked) {
            EXPECT_NO_THROW(film.read(pass));
        } else {
            EXPECT_THROW(film.read(pass), std::invalid_argument);
        }
    }
    const auto saved = film.save();
    ASSERT_EQ(saved.size(), 2u);
    EXPECT_EQ(saved.at("depth").size(), 16u);
}

TEST(Film, AVarianceAloneDoesNotGiveItsMean) {
    constexpr std::pair<PassId, PassId> pairs[] = {{PassId::variance, PassId::combined},
                                                   {PassId::volume_variance, PassId::volume},
                                                   {PassId::surface_variance, PassId::surface}};
    for (const auto& [variance, mean] : pairs) {
        Film film(1, 1, {&variance, 1});
        film.add(0, 0, sample_of(1), 1);
        film.add(0, 0, sample_of(3), 1);
        EXPECT_GT(film.read(variance)[0], 0);
        EXPECT_FALSE(film.has(mean));
        EXPECT_THROW(film.read(mean), std::invalid_argument);

        Film again(1, 1, {&variance, 1});
        again.restore(film.save());
        EXPECT_EQ(again.read(variance), film.read(variance));
    }
}

TEST(Film, RestoresWhatItSavedAndRefusesWhatDoesNotFit) {
    Film film(3, 2, kSome);
    film.add(1, 1, sample_of(2), 1);
    Film again(3, 2, kSome);
    again.restore(film.save());
    for (const PassId pass : kSome)
        EXPECT_EQ(again.read(pass), film.read(pass));
    EXPECT_EQ(again.count(1, 1), 1u);

    Film wider(4, 2, kSome);
    EXPECT_THROW(wider.restore(film.save()), std::invalid_argument);
    Film turned(2, 3, kSome);
    turned.restore(
        film.save());  // a checkpoint knows only sizes; the checkpoint's own header knows the frame
    const PassId more[] = {PassId::combined, PassId::albedo};
    Film other(3, 2, more);
    EXPECT_THROW(other.restore(film.save()), std::invalid_argument);
    EXPECT_THROW(other.restore({}), std::invalid_argument);
    EXPECT_EQ(other.count(1, 1), 0u);  // a refused checkpoint changes nothing
}

TEST(Film, RefusesCountsThatAreNone) {
    const PassId passes[] = {PassId::combined};
    Film film(2, 1, passes);
    film.add(0, 0, {}, 1);
    for (const double wrong : {-1.0, 0.5, 4e9, 1e300, double{NAN}, double{INFINITY}}) {
        auto saved = film.save();
        saved.at("sample_count")[1] = wrong;
        EXPECT_THROW(film.restore(saved), std::invalid_argument) << wrong;
    }
    EXPECT_EQ(film.count(0, 0), 1u) << "what is refused changes nothing";
}

TEST(Film, SamplesMayStandForSeveral) {
    Film film(1, 1, kSome, {.error = true, .weights = true});
    film.add(0, 0, sample_of(1), 1);
    film.add(0, 0, sample_of(3), 1, 3);
    EXPECT_EQ(film.count(0, 0), 4u);
    EXPECT_EQ(film.read(PassId::sample_count)[0], 2);
    EXPECT_EQ(film.read(PassId::cost)[0], 2.5f);
    EXPECT_EQ(film.read(PassId::depth)[0], 10) << "of the first sample";
    // Red, green and blue are 1, 3, 1 and 3, 7, 3: the weighted spread about the mean is 3 / 16 of the
    // squared difference; the squared shares add up to 10 / 16, which is missing of it.
    const double red = 4 * 3 / 16.0 * (10.0 / 6), green = 4 * red;
    EXPECT_FLOAT_EQ(film.read(PassId::variance)[0], static_cast<float>((2 * red + green) / 3));
    const double error = (2 * red / (2.5 * 2.5 + 0.01) + green / (36 + 0.01)) / 3;
    EXPECT_NEAR(film.relative_error(), error, 1e-12);
    Film again(1, 1, kSome, {.error = true, .weights = true});
    again.restore(film.save());
    EXPECT_EQ(again.relative_error(), film.relative_error());
    EXPECT_EQ(again.read(PassId::sample_count), film.read(PassId::sample_count));
    Film equal(1, 1, kSome);
    EXPECT_NO_THROW(equal.restore(film.save()));
    EXPECT_THROW(again.restore(equal.save()), std::invalid_argument) << "it does not know how many there are";
}

TEST(Film, TellsItsErrorOnceEveryPixelCan) {
    const PassId depth[] = {PassId::depth};
    Film film(2, 1, depth, {.error = true});
    EXPECT_TRUE(std::isinf(film.relative_error()));
    film.add(0, 0, sample_of(1), 1);
    EXPECT_TRUE(std::isinf(film.relative_error())) << "one sample has no spread";
    film.add(0, 0, sample_of(3), 1);
    // Variances of the means 1, 4, 1 at means 2, 5, 2; the other pixel is left out.
    EXPECT_NEAR(film.relative_error(), (2 * 1 / 4.01 + 4 / 25.01) / 3, 1e-12);
    EXPECT_FALSE(film.has(PassId::variance)) << "what it keeps for itself is no pass";
    EXPECT_THROW(Film(1, 1, depth).relative_error(), std::logic_error);
}

TEST(Film, LightTimesItsColorIsTheLight) {
    constexpr PassId passes[] = {PassId::glossy_direct, PassId::glossy_color, PassId::volume_indirect,
                                 PassId::environment};
    Film film(1, 1, passes);
    ASSERT_TRUE(film.has_parts());
    SampleParts parts;
    parts.direct[SampleParts::glossy] = {1, 2, 0};
    parts.color[SampleParts::glossy] = {0.5f, 0.25f, 0};
    parts.indirect[SampleParts::volume] = {3, 0, 0};
    parts.environment = {0, 0, 5};
    film.add(0, 0, {}, 2, 1, &parts);
    film.add(0, 0, {}, 2, 3, &parts);
    EXPECT_EQ(film.read(PassId::glossy_direct), (std::vector<float>{4, 16, 0}))
        << "0 where there is no colour";
    EXPECT_EQ(film.read(PassId::glossy_color), (std::vector<float>{0.5f, 0.25f, 0}));
    EXPECT_EQ(film.read(PassId::volume_indirect), (std::vector<float>{6, 0, 0}));
    EXPECT_EQ(film.read(PassId::environment), (std::vector<float>{0, 0, 10}));
    EXPECT_THROW(film.read(PassId::glossy_indirect), std::invalid_argument);
    EXPECT_FALSE(Film(1, 1, kSome).has_parts());
}

TEST(Film, MattesAreRestoredWithTheRest) {
    constexpr PassId passes[] = {PassId::cryptoobject00, PassId::cryptomaterial01};
    Film film(2, 1, passes);
    SampleParts parts;
    parts.mattes = {{1, 2, 3, 0.25f}, {4, 2, 5, 0.5f}};
    film.add(1, 0, {}, 1, 1, &parts);
    film.add(1, 0, {}, 1, 1, &parts);
    const auto pixels = film.read(PassId::cryptoobject00);
    EXPECT_EQ(pixels[5], 0.5f) << "coverage of the larger, of two samples";
    EXPECT_EQ(pixels[7], 0.25f);
    EXPECT_THROW(film.read(PassId::cryptoasset00), std::invalid_argument);
    Film again(2, 1, passes);
    again.restore(film.save());
    EXPECT_EQ(again.read(PassId::cryptoobject00), pixels);
    auto saved = film.save();
    saved.at("mattes of objects, ids").pop_back();
    EXPECT_THROW(again.restore(saved), std::invalid_argument);
}

TEST(Film, TheNoisyImageIsCombined) {
    constexpr PassId passes[] = {PassId::noisy_image};
    Film film(1, 1, passes);
    film.add(0, 0, sample_of(1), 1);
    EXPECT_EQ(film.read(PassId::noisy_image), (std::vector<float>{1, 3, 1, 0.5f}));
    EXPECT_FALSE(film.has(PassId::combined));
}

TEST(Film, RefusesAnEmptyFrame) {
    EXPECT_THROW(Film(0, 4, kSome), std::invalid_argument);
    EXPECT_THROW(Film(4, -1, kSome), std::invalid_argument);
}

}  // namespace
}  // namespace nephele
