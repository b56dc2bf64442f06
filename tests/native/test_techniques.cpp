// SPDX-License-Identifier: GPL-3.0-or-later
// The trial of ways of guiding, and the estimate of the image that errors are measured against.
#include "guiding/techniques.h"

#include <gtest/gtest.h>

#include <limits>

#include "guiding/image_estimate.h"
#include "guiding_fixtures.h"

namespace nephele::test {
namespace {

Settings settings_with(bool directions, bool segments, bool roulette) {
    Settings s = vsp_settings(Control::conditional);
    s.guide_directions = directions;
    s.vsp_secondary = segments;
    s.guided_roulette = roulette;
    return s;
}
/// A trial in which the sets have so much error and work a path.
Trial trial_of(const std::array<std::pair<double, double>, kSets>& shown) {
    Trial trial{};
    for (std::size_t i = 0; i < shown.size(); ++i) {
        for (int n = 0; n < 100; ++n)
            trial[i].add(shown[i].first, shown[i].second);
    }
    return trial;
}

TEST(Techniques, SetsAreNoneAndAllThatTheSettingsAllow) {
    for (int bits = 0; bits < 8; ++bits) {
        const bool directions = bits & 1, segments = bits & 2, roulette = bits & 4;
        const TechniqueChoice choice(settings_with(directions, segments, roulette));
        EXPECT_FALSE(choice.decided());
        EXPECT_EQ(choice.set(choice.draw(0)), Techniques());
        EXPECT_EQ(choice.set(choice.draw(kOneMinusEpsilon)), (Techniques{directions, segments, roulette}));
    }
    Settings delta = settings_with(false, true, false);
    delta.distance_sampling = Settings::DistanceSampling::delta;
    EXPECT_EQ(TechniqueChoice(delta).draw(kOneMinusEpsilon), 0) << "segments are guided by VSPG alone";
    Settings always = settings_with(true, true, true);
    always.train_field = Settings::TrainField::always;
    EXPECT_TRUE(TechniqueChoice(always).decided());
    EXPECT_EQ(TechniqueChoice(always).set(TechniqueChoice(always).draw(0)), (Techniques{true, true, true}));
}

// False alarms: 6 in 100000 seeds (4 standard deviations).
TEST(Techniques, PathsOnTrialDrawBothSetsAlike) {
    const TechniqueChoice choice(settings_with(true, true, true));
    Rng rng(1051);
    constexpr int kDraws = 100000;
    int all = 0;
    for (int i = 0; i < kDraws; ++i)
        all += choice.draw(rng.next());
    EXPECT_NEAR(all, kDraws / 2, 4 * std::sqrt(kDraws / 4.0));
}

TEST(Techniques, DecidesForTheLeastErrorTimesWork) {
    const auto chosen = [](std::pair<double, double> none, std::pair<double, double> all, bool end) {
        TechniqueChoice choice(settings_with(true, true, true));
        choice.decide(trial_of({none, all}), end);
        if (choice.decided()) {
            for (const float u : {0.0f, 0.5f, kOneMinusEpsilon})
                EXPECT_EQ(choice.draw(u), choice.chosen());
        }
        return choice.chosen();
    };
    for (const bool end : {false, true}) {
        EXPECT_EQ(chosen({1, 10}, {0.5, 10}, end), 1);
        EXPECT_EQ(chosen({1, 10}, {2, 10}, end), 0);
        EXPECT_EQ(chosen({1, 10}, {0.5, 30}, end), 0) << "work counts as error does";
        EXPECT_EQ(chosen({1, 10}, {1, 7}, end), 1);
        EXPECT_EQ(chosen({0, 10}, {0, 1}, end), end ? 0 : -1) << "without noise nothing has to be guided";
    }
    for (const double all : {0.8, 0.85, 1.0, 1.3})
        EXPECT_EQ(chosen({1, 10}, {all, 10}, false), -1) << "not clear yet: " << all;
    EXPECT_EQ(chosen({1, 10}, {0.85, 10}, true), 1);
    EXPECT_EQ(chosen({1, 10}, {0.95, 10}, true), 0) << "learning takes time as well";
    EXPECT_EQ(chosen({1, 10}, {1, 10}, true), 0);
}

TEST(Techniques, DecidesNothingBeforeBothHaveBeenTried) {
    for (std::size_t missing = 0; missing < kSets; ++missing) {
        TechniqueChoice choice(settings_with(true, true, true));
        Trial trial = trial_of({{{1, 10}, {0.1, 10}}});
        trial[missing] = {};
        choice.decide(trial, true);
        EXPECT_FALSE(choice.decided()) << missing;
    }
}

TEST(Techniques, TakesUpWhatWasChosen) {
    TechniqueChoice choice(settings_with(true, false, false));
    for (const int chosen : {1, 0, -1}) {
        choice.restore(chosen);
        EXPECT_EQ(choice.chosen(), chosen);
        EXPECT_EQ(choice.decided(), chosen >= 0);
    }
    for (const double wrong : {-2.0, 2.0, 1000.0, 0.5, 1e30, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THROW(choice.restore(wrong), std::invalid_argument);
    EXPECT_EQ(choice.chosen(), -1);
}

TEST(PathPair, TellsTheVarianceOfItsSet) {
    PathPair pair;
    EXPECT_FALSE(pair.variance(0, 3));
    EXPECT_FALSE(pair.variance(1, 100));
    EXPECT_FLOAT_EQ(pair.variance(0, 5).value(), 2);
    EXPECT_FALSE(pair.variance(0, 5)) << "no path is in two pairs";
    EXPECT_FLOAT_EQ(pair.variance(1, 0).value(), 5000);
    EXPECT_FLOAT_EQ(pair.variance(0, 5).value(), 0);
    // Of light that is 0 or 2 alike often, the variance is 1; of 100000 pairs, within 4 standard deviations:
    // false alarms 6 in 100000 seeds.
    Rng rng(1069);
    PathPair coins;
    double sum = 0;
    for (int i = 0; i < 200000; ++i)
        sum += double{coins.variance(1, rng.next() < 0.5f ? 0.0f : 2.0f).value_or(0)};
    EXPECT_NEAR(sum / 100000, 1, 4 / std::sqrt(100000.0));
}

TEST(TrialSums, DoNotDependOnOrder) {
    Rng rng(1061);
    std::vector<std::pair<double, double>> paths;
    paths.reserve(10000);
    for (int i = 0; i < 10000; ++i)
        paths.emplace_back(std::exp(20 * double{rng.next()} - 10), 1000 * double{rng.next()});
    TrialSums forward, backward, parts[3], joined;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        forward.add(paths[i].first, paths[i].second);
        backward.add(paths[paths.size() - 1 - i].first, paths[paths.size() - 1 - i].second);
        parts[i % 3].add(paths[i].first, paths[i].second);
    }
    for (const TrialSums& part : parts)
        joined += part;
    for (const TrialSums& sums : {backward, joined}) {
        EXPECT_EQ(sums.paths, forward.paths);
        EXPECT_EQ(sums.error, forward.error);
        EXPECT_EQ(sums.work, forward.work);
    }
}

TEST(TrialSums, BoundWhatOnePathAdds) {
    TrialSums worst, sums;
    worst.add(1e4, 1e7);
    sums.add(1e30, std::numeric_limits<double>::infinity());
    EXPECT_EQ(sums.error, worst.error);
    EXPECT_EQ(sums.work, worst.work);
    TrialSums least;
    least.add(-1, std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(least.error + least.work, 0U);
    EXPECT_EQ(least.paths, 1U);
}

constexpr int kSide = 16;

/// An image whose left half brings 1 and whose right half 4 on average, half of the samples nothing.
ImageEstimate image_of(int samples, std::uint64_t seed = 1063) {
    Rng rng(seed);
    ImageEstimate image(kSide, kSide);
    for (int i = 0; i < samples * kSide * kSide; ++i) {
        const int x = i % kSide, y = i / kSide % kSide;
        image.add(x, y, (rng.next() < 0.5f ? 2.0f : 0.0f) * (x < kSide / 2 ? 1.0f : 4.0f), 8);
    }
    image.update();
    return image;
}

TEST(ImageEstimate, KnowsNothingAtFirst) {
    ImageEstimate image(kSide, kSide);
    EXPECT_EQ(image.worth(3, 4), 0);
    image.update();
    EXPECT_EQ(image.worth(3, 4), 0);
    EXPECT_EQ(image.scale(3, 4), 0);
}

TEST(ImageEstimate, WorthIsByRadianceNoiseAndWork) {
    // Variance 1 and 16 of the halves' samples, work 8, and squared scales of the squared radiance and a
    // tenth of the image's mean, 2.5. The mean of a column's 16 x 1024 samples has a relative standard
    // deviation of 1/128; the tolerances are 6 of it: false alarms 1 in 10^8.
    const ImageEstimate image = image_of(1024);
    const double dark = 0.1 * 2.5 * 2.5, noise = (1 / (1 + dark) + 16 / (16 + dark)) / 2;
    for (const int x : {2, 13}) {
        const double radiance = x < kSide / 2 ? 1 : 4, scale = std::sqrt(radiance * radiance + dark);
        double worth = 0, error_scale = 0;
        for (int y = 0; y < kSide; ++y) {
            worth += double{image.worth(x, y)} / kSide;
            error_scale += double{image.scale(x, y)} / kSide;
        }
        EXPECT_NEAR(error_scale / scale, 1, 0.05) << x;
        EXPECT_NEAR(worth / (scale * std::sqrt(noise / 8)), 1, 0.05) << x;
    }
}

TEST(ImageEstimate, WithoutNoiseBranchesAreWorthNothing) {
    ImageEstimate image(kSide, kSide);
    for (int i = 0; i < 64 * kSide * kSide; ++i)
        image.add(i % kSide, i / kSide % kSide, 3, 8);
    image.update();
    EXPECT_NEAR(image.worth(5, 5), 0, 0.01);
    EXPECT_NEAR(image.scale(5, 5), 3 * std::sqrt(1.1), 1e-4);
}

TEST(ImageEstimate, GoesOnFromWhatWasSaved) {
    ImageEstimate image = image_of(16), other(kSide, kSide);
    std::map<std::string, std::vector<double>> saved, again;
    image.save(saved);
    other.restore(saved);
    other.save(again);
    EXPECT_TRUE(saved == again);
    for (ImageEstimate* e : {&image, &other}) {
        e->add(3, 3, 7, 5);
        e->update();
    }
    for (int i = 0; i < kSide * kSide; ++i)
        EXPECT_EQ(image.worth(i % kSide, i / kSide), other.worth(i % kSide, i / kSide));
    ImageEstimate wrong(kSide, kSide + 1);
    EXPECT_THROW(wrong.restore(saved), std::invalid_argument);
    EXPECT_FALSE(wrong.inherit(saved, 8));
    EXPECT_THROW(other.restore({}), std::invalid_argument);
    for (const auto& [name, values] : saved) {
        auto bad = saved;
        bad.at(name).pop_back();
        EXPECT_THROW(other.restore(bad), std::invalid_argument) << name;
        bad = saved;
        bad.at(name)[5] = -1;
        EXPECT_THROW(other.restore(bad), std::invalid_argument) << name;
    }
}

TEST(ImageEstimate, InheritsAsIfFromFewSamples) {
    std::map<std::string, std::vector<double>> saved;
    const ImageEstimate before = image_of(1024);
    before.save(saved);
    ImageEstimate heir(kSide, kSide);
    EXPECT_FALSE(heir.inherit({}, 8));
    ASSERT_TRUE(heir.inherit(saved, 8));
    EXPECT_EQ(heir.worth(5, 5), before.worth(5, 5)) << "at once";
    // 56 samples of another image count for seven eighths.
    for (int i = 0; i < 56 * kSide * kSide; ++i)
        heir.add(i % kSide, i / kSide % kSide, i / (kSide * kSide) % 2 == 0 ? 0 : 200, 8);
    heir.update();
    EXPECT_GT(heir.worth(2, 8), 40 * before.worth(2, 8));
}

}  // namespace
}  // namespace nephele::test
