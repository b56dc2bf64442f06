// SPDX-License-Identifier: GPL-3.0-or-later
// Reading of OpenVDB files: files are written with OpenVDB itself, read back, and damaged in every way we
// know.
#include "grids/vdb_file.h"

#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <fstream>
#include <limits>
#include <thread>

#include "vdb_fixture.h"

namespace nephele {
namespace {

template <typename Grid>
class VdbFileOf : public VdbFile {};
using ScalarGrids =
    testing::Types<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::BoolGrid>;
TYPED_TEST_SUITE(VdbFileOf, ScalarGrids);

TYPED_TEST(VdbFileOf, GivesEveryValueBackUnderEveryCompression) {
    for (const std::uint32_t compression : {kPlain, kMasked, kZip, kBlosc}) {
        const auto grid = random_grid<TypeParam>(compression + 1, compression % 2 ? 0 : 1);
        this->write({grid}, compression);
        const LoadedGrid loaded = load_grid(this->path_, "density");
        expect_equal(*grid, *loaded.grid);
        EXPECT_TRUE(loaded.warnings.empty());
    }
}

TEST_F(VdbFile, HalvesStayHalves) {
    const auto grid = random_grid<openvdb::FloatGrid>(5, 0);
    grid->setSaveFloatAsHalf(true);
    write({grid});
    const LoadedGrid loaded = load_grid(path_, "density");
    EXPECT_EQ(loaded.grid->voxel_type(), VoxelType::half_float);
    openvdb::io::File file(path_);
    file.open();
    expect_equal(*openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density")), *loaded.grid);
    EXPECT_TRUE(list_grids(path_).at(0).half);
}

TEST_F(VdbFile, MasksAreOneWhereTheyAreOn) {
    const auto mask = openvdb::MaskGrid::create();
    mask->setName("density");
    mask->tree().setValueOn(Coord(1, 2, 3));
    mask->tree().addTile(1, Coord(16, 0, 0), true, true);
    write({mask});
    const LoadedGrid loaded = load_grid(path_, "density");
    EXPECT_EQ(loaded.grid->lookup(1, 2, 3), 1.0f);
    EXPECT_EQ(loaded.grid->lookup(1, 2, 4), 0.0f);
    EXPECT_EQ(loaded.grid->lookup(17, 7, 7), 1.0f);
}

TEST_F(VdbFile, AnyAffineTransformComesInColumnConvention) {
    // A mirror, a shear, a rotation and unequal scales at once; OpenVDB writes it for row vectors.
    const openvdb::Mat4d m(-2.0, 0.5, 0.0, 0.0, 0.25, 0.75, -1.0, 0.0, 0.1, 1.0, 3.0, 0.0, 10.0, -20.0, 30.0,
                           1.0);
    const auto grid = random_grid<openvdb::FloatGrid>(6, 0);
    for (const auto& transform : {openvdb::math::Transform::createLinearTransform(m),
                                  openvdb::math::Transform::createLinearTransform(0.05)}) {
        grid->setTransform(transform);
        write({grid});
        const LoadedGrid loaded = load_grid(path_, "density");
        const openvdb::Vec3d p(1.5, -2.25, 7), world = transform->indexToWorld(p);
        for (std::size_t r = 0; r < 3; ++r) {
            const double* w = &loaded.world_from_index[4 * r];
            const double* i = &loaded.index_from_world[4 * r];
            EXPECT_NEAR(w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + w[3], world[static_cast<int>(r)], 1e-12);
            EXPECT_NEAR(i[0] * world[0] + i[1] * world[1] + i[2] * world[2] + i[3], p[static_cast<int>(r)],
                        1e-9);
        }
        EXPECT_EQ(loaded.index_from_world[15], 1.0);
    }
}

TEST_F(VdbFile, RefusesFrusta) {
    const auto frustum = random_grid<openvdb::FloatGrid>(7, 0, "frustum");
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(100)), 0.5, 10, 0.1));
    write({frustum});
    const std::string error = load_error("frustum");
    EXPECT_NE(error.find("frustum transform"), std::string::npos);
    EXPECT_NE(error.find(path_ + ": grid \"frustum\""), std::string::npos) << error;
}

