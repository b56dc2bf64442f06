// SPDX-License-Identifier: GPL-3.0-or-later
// Where resampling a whole segment pays against plain delta tracking: closed forms of both variances.
#include <gtest/gtest.h>

#include "guiding/learned_guide.h"

namespace nephele::test {
namespace {

/// 100 segments whose streams all find these weights; extra: lookups a walk takes more than a flight.
RayMeans walked(float volume, float surface, float extra) {
    VspRecord r;
    r.known = r.walked = true;
    r.volume_weight = volume;
    r.surface_weight = surface;
    r.volume_square = volume * volume;
    r.surface_square = surface * surface;
    r.both = volume * surface;
    r.extra_work = extra;
    RayMeans means;
    add_means(means, r, 100);
    return means;
}
Pooled branch(float light, float noise, float cost) {
    return {light, cost, 1, noise};
}

TEST(WalkShare, WalksWhereTheBranchesDifferMuchAndAreNotNoisy) {
    // Half scatters into the dark, half passes to a bright wall: delta tracking has variance 1/4, a walk
    // none.
    EXPECT_EQ(walk_share(walked(0.5f, 0.5f, 10), branch(0, 0, 20), branch(1, 0, 20), 0.25f), 1);
}

TEST(WalkShare, FliesWhereBothBranchesAreAlikeAndTheWalkTakesTime) {
    // Both branches bring 1: delta tracking has no variance to be saved.
    EXPECT_EQ(walk_share(walked(0.5f, 0.5f, 10), branch(1, 0.5f, 20), branch(1, 0.5f, 20), 0.25f), 0);
}

TEST(WalkShare, FliesWhereTheNoiseIsThatOfTheBranches) {
    // A variance of 100 in either branch: what the decision adds is next to nothing against it.
    EXPECT_EQ(walk_share(walked(0.5f, 0.5f, 5), branch(1, 100, 20), branch(1.2f, 100, 20), 0.25f), 0);
}

TEST(WalkShare, WeighsVarianceAgainstWork) {
    // V = T = 1/2, radiances 1 and 3, no noise: a flight's variance is 1 whatever it costs, a walk's is 0.
    EXPECT_EQ(walk_share(walked(0.5f, 0.5f, 1000), branch(1, 0, 1100), branch(3, 0, 1100), 0.25f), 1);
    // With noise n in both, a flight has (1 + 9) (1 + n) / 2 - 4, a walk (1 + 3)^2 (1 + n) / 4 - 4: at n = 1,
    // 6 against 4. A walk may cost 1.5 times as much.
    const auto at_extra = [](float extra) {
        return walk_share(walked(0.5f, 0.5f, extra), branch(1, 1, 100 + extra), branch(3, 1, 100 + extra),
                          0.25f);
    };
    EXPECT_EQ(at_extra(45), 1);
    EXPECT_EQ(at_extra(55), 0);
}

TEST(WalkShare, TriesUntilItKnows) {
    RayMeans few = thinned(walked(0.5f, 0.5f, 10), 0.1f);
    EXPECT_EQ(walk_share(few, branch(0, 0, 20), branch(1, 0, 20), 0.25f), 0.25f);
    Pooled unknown = branch(0, 0, 20);
    unknown.known = 0.3f;
    EXPECT_EQ(walk_share(walked(0.5f, 0.5f, 10), unknown, branch(1, 0, 20), 1), 1);
}

TEST(WalkShare, OnlyWalksByTheWeightsAsTheyAreCount) {
    VspRecord r;
    r.known = r.walked = r.weighed = true;
    r.majorant_depth = 3;
    RayMeans means;
    add_means(means, r, 100);
    EXPECT_EQ(means.walks, 0);
    EXPECT_EQ(means.majorant_depth / means.depths, 3);
    EXPECT_EQ(walk_share(means, branch(1, 0.5f, 20), branch(1, 0.5f, 20), 1), 1);
}

}  // namespace
}  // namespace nephele::test
