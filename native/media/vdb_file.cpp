// SPDX-License-Identifier: GPL-3.0-or-later
// Conversion of OpenVDB trees into BrickGrids.
//
// A tree's topology is read first, then the voxels of each leaf pass through one scratch leaf into their brick, in the
// order of the file: the peak of memory is the result plus the topology, about 5 %.

// OpenVDB's headers assert what damaged files break; an assertion would take the host down with it.
#ifndef NDEBUG
#define NDEBUG
#endif

#include "media/vdb_file.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <new>
#include <stdexcept>
#include <type_traits>

#include <openvdb/math/Transform.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetUtil.h>

#include "media/vdb_archive.h"

namespace nephele {

namespace {

using openvdb::Coord;

// --- From tree to bricks ----------------------------------------------------------------------------------------

/// A value as the renderer can use it; NaN, infinite and negative ones are 0.
template <typename Value>
float cleaned(const Value& value) {
    const auto v = static_cast<float>(value);
    return v >= 0 && v <= std::numeric_limits<float>::max() ? v : 0;
}

template <typename Vec3>
IndexBox index_box(const Vec3& min, const Vec3& max) {
    const IndexBox box{{min[0], min[1], min[2]}, {max[0], max[1], max[2]}};
    return box.empty() ? IndexBox{} : box;
}

/// Calls visit(corner, edge, value) for all constant cubes of a tree.
template <typename Tree, typename Visit>
void visit_tiles(const Tree& tree, const Visit& visit) {
    using Upper = typename Tree::RootNodeType::ChildNodeType;
    using Lower = typename Upper::ChildNodeType;
    for (auto t = tree.root().cbeginValueAll(); t; ++t) visit(t.getCoord(), Upper::DIM, *t);
    for (auto upper = tree.root().cbeginChildOn(); upper; ++upper) {
        for (auto t = upper->cbeginValueAll(); t; ++t) visit(t.getCoord(), Lower::DIM, *t);
        for (auto lower = upper->cbeginChildOn(); lower; ++lower) {
            for (auto t = lower->cbeginValueAll(); t; ++t) visit(t.getCoord(), Tree::LeafNodeType::DIM, *t);
        }
    }
}

/// Calls visit(leaf) for all leaves, in the order in which files hold their voxels.
template <typename Tree, typename Visit>
void visit_leaves(const Tree& tree, const Visit& visit) {
    for (auto upper = tree.root().cbeginChildOn(); upper; ++upper) {
        for (auto lower = upper->cbeginChildOn(); lower; ++lower) {
            for (auto leaf = lower->cbeginChildOn(); leaf; ++leaf) visit(*leaf);
        }
    }
}

/// The box of all that a tree's topology sets apart from the background, and the number of its leaves.
template <typename Tree>
IndexBox survey(const Tree& tree, std::size_t& leaves) {
    constexpr std::int64_t kLimit = INT32_MAX;
    IndexBox box{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    const auto include = [&](const Coord& corner, std::int64_t edge) {
        for (std::size_t a = 0; a < 3; ++a) {
            const std::int64_t first = corner[static_cast<int>(a)];
            box.min[a] = std::min(box.min[a], static_cast<int>(first));
            box.max[a] = std::max(box.max[a], static_cast<int>(std::min(first + edge - 1, kLimit)));
        }
    };
    const float background = cleaned(tree.background());
    visit_tiles(tree, [&](const Coord& corner, std::int64_t edge, const auto& value) {
        if (cleaned(value) != background) include(corner, edge);
    });
    leaves = 0;
    visit_leaves(tree, [&](const auto& leaf) {
        include(leaf.origin(), leaf.dim());
        ++leaves;
    });
    return box;
}

/// Bricks of a tree whose topology has been read. Its leaves' values are in the tree, or else come from `stream`.
/// `replaced` receives the number of voxels that were NaN, infinite or negative.
template <typename Tree>
std::shared_ptr<const BrickGrid> bricks_of(const Tree& tree, VoxelType type, std::istream* stream, bool half,
                                           std::int64_t& replaced) {
    using Leaf = typename Tree::LeafNodeType;
    static_assert(Leaf::DIM == BrickGrid::kBrickSize && Tree::RootNodeType::ChildNodeType::ChildNodeType::DIM ==
                                                            BrickGrid::kBlockSize);
    std::size_t leaves = 0;
    const IndexBox extent = survey(tree, leaves);
    const float background = cleaned(tree.background());
    replaced = 0;
    const auto clean = [&](const auto& value, std::int64_t voxels) {
        const float v = cleaned(value);
        if (v != static_cast<float>(value)) replaced += voxels;
        return v;
    };
    BrickGridBuilder builder(extent, background, type, leaves);
    visit_tiles(tree, [&](const Coord& corner, std::int64_t edge, const auto& value) {
        const bool is_background = value == tree.background();
        const float v = is_background ? background : clean(value, edge * edge * edge);
        if (v != background) builder.set_tile({corner[0], corner[1], corner[2]}, edge, v);
    });
    Leaf scratch;
    float voxels[BrickGrid::kBrickVoxels];
    visit_leaves(tree, [&](const Leaf& leaf) {
        const Coord corner = leaf.origin();
        if (stream) {
            scratch.setValueMask(leaf.getValueMask());
            scratch.readBuffers(*stream, half);
        }
        const Leaf& source = stream ? scratch : leaf;
        for (openvdb::Index v = 0; v < Leaf::SIZE; ++v) voxels[v] = clean(source.getValue(v), 1);
        builder.set_brick({corner[0], corner[1], corner[2]}, voxels);
    });
    openvdb::CoordBBox active;
    tree.evalActiveVoxelBoundingBox(active);
    return builder.finish(static_cast<std::int64_t>(tree.activeVoxelCount()), index_box(active.min(), active.max()));
}

/// Reads the tree of `grid`, in front of which the reader stands.
template <typename Grid>
void read_tree(VdbReader& reader, Grid& grid, const VdbDescriptor& owner, LoadedGrid& out) {
    constexpr bool is_real = std::is_floating_point_v<typename Grid::ValueType>;
    constexpr bool is_bool = std::is_same_v<typename Grid::ValueType, bool>;
    std::istream* stream = &reader.stream();
    grid.readTopology(*stream);
    VoxelType type = (is_real && owner.half) || is_bool ? VoxelType::half_float : VoxelType::single_float;
    if constexpr (is_real) {
        if (grid.getGridClass() == openvdb::GRID_LEVEL_SET) {
            grid.readBuffers(*stream);
            stream = nullptr;
            openvdb::tools::sdfToFogVolume(grid);
            type = VoxelType::single_float;
            out.warnings.push_back("is a level set: its inside is taken as a fog of density 1");
        }
    }
    std::int64_t replaced = 0;
    out.grid = bricks_of(grid.tree(), type, stream, owner.half, replaced);
    if (replaced > 0) {
        out.warnings.push_back("has " + std::to_string(replaced) +
                               " voxels that are NaN, infinite or negative: they count as 0");
    }
}

/// Calls read_tree for the one of `Grids` that `grid` is; false where it is none of them.
template <typename... Grids>
bool read_tree_as(VdbReader& reader, openvdb::GridBase& grid, const VdbDescriptor& owner, LoadedGrid& out) {
    const auto attempt = [&]<typename Grid>(const Grid*) {
        if (!grid.isType<Grid>()) return false;
        read_tree(reader, static_cast<Grid&>(grid), owner, out);
        return true;
    };
    return (attempt(static_cast<const Grids*>(nullptr)) || ...);
}

void read_transform(const openvdb::math::Transform& transform, LoadedGrid& out) {
    if (!transform.isLinear()) {
        throw std::runtime_error("has a frustum transform, which is not affine: resample it to a regular grid");
    }
    const openvdb::Mat4d world = transform.baseMap()->getAffineMap()->getMat4();  // for row vectors
    const openvdb::Mat4d index = world.inverse();
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
            const auto at = static_cast<std::size_t>(4 * r + c);
            out.world_from_index[at] = world(c, r);
            out.index_from_world[at] = index(c, r);
            if (!std::isfinite(index(c, r))) throw std::runtime_error("has a singular transform");
        }
    }
}

LoadedGrid read_grid(VdbReader& reader, const VdbDescriptor& d) {
    LoadedGrid out;
    openvdb::GridBase::Ptr grid = reader.read_head(d);
    read_transform(grid->transform(), out);
    const VdbDescriptor& owner = reader.tree_owner(d);
    if (&owner != &d) {
        const openvdb::GridClass grid_class = grid->getGridClass();
        grid = reader.read_head(owner);
        grid->setGridClass(grid_class);
    }
    if (!read_tree_as<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                      openvdb::BoolGrid, openvdb::MaskGrid>(reader, *grid, owner, out)) {
        throw std::runtime_error("is of type " + grid->valueType() +
                                 "; a density must be a scalar: float, double, int32, int64 or bool");
    }
    return out;
}

GridInfo read_info(VdbReader& reader, const VdbDescriptor& d) {
    GridInfo info{d.shown_name(), d.type, d.half, 0, {}, {}};
    openvdb::MetaMap metadata = reader.read_metadata(d);
    metadata.removeMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD);
    for (auto m = metadata.beginMeta(); m != metadata.endMeta(); ++m) info.metadata[m->first] = m->second->str();
    if (!openvdb::GridBase::isRegistered(d.type)) return info;

