// SPDX-License-Identifier: GPL-3.0-or-later
// The frame of an OpenVDB file: header, grid descriptors, metadata, transforms. Only vdb_file.cpp may include
// this.
//
// openvdb::io::File is not used: it holds a whole tree beside the result, copies files to a temporary folder,
// refuses files that hold any type of grid it does not know, and trusts all counts. This stream throws at its
// end.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include "grids/vdb_tree.h"

namespace nephele {

/// Where a file keeps a grid.
struct VdbDescriptor {
    std::string unique_name, name, type, parent;  // parent: the grid whose tree this one shares, or empty
    bool half = false;
    std::int64_t position = 0;

    /// "name", or "name[1]" and so on where a file has several of a name.
    std::string shown_name() const { return openvdb::io::GridDescriptor::nameAsString(unique_name); }
    /// "float" of "Tree_float_5_4_3".
    std::string value_type() const {
        const std::size_t begin = type.find('_') + 1, end = type.find('_', begin);
        return type.substr(begin, end - begin);
    }
};

/// Reads the parts of a file; throws std::runtime_error, std::ios_base::failure or openvdb::Exception.
class VdbReader : public openvdb::io::Archive {
  public:
    explicit VdbReader(const std::string& path);

    const std::vector<VdbDescriptor>& descriptors() const { return descriptors_; }
    std::istream& stream() { return stream_; }
    /// The first grid of that name; null where there is none. "name[1]" and so on pick one of several.
    const VdbDescriptor* find(const std::string& grid_name) const;
    /// Number of grids of that name.
    std::size_t count(const std::string& grid_name) const;
    /// The names of all grids, for messages.
    std::string names() const;
    /// The descriptor whose tree `d` uses: itself, or the grid it is an instance of.
    const VdbDescriptor& tree_owner(const VdbDescriptor& d) const;
    /// Leaves the stream in front of the transform.
    openvdb::MetaMap read_metadata(const VdbDescriptor& d);
    /// Leaves the stream in front of the tree.
    openvdb::math::Transform read_transform(const VdbDescriptor& d);
    /// OpenVDB's own grid, of any type, with its topology and perhaps its voxels.
    openvdb::GridBase::Ptr read_openvdb_grid(const VdbDescriptor& d, bool with_voxels);

  private:
    std::string read_name();
    openvdb::MetaMap read_metadata();
    VdbDescriptor read_descriptor(std::int64_t& end);
    void read_descriptors();
    void skip_grid(const VdbDescriptor& d);

