// SPDX-License-Identifier: GPL-3.0-or-later
#include "grids/grid_cache.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include <tbb/task_arena.h>

namespace nephele {

namespace {

/// The file changed while it was read.
struct Changed {};

}  // namespace

// --- GridCache

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

void GridCache::hold(ValueByKey values) {
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

// --- GridCacheScope

GridCache::Value GridCacheScope::use(const std::string& key, const std::function<GridCache::Value()>& make) {
    GridCache::Value value = cache_->find_or_make(key, make);
    const std::lock_guard lock(mutex_);
    used_.insert_or_assign(key, value);
    return value;
}

std::string GridCacheScope::Request::key(const FileStamp& stamp) const {
    return std::string(kind) + ' ' + stamp.text() + ' ' +
           std::to_string(static_cast<int>(options.precision)) + ' ' +
           std::to_string(std::bit_cast<std::uint32_t>(options.clipping)) +
           (options.keep_negative ? " signed " : " ") + std::to_string(path.size()) + ' ' + path + ' ' + name;
}

template <typename T, typename Load>
std::shared_ptr<const T> GridCacheScope::read(const Request& request, const Load& load) {
    constexpr int kAttempts = 3;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        const FileStamp stamp = cache_->probe_(request.path);
        const auto make = [&]() -> GridCache::Value {
            auto value = std::make_shared<const T>(load());
            let_settle(stamp);
            if (cache_->probe_(request.path) != stamp)
                throw Changed();
            return value;
        };
        try {
            return std::static_pointer_cast<const T>(use(request.key(stamp), make));
        } catch (const Changed&) {  // once more, from its new beginning
        }
    }
    throw std::runtime_error(request.path +
                             " is being written to while it is read: render once it is complete");
}

std::shared_ptr<const LoadedGrid> GridCacheScope::grid(const std::string& path, const std::string& name,
                                                       const GridOptions& options) {
    return read<LoadedGrid>({"numbers", path, name, options}, [&] { return load_grid(path, name, options); });
}

std::shared_ptr<const LoadedVectorGrid> GridCacheScope::vector_grid(const std::string& path,
                                                                    const std::string& name,
                                                                    const GridOptions& options) {
    return read<LoadedVectorGrid>({"vectors", path, name, options},
                                  [&] { return load_vector_grid(path, name, options); });
}

std::shared_ptr<const std::vector<GridInfo>> GridCacheScope::list(const std::string& path) {
    return read<std::vector<GridInfo>>({"list", path, {}, {}}, [&] { return list_grids(path); });
}

void GridCacheScope::commit() {
    const std::lock_guard lock(mutex_);
    cache_->hold(used_);
}

}  // namespace nephele
