// SPDX-License-Identifier: GPL-3.0-or-later
#include "grids/grid_cache.h"

#include <sys/stat.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>

#include <tbb/task_arena.h>

namespace nephele {

namespace {

/// What tells whether a file is still the one that was read; all 0 where there is none.
struct FileStamp {
    std::int64_t size = 0, modified = 0, changed = 0;  // times: ns since 1970
    std::uint64_t device = 0, inode = 0;

    bool operator==(const FileStamp&) const = default;
    std::string text() const {
        return std::to_string(size) + ' ' + std::to_string(modified) + ' ' + std::to_string(changed) + ' ' +
               std::to_string(device) + ' ' + std::to_string(inode);
    }
};

FileStamp stamp_of(const std::string& path) {
    const auto nanoseconds = [](const timespec& t) {
        return std::int64_t{t.tv_sec} * 1'000'000'000 + std::int64_t{t.tv_nsec};
    };
    struct stat s {};
    if (stat(path.c_str(), &s) != 0)
        return {};
    return {s.st_size, nanoseconds(s.st_mtim), nanoseconds(s.st_ctim), s.st_dev, s.st_ino};
}

/// Waits until a change of the file is sure to change its stamp: file systems count time in steps of a few
/// milliseconds, and within one of them a file may be read and written again.
void let_settle(const FileStamp& stamp) {
    using namespace std::chrono;
    constexpr nanoseconds kStep = milliseconds(20);
    const nanoseconds age =
        system_clock::now().time_since_epoch() - nanoseconds(std::max(stamp.modified, stamp.changed));
    if (age >= nanoseconds(0) && age < kStep)
        std::this_thread::sleep_for(kStep - age);
}

/// The file changed while it was read.
struct Changed {};

std::string key_of(const std::string& kind, const GridRequest& request, const FileStamp& stamp) {
    const GridOptions& o = request.options;
    return kind + ' ' + stamp.text() + ' ' + std::to_string(static_cast<int>(o.precision)) + ' ' +
           std::to_string(std::bit_cast<std::uint32_t>(o.clipping)) + (o.keep_negative ? " signed " : " ") +
           std::to_string(request.path.size()) + ' ' + request.path + ' ' + request.name;
}

constexpr char kNumbers[] = "numbers", kVectors[] = "vectors", kList[] = "list";

}  // namespace

// --- GridCache
// ------------------------------------------------------------------------------------------------

GridCache& GridCache::process() {
    static GridCache cache;
    return cache;
}

GridCache::Statistics GridCache::statistics() const {
    const std::lock_guard lock(mutex_);
    return statistics_;
}

std::size_t GridCache::size() const {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(std::count_if(
        slots_.begin(), slots_.end(), [](const auto& entry) { return !entry.second->value.expired(); }));
}

void GridCache::clear() {
    hold({});
}

GridCache::Value GridCache::find_or_make(const std::string& key, const std::function<Value()>& make) {
    std::shared_ptr<Slot> slot;
    {
        const std::lock_guard lock(mutex_);
        auto& entry = slots_[key];
        if (!entry)
            entry = std::make_shared<Slot>();
        slot = entry;
    }
    const std::lock_guard making(slot->making);
    Value value = slot->value.lock();
    {
        const std::lock_guard lock(mutex_);
        ++(value ? statistics_.hits : statistics_.misses);
    }
    if (!value) {
        // Isolated: a task of another scene, taken up while this one waits for its own, might want this slot.
        value = tbb::this_task_arena::isolate(make);
        const std::lock_guard lock(mutex_);
        slot->value = value;
    }
    return value;
}

void GridCache::hold(HeldByKey values) {
    {
        const std::lock_guard lock(mutex_);
        held_.swap(values);
    }
    values.clear();  // without the lock: freeing gigabytes takes its time
    const std::lock_guard lock(mutex_);
    std::erase_if(slots_, [](const auto& entry) {  // those that nobody waits for nor has the value of
        return entry.second.use_count() == 1 && entry.second->value.expired();
    });
}

GridCache::HeldByKey GridCache::held() const {
    const std::lock_guard lock(mutex_);
    return held_;
}

// --- GridCacheScope
// -------------------------------------------------------------------------------------------

GridCache::Value GridCacheScope::use(const std::string& key, const std::function<GridCache::Value()>& make,
                                     const IdsOf& ids_of) {
    GridCache::Value value = cache_->find_or_make(key, make);
    const std::lock_guard lock(mutex_);
    used_.insert_or_assign(key, GridCache::Held{value, ids_of(value.get())});
    return value;
}

template <typename T, typename Load>
std::shared_ptr<const T> GridCacheScope::read(const std::string& kind, const GridRequest& request,
                                              const Load& load) {
    constexpr int kAttempts = 3;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        const FileStamp stamp = stamp_of(request.path);
        const auto make = [&]() -> GridCache::Value {
            auto value = std::make_shared<const T>(load());
            let_settle(stamp);
            if (stamp_of(request.path) != stamp)
                throw Changed();
            return value;
        };
        const auto ids = [](const void* value) -> std::vector<std::uint64_t> {
            if constexpr (std::is_base_of_v<GridPlacement, T>)
                return {static_cast<const T*>(value)->id};
            return {};
        };
        try {
            return std::static_pointer_cast<const T>(use(key_of(kind, request, stamp), make, ids));
        } catch (const Changed&) {  // once more, from its new beginning
        }
    }
    throw std::runtime_error(request.path +
                             " is being written to while it is read: render once it is complete");
}

std::shared_ptr<const LoadedGrid> GridCacheScope::grid(const std::string& path, const std::string& name,
                                                       const GridOptions& options) {
    return read<LoadedGrid>(kNumbers, {path, name, options}, [&] { return load_grid(path, name, options); });
}

std::shared_ptr<const LoadedVectorGrid> GridCacheScope::vector_grid(const std::string& path,
                                                                    const std::string& name,
                                                                    const GridOptions& options) {
    return read<LoadedVectorGrid>(kVectors, {path, name, options, true},
                                  [&] { return load_vector_grid(path, name, options); });
}

std::shared_ptr<const std::vector<GridInfo>> GridCacheScope::list(const std::string& path) {
    return read<std::vector<GridInfo>>(kList, {path, {}, {}}, [&] { return list_grids(path); });
}

void GridCacheScope::expect(const std::vector<GridRequest>& requests) {
    GridCache::HeldByKey held = cache_->held();
    std::set<std::uint64_t> ids;
    for (const GridRequest& request : requests) {
        const std::string key =
            key_of(request.vectors ? kVectors : kNumbers, request, stamp_of(request.path));
        if (const auto found = held.find(key); found != held.end())
            ids.insert(found->second.grids.begin(), found->second.grids.end());
    }
    std::erase_if(held, [&](const auto& entry) {
        return !std::all_of(entry.second.grids.begin(), entry.second.grids.end(),
                            [&](std::uint64_t id) { return ids.contains(id); });
    });
    cache_->hold(std::move(held));
}

void GridCacheScope::commit() {
    const std::lock_guard lock(mutex_);
    cache_->hold(used_);
}

}  // namespace nephele
