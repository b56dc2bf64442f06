// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are cut short or altered, and the memory that loading takes.
#include <gtest/gtest.h>
#include <malloc.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "vdb_fixture.h"

namespace nephele {
namespace {

std::vector<char> bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST_F(VdbFile, EveryTruncationIsAnError) {
    write({random_grid<openvdb::FloatGrid>(8, 0.5f), random_grid<openvdb::FloatGrid>(9, 0, "other")});
    const std::vector<char> whole = bytes_of(path_);
    ASSERT_GT(whole.size(), 10000u);
    for (std::size_t length = 0; length < whole.size(); length += length < 2000 ? 1 : 9973) {
        std::ofstream(path_, std::ios::binary | std::ios::trunc)
            .write(whole.data(), static_cast<std::streamsize>(length));
        const std::string error = load_error("density");
        ASSERT_EQ(error.compare(0, path_.size(), path_), 0) << "length " << length << ": " << error;
    }
}

TEST_F(VdbFile, EveryTruncationOfAStreamIsAnError) {
    std::ofstream out(path_, std::ios::binary);
    openvdb::io::Stream(out).write(openvdb::GridCPtrVec{random_grid<openvdb::FloatGrid>(8, 0.5f)});
    out.close();
    const std::vector<char> whole = bytes_of(path_);
    for (std::size_t length = 1; length < whole.size(); length += length < 1000 ? 13 : 4999) {
        std::ofstream(path_, std::ios::binary | std::ios::trunc)
            .write(whole.data(), static_cast<std::streamsize>(length));
        const std::string error = load_error("density");
        ASSERT_EQ(error.compare(0, path_.size(), path_), 0) << "length " << length << ": " << error;
    }
}

/// OpenVDB's own reader would first make room for a name of 3 GB.
TEST_F(VdbFile, ALongNameOfATransformIsAnError) {
    write({random_grid<openvdb::FloatGrid>(8, 0)});
    std::vector<char> bytes = bytes_of(path_);
    const std::string kind = "UniformScaleMap";
    const auto place = std::search(bytes.begin(), bytes.end(), kind.begin(), kind.end());
    ASSERT_NE(place, bytes.end());
    const std::uint32_t length = 3469659854;
    std::memcpy(&*(place - sizeof(length)), &length, sizeof(length));
    std::ofstream(path_, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    EXPECT_NE(load_error("density").find("a name of 3469659854 letters"), std::string::npos)
        << load_error("density");
}

class DamagedVdbFile : public VdbFile, public testing::WithParamInterface<bool> {};
INSTANTIATE_TEST_SUITE_P(WrittenAsStream, DamagedVdbFile, testing::Bool());

TEST_P(DamagedVdbFile, FlippedBytesNeverCrash) {
    const bool stream = GetParam();
    int errors = 0, loads = 0;
    for (const std::uint32_t compression : {kPlain, kZip, kBlosc}) {
        const auto grid = random_grid<openvdb::FloatGrid>(8, 0.5f);
        const auto vectors = openvdb::Vec3SGrid::create();
        vectors->setName("velocity");
        for (auto v = grid->cbeginValueOn(); v; ++v)
            vectors->tree().setValue(v.getCoord(), openvdb::Vec3s(*v, -*v, 1));
        if (stream) {
            std::ofstream out(path_, std::ios::binary);
            openvdb::io::Stream archive(out);
            archive.setCompression(compression);
            archive.write(openvdb::GridCPtrVec{grid, vectors});
        } else {
            write({grid, vectors}, compression);
        }
        const std::vector<char> whole = bytes_of(path_);
        Rng rng(compression + 77);
        for (int n = 0; n < 200; ++n) {
            std::vector<char> damaged = whole;
            for (int flips = n % 5; flips >= 0; --flips) {
                // Half of the damage goes to the first kilobytes, where the counts are.
                const auto range =
                    static_cast<float>(n % 2 ? damaged.size() : std::min<std::size_t>(damaged.size(), 3000));
                damaged[static_cast<std::size_t>(rng.next() * range)] = static_cast<char>(rng.next_uint());
            }
            std::ofstream(path_, std::ios::binary | std::ios::trunc)
                .write(damaged.data(), static_cast<std::streamsize>(damaged.size()));
            for (const std::string& error :
                 {load_error("density"), error_of([&] { load_vector_grid(path_, "velocity"); })}) {
                error.empty() ? ++loads : ++errors;
                ASSERT_TRUE(error.empty() || error.compare(0, path_.size(), path_) == 0) << error;
            }
        }
    }
    EXPECT_GT(errors, 50);  // the test would be idle if nothing were noticed,
    EXPECT_GT(loads, 50);   // or if all damage hit the header
}

// --- Memory
// -----------------------------------------------------------------------------------------------------

#if !defined(__SANITIZE_ADDRESS__)
/// Resident memory in KiB: `VmRSS`, or the peak since the last reset, `VmHWM`.
double status_kib(const std::string& key) {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        double kib = 0;
        if (word == key + ":" && status >> kib)
            return kib;
    }
    return 0;
}

TEST_F(VdbFile, LoadingTakesLittleMoreMemoryThanTheResult) {
    constexpr int kSize = 208;  // 9 million voxels, all different
    for (const bool half : {false, true}) {
        {
            const auto grid = openvdb::FloatGrid::create();
            grid->setName("density");
            grid->setSaveFloatAsHalf(half);
            auto accessor = grid->getAccessor();
            Rng rng(1);
            for (int i = 0; i < kSize; ++i) {
                for (int j = 0; j < kSize; ++j) {
                    for (int k = 0; k < kSize; ++k)
                        accessor.setValue(Coord(i, j, k), rng.next() + 0.01f);
                }
            }
            write({grid});
        }
        malloc_trim(0);
        if (!(std::ofstream("/proc/self/clear_refs") << 5))
            GTEST_SKIP() << "the kernel does not reset peaks";
        const double before = status_kib("VmRSS");
        const LoadedGrid loaded = load_grid(path_, "density");
        const double peak = (status_kib("VmHWM") - before) * 1024;
        const double voxel_bytes = std::pow(kSize, 3) * (half ? 2 : 4);
        EXPECT_LT(peak, (half ? 1.4 : 1.2) * voxel_bytes);
        EXPECT_GT(peak, 0.9 * voxel_bytes);  // or the measurement is broken
    }
}
#endif

}  // namespace
}  // namespace nephele
