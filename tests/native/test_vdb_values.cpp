// SPDX-License-Identifier: GPL-3.0-or-later
// What the values of VDB files become: vectors, precision, clipping, kinds of grids that are no volume.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <limits>

#include "grids/vdb_file.h"
#include "math/transform.h"
#include "vdb_fixture.h"

namespace openvdb::OPENVDB_VERSION_NAME {
template <>  // the name that newer OpenVDBs give it
inline const char* typeNameAsString<Vec3H>() {
    return "vec3h";
}
}  // namespace openvdb::OPENVDB_VERSION_NAME

namespace nephele {
namespace {

using Precision = GridOptions::Precision;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();

openvdb::FloatGrid::Ptr density_of(std::initializer_list<float> values) {
    const auto grid = openvdb::FloatGrid::create();
    grid->setName("density");
    int i = 0;
    for (const float value : values)
        grid->tree().setValue(Coord(i++, 0, 0), value);
    return grid;
}

// --- Vectors
// --------------------------------------------------------------------------------------------------

template <typename Grid>
typename Grid::Ptr random_vectors(std::uint64_t seed, const std::string& name = "velocity") {
    using Vector = typename Grid::ValueType;
    const auto grid = Grid::create(Vector(1, -2, 3));
    grid->setName(name);
    Rng rng(seed);
    const auto pick = [&](int n) { return static_cast<int>(rng.next() * static_cast<float>(n)); };
    const auto element = [&] { return static_cast<typename Vector::ValueType>(rng.next() * 20 - 10); };
    for (int n = 0; n < 3000; ++n) {
        const Coord at(pick(40) - 20, pick(40) - 150, pick(300));
        const Vector value(element(), element(), element());
        n % 10 == 0 ? grid->tree().setValueOff(at, value) : grid->tree().setValue(at, value);
    }
    grid->tree().addTile(1, Coord(-300, 8, 16), Vector(3, -4, 5), true);
    return grid;
}

template <typename Grid>
void expect_equal_vectors(const Grid& source, const LoadedVectorGrid& loaded) {
    const auto box = source.evalActiveVoxelBoundingBox();
    for (std::size_t a = 0; a < 3; ++a) {
        const BrickGrid& grid = *loaded.components[a];
        for (auto v = source.cbeginValueAll(); v; ++v) {
            const Coord c = v.getCoord();
            ASSERT_EQ(grid.lookup(c[0], c[1], c[2]), static_cast<float>((*v)[static_cast<int>(a)]));
        }
        EXPECT_EQ(grid.lookup(5000, 0, 0), static_cast<float>(source.background()[static_cast<int>(a)]));
        EXPECT_EQ(grid.active_voxels(), static_cast<std::int64_t>(source.activeVoxelCount()));
        EXPECT_EQ(grid.active_bounds(), (IndexBox{{box.min()[0], box.min()[1], box.min()[2]},
                                                  {box.max()[0], box.max()[1], box.max()[2]}}));
    }
}

template <typename Grid>
class VectorsOf : public VdbFile {};
using VectorGrids = testing::Types<openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>;
TYPED_TEST_SUITE(VectorsOf, VectorGrids);

TYPED_TEST(VectorsOf, GiveEveryComponentBackUnderEveryCompression) {
    for (const std::uint32_t compression : {kPlain, kMasked, kZip, kBlosc}) {
        const auto grid = random_vectors<TypeParam>(compression + 1);
        this->write({grid}, compression);
        const LoadedVectorGrid loaded = load_vector_grid(this->path_, "velocity");
        expect_equal_vectors(*grid, loaded);
        EXPECT_EQ(loaded.components[0]->voxel_type(), VoxelType::single_float);
        EXPECT_TRUE(loaded.warnings.empty());
        EXPECT_TRUE(is_vector_type(list_grids(this->path_).at(0).type));
    }
}

TEST_F(VdbFile, HalvesOfVectorsStayHalves) {
    const auto grid = random_vectors<openvdb::Vec3SGrid>(5);
    grid->setSaveFloatAsHalf(true);
    for (const std::uint32_t compression : {kPlain, kZip, kBlosc}) {
        write({grid}, compression);
        const LoadedVectorGrid loaded = load_vector_grid(path_, "velocity");
        EXPECT_EQ(loaded.components[1]->voxel_type(), VoxelType::half_float);
        openvdb::io::File file(path_);
        file.open();
        expect_equal_vectors(*openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("velocity")), loaded);
    }
}

TEST_F(VdbFile, GridsOfTrueHalvesAreRead) {  // newer OpenVDBs write these
    using openvdb::math::half;
    using HalfGrid = openvdb::Grid<openvdb::tree::Tree4<half, 5, 4, 3>::Type>;
    using VectorGrid = openvdb::Grid<openvdb::tree::Tree4<openvdb::Vec3H, 5, 4, 3>::Type>;
    const auto grid = HalfGrid::create(half(0.0f));
    grid->setName("density");
    grid->tree().setValue(Coord(1, 2, 3), half(0.5f));
    const auto vectors = VectorGrid::create(openvdb::Vec3H(half(0.0f)));
    vectors->setName("velocity");
    vectors->tree().setValue(Coord(1, 2, 3), openvdb::Vec3H(half(0.5f), half(-1.0f), half(2.0f)));
    write({grid, vectors});
    const LoadedGrid loaded = load_grid(path_, "density");
    EXPECT_EQ(loaded.grid->lookup(1, 2, 3), 0.5f);
    EXPECT_EQ(loaded.grid->voxel_type(), VoxelType::half_float);
    EXPECT_EQ(load_vector_grid(path_, "velocity").components[1]->lookup(1, 2, 3), -1.0f);
}

TEST_F(VdbFile, WrongVectorsBecomeZeroAndAreCounted) {
    const auto grid = openvdb::Vec3SGrid::create();
    grid->setName("velocity");
    grid->tree().setValue(Coord(0, 0, 0), openvdb::Vec3s(1, kNan, 2));
    grid->tree().setValue(Coord(1, 0, 0), openvdb::Vec3s(kInfinite, kNan, 2));
    grid->tree().setValue(Coord(2, 0, 0), openvdb::Vec3s(-1, -1e-6f, 2));
    write({grid});
    GridOptions options;
    options.clipping = 0.5f;  // means nothing here
    const LoadedVectorGrid loaded = load_vector_grid(path_, "velocity", options);
    const auto at = [&](int i) {
        const auto& c = loaded.components;
        return Vec3f(c[0]->lookup(i, 0, 0), c[1]->lookup(i, 0, 0), c[2]->lookup(i, 0, 0));
    };
    EXPECT_EQ(at(0), Vec3f(0));
    EXPECT_EQ(at(1), Vec3f(0));
    EXPECT_EQ(at(2), Vec3f(-1, -1e-6f, 2));
    EXPECT_EQ(loaded.warnings,
              std::vector<std::string>{path_ + ": grid \"velocity\" has 2 voxels that are NaN or "
                                               "infinite: they count as 0"});
}

// --- Options
// --------------------------------------------------------------------------------------------------

TEST_F(VdbFile, NegativeNumbersStayWhereAskedFor) {
    write({density_of({-3, 0.25f, kNan, -kInfinite})});
    GridOptions options;
    options.keep_negative = true;
    options.clipping = 0.5f;
    const LoadedGrid loaded = load_grid(path_, "density", options);
    EXPECT_EQ(loaded.grid->lookup(0, 0, 0), -3.0f);
    EXPECT_EQ(loaded.grid->lookup(1, 0, 0), 0.25f);
    EXPECT_EQ(loaded.grid->lookup(2, 0, 0), 0.0f);
    ASSERT_EQ(loaded.warnings.size(), 1u);
    EXPECT_NE(loaded.warnings[0].find("has 2 voxels that are NaN or infinite"), std::string::npos);
    EXPECT_EQ(loaded.grid->trilinear(Vec3f(0.5f, 0, 0)), -1.375f);
    EXPECT_EQ(loaded.grid->bounds(), (IndexBox{{0, 0, 0}, {1, 0, 0}}));
}

TEST_F(VdbFile, ValuesBelowTheClippingAreZero) {
    const auto grid = density_of({0.5f, 0.25f, 0.2499f, -1});
    grid->tree().addTile(1, Coord(8, 0, 0), 0.125f, true);
    write({grid});
    GridOptions options;
    options.clipping = 0.25f;
    const LoadedGrid loaded = load_grid(path_, "density", options);
    EXPECT_EQ(loaded.grid->lookup(0, 0, 0), 0.5f);
    EXPECT_EQ(loaded.grid->lookup(1, 0, 0), 0.25f);
    EXPECT_EQ(loaded.grid->lookup(2, 0, 0), 0.0f);
    EXPECT_EQ(loaded.grid->lookup(9, 0, 0), 0.0f);
    EXPECT_EQ(loaded.grid->bounds(), (IndexBox{{0, 0, 0}, {1, 0, 0}}));
    ASSERT_EQ(loaded.warnings.size(), 1u);  // of the negative one alone
    EXPECT_NE(loaded.warnings[0].find("has 1 voxels"), std::string::npos);
}

TEST_F(VdbFile, PrecisionIsTheFilesOrAsAsked) {
    const auto grid = density_of({1.0f / 3, 2.0f / 3});
    const float as_half = half_to_float(0x3555);  // 1/3
    for (const bool stored_as_half : {false, true}) {
        grid->setSaveFloatAsHalf(stored_as_half);
        write({grid});
        for (const Precision precision : {Precision::file, Precision::half, Precision::full}) {
            const LoadedGrid loaded = load_grid(path_, "density", {precision});
            const bool half =
                precision == Precision::half || (precision == Precision::file && stored_as_half);
            EXPECT_EQ(loaded.grid->voxel_type(), half ? VoxelType::half_float : VoxelType::single_float);
            EXPECT_EQ(loaded.grid->lookup(0, 0, 0), half || stored_as_half ? as_half : 1.0f / 3);
            EXPECT_TRUE(loaded.warnings.empty());
        }
    }
}

TEST_F(VdbFile, WhatHalvesCannotHoldIsCutWithAWarning) {
    write({density_of({1, 65504, 1e6f})});
    const LoadedGrid loaded = load_grid(path_, "density", {Precision::half});
    EXPECT_EQ(loaded.grid->lookup(1, 0, 0), 65504.0f);
    EXPECT_EQ(loaded.grid->lookup(2, 0, 0), 65504.0f);
    ASSERT_EQ(loaded.warnings.size(), 1u);
    EXPECT_NE(loaded.warnings[0].find("has 1 voxels beyond 65504"), std::string::npos);
    EXPECT_EQ(load_grid(path_, "density", {Precision::full}).grid->lookup(2, 0, 0), 1e6f);
}

// --- Kinds
// ----------------------------------------------------------------------------------------------------

TEST_F(VdbFile, WhatIsNoVolumeIsLeftOutWithOneWarning) {
    const auto sphere = openvdb::FloatGrid::create(3);
    sphere->setName("surface");
    sphere->setGridClass(openvdb::GRID_LEVEL_SET);
    sphere->tree().setValue(Coord(0, 0, 0), -1);
    const auto velocity = random_vectors<openvdb::Vec3SGrid>(3);
    using StringGrid = openvdb::Grid<openvdb::tree::Tree4<std::string, 5, 4, 3>::Type>;
    const auto names = StringGrid::create();
    names->setName("names");
    const auto density = density_of({1});
    write({sphere, velocity, names, density});
    const auto expect_refused = [&](const auto& loaded, const auto& first_grid, const char* reason) {
        EXPECT_EQ(first_grid, nullptr);
        ASSERT_EQ(loaded.warnings.size(), 1u);
        EXPECT_EQ(loaded.warnings[0].find(path_ + ": grid \""), 0u) << loaded.warnings[0];
        EXPECT_NE(loaded.warnings[0].find(reason), std::string::npos) << loaded.warnings[0];
        EXPECT_NE(loaded.warnings[0].find("left out"), std::string::npos) << loaded.warnings[0];
    };
    for (const auto& [name, reason] : {std::pair("surface", "level set"),
                                       {"velocity", "is of type vec3s"},
                                       {"names", "is of type string"}}) {
        const LoadedGrid loaded = load_grid(path_, name);
        expect_refused(loaded, loaded.grid, reason);
    }
    for (const auto& [name, reason] :
         {std::pair("density", "is of type float"), {"names", "is of type string"}}) {
        const LoadedVectorGrid loaded = load_vector_grid(path_, name);
        expect_refused(loaded, loaded.components[0], reason);
    }
}

TEST_F(VdbFile, AbsentGridsAreAWarning) {
    write({random_grid<openvdb::FloatGrid>(1, 0, "smoke"), random_grid<openvdb::FloatGrid>(2, 0, "heat")});
    const std::vector<std::string> expected{path_ + " has no grid \"density\"; its grids: smoke, heat"};
    const LoadedGrid loaded = load_grid(path_, "density");
    EXPECT_EQ(loaded.grid, nullptr);
    EXPECT_EQ(loaded.warnings, expected);
    EXPECT_EQ(load_vector_grid(path_, "density").warnings, expected);
}

TEST_F(VdbFile, EveryGridOfAFluidCacheIsReadOrRefused) {
    const fs::path path = fs::path(__FILE__).parent_path() / "../../../shared/data/c42_fluid_data_0001.vdb";
    if (!fs::exists(path))
        GTEST_SKIP() << "no file " << path;
    openvdb::io::File file(path);
    file.open(false);
    int numbers = 0, vectors = 0, level_sets = 0;
    for (const GridInfo& info : list_grids(path)) {
        const openvdb::GridBase::Ptr grid = file.readGrid(info.name);
        if (info.type == "vec3s") {
            ++vectors;
            expect_equal_vectors(*openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid),
                                 load_vector_grid(path, info.name));
            continue;
        }
        GridOptions options;
        options.keep_negative = true;  // some have voxels a little below 0
        const LoadedGrid loaded = load_grid(path, info.name, options);
        if (grid->getGridClass() == openvdb::GRID_LEVEL_SET) {
            ++level_sets;
            EXPECT_EQ(loaded.grid, nullptr);
            continue;
        }
        ++numbers;
        ASSERT_NE(loaded.grid, nullptr) << info.name;
        EXPECT_EQ(loaded.grid->active_voxels(), info.active_voxels);
        const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
        const auto integers = openvdb::gridPtrCast<openvdb::Int32Grid>(grid);
        floats ? expect_equal(*floats, *loaded.grid) : expect_equal(*integers, *loaded.grid);
    }
    EXPECT_EQ(numbers, 18);
    EXPECT_EQ(vectors, 2);
    EXPECT_EQ(level_sets, 4);
}

