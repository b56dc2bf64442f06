// SPDX-License-Identifier: GPL-3.0-or-later
// A read-only array whose memory may belong to somebody else (a numpy array): shared, never copied.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace nephele {

template <typename T>
class Buffer {
  public:
    Buffer() = default;
    Buffer(const T* data, std::size_t size, std::shared_ptr<const void> owner)
        : data_(data), size_(size), owner_(std::move(owner)) {}
    explicit Buffer(std::vector<T> values) {
        auto held = std::make_shared<const std::vector<T>>(std::move(values));
        data_ = held->data();
        size_ = held->size();
        owner_ = std::move(held);
    }

    const T& operator[](std::size_t i) const { return data_[i]; }
    const T* data() const { return data_; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    const T* begin() const { return data_; }
    const T* end() const { return data_ + size_; }
    /// What keeps the memory.
    const std::shared_ptr<const void>& owner() const { return owner_; }

  private:
    const T* data_ = nullptr;
    std::size_t size_ = 0;
    std::shared_ptr<const void> owner_;
};

}  // namespace nephele
