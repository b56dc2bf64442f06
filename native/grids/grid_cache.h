// SPDX-License-Identifier: GPL-3.0-or-later
// Grids, and what is built of them, kept from one scene to the next: a render of the same scene reads no
// file, and the next frame of an animation reads only the files that changed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/part_cache.h"
#include "grids/file_stamp.h"
#include "grids/vdb_file.h"

namespace nephele {

/// Thread-safe. One serves the whole process; tests make their own.
class GridCache : public PartCache {
  public:
    /// How it learns of a file's state: stamp_of(), unless a test stands in for the file system.
    using Probe = std::function<FileStamp(const std::string& path)>;
    explicit GridCache(Probe probe = stamp_of) : probe_(std::move(probe)) {}

    static GridCache& process();

  private:
    friend class GridCacheScope;
    Probe probe_;
};

/// What one scene takes from the cache.
class GridCacheScope : public PartScope {
  public:
    explicit GridCacheScope(GridCache& cache = GridCache::process()) : PartScope(cache), cache_(&cache) {}

    /// load_grid() and its kin, once per file and options for as long as size, times and inode of the file
    /// stay.
    std::shared_ptr<const LoadedGrid> grid(const std::string& path, const std::string& name,
                                           const GridOptions& options = {});
    std::shared_ptr<const LoadedVectorGrid> vector_grid(const std::string& path, const std::string& name,
                                                        const GridOptions& options = {});
    std::shared_ptr<const std::vector<GridInfo>> list(const std::string& path);

    /// The value of a key, made by make() -> T where it is not there. `grids`: GridPlacement::id of the grids
    /// that it is built of; they are part of the key, the rest of which must hold all else that make() reads.
    template <typename T, typename Make>
    std::shared_ptr<const T> get_or_make(const std::string& key, const std::vector<std::uint64_t>& grids,
                                         const Make& make) {
        return PartScope::get_or_make<T>(PartKey().add(key).add(std::span(grids)), make);
    }

  private:
    /// One grid of a file, or all of its names.
    struct Request {
        const char* kind;  ///< of value
        std::string path, name;
        GridOptions options;

        std::string key(const FileStamp& stamp) const;
    };
    template <typename T, typename Load>
    std::shared_ptr<const T> read(const Request& request, const Load& load);

    GridCache* cache_;
};

}  // namespace nephele
