// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of scenes, kept from one scene to the next: what did not change is not built again.
//
// A scene asks through a PartScope, and says with commit() that it is complete. The cache holds what the
// last complete scene used; what older scenes used can be found for as long as they live themselves.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <typeinfo>

#include "base/part_key.h"

namespace nephele {

/// Thread-safe.
class PartCache {
  public:
    /// Requests that found their value, and those that had to make it.
    struct Statistics {
        std::size_t hits = 0, misses = 0;
    };

    PartCache() = default;
    PartCache(const PartCache&) = delete;
    PartCache& operator=(const PartCache&) = delete;

    Statistics statistics() const;
    /// Number of values that can be found: those of the last complete scene, and of all that are alive.
    std::size_t size() const;
    /// Lets go of all values.
    void clear();

  private:
    friend class PartScope;
    using Value = std::shared_ptr<const void>;
    /// Where a value is, or is being made.
    struct Slot {
        std::mutex making;                ///< locked by who makes or looks up the value
        std::weak_ptr<const void> value;  ///< read under either lock, written under `making` and mutex_
    };
    using ValueByKey = std::map<std::string, Value>;

    Value find_or_make(const std::string& key, const std::function<Value()>& make);
    void hold(ValueByKey values);
    void let_go(const std::string& begin);

    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<Slot>> slots_;
    ValueByKey held_;  ///< by the last complete scene
    Statistics statistics_;
};

/// What one scene takes from the cache. Its requests may come from several threads; equal ones are served by
/// one making. Not to be copied; what it handed out outlives it.
class PartScope {
  public:
    explicit PartScope(PartCache& cache) : parts_(&cache) {}
    PartScope(const PartScope&) = delete;
    PartScope& operator=(const PartScope&) = delete;

    /// The value of a key, made by make() -> std::shared_ptr<const T> where it is not there. The key must
    /// hold all that make() reads. make() may ask this scope for other keys. What it throws reaches the
    /// caller, and nothing is kept.
    template <typename T, typename Make>
    std::shared_ptr<const T> share(const PartKey& key, const Make& make) {
        struct Kept {
            std::shared_ptr<const T> value;
            std::vector<std::shared_ptr<const void>> named_by_key;
        };
        const auto erased = [&]() -> PartCache::Value {
            return std::make_shared<const Kept>(Kept{make(), key.kept()});
        };
        const auto kept = std::static_pointer_cast<const Kept>(use(typed<T>(key.text()), erased));
        return {kept, kept->value.get()};
    }
    /// The same for make() -> T.
    template <typename T, typename Make>
    std::shared_ptr<const T> get_or_make(const PartKey& key, const Make& make) {
        return share<T>(key, [&] { return std::make_shared<const T>(make()); });
    }

    /// Of the last scene's parts, none whose key begins so will be asked for any more: they need not be there
    /// while others are built in their place.
    template <typename T>
    void let_go(const PartKey& begin) {
        let_go(typed<T>(begin.text()));
    }

    /// The scene is complete: from now on the cache holds what it used, and nothing else.
    void commit();

  protected:
    PartCache::Value use(const std::string& key, const std::function<PartCache::Value()>& make);
    template <typename T>
    static std::string typed(const std::string& key) {
        return std::string(typeid(T).name()) + ' ' + key;
    }

  private:
    void let_go(const std::string& begin);

    PartCache* parts_;
    std::mutex mutex_;
    PartCache::ValueByKey used_;
};

}  // namespace nephele
