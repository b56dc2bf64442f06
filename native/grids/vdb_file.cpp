// SPDX-License-Identifier: GPL-3.0-or-later
// Conversion of OpenVDB grids into BrickGrids: the voxels of each leaf go straight from the stream into their
// brick.

// OpenVDB's headers assert what damaged files break; an assertion would take the host down with it.
#ifndef NDEBUG
#define NDEBUG
#endif

#include "grids/vdb_file.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <new>
#include <stdexcept>
#include <type_traits>

#include <openvdb/math/Transform.h>
#include <openvdb/openvdb.h>

#include "grids/vdb_archive.h"
#include "grids/vdb_tree.h"

namespace nephele {

namespace {

/// What a stored value means to the renderer.
struct ValueMap {
    bool is_level_set = false;
    float fog_scale = 0;  // level sets: 1 / the background, which is half the width of their narrow band
    std::int64_t replaced = 0;

    /// Level sets: 0 outside, growing inwards to 1 across half the narrow band. Others: the value; NaN,
    /// infinite and negative ones become 0, and count as `voxels` replaced.
    template <typename Value>
    float operator()(const Value& value, std::int64_t voxels) {
        auto v = static_cast<float>(value);
        if (is_level_set)
            v = v < 0 ? std::min(-v * fog_scale, 1.0f) : v >= 0 ? 0 : v;
        if (v >= 0 && v <= std::numeric_limits<float>::max())
            return v;
        replaced += voxels;
        return 0;
    }
};

/// The box of all that is set apart from the background.
template <typename Reader>
IndexBox extent_of(const Reader& tree) {
    IndexBox box;
    const auto include = [&](const openvdb::Coord& corner, std::int64_t edge) {
        const int last = static_cast<int>(edge) - 1;
        box.include({corner[0], corner[1], corner[2]});
        box.include({corner[0] + last, corner[1] + last, corner[2] + last});
    };
    for (const auto& tile : tree.tiles())
        include(tile.corner, tile.edge);
    for (const auto& leaf : tree.leaves())
        include(leaf.corner, BrickGrid::kBrickSize);
    return box;
}

template <typename Reader>
std::shared_ptr<const BrickGrid> bricks_of(Reader& tree, VoxelType type, ValueMap& map) {
    BrickGridBuilder builder(extent_of(tree), map(tree.background(), 0), type, tree.leaves().size());
    for (const auto& tile : tree.tiles()) {
        builder.set_tile({tile.corner[0], tile.corner[1], tile.corner[2]}, tile.edge,
                         map(tile.value, tile.edge * tile.edge * tile.edge));
    }
    decltype(tree.background()) values[BrickGrid::kBrickVoxels];
    float voxels[BrickGrid::kBrickVoxels];
    for (const auto& leaf : tree.leaves()) {
        tree.read_leaf(values);
        for (int v = 0; v < BrickGrid::kBrickVoxels; ++v)
            voxels[v] = map(values[v], 1);
        builder.set_brick({leaf.corner[0], leaf.corner[1], leaf.corner[2]}, voxels);
    }
    return builder.finish(tree.active_voxels(), tree.active_bounds());
}

void store_transform(const openvdb::math::Transform& transform, LoadedGrid& out) {
    if (!transform.isLinear()) {
        throw std::runtime_error(
            "has a frustum transform, which is not affine: resample it to a regular grid");
    }
    const openvdb::Mat4d world = transform.baseMap()->getAffineMap()->getMat4();  // for row vectors
    const openvdb::Mat4d index = world.inverse();
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
            const auto at = static_cast<std::size_t>(4 * r + c);
            out.world_from_index[at] = world(c, r);
            out.index_from_world[at] = index(c, r);
            if (!std::isfinite(index(c, r)))
                throw std::runtime_error("has a singular transform");
        }
    }
}

