// SPDX-License-Identifier: GPL-3.0-or-later
// Grids, and what is built of them, kept from one scene to the next: a render of the same scene reads no
// file, and the next frame of an animation reads only the files that changed.
//
// A scene asks through a GridCacheScope, and says with commit() that it is complete. The cache holds what the
// last complete scene used; what older scenes used can be found for as long as they live themselves.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include "grids/file_stamp.h"
#include "grids/vdb_file.h"

namespace nephele {

/// Thread-safe. One serves the whole process; tests make their own.
class GridCache {
  public:
    /// How it learns of a file's state: stamp_of(), unless a test stands in for the file system.
    using Probe = std::function<FileStamp(const std::string& path)>;
    explicit GridCache(Probe probe = stamp_of) : probe_(std::move(probe)) {}

    /// Requests that found their value, and those that had to make it.
    struct Statistics {
        std::size_t hits = 0, misses = 0;
    };

    static GridCache& process();

    Statistics statistics() const;
    /// Number of values that can be found: those of the last complete scene, and of all that are alive.
    std::size_t size() const;
    /// Lets go of all values.
    void clear();

  private:
    friend class GridCacheScope;
    using Value = std::shared_ptr<const void>;
    /// Where a value is, or is being made.
    struct Slot {
        std::mutex making;                ///< locked by who makes or looks up the value
        std::weak_ptr<const void> value;  ///< read under either lock, written under `making` and mutex_
    };
    using ValueByKey = std::map<std::string, Value>;

    Value find_or_make(const std::string& key, const std::function<Value()>& make);
    void hold(ValueByKey values);

    Probe probe_;
    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<Slot>> slots_;
    ValueByKey held_;  ///< by the last complete scene
    Statistics statistics_;
};

/// What one scene takes from the cache. Its requests may come from several threads; equal ones are served by
/// one reading. Not to be copied; what it handed out outlives it.
class GridCacheScope {
  public:
    explicit GridCacheScope(GridCache& cache = GridCache::process()) : cache_(&cache) {}
    GridCacheScope(const GridCacheScope&) = delete;
    GridCacheScope& operator=(const GridCacheScope&) = delete;

    /// load_grid() and its kin, once per file and options for as long as size, times and inode of the file
    /// stay.
    std::shared_ptr<const LoadedGrid> grid(const std::string& path, const std::string& name,
                                           const GridOptions& options = {});
    std::shared_ptr<const LoadedVectorGrid> vector_grid(const std::string& path, const std::string& name,
                                                        const GridOptions& options = {});
    std::shared_ptr<const std::vector<GridInfo>> list(const std::string& path);

    /// The value of a key, made by make() -> T where it is not there. `grids`: GridPlacement::id of the grids
    /// that it is built of; they are part of the key, the rest of which must hold all else that make() reads.
    /// make() may ask this scope for other keys. What it throws reaches the caller, and nothing is kept.
    template <typename T, typename Make>
    std::shared_ptr<const T> get_or_make(const std::string& key, const std::vector<std::uint64_t>& grids,
                                         const Make& make) {
        std::string full = std::string(typeid(T).name()) + ' ' + key;
        for (const std::uint64_t id : grids)
            full += ' ' + std::to_string(id);
        const auto erased = [&]() -> GridCache::Value { return std::make_shared<const T>(make()); };
        return std::static_pointer_cast<const T>(use(full, erased));
    }

    /// The scene is complete: from now on the cache holds what it used, and nothing else.
    void commit();

  private:
    /// One grid of a file, or all of its names.
    struct Request {
        const char* kind;  ///< of value
        std::string path, name;
        GridOptions options;

        std::string key(const FileStamp& stamp) const;
    };
    GridCache::Value use(const std::string& key, const std::function<GridCache::Value()>& make);
    template <typename T, typename Load>
    std::shared_ptr<const T> read(const Request& request, const Load& load);

    GridCache* cache_;
    std::mutex mutex_;
    GridCache::ValueByKey used_;
};

}  // namespace nephele
