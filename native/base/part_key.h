// SPDX-License-Identifier: GPL-3.0-or-later
// What a part of a scene is made of, as the key to find it by: numbers and text by value, arrays and other
// parts by address. The key keeps what it has the address of, and so does the part found by it: no address
// comes to stand for something else. Arrays never change once they are part of a scene.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/buffer.h"
#include "math/transform.h"

namespace nephele {

class PartKey {
  public:
    template <typename T>
    requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) PartKey& add(T value) {
        return bytes(&value, sizeof value);
    }
    PartKey& add(Vec3f v) { return add(v.x).add(v.y).add(v.z); }
    PartKey& add(const Transform& m) {
        for (const Vec3f row : m.row)
            add(row);
        return add(m.translation);
    }
    PartKey& add(std::string_view text) { return add(text.size()).bytes(text.data(), text.size()); }
    /// Elements without padding.
    template <typename T, std::size_t N>
    requires(std::is_trivially_copyable_v<T>) PartKey& add(std::span<T, N> values) {
        return add(values.size()).bytes(values.data(), values.size_bytes());
    }
    /// An array, by its address.
    template <typename T>
    PartKey& add(const Buffer<T>& array) {
        kept_.push_back(array.owner());
        return address(array.data()).add(array.size());
    }
    /// Something that others share, by its address.
    template <typename T>
    PartKey& add(const std::shared_ptr<T>& shared) {
        kept_.push_back(shared);
        return address(shared.get());
    }

    const std::string& text() const { return text_; }
    const std::vector<std::shared_ptr<const void>>& kept() const { return kept_; }

  private:
    PartKey& bytes(const void* data, std::size_t size) {
        text_.append(static_cast<const char*>(data), size);
        return *this;
    }
    PartKey& address(const void* p) { return bytes(&p, sizeof p); }

    std::string text_;
    std::vector<std::shared_ptr<const void>> kept_;
};

}  // namespace nephele