LoadedGrid read_grid(VdbReader& reader, const VdbDescriptor& d) {
    LoadedGrid out;
    const openvdb::MetaMap metadata = reader.read_metadata(d);
    const auto grid_class = metadata.getMetadata<openvdb::StringMetadata>(openvdb::GridBase::META_GRID_CLASS);
    const VdbDescriptor& owner = reader.tree_owner(d);
    store_transform(reader.read_transform(d), out);
    reader.read_transform(owner);
    const bool is_scalar = with_vdb_tree(reader.stream(), owner.type, owner.half, [&](auto& tree) {
        using Value = decltype(tree.background());
        ValueMap map;
        if (std::is_floating_point_v<Value> && grid_class && grid_class->value() == "level set") {
            map.is_level_set = true;
            map.fog_scale = 1 / static_cast<float>(tree.background());
            out.warnings.push_back("is a level set: its inside is taken as a fog of density 1");
        }
        const bool half = std::is_same_v<Value, bool> || (std::is_floating_point_v<Value> && owner.half);
        out.grid =
            bricks_of(tree, half && !map.is_level_set ? VoxelType::half_float : VoxelType::single_float, map);
        if (map.replaced > 0) {
            out.warnings.push_back("has " + std::to_string(map.replaced) +
                                   " voxels that are NaN, infinite or negative: they count as 0");
        }
    });
    if (!is_scalar) {
        throw std::runtime_error("is of type " + d.value_type() + " (" + d.type +
                                 "); a density must be a scalar: float, double, int32, int64, bool or mask");
    }
    return out;
}

GridInfo read_info(VdbReader& reader, const VdbDescriptor& d) {
    GridInfo info{d.shown_name(), d.value_type(), d.half, 0, {}, {}};
    const openvdb::MetaMap metadata = reader.read_metadata(d);
    for (auto m = metadata.beginMeta(); m != metadata.endMeta(); ++m) {
        info.metadata[m->first] = m->second->str();
    }
    // Files usually keep the statistics; where they do not, the topology tells.
    using openvdb::GridBase;
    const auto count = metadata.getMetadata<openvdb::Int64Metadata>(GridBase::META_FILE_VOXEL_COUNT);
    const auto min = metadata.getMetadata<openvdb::Vec3IMetadata>(GridBase::META_FILE_BBOX_MIN);
    const auto max = metadata.getMetadata<openvdb::Vec3IMetadata>(GridBase::META_FILE_BBOX_MAX);
    const auto set_box = [&](const auto& lo, const auto& hi) {
        const IndexBox box{{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
        if (!box.empty())
            info.active_bounds = box;  // empty ones come in all shapes
    };
    if (count && min && max) {
        info.active_voxels = count->value();
        set_box(min->value(), max->value());
        return info;
    }
    const VdbDescriptor& owner = reader.tree_owner(d);
    reader.read_transform(owner);
    const bool is_scalar = with_vdb_tree(reader.stream(), owner.type, owner.half, [&](const auto& tree) {
        info.active_voxels = tree.active_voxels();
        info.active_bounds = tree.active_bounds();
    });
    if (!is_scalar && GridBase::isRegistered(owner.type)) {
        const GridBase::Ptr grid = reader.read_openvdb_grid(owner, false);
        const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
        info.active_voxels = static_cast<std::int64_t>(grid->activeVoxelCount());
        set_box(box.min(), box.max());
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
    const VdbDescriptor& d = naming(
        path, [&]() -> std::reference_wrapper<const VdbDescriptor> { return reader->find(grid_name); });
    const std::string what = path + ": grid \"" + d.shown_name() + '"';
    LoadedGrid out = naming(what, [&] { return read_grid(*reader, d); });
    for (std::string& warning : out.warnings)
        warning = what + ' ' + warning;
    return out;
}

std::vector<GridInfo> list_grids(const std::string& path) {
    return naming(path, [&] {
        VdbReader reader(path);
        std::vector<GridInfo> out;
        for (const VdbDescriptor& d : reader.descriptors())
            out.push_back(read_info(reader, d));
        return out;
    });
}

}  // namespace nephele
