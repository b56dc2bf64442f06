// SPDX-License-Identifier: GPL-3.0-or-later
// What tests of VDB files share: a folder of their own, and random grids written with OpenVDB itself.
#pragma once

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "grids/vdb_file.h"
#include "math/sampler.h"

namespace nephele {

namespace fs = std::filesystem;
using openvdb::Coord;

inline constexpr std::uint32_t kPlain = openvdb::io::COMPRESS_NONE,
                               kMasked = openvdb::io::COMPRESS_ACTIVE_MASK,
                               kZip = openvdb::io::COMPRESS_ZIP | kMasked,
                               kBlosc = openvdb::io::COMPRESS_BLOSC | kMasked;

class VdbFile : public testing::Test {
  protected:
    void SetUp() override {
        openvdb::initialize();
        folder_ = fs::temp_directory_path() / ("nephele_vdb_" + std::to_string(getpid()));
        fs::create_directories(folder_);
        path_ = (folder_ / "grids.vdb").string();
    }
    void TearDown() override { fs::remove_all(folder_); }

    void write(const openvdb::GridCPtrVec& grids, std::uint32_t compression = kBlosc) {
        openvdb::io::File file(path_);
        file.setCompression(compression);
        file.write(grids);
    }
    /// The message of the std::runtime_error that f throws, or an empty string.
    template <typename F>
    static std::string error_of(const F& f) {
        try {
            f();
        } catch (const std::runtime_error& e) {
            return e.what();
        }
        return {};
    }
    std::string load_error(const std::string& name) {
        return error_of([&] { load_grid(path_, name); });
    }

    fs::path folder_;
    std::string path_;
};

/// Random values in clumps, tiles of each size, at negative and positive indices.
template <typename Grid>
typename Grid::Ptr random_grid(std::uint64_t seed, typename Grid::ValueType background,
                               const std::string& name = "density") {
    using Value = typename Grid::ValueType;
    auto grid = Grid::create(background);
    grid->setName(name);
    Rng rng(seed);
    const auto pick = [&](int n) { return static_cast<int>(rng.next() * static_cast<float>(n)); };
    auto accessor = grid->getAccessor();
    for (int clump = 0; clump < 20; ++clump) {
        const Coord centre(pick(500) - 250, pick(500) - 250, pick(500) - 250);
        for (int n = 0; n < 400; ++n) {
            const Coord at = centre + Coord(pick(12), pick(12), pick(12));
            const auto value = static_cast<Value>(rng.next() * 50);
            n % 10 == 0 ? accessor.setValueOff(at, value) : accessor.setValue(at, value);
        }
    }
    grid->tree().addTile(1, Coord(-300, 8, 16), static_cast<Value>(3), true);
    grid->tree().addTile(2, Coord(256, -128, 0), static_cast<Value>(1), true);
    grid->tree().addTile(1, Coord(400, 8, 16), static_cast<Value>(2),
                         false);  // inactive tiles have values, too
    return grid;
}

template <typename Grid>
void expect_equal(const Grid& source, const BrickGrid& loaded) {
    auto accessor = source.getConstAccessor();
    for (int i = -320; i < 420; i += 2) {
        for (int j = -270; j < 280; j += 5) {
            for (int k = -270 + (i + j) % 5; k < 280; k += 5) {
                ASSERT_EQ(loaded.lookup(i, j, k), static_cast<float>(accessor.getValue(Coord(i, j, k))))
                    << i << ' ' << j << ' ' << k;
            }
        }
    }
    for (auto v = source.cbeginValueOn(); v; ++v) {
        const Coord c = v.getCoord();
        ASSERT_EQ(loaded.lookup(c[0], c[1], c[2]), static_cast<float>(*v));
    }
    EXPECT_EQ(loaded.active_voxels(), static_cast<std::int64_t>(source.activeVoxelCount()));
    const auto box = source.evalActiveVoxelBoundingBox();
    if (box.empty()) {
        EXPECT_TRUE(loaded.active_bounds().empty());
    } else {
        EXPECT_EQ(loaded.active_bounds(), (IndexBox{{box.min()[0], box.min()[1], box.min()[2]},
                                                    {box.max()[0], box.max()[1], box.max()[2]}}));
    }
}

}  // namespace nephele