    // Files usually keep the statistics; where they do not, the topology tells.
    using openvdb::GridBase;
    const auto count = metadata.getMetadata<openvdb::Int64Metadata>(GridBase::META_FILE_VOXEL_COUNT);
    const auto min = metadata.getMetadata<openvdb::Vec3IMetadata>(GridBase::META_FILE_BBOX_MIN);
    const auto max = metadata.getMetadata<openvdb::Vec3IMetadata>(GridBase::META_FILE_BBOX_MAX);
    if (count && min && max) {
        info.type = GridBase::createGrid(d.type)->valueType();
        info.active_voxels = count->value();
        info.active_bounds = index_box(min->value(), max->value());
    } else {
        const GridBase::Ptr grid = reader.read_head(reader.tree_owner(d));
        grid->readTopology(reader.stream());
        const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
        info.type = grid->valueType();
        info.active_voxels = static_cast<std::int64_t>(grid->activeVoxelCount());
        info.active_bounds = index_box(box.min(), box.max());
    }
    return info;
}

/// Runs f; whatever it throws comes out as one std::runtime_error that begins with the file (and grid).
template <typename F>
auto naming(const std::string& what, const F& f) {
    try {
        return f();
    } catch (const std::ios_base::failure&) {
        throw std::runtime_error(what + " is truncated or damaged: write or copy it again");
    } catch (const std::bad_alloc&) {
        throw std::runtime_error(what + " is damaged, or too large for the memory of this machine");
    } catch (const openvdb::Exception& e) {
        throw std::runtime_error(what + " cannot be read, OpenVDB says: " + e.what());
    } catch (const std::exception& e) {
        throw std::runtime_error(what + ' ' + e.what());
    }
}

}  // namespace

LoadedGrid load_grid(const std::string& path, const std::string& grid_name) {
    const auto reader = naming(path, [&] { return std::make_unique<VdbReader>(path); });
    const VdbDescriptor& d = naming(path, [&]() -> std::reference_wrapper<const VdbDescriptor> {
        return reader->find(grid_name);
    });
    const std::string what = path + ": grid \"" + d.shown_name() + '"';
    LoadedGrid out = naming(what, [&] { return read_grid(*reader, d); });
    for (std::string& warning : out.warnings) warning = what + ' ' + warning;
    return out;
}

std::vector<GridInfo> list_grids(const std::string& path) {
    return naming(path, [&] {
        VdbReader reader(path);
        std::vector<GridInfo> out;
        for (const VdbDescriptor& d : reader.descriptors()) out.push_back(read_info(reader, d));
        return out;
    });
}

}  // namespace nephele
