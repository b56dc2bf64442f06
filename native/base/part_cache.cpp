// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/part_cache.h"

#include <algorithm>

#include <tbb/task_arena.h>

namespace nephele {

PartCache::Statistics PartCache::statistics() const {
    const std::lock_guard lock(mutex_);
    return statistics_;
}

std::size_t PartCache::size() const {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(std::count_if(
        slots_.begin(), slots_.end(), [](const auto& entry) { return !entry.second->value.expired(); }));
}

void PartCache::clear() {
    hold({});
}

PartCache::Value PartCache::find_or_make(const std::string& key, const std::function<Value()>& make) {
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

void PartCache::hold(ValueByKey values) {
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

/// Of the values that it holds, those whose key begins so.
void PartCache::let_go(const std::string& begin) {
    ValueByKey gone;
    const std::lock_guard lock(mutex_);
    for (auto i = held_.lower_bound(begin); i != held_.end() && i->first.starts_with(begin);) {
        const auto next = std::next(i);
        gone.insert(held_.extract(i));
        i = next;
    }
}

void PartScope::let_go(const std::string& begin) {
    parts_->let_go(begin);
}

PartCache::Value PartScope::use(const std::string& key, const std::function<PartCache::Value()>& make) {
    PartCache::Value value = parts_->find_or_make(key, make);
    const std::lock_guard lock(mutex_);
    used_.insert_or_assign(key, value);
    return value;
}

void PartScope::commit() {
    const std::lock_guard lock(mutex_);
    parts_->hold(used_);
}

}  // namespace nephele
