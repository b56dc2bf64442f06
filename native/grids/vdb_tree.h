// SPDX-License-Identifier: GPL-3.0-or-later
// The tree of an OpenVDB grid of numbers or vectors, as its bytes stream by. Only vdb_file.cpp may include
// this.
//
// The format (versions 222 and newer): root, then upper nodes of 32^3 lower nodes of 16^3 leaves, depth
// first, with masks and tile values; then, in the same order, the voxels of the leaves. Parsing it here, with
// OpenVDB's own masks and decompressors, has two reasons. Leaves pass through one at a time, so that loading
// takes little more memory than its result. And every size is checked before it is used: OpenVDB writes
// beyond its buffers where a damaged file gives a block a wrong size.
#pragma once

#include <cstdint>
#include <cstring>
#include <istream>
#include <memory>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <type_traits>
#include <vector>

#include <openvdb/io/Compression.h>
#include <openvdb/openvdb.h>

#include "grids/brick_grid.h"

namespace nephele {

/// A stream that reads from memory and throws at its end.
class MemoryStream : private std::streambuf, public std::istream {
  public:
    MemoryStream() : std::istream(static_cast<std::streambuf*>(this)) { exceptions(failbit | badbit); }
    void set(std::vector<char>& bytes) {
        setg(bytes.data(), bytes.data(), bytes.data() + bytes.size());
        clear();
    }
};

enum class VdbLeafKind { values, bools, mask };

/// Value: one of those in with_vdb_tree(). The stream must throw at its end and carry OpenVDB's tags.
template <typename Value>
class VdbTreeReader {
  public:
    using LeafMask = openvdb::util::NodeMask<3>;
    struct Tile {
        openvdb::Coord corner;
        std::int64_t edge;
        Value value;
    };
    struct Leaf {
        openvdb::Coord corner;
        LeafMask active;
    };
    static constexpr openvdb::Index kLeafVoxels = LeafMask::SIZE;

    VdbTreeReader(std::istream& stream, bool reals_are_halves, VdbLeafKind kind)
        : stream_(stream),
          half_(reals_are_halves && openvdb::io::RealToHalf<Value>::isReal),
          kind_(kind),
          compression_(openvdb::io::getDataCompression(stream)) {}

    void read_topology();
    /// The 512 values of each leaf, z fastest; to be called once for each of leaves(), in order.
    void read_leaf(Value* values);

    Value background() const { return background_; }
    /// All tiles whose value is not the background's.
    const std::vector<Tile>& tiles() const { return tiles_; }
    const std::vector<Leaf>& leaves() const { return leaves_; }
    std::int64_t active_voxels() const { return active_voxels_; }
    const IndexBox& active_bounds() const { return active_bounds_; }

  private:
    template <int Log2Dim>
    void read_node(const openvdb::Coord& corner);
    template <typename Mask>
    void read_values(Value* out, const Mask& active);
    void read_block(Value* out, openvdb::Index count);
    void add_tile(const openvdb::Coord& corner, std::int64_t edge, Value value, bool active);
    void add_leaf(const openvdb::Coord& corner);

    template <typename T>
    T read() {
        T value{};
        stream_.read(reinterpret_cast<char*>(&value), sizeof(T));
        make_sound(&value, 1);
        return value;
    }
    /// Any byte but 0 is true: those of a damaged file need not be truth values of C++.
    template <typename T>
    static void make_sound(T* values, std::size_t count) {
        if constexpr (std::is_same_v<T, bool>) {
            auto* bytes = reinterpret_cast<unsigned char*>(values);
            for (std::size_t i = 0; i < count; ++i)
                bytes[i] = bytes[i] != 0 ? 1 : 0;
        }
    }
    [[noreturn]] static void damaged() {
        throw std::runtime_error("is damaged: write or copy the file again");
    }

