// SPDX-License-Identifier: GPL-3.0-or-later
// What the cache of grids keeps, what it lets go of, and that it never hands out what a file no longer holds.
#include "grids/grid_cache.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <atomic>
#include <fstream>

#include <tbb/parallel_for.h>

#include "vdb_fixture.h"

namespace nephele {
namespace {

class GridCacheTest : public VdbFile {
  protected:
    /// Writes a file of one voxel of that value; the size does not depend on it.
    std::string write_value(const std::string& file, float value) {
        const auto grid = openvdb::FloatGrid::create();
        grid->setName("density");
        grid->tree().setValue(Coord(0, 0, 0), value);
        const auto velocity = openvdb::Vec3SGrid::create();
        velocity->setName("velocity");
        velocity->tree().setValue(Coord(0, 0, 0), openvdb::Vec3s(value));
        path_ = (folder_ / file).string();
        write({grid, velocity}, kPlain);
        return path_;
    }
    static float value_of(const LoadedGrid& loaded) { return loaded.grid->lookup(0, 0, 0); }
    /// Requests since the last call: (hits, misses).
    std::pair<std::size_t, std::size_t> news() {
        const GridCache::Statistics now = cache_.statistics();
        const std::pair since(now.hits - seen_.hits, now.misses - seen_.misses);
        seen_ = now;
        return since;
    }
    using Count = std::pair<std::size_t, std::size_t>;

