// SPDX-License-Identifier: GPL-3.0-or-later
// A fuzzer's bytes, read as the numbers that a target asks for. After their end come zeros.
#pragma once

#include <algorithm>
#include <cfloat>
#include <cstring>
#include <limits>

#include "targets.h"

namespace nephele::fuzz {

class Bytes {
  public:
    explicit Bytes(Data data) : data_(data) {}

    bool empty() const { return data_.empty(); }

    template <typename T>
    T take() {
        T value{};
        const std::size_t size = std::min(sizeof(T), data_.size());
        if (size > 0)
            std::memcpy(&value, data_.data(), size);
        data_ = data_.subspan(size);
        return value;
    }
    /// In [0, n).
    std::size_t below(std::size_t n) { return (n <= 256 ? take<std::uint8_t>() : take<std::uint32_t>()) % n; }
    /// Small numbers, those at the edge of what a float holds, or any.
    float real() {
        constexpr float kSpecial[] = {0,
                                      1,
                                      -1,
                                      0.5f,
                                      -0.0f,
                                      std::numeric_limits<float>::infinity(),
                                      FLT_MAX,
                                      FLT_MIN,
                                      -FLT_MAX,
                                      1e12f,
                                      1e-12f,
                                      1e20f,
                                      1e-20f,
                                      std::numeric_limits<float>::quiet_NaN(),
                                      FLT_TRUE_MIN,
                                      -std::numeric_limits<float>::infinity()};
        switch (below(4)) {
            case 0:
                return kSpecial[below(std::size(kSpecial))];
            case 1:
                return static_cast<float>(take<std::int8_t>()) / 16;
            case 2:
                return static_cast<float>(take<std::int16_t>()) / 1024;
            default:
                return take<float>();
        }
    }

  private:
    Data data_;
};

}  // namespace nephele::fuzz