TEST_F(VdbFile, ErrorsNameTheFileAndTheRemedy) {
    EXPECT_EQ(load_error("density"), path_ + " cannot be opened: check that the file exists and may be read");
    std::ofstream(path_) << "this is a text, not a volume";
    EXPECT_EQ(load_error("density"), path_ + " is not an OpenVDB file");
    std::ofstream(path_, std::ios::trunc) << "x";
    EXPECT_EQ(load_error("density"), path_ + " is not an OpenVDB file");
    EXPECT_NE(error_of([&] { list_grids(folder_.string()); }).find("cannot be opened"), std::string::npos);
}

TEST_F(VdbFile, EmptyGridsAreEmpty) {
    write({openvdb::createGrid<openvdb::FloatGrid>(0.0f)});
    const std::string name = list_grids(path_).at(0).name;
    const LoadedGrid loaded = load_grid(path_, name);
    EXPECT_TRUE(loaded.grid->bounds().empty());
    EXPECT_TRUE(loaded.grid->active_bounds().empty());
    EXPECT_EQ(loaded.grid->lookup(1, 2, 3), 0.0f);
}

TEST_F(VdbFile, RefusesHugeExtents) {
    const auto grid = openvdb::FloatGrid::create();
    grid->setName("density");
    grid->tree().setValue(Coord(-8000000, -8000000, -8000000), 1);
    grid->tree().setValue(Coord(8000000, 8000000, 8000000), 1);
    write({grid});
    EXPECT_NE(load_error("density").find("2^24 blocks"), std::string::npos) << load_error("density");
    grid->tree().setValue(Coord(2147483647, 0, 0), 1);
    write({grid});
    EXPECT_NE(load_error("density").find("origin of index space"), std::string::npos)
        << load_error("density");
}

TEST_F(VdbFile, WrongValuesBecomeZeroAndAreCounted) {
    const auto grid = openvdb::FloatGrid::create();
    grid->setName("density");
    grid->tree().setValue(Coord(0, 0, 0), std::numeric_limits<float>::quiet_NaN());
    grid->tree().setValue(Coord(1, 0, 0), std::numeric_limits<float>::infinity());
    grid->tree().setValue(Coord(2, 0, 0), -1e-3f);
    grid->tree().setValue(Coord(3, 0, 0), 0.5f);
    grid->tree().addTile(1, Coord(8, 0, 0), -2, true);
    write({grid});
    const LoadedGrid loaded = load_grid(path_, "density");
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(loaded.grid->lookup(i, 0, 0), 0.0f);
    EXPECT_EQ(loaded.grid->lookup(3, 0, 0), 0.5f);
    EXPECT_EQ(loaded.grid->lookup(9, 1, 1), 0.0f);
    ASSERT_EQ(loaded.warnings.size(), 1u);
    EXPECT_EQ(
        loaded.warnings[0],
        path_ + ": grid \"density\" has 515 voxels that are NaN, infinite or negative: they count as 0");
}

TEST_F(VdbFile, SharedTreesAndEqualNamesAreFound) {
    const auto first = random_grid<openvdb::FloatGrid>(8, 0, "density");
    const auto shared = openvdb::FloatGrid::create(first->treePtr());
    shared->setName("shared");
    shared->setTransform(openvdb::math::Transform::createLinearTransform(4.0));
    const auto second = random_grid<openvdb::FloatGrid>(9, 0, "density");
    write({first, shared, second});
    const LoadedGrid instance = load_grid(path_, "shared");
    expect_equal(*first, *instance.grid);
    EXPECT_EQ(instance.world_from_index[0], 4.0);
    const LoadedGrid one_of_two = load_grid(path_, "density");
    expect_equal(*first, *one_of_two.grid);
    EXPECT_EQ(one_of_two.warnings,
              std::vector<std::string>{path_ +
                                       ": grid \"density[0]\" is one of 2 of this name: the first is used"});
    EXPECT_TRUE(load_grid(path_, "density[1]").warnings.empty());
    expect_equal(*second, *load_grid(path_, "density[1]").grid);
    EXPECT_EQ(list_grids(path_).at(1).active_voxels, static_cast<std::int64_t>(first->activeVoxelCount()));
}