    std::istream& stream_;
    bool half_;
    VdbLeafKind kind_;
    std::uint32_t compression_;
    Value background_{};
    std::vector<Tile> tiles_;
    std::vector<Leaf> leaves_;
    std::int64_t active_voxels_ = 0;
    IndexBox active_bounds_;
    std::vector<char> block_;
    MemoryStream memory_;
};

template <typename Value>
void VdbTreeReader<Value>::read_topology() {
    read<std::int32_t>();  // number of buffers a leaf, a relic
    background_ = read<Value>();
    const auto tile_count = read<std::uint32_t>(), child_count = read<std::uint32_t>();
    const auto read_corner = [&] {
        const auto x = read<std::int32_t>(), y = read<std::int32_t>(), z = read<std::int32_t>();
        if ((x | y | z) & 4095)
            damaged();
        return openvdb::Coord(x, y, z);
    };
    for (std::uint32_t n = 0; n < tile_count; ++n) {
        const openvdb::Coord corner = read_corner();
        const auto value = read<Value>();
        add_tile(corner, 4096, value, read<char>() != 0);
    }
    for (std::uint32_t n = 0; n < child_count; ++n)
        read_node<5>(read_corner());
}

/// An upper node (Log2Dim 5) or a lower node (4).
template <typename Value>
template <int Log2Dim>
void VdbTreeReader<Value>::read_node(const openvdb::Coord& corner) {
    using Mask = openvdb::util::NodeMask<Log2Dim>;
    constexpr int kChildEdge = Log2Dim == 5 ? 128 : 8, kDim = 1 << Log2Dim;
    Mask children, active;
    children.load(stream_);
    active.load(stream_);
    const std::unique_ptr<Value[]> values(new Value[Mask::SIZE]);
    read_values(values.get(), active);
    for (openvdb::Index i = 0; i < Mask::SIZE; ++i) {
        const auto n = static_cast<int>(i);
        const openvdb::Coord at =
            corner + openvdb::Coord(kChildEdge * (n >> 2 * Log2Dim), kChildEdge * (n >> Log2Dim & (kDim - 1)),
                                    kChildEdge * (n & (kDim - 1)));
        if (!children.isOn(i)) {
            add_tile(at, kChildEdge, values[i], active.isOn(i));
        } else if constexpr (Log2Dim == 5) {
            read_node<4>(at);
        } else {
            add_leaf(at);
        }
    }
}

template <typename Value>
void VdbTreeReader<Value>::add_tile(const openvdb::Coord& corner, std::int64_t edge, Value value,
                                    bool active) {
    if (value != background_)
        tiles_.push_back({corner, edge, value});
    if (!active)
        return;
    active_voxels_ += edge * edge * edge;
    const int last = static_cast<int>(edge) - 1;
    active_bounds_.include({corner[0], corner[1], corner[2]});
    active_bounds_.include({corner[0] + last, corner[1] + last, corner[2] + last});
}

template <typename Value>
void VdbTreeReader<Value>::add_leaf(const openvdb::Coord& corner) {
    Leaf& leaf = leaves_.emplace_back();
    leaf.corner = corner;
    leaf.active.load(stream_);
    active_voxels_ += leaf.active.countOn();
    for (auto voxel = leaf.active.beginOn(); voxel; ++voxel) {
        const auto v = static_cast<int>(voxel.pos());
        active_bounds_.include({corner[0] + (v >> 6), corner[1] + (v >> 3 & 7), corner[2] + (v & 7)});
    }
}

template <typename Value>
void VdbTreeReader<Value>::read_leaf(Value* values) {
    LeafMask active;
    active.load(stream_);
    if (kind_ == VdbLeafKind::values) {
        read_values(values, active);
        return;
    }
    openvdb::Int32 corner[3];  // known already
    stream_.read(reinterpret_cast<char*>(corner), sizeof(corner));
    if (kind_ == VdbLeafKind::bools)
        active.load(stream_);
    for (openvdb::Index v = 0; v < kLeafVoxels; ++v)
        values[v] = static_cast<Value>(active.isOn(v));
}

/// A node's values: all of them or the active ones, and then one or two values that stand for the inactive
/// ones.
template <typename Value>
template <typename Mask>
void VdbTreeReader<Value>::read_values(Value* out, const Mask& active) {
    using namespace openvdb::io;
    const int layout = read<std::int8_t>();
    if (layout < NO_MASK_OR_INACTIVE_VALS || layout > NO_MASK_AND_ALL_VALS)
        damaged();
    Value inactive[2] = {
        layout == NO_MASK_OR_INACTIVE_VALS ? background_ : openvdb::math::negative(background_), background_};
    if (layout == NO_MASK_AND_ONE_INACTIVE_VAL || layout == MASK_AND_ONE_INACTIVE_VAL ||
        layout == MASK_AND_TWO_INACTIVE_VALS) {
        inactive[0] = read<Value>();
    }
    if (layout == MASK_AND_TWO_INACTIVE_VALS)
        inactive[1] = read<Value>();
    Mask selection;
    if (layout == MASK_AND_NO_INACTIVE_VALS || layout == MASK_AND_ONE_INACTIVE_VAL ||
        layout == MASK_AND_TWO_INACTIVE_VALS) {
        selection.load(stream_);
    }
    const bool active_only = compression_ & COMPRESS_ACTIVE_MASK && layout != NO_MASK_AND_ALL_VALS;
    openvdb::Index stored = active_only ? active.countOn() : Mask::SIZE;
    read_block(out, stored);
    if (stored == Mask::SIZE)
        return;
    // Spread the active values, last first: they never overtake those still to be moved.
    for (openvdb::Index i = Mask::SIZE; i-- > 0;)
        out[i] = active.isOn(i) ? out[--stored] : inactive[selection.isOn(i)];
}

/// `count` values, decompressed. Compressed blocks begin with their size; a negated one marks plain bytes.
template <typename Value>
void VdbTreeReader<Value>::read_block(Value* out, openvdb::Index count) {
    using namespace openvdb::io;
    using Reader = HalfReader<RealToHalf<Value>::isReal, Value>;
    if (half_ && count == 0)
        return;
    std::istream* source = &stream_;
    if (compression_ & (COMPRESS_BLOSC | COMPRESS_ZIP)) {
        constexpr auto kHalf = std::int64_t{sizeof(typename RealToHalf<Value>::HalfT)};
        const std::int64_t bytes = count * (half_ ? kHalf : std::int64_t{sizeof(Value)});
        const auto size = read<std::int64_t>();
        if (size <= 0 ? -size != bytes : size > bytes + 64)
            damaged();
        const auto stored = static_cast<std::size_t>(size <= 0 ? -size : size);
        block_.resize(sizeof(size) + stored);
        std::memcpy(block_.data(), &size, sizeof(size));
        stream_.read(block_.data() + sizeof(size), static_cast<std::streamsize>(stored));
        if (compression_ & COMPRESS_BLOSC && size > 0) {  // Blosc trusts its header: sizes at bytes 4 and 12
            std::int32_t header[4];
            if (stored < sizeof(header))
                damaged();
            std::memcpy(header, block_.data() + sizeof(size), sizeof(header));
            if (header[1] != bytes || header[3] != size)
                damaged();
        }
        memory_.set(block_);
        source = &memory_;
    }
    half_ ? Reader::read(*source, out, count, compression_)
          : readData<Value>(*source, out, count, compression_);
    make_sound(out, count);
}

template <typename Value>
inline constexpr bool kIsVector = openvdb::VecTraits<Value>::IsVec;

/// Reads the topology of a grid of numbers or vectors, in front of whose tree the stream stands, and calls
/// f(tree reader). Returns false where `type` is neither.
template <typename F>
bool with_vdb_tree(std::istream& stream, const std::string& type, bool reals_are_halves, const F& f) {
    const auto call = [&]<typename Value>(Value, VdbLeafKind kind = VdbLeafKind::values) {
        VdbTreeReader<Value> tree(stream, reals_are_halves, kind);
        tree.read_topology();
        f(tree);
        return true;
    };
    using openvdb::math::half;
    if (type == "Tree_float_5_4_3")
        return call(float{});
    if (type == "Tree_double_5_4_3")
        return call(double{});
    if (type == "Tree_half_5_4_3")
        return call(half{});
    if (type == "Tree_int32_5_4_3")
        return call(std::int32_t{});
    if (type == "Tree_int64_5_4_3")
        return call(std::int64_t{});
    if (type == "Tree_bool_5_4_3")
        return call(bool{}, VdbLeafKind::bools);
    if (type == "Tree_mask_5_4_3")
        return call(bool{}, VdbLeafKind::mask);
    if (type == "Tree_vec3s_5_4_3")
        return call(openvdb::Vec3s{});
    if (type == "Tree_vec3d_5_4_3")
        return call(openvdb::Vec3d{});
    if (type == "Tree_vec3i_5_4_3")
        return call(openvdb::Vec3i{});
    if (type == "Tree_vec3h_5_4_3")
        return call(openvdb::Vec3H{});
    return false;
}

}  // namespace nephele