// --- Far from the origin
// --------------------------------------------------------------------------------------

TEST_F(VdbFile, OffsetsThatTheObjectCancelsCostNoPrecision) {
    const double voxel = 0.01, offset = 1e6;
    openvdb::Mat4d near(0.8, 0.6, 0.0, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 0.5, -2.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    near.postScale(openvdb::Vec3d(voxel));  // rotated, sheared, mirrored
    near.postTranslate(openvdb::Vec3d(0.25, 0.5, 0.75));
    openvdb::Mat4d far = near;
    far.postTranslate(openvdb::Vec3d(offset, -offset, offset));
    double world_from_object[16] = {1, 0, 0, -offset, 0, 1, 0, offset, 0, 0, 1, -offset, 0, 0, 0, 1};
    const auto grid = random_grid<openvdb::FloatGrid>(6, 0);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(far));
    write({grid});
    const LoadedGrid loaded = load_grid(path_, "density");
    double object_from_index[16], world_from_index[16];
    std::copy(loaded.world_from_index.begin(), loaded.world_from_index.end(), object_from_index);
    multiply(world_from_object, object_from_index, world_from_index);
    const Transform index_from_world = inverse_of(world_from_index);
    for (const openvdb::Vec3d p : {openvdb::Vec3d(0, 0, 0), {10.5, -3.25, 7}, {-100, 200, 300}}) {
        const openvdb::Vec3d world = near.transform(p);  // as if the file stood here
        const Vec3f q = index_from_world.point(
            Vec3f(static_cast<float>(world[0]), static_cast<float>(world[1]), static_cast<float>(world[2])));
        for (int a = 0; a < 3; ++a)  // floats of some 300 voxels; 1e-10 m of double rounding adds 1e-8 voxels
            EXPECT_NEAR(q[a], p[a], 2e-4);
    }
}

}  // namespace
}  // namespace nephele