TEST_F(VdbFile, ReadsFilesWrittenAsStreams) {  // these hold no offsets
    const auto first = random_grid<openvdb::FloatGrid>(8, 0, "first"),
               second = random_grid<openvdb::FloatGrid>(9, 0, "second");
    std::ofstream out(path_, std::ios::binary);
    openvdb::io::Stream(out).write(openvdb::GridCPtrVec{first, second});
    out.close();
    expect_equal(*second, *load_grid(path_, "second").grid);
    expect_equal(*first, *load_grid(path_, "first").grid);
}

TEST_F(VdbFile, ListsGridsWithOrWithoutStoredStatistics) {
    const auto density = random_grid<openvdb::FloatGrid>(8, 0);
    density->setGridClass(openvdb::GRID_FOG_VOLUME);
    density->insertMeta("author", openvdb::StringMetadata("someone"));
    const auto velocity = openvdb::Vec3SGrid::create();
    velocity->setName("velocity");
    for (const bool statistics : {true, false}) {
        openvdb::io::File file(path_);
        file.setGridStatsMetadataEnabled(statistics);
        file.write(openvdb::GridCPtrVec{density, velocity});
        const std::vector<GridInfo> grids = list_grids(path_);
        ASSERT_EQ(grids.size(), 2u);
        EXPECT_EQ(grids[0].name, "density");
        EXPECT_EQ(grids[0].type, "float");
        EXPECT_EQ(grids[0].active_voxels, static_cast<std::int64_t>(density->activeVoxelCount()));
        EXPECT_EQ(grids[0].active_bounds, load_grid(path_, "density").grid->active_bounds());
        EXPECT_EQ(grids[0].metadata.at("author"), "someone");
        EXPECT_EQ(grids[0].metadata.at("class"), "fog volume");
        EXPECT_EQ(grids[1].type, "vec3s");
        EXPECT_EQ(grids[1].active_voxels, 0);
        EXPECT_TRUE(grids[1].active_bounds.empty());
    }
}

TEST_F(VdbFile, LoadsFromManyThreadsAtOnce) {
    const auto grid = random_grid<openvdb::FloatGrid>(8, 0);
    write({grid});
    std::array<LoadedGrid, 4> loaded;
    std::vector<std::thread> threads;
    for (LoadedGrid& l : loaded)
        threads.emplace_back([&] { l = load_grid(path_, "density"); });
    for (std::thread& t : threads)
        t.join();
    for (const LoadedGrid& l : loaded)
        expect_equal(*grid, *l.grid);
}

// --- Files of others
// --------------------------------------------------------------------------------------------

struct KnownFile {
    const char* file;
    std::int64_t active_voxels;
    VoxelType type;
};

void PrintTo(const KnownFile& known, std::ostream* out) {
    *out << known.file;
}

class RealVdbFile : public testing::TestWithParam<KnownFile> {};
INSTANTIATE_TEST_SUITE_P(
    Files, RealVdbFile,
    testing::Values(KnownFile{"wdas_cloud_sixteenth.vdb", 415642, VoxelType::single_float},
                    KnownFile{"openvdb_smoke1.vdb", 1049275, VoxelType::half_float},
                    KnownFile{"usd_smoke_000003.vdb", 90197, VoxelType::single_float},
                    KnownFile{"sergeneren_box21.vdb", 9261, VoxelType::single_float},
                    KnownFile{"c42_fluid_data_0001.vdb", 1665, VoxelType::half_float},
                    KnownFile{"gaffer_arnold_sphere.vdb", 465, VoxelType::single_float}));

TEST_P(RealVdbFile, LoadsAsOpenVdbItselfReadsIt) {
    const fs::path folder = fs::path(__FILE__).parent_path() / "../../../shared/data";
    if (!fs::exists(folder))
        GTEST_SKIP() << "no folder " << folder;
    const std::string path = (folder / GetParam().file).string();
    const LoadedGrid loaded = load_grid(path, "density");
    EXPECT_EQ(loaded.grid->active_voxels(), GetParam().active_voxels);
    EXPECT_EQ(loaded.grid->voxel_type(), GetParam().type);
    EXPECT_TRUE(loaded.warnings.empty());
    openvdb::initialize();
    openvdb::io::File file(path);
    file.open(false);
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
    expect_equal(*grid, *loaded.grid);
}

}  // namespace
}  // namespace nephele