    // The stream keeps the address of this pointer.
    openvdb::io::StreamMetadata::Ptr stream_metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
    std::ifstream stream_;
    std::int64_t size_ = 0;
    std::vector<VdbDescriptor> descriptors_;
};

inline VdbReader::VdbReader(const std::string& path) : stream_(path, std::ios::binary) {
    // Initialising registers all grid types, once, under OpenVDB's own lock.
    static const bool initialized = (openvdb::initialize(), true);
    static_cast<void>(initialized);
    if (!stream_ || !std::filesystem::is_regular_file(path)) {
        throw std::runtime_error("cannot be opened: check that the file exists and may be read");
    }
    stream_.exceptions(std::ios::failbit | std::ios::badbit);
    stream_.seekg(0, std::ios::end);
    size_ = stream_.tellg();
    stream_.seekg(0);
    std::int64_t magic = 0;
    if (size_ >= 8)
        stream_.read(reinterpret_cast<char*>(&magic), 8);
    if (magic != openvdb::OPENVDB_MAGIC)
        throw std::runtime_error("is not an OpenVDB file");
    stream_.seekg(0);
    readHeader(stream_);
    openvdb::io::setStreamMetadataPtr(stream_, stream_metadata_, false);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
    if (fileVersion() < openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION) {
        throw std::runtime_error("has the outdated VDB format " + std::to_string(fileVersion()) +
                                 ": open and save it with a program that uses a newer OpenVDB");
    }
    read_metadata();
    read_descriptors();
}

inline std::string VdbReader::read_name() {
    std::uint32_t length = 0;
    stream_.read(reinterpret_cast<char*>(&length), sizeof(length));
    if (length > 65536)
        throw std::runtime_error("is damaged: a name of " + std::to_string(length) + " letters");
    std::string name(length, '\0');
    stream_.read(name.data(), length);
    return name;
}

inline VdbDescriptor VdbReader::read_descriptor(std::int64_t& end) {
    VdbDescriptor d;
    d.unique_name = read_name();
    d.name = openvdb::io::GridDescriptor::stripSuffix(d.unique_name);
    d.type = read_name();
    constexpr char kHalfSuffix[] = "_HalfFloat";
    if (d.type.ends_with(kHalfSuffix)) {
        d.half = true;
        d.type.resize(d.type.size() - (sizeof(kHalfSuffix) - 1));
    }
    d.parent = read_name();
    std::int64_t offsets[3];  // of the grid, its blocks, its end; zeros where the writer could not seek
    stream_.read(reinterpret_cast<char*>(offsets), sizeof(offsets));
    d.position = inputHasGridOffsets() ? offsets[0] : std::int64_t{stream_.tellg()};
    end = offsets[2];
    return d;
}

inline void VdbReader::read_descriptors() {
    const std::int32_t count = readGridCount(stream_);
    for (std::int32_t n = 0; n < count; ++n) {
        std::int64_t end = 0;
        VdbDescriptor d = read_descriptor(end);
        if (inputHasGridOffsets()) {
            if (d.position < stream_.tellg() || end < d.position)
                throw std::runtime_error("is damaged");
            if (end > size_) {
                throw std::runtime_error("is truncated: grid \"" + d.shown_name() + "\" ends at byte " +
                                         std::to_string(end) + ", the file at byte " + std::to_string(size_));
            }
            descriptors_.push_back(std::move(d));
        } else {  // the next descriptor comes after this grid's voxels, however many they are
            skip_grid(d);
            end = stream_.tellg();
            descriptors_.push_back(std::move(d));
        }
        stream_.seekg(end);
    }
}

inline void VdbReader::skip_grid(const VdbDescriptor& d) {
    read_transform(d);
    if (!d.parent.empty())
        return;
    const bool known = with_vdb_tree(stream_, d.type, d.half, [](auto& tree) {
        decltype(tree.background()) values[BrickGrid::kBrickVoxels];
        for (std::size_t n = tree.leaves().size(); n > 0; --n)
            tree.read_leaf(values);
    });
    if (!known)
        read_openvdb_grid(d, true);
}

inline const VdbDescriptor* VdbReader::find(const std::string& grid_name) const {
    for (const VdbDescriptor& d : descriptors_) {
        if (d.name == grid_name)
            return &d;
    }
    for (const VdbDescriptor& d : descriptors_) {
        if (d.shown_name() == grid_name)
            return &d;
    }
    return nullptr;
}

inline std::size_t VdbReader::count(const std::string& grid_name) const {
    return static_cast<std::size_t>(
        std::count_if(descriptors_.begin(), descriptors_.end(),
                      [&](const VdbDescriptor& d) { return d.name == grid_name; }));
}

inline std::string VdbReader::names() const {
    std::string names;
    for (const VdbDescriptor& d : descriptors_)
        names += (names.empty() ? "" : ", ") + d.shown_name();
    return names.empty() ? "none" : names;
}

inline const VdbDescriptor& VdbReader::tree_owner(const VdbDescriptor& d) const {
    if (d.parent.empty())
        return d;
    for (const VdbDescriptor& other : descriptors_) {
        if (other.unique_name == d.parent && other.parent.empty())
            return other;
    }
    throw std::runtime_error("is damaged: the grid that \"" + d.shown_name() +
                             "\" shares its voxels with is absent");
}

inline openvdb::MetaMap VdbReader::read_metadata(const VdbDescriptor& d) {
    stream_.seekg(d.position);
    readGridCompression(stream_);
    return read_metadata();
}

/// As MetaMap::readMeta, which allocates whatever size the file names.
inline openvdb::MetaMap VdbReader::read_metadata() {
    openvdb::MetaMap metadata;
    std::uint32_t count = 0;
    stream_.read(reinterpret_cast<char*>(&count), sizeof(count));
    for (std::uint32_t n = 0; n < count; ++n) {
        const std::string name = read_name(), type = read_name();
        std::uint32_t size = 0;
        stream_.read(reinterpret_cast<char*>(&size), sizeof(size));
        if (size > size_ - stream_.tellg())
            throw std::runtime_error("is damaged: metadata \"" + name + "\" is too long");
        std::vector<char> bytes(sizeof(size) + size);
        std::memcpy(bytes.data(), &size, sizeof(size));
        stream_.read(bytes.data() + sizeof(size), size);
        if (!openvdb::Metadata::isRegisteredType(type) || type == "__delayedload")
            continue;
        MemoryStream memory;
        memory.set(bytes);
        const openvdb::Metadata::Ptr value = openvdb::Metadata::createMetadata(type);
        value->read(memory);
        metadata.insertMeta(name, *value);
    }
    return metadata;
}

inline openvdb::math::Transform VdbReader::read_transform(const VdbDescriptor& d) {
    read_metadata(d);
    const std::streampos kind = stream_.tellg();
    read_name();  // OpenVDB would allocate whatever length the file names
    stream_.seekg(kind);
    openvdb::math::Transform transform;
    transform.read(stream_);
    return transform;
}

inline openvdb::GridBase::Ptr VdbReader::read_openvdb_grid(const VdbDescriptor& d, bool with_voxels) {
    if (!openvdb::GridBase::isRegistered(d.type)) {
        throw std::runtime_error("holds grid \"" + d.shown_name() + "\" of a type unknown here: " + d.type);
    }
    const openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(d.type);
    grid->setSaveFloatAsHalf(d.half);
    read_transform(d);
    openvdb::io::setGridBackgroundValuePtr(stream_, nullptr);
    grid->readTopology(stream_);
    if (with_voxels)
        grid->readBuffers(stream_);
    return grid;
}

}  // namespace nephele
