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
#include <vector>

#include "grids/vdb_file.h"

namespace nephele {

/// Thread-safe. One serves the whole process; tests make their own.
class GridCache {
  public:
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
    struct Held {
        Value value;
        std::vector<std::uint64_t> grids;  ///< ids of the grids that it is, or was built of
    };
    using HeldByKey = std::map<std::string, Held>;

    Value find_or_make(const std::string& key, const std::function<Value()>& make);
    void hold(HeldByKey values);
    HeldByKey held() const;

    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<Slot>> slots_;
    HeldByKey held_;  ///< by the last complete scene
    Statistics statistics_;
};

/// One grid that a scene is about to ask for.
struct GridRequest {
    std::string path, name;
    GridOptions options;
    bool vectors = false;
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
        return std::static_pointer_cast<const T>(use(full, erased, [&](const void*) { return grids; }));
    }

    /// Before the first request: lets go of all that older scenes alone hold and these do not name, so that
    /// the grids of two frames do not stand in memory together. Optional; other requests stay allowed.
    void expect(const std::vector<GridRequest>& requests);
    /// The scene is complete: from now on the cache holds what it used, and nothing else.
    void commit();

  private:
    using IdsOf = std::function<std::vector<std::uint64_t>(const void*)>;
    GridCache::Value use(const std::string& key, const std::function<GridCache::Value()>& make,
                         const IdsOf& ids_of);
    template <typename T, typename Load>
    std::shared_ptr<const T> read(const std::string& kind, const GridRequest& request, const Load& load);

    GridCache* cache_;
    std::mutex mutex_;
    GridCache::HeldByKey used_;
};

}  // namespace nephele
