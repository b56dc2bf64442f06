// SPDX-License-Identifier: GPL-3.0-or-later
// Conversion of OpenVDB grids into BrickGrids: the voxels of each leaf go straight from the stream into their
// brick.

// OpenVDB's headers assert what damaged files break; an assertion would take the host down with it.
#ifndef NDEBUG
#define NDEBUG
#endif

#include "grids/vdb_file.h"

#include <algorithm>
#include <atomic>
#include <cmath>
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

constexpr float kLargestHalf = 65504;

/// What a stored value means to the renderer, and how many voxels it had to change.
class ValueMap {
  public:
    ValueMap(const GridOptions& options, VoxelType type)
        : keep_negative_(options.keep_negative),
          clipping_(options.keep_negative ? -std::numeric_limits<float>::infinity() : options.clipping),
          largest_(type == VoxelType::half_float ? kLargestHalf : std::numeric_limits<float>::max()) {}

    /// The `Count` components of a value that fills `voxels` voxels.
    template <std::size_t Count>
    void operator()(float (&v)[Count], std::int64_t voxels) {
        bool wrong = false, beyond = false;
        for (const float x : v)
            wrong |= !std::isfinite(x) || (x < 0 && !keep_negative_);
        for (float& x : v) {
            beyond |= !wrong && std::fabs(x) > largest_;
            x = wrong || x < clipping_ ? 0 : std::clamp(x, -largest_, largest_);
        }
        wrong_ += wrong ? voxels : 0;
        beyond_ += beyond ? voxels : 0;
    }

    void warn(std::vector<std::string>& warnings) const {
        if (wrong_ > 0) {
            warnings.push_back("has " + std::to_string(wrong_) + " voxels that are NaN" +
                               (keep_negative_ ? " or infinite" : ", infinite or negative") +
                               ": they count as 0");
        }
        if (beyond_ > 0) {
            warnings.push_back("has " + std::to_string(beyond_) +
                               " voxels beyond 65504, the largest number of half precision: they count as "
                               "that; use full precision");
        }
    }

  private:
    bool keep_negative_;
    float clipping_, largest_;
    std::int64_t wrong_ = 0, beyond_ = 0;
};

/// The components of a stored number or vector as floats.
template <typename Value, std::size_t Count>
void to_floats(const Value& value, float (&out)[Count]) {
    if constexpr (Count == 3) {
        for (int a = 0; a < 3; ++a)
            out[a] = static_cast<float>(value[a]);
    } else {
        out[0] = static_cast<float>(value);
    }
}

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

template <std::size_t Count>
using Components = std::array<std::shared_ptr<const BrickGrid>, Count>;

/// The grid, or the grids of its three components, in one pass over the leaves.
template <std::size_t Count, typename Reader>
Components<Count> bricks_of(Reader& tree, VoxelType type, ValueMap& map) {
    float value[Count];
    to_floats(tree.background(), value);
    map(value, 0);
    std::vector<BrickGridBuilder> builders;
    const IndexBox extent = extent_of(tree);
    for (const float background : value)
        builders.emplace_back(extent, background, type, tree.leaves().size());
    for (const auto& tile : tree.tiles()) {
        to_floats(tile.value, value);
        map(value, tile.edge * tile.edge * tile.edge);
        for (std::size_t a = 0; a < Count; ++a)
            builders[a].set_tile({tile.corner[0], tile.corner[1], tile.corner[2]}, tile.edge, value[a]);
    }
    decltype(tree.background()) values[BrickGrid::kBrickVoxels];
    float voxels[Count][BrickGrid::kBrickVoxels];
    for (const auto& leaf : tree.leaves()) {
        tree.read_leaf(values);
        for (int v = 0; v < BrickGrid::kBrickVoxels; ++v) {
            to_floats(values[v], value);
            map(value, 1);
            for (std::size_t a = 0; a < Count; ++a)
                voxels[a][v] = value[a];
        }
        for (std::size_t a = 0; a < Count; ++a)
            builders[a].set_brick({leaf.corner[0], leaf.corner[1], leaf.corner[2]}, voxels[a]);
    }
    Components<Count> out;
    for (std::size_t a = 0; a < Count; ++a)
        out[a] = builders[a].finish(tree.active_voxels(), tree.active_bounds());
    return out;
}

