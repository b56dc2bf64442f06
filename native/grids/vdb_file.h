// SPDX-License-Identifier: GPL-3.0-or-later
// Reads grids of OpenVDB files into BrickGrids. vdb_file.cpp is the one file that includes OpenVDB.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "grids/brick_grid.h"

namespace nephele {

/// What grids of numbers and of vectors have in common once read.
struct GridPlacement {
    /// Row-major, column vectors: p_index = index_from_world * p_world, "world" being the file's own space.
    std::array<double, 16> index_from_world{};
    std::array<double, 16> world_from_index{};
    /// Whole sentences, naming file and grid.
    std::vector<std::string> warnings;
    /// Differs between all grids ever read by this process, so that what is built of one can name it.
    std::uint64_t id = 0;
};

struct LoadedGrid : GridPlacement {
    std::shared_ptr<const BrickGrid> grid;  ///< null where the file has no such grid of numbers: see warnings
};

struct LoadedVectorGrid : GridPlacement {
    /// x, y and z on the same voxels; all null where the file has no such grid of vectors: see warnings.
    std::array<std::shared_ptr<const BrickGrid>, 3> components;
};

/// How grids are read.
struct GridOptions {
    enum class Precision { file, half, full } precision = Precision::file;  ///< of the voxels kept
    float clipping = 0;          ///< smaller values count as 0; not where negative ones are kept
    bool keep_negative = false;  ///< as for components of a velocity; densities have none

    auto operator<=>(const GridOptions&) const = default;
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

/// Loads one grid of numbers (float, double, half, int32, int64, bool, mask; halves stay halves). NaN,
/// infinite and negative values become 0 with a warning, and so do, silently, those below the clipping. What
/// cannot be rendered as a volume comes back null with one warning: a grid that the file does not have, level
/// sets, points, strings, vectors. Of several grids of one name the first counts, with a warning. Memory
/// peaks near the size of the result. Thread-safe. Throws std::runtime_error naming file, grid and remedy
/// where the file is missing, no VDB or damaged, the grid has a frustum transform or is too large.
LoadedGrid load_grid(const std::string& path, const std::string& grid_name, const GridOptions& options = {});

/// The same for a grid of vectors (vec3s, vec3d, vec3i, vec3h), in one pass over the file. Vectors with a NaN
/// or infinite component become 0 with a warning; negative components stay, and there is no clipping.
LoadedVectorGrid load_vector_grid(const std::string& path, const std::string& grid_name,
                                  const GridOptions& options = {});

/// Whether grids of GridInfo::type are for load_vector_grid.
bool is_vector_type(const std::string& type);

/// All grids of a file, in the file's order. Throws like load_grid.
std::vector<GridInfo> list_grids(const std::string& path);

}  // namespace nephele
