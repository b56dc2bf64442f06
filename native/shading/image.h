// SPDX-License-Identifier: GPL-3.0-or-later
// An image texture. First row at the bottom; RGBA; bytes (sRGB-encoded or linear) or linear floats.
#pragma once

#include <string>

#include "base/buffer.h"
#include "math/vec.h"

namespace nephele {

struct Image {
    enum class Extension { repeat, extend, clip, mirror };
    enum class Filter { linear, closest, cubic };

    std::string name;
    int width = 0, height = 0;
    Buffer<std::uint8_t> bytes;  ///< exactly one of bytes and floats is filled
    Buffer<float> floats;
    bool srgb = false;

    struct Texel {
        Rgb rgb;
        float alpha = 1;
    };
    /// Texel (x, y), inside the image; linear.
    Texel texel(int x, int y) const;
    /// Value at (u, v), [0,1]^2 covering the image. Cubic: uniform B-splines, which blur a little.
    Texel sample(Vec2f uv, Filter filter, Extension extension) const;
};

}  // namespace nephele