void store_transform(const openvdb::math::Transform& transform, GridPlacement& out) {
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

template <typename Value>
VoxelType voxel_type(GridOptions::Precision precision, bool stored_as_halves) {
    using Precision = GridOptions::Precision;
    using Element = typename openvdb::VecTraits<Value>::ElementType;
    constexpr bool kFits = std::is_same_v<Value, bool> || std::is_same_v<Element, openvdb::math::half>;
    const bool real = openvdb::io::RealToHalf<Value>::isReal;
    const bool half = precision == Precision::half ||
                      (precision == Precision::file && (kFits || (real && stored_as_halves)));
    return half ? VoxelType::half_float : VoxelType::single_float;
}

/// Why a grid of this kind is no volume of `Count` components; empty where it is one.
template <std::size_t Count>
std::string refusal(const VdbDescriptor& d, const openvdb::MetaMap& metadata) {
    const auto grid_class = metadata.getMetadata<openvdb::StringMetadata>(openvdb::GridBase::META_GRID_CLASS);
    if (d.type.starts_with("Tree_pt"))
        return "holds points, not a volume: rasterise them into a fog volume";
    if (Count == 1 && grid_class && grid_class->value() == "level set" && !is_vector_type(d.value_type()))
        return "is a level set, a surface and not a volume: convert it to a fog volume";
    if (is_vector_type(d.value_type()) == (Count == 3))
        return {};
    return "is of type " + d.value_type() + " (" + d.type +
           (Count == 1 ? "); a density must be a number: float, double, half, int32, int64, bool or mask"
                       : "); a velocity must be a vector: vec3s, vec3d, vec3h or vec3i");
}

/// Fills `out`; empty components, with a warning, where the grid is none of that kind.
template <std::size_t Count>
Components<Count> read_grid(VdbReader& reader, const VdbDescriptor& d, const GridOptions& options,
                            GridPlacement& out) {
    Components<Count> grids;
    const VdbDescriptor& owner = reader.tree_owner(d);
    std::string reason = refusal<Count>(d, reader.read_metadata(d));
    if (reason.empty()) {
        store_transform(reader.read_transform(d), out);
        reader.read_transform(owner);
        const bool known = with_vdb_tree(reader.stream(), owner.type, owner.half, [&](auto& tree) {
            using Value = decltype(tree.background());
            if constexpr (kIsVector<Value> == (Count == 3)) {
                const VoxelType type = voxel_type<Value>(options.precision, owner.half);
                ValueMap map(options, type);
                grids = bricks_of<Count>(tree, type, map);
                map.warn(out.warnings);
            }
        });
        if (!known)
            reason = "is of type " + d.value_type() + " (" + d.type + "), which is unknown here";
    }
    if (!reason.empty())
        out.warnings.push_back(reason + "; it is left out");
    return grids;
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
    const bool known = with_vdb_tree(reader.stream(), owner.type, owner.half, [&](const auto& tree) {
        info.active_voxels = tree.active_voxels();
        info.active_bounds = tree.active_bounds();
    });
    if (!known && GridBase::isRegistered(owner.type)) {
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

std::uint64_t next_id() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

/// Reads the grid of that name into `out`; empty components, with a warning, where there is none.
template <std::size_t Count>
Components<Count> load_components(const std::string& path, const std::string& grid_name,
                                  const GridOptions& options, GridPlacement& out) {
    out.id = next_id();
    const auto reader = naming(path, [&] { return std::make_unique<VdbReader>(path); });
    const VdbDescriptor* d = reader->find(grid_name);
    if (!d) {
        out.warnings.push_back(path + " has no grid \"" + grid_name + "\"; its grids: " + reader->names());
        return {};
    }
    const std::string what = path + ": grid \"" + d->shown_name() + '"';
    if (const std::size_t count = reader->count(grid_name); count > 1)
        out.warnings.push_back("is one of " + std::to_string(count) + " of this name: the first is used");
    Components<Count> grids = naming(what, [&] { return read_grid<Count>(*reader, *d, options, out); });
    for (std::string& warning : out.warnings)
        warning = what + ' ' + warning;
    return grids;
}

}  // namespace

LoadedGrid load_grid(const std::string& path, const std::string& grid_name, const GridOptions& options) {
    LoadedGrid out;
    out.grid = load_components<1>(path, grid_name, options, out)[0];
    return out;
}

LoadedVectorGrid load_vector_grid(const std::string& path, const std::string& grid_name,
                                  const GridOptions& options) {
    LoadedVectorGrid out;
    GridOptions signed_options = options;
    signed_options.keep_negative = true;
    out.components = load_components<3>(path, grid_name, signed_options, out);
    return out;
}

bool is_vector_type(const std::string& type) {
    return type == "vec3s" || type == "vec3d" || type == "vec3h" || type == "vec3i";
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
