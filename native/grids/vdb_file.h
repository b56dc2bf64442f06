// SPDX-License-Identifier: GPL-3.0-or-later
// Reads scalar grids of OpenVDB files into BrickGrids. vdb_file.cpp is the one file that includes OpenVDB.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "grids/brick_grid.h"

namespace nephele {

struct LoadedGrid {
    std::shared_ptr<const BrickGrid> grid;
    /// Row-major, column vectors: p_index = index_from_world * p_world, "world" being the file's own space.
    std::array<double, 16> index_from_world{};
    std::array<double, 16> world_from_index{};
    std::vector<std::string> warnings;
};

/// How grids are read.
struct GridOptions {
    enum class Precision { file, half, full } precision = Precision::file;  ///< of the voxels kept
    float clipping = 0;  ///< smaller values count as 0
};

/// What a file tells of a grid without its voxels.
struct GridInfo {
    std::string name;
    std::string type;   ///< OpenVDB's name of the value type: "float", "vec3s", ...
    bool half = false;  ///< values are stored as halves
    std::int64_t active_voxels = 0;
    IndexBox active_bounds;
    std::map<std::string, std::string> metadata;
};

/// Loads one scalar grid (float, double, int32, int64, bool; halves stay halves). NaN, infinite and negative
/// values become 0 with a warning; a level set becomes the fog of its interior with a warning. Memory peaks
/// near the size of the result. Thread-safe. Throws std::runtime_error naming file, grid and remedy where the
/// file is missing, no VDB or damaged, the grid is absent, not scalar, not affine, or too large.
LoadedGrid load_grid(const std::string& path, const std::string& grid_name);

/// All grids of a file, in the file's order. Throws like load_grid.
std::vector<GridInfo> list_grids(const std::string& path);

}  // namespace nephele
