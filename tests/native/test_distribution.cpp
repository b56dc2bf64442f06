// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/distribution.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "cell_counts.h"
#include "math/sampler.h"

namespace nephele::test {
namespace {

TEST(DiscreteDistribution, FollowsItsWeights) {
    const std::vector<float> weights{0, 3, 1, 0, 0.5f, 10, 0, 2};
    const DiscreteDistribution d(weights);
    constexpr int kDraws = 200000;
    std::vector<std::uint64_t> counts(weights.size());
    std::vector<double> expected;
    for (const float w : weights)
        expected.push_back(w / 16.5);
    Rng rng(1);
    for (int i = 0; i < kDraws; ++i) {
        const auto c = d.sample(rng.next());
        ++counts[c.index];
        EXPECT_FLOAT_EQ(c.probability, d.probability(c.index));
        EXPECT_FLOAT_EQ(c.probability, weights[c.index] / 16.5f);
        ASSERT_GE(c.u, 0);
        ASSERT_LT(c.u, 1);
    }
    EXPECT_GT(chi_square_p(counts, expected, kDraws), kFalseAlarm);
}

TEST(DiscreteDistribution, RescaledNumberIsUniform) {
    const DiscreteDistribution d(std::vector<float>{1, 2, 7});
    std::vector<std::uint64_t> counts(30);
    Rng rng(2);
    constexpr int kDraws = 300000;
    for (int i = 0; i < kDraws; ++i) {
        const auto c = d.sample(rng.next());
        if (c.index == 2)
            ++counts[static_cast<std::size_t>(c.u * 30)];
    }
    EXPECT_GT(chi_square_p(counts, std::vector<double>(30, 0.7 / 30), kDraws), kFalseAlarm);
}

TEST(DiscreteDistribution, TinyWeightsBesideAHugeOneKeepTheirShare) {
    std::vector<float> weights(1000000, 1e-6f);
    weights[500000] = 1e6f;
    const DiscreteDistribution d(weights);
    for (const std::size_t i :
         {std::size_t{0}, std::size_t{499999}, std::size_t{500001}, std::size_t{999999}}) {
        EXPECT_NEAR(d.probability(i), 1e-12, 1e-15) << i;
    }
    double sum = 0;
    for (std::size_t i = 0; i < weights.size(); ++i)
        sum += d.probability(i);
    EXPECT_NEAR(sum, 1, 1e-6);
}

TEST(DiscreteDistribution, EndsNeverGiveAnImpossibleIndex) {
    const DiscreteDistribution d(std::vector<float>{0, 0, 1e-30f, 5, 0});
    EXPECT_EQ(d.sample(0).index, 2u);
    EXPECT_EQ(d.sample(kOneMinusEpsilon).index, 3u);
    EXPECT_EQ(DiscreteDistribution(std::vector<float>{7}).sample(kOneMinusEpsilon).index, 0u);
}

TEST(DiscreteDistribution, EmptyAndFaulty) {
    EXPECT_TRUE(DiscreteDistribution().empty());
    EXPECT_TRUE(DiscreteDistribution(std::vector<float>{0, 0}).empty());
    EXPECT_EQ(DiscreteDistribution(std::vector<float>{0, 0}).probability(1), 0);
    EXPECT_THROW(DiscreteDistribution(std::vector<float>{1, -1}), std::invalid_argument);
    EXPECT_THROW(DiscreteDistribution(std::vector<float>{1, NAN}), std::invalid_argument);
}

}  // namespace
}  // namespace nephele::test
