// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors whose first elements are 0 without being written: the system hands out memory that is zero, page by
// page as it is used, so that the buffers of a large image do not delay its first pixels.
#pragma once

#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace nephele {

template <typename T>
struct ZeroedAllocator {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= alignof(std::max_align_t));
    using value_type = T;

    ZeroedAllocator() = default;
    template <typename U>
    explicit(false) ZeroedAllocator(const ZeroedAllocator<U>&) {}

    T* allocate(std::size_t n) {
        void* p = std::calloc(n, sizeof(T));
        if (p == nullptr)
            throw std::bad_alloc();
        return static_cast<T*>(p);
    }
    void deallocate(T* p, std::size_t) { std::free(p); }
    /// Elements without a value stay as allocated.
    void construct(T*) {}
    template <typename... Arguments>
    void construct(T* p, Arguments&&... arguments) {
        std::construct_at(p, std::forward<Arguments>(arguments)...);
    }
    bool operator==(const ZeroedAllocator&) const { return true; }
};

/// To be sized once, by resize() while it is empty. All bits 0 must be a T's default.
template <typename T>
using ZeroedVector = std::vector<T, ZeroedAllocator<T>>;

}  // namespace nephele