    GridCache cache_;
    GridCache::Statistics seen_;
};

TEST_F(GridCacheTest, ASecondSceneReadsNothing) {
    const std::string path = write_value("a.vdb", 2);
    std::uint64_t id = 0;
    for (int scene = 0; scene < 3; ++scene) {
        GridCacheScope scope(cache_);
        EXPECT_EQ(scope.list(path)->size(), 2u);
        const auto grid = scope.grid(path, "density");
        EXPECT_EQ(value_of(*grid), 2.0f);
        EXPECT_EQ(scope.vector_grid(path, "velocity")->components[2]->lookup(0, 0, 0), 2.0f);
        const auto sum = scope.get_or_make<double>("sum", {grid->id}, [&] { return 7.0 + value_of(*grid); });
        EXPECT_EQ(*sum, 9.0);
        scope.commit();
        EXPECT_EQ(news(), scene == 0 ? Count(0, 4) : Count(4, 0));
        if (scene > 0) {
            EXPECT_EQ(grid->id, id);
        }
        id = grid->id;
    }
}

TEST_F(GridCacheTest, OptionsAndNamesAndKindsAreDifferentGrids) {
    const std::string path = write_value("a.vdb", 2);
    GridCacheScope scope(cache_);
    GridOptions half, clipped, negative;
    half.precision = GridOptions::Precision::half;
    clipped.clipping = 3;
    negative.keep_negative = true;
    EXPECT_EQ(value_of(*scope.grid(path, "density")), 2.0f);
    EXPECT_EQ(scope.grid(path, "density", half)->grid->voxel_type(), VoxelType::half_float);
    EXPECT_EQ(value_of(*scope.grid(path, "density", clipped)), 0.0f);
    scope.grid(path, "density", negative);
    EXPECT_EQ(scope.grid(path, "velocity")->grid, nullptr);  // its warnings are kept like values
    EXPECT_EQ(scope.grid(path, "velocity")->warnings.size(), 1u);
    EXPECT_NE(scope.vector_grid(path, "velocity")->components[0], nullptr);
    EXPECT_EQ(news(), Count(1, 6));
}

TEST_F(GridCacheTest, AChangedFileIsReadAgainHoweverSoonItChanged) {
    for (int k = 1; k < 20; ++k) {
        const std::string path = write_value("a.vdb", static_cast<float>(k));  // all of one size
        GridCacheScope scope(cache_);
        EXPECT_EQ(value_of(*scope.grid(path, "density")), static_cast<float>(k));
        scope.commit();
    }
    EXPECT_EQ(news(), Count(0, 19));
}

TEST_F(GridCacheTest, WhatTheNewSceneDoesNotUseIsLetGo) {
    const std::string a = write_value("a.vdb", 1), b = write_value("b.vdb", 2);
    std::weak_ptr<const LoadedGrid> old;
    std::weak_ptr<const int> built;
    {
        GridCacheScope scope(cache_);
        old = scope.grid(a, "density");
        built = scope.get_or_make<int>("x", {old.lock()->id}, [] { return 1; });
        scope.grid(b, "density");
        scope.commit();
    }
    EXPECT_FALSE(old.expired());
    {
        GridCacheScope scope(cache_);  // one that fails half-way changes nothing
        scope.grid(b, "density");
    }
    EXPECT_FALSE(old.expired());
    news();
    {
        GridCacheScope scope(cache_);
        scope.grid(b, "density");
        EXPECT_FALSE(old.expired());
        scope.commit();
    }
    EXPECT_TRUE(old.expired());
    EXPECT_TRUE(built.expired());
    EXPECT_EQ(news(), Count(1, 0));
    EXPECT_EQ(cache_.size(), 1u);
    cache_.clear();
    EXPECT_EQ(cache_.size(), 0u);
}

TEST_F(GridCacheTest, AliveGridsAreSharedBetweenScenes) {
    const std::string path = write_value("a.vdb", 1);
    GridCacheScope first(cache_), second(cache_), third(cache_);
    const auto grid = first.grid(path, "density");  // not committed: the first still renders
    EXPECT_EQ(second.grid(path, "density"), grid);
    third.commit();  // holds nothing
    EXPECT_EQ(third.grid(path, "density"), grid);
    EXPECT_EQ(news(), Count(2, 1));
}

TEST_F(GridCacheTest, ErrorsAreNotKept) {
    const std::string path = (folder_ / "late.vdb").string();
    GridCacheScope scope(cache_);
    EXPECT_NE(error_of([&] { scope.grid(path, "density"); }).find("cannot be opened"), std::string::npos);
    write_value("late.vdb", 4);
    EXPECT_EQ(value_of(*scope.grid(path, "density")), 4.0f);
    fs::remove(path);
    EXPECT_NE(error_of([&] { scope.grid(path, "density"); }).find("cannot be opened"), std::string::npos);
    int calls = 0;
    const auto fail = [&]() -> int {
        ++calls;
        throw std::runtime_error("no");
    };
    for (int n = 0; n < 2; ++n)
        EXPECT_EQ(error_of([&] { scope.get_or_make<int>("fails", {}, fail); }), "no");
    EXPECT_EQ(calls, 2);
}

// The cache asks for a file's stamp before it reads, and again after.
TEST_F(GridCacheTest, AFileThatNeverRestsIsAnError) {
    const std::string path = write_value("a.vdb", 1);
    std::int64_t asked = 0;
    bool rests = false;
    GridCache cache([&](const std::string& file) {
        FileStamp stamp = stamp_of(file);
        if (!rests)
            stamp.changed += ++asked;
        return stamp;
    });
    GridCacheScope scope(cache);
    EXPECT_EQ(error_of([&] { scope.grid(path, "density"); }),
              path + " is being written to while it is read: render once it is complete");
    EXPECT_EQ(asked, 6);  // three readings
    rests = true;
    EXPECT_EQ(value_of(*scope.grid(path, "density")), 1.0f);  // the error was not kept
    EXPECT_EQ(value_of(*scope.grid(path, "density")), 1.0f);
    EXPECT_EQ(cache.statistics().hits, 1u);
}

TEST_F(GridCacheTest, AFileWrittenToWhileItIsReadIsReadAgain) {
    const std::string path = write_value("a.vdb", 1);
    int asked = 0;
    GridCache cache([&](const std::string& file) {
        if (++asked == 2)  // the first reading is over
            write_value("a.vdb", 2);
        return stamp_of(file);
    });
    GridCacheScope scope(cache);
    EXPECT_EQ(value_of(*scope.grid(path, "density")), 2.0f);
    EXPECT_EQ(asked, 4);
    EXPECT_EQ(value_of(*scope.grid(path, "density")), 2.0f);
    EXPECT_EQ(cache.statistics().hits, 1u);
}

TEST_F(GridCacheTest, EqualRequestsAtOnceBuildOnce) {
    GridCacheScope scope(cache_);
    std::atomic<int> built = 0, inner = 0;
    // The value itself is built in parallel, from another value: a thread that waits for its own tasks must
    // not take up another request of the same value.
    tbb::parallel_for(0, 200, [&](int n) {
        const auto value = scope.get_or_make<int>("slow " + std::to_string(n % 3), {}, [&] {
            ++built;
            const auto part = scope.get_or_make<int>("part", {}, [&] { return ++inner; });
            std::atomic<int> sum = 0;
            tbb::parallel_for(0, 1000, [&](int i) { sum += i; });
            return sum * *part;
        });
        EXPECT_EQ(*value, 499500);
    });
    EXPECT_EQ(built, 3);
    EXPECT_EQ(inner, 1);
    EXPECT_EQ(news(), Count(199, 4));
}

TEST_F(GridCacheTest, TheSameKeyOfAnotherTypeIsAnotherValue) {
    GridCacheScope scope(cache_);
    EXPECT_EQ(*scope.get_or_make<int>("k", {}, [] { return 1; }), 1);
    EXPECT_EQ(*scope.get_or_make<float>("k", {}, [] { return 2.5f; }), 2.5f);
    EXPECT_EQ(*scope.get_or_make<int>("k", {5}, [] { return 3; }), 3);
}

}  // namespace
}  // namespace nephele
