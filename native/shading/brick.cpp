// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/brick.h"

#include <cstdint>

namespace nephele {
namespace {

/// A hash of a brick's number in [0, 1]: the integer noise of Perlin's early demos, as Blender has it.
float brick_random(std::uint32_t n) {
    n = (n + 1013) & 0x7fffffffu;
    n ^= n >> 13;
    const std::uint32_t mixed = (n * (n * n * 60493u + 19990303u) + 1376312589u) & 0x7fffffffu;
    return 0.5f * static_cast<float>(mixed) / 1073741824.0f;
}

std::int32_t whole(float x) {
    return std::isfinite(x) ? static_cast<std::int32_t>(std::clamp(std::floor(x), -2e9f, 2e9f)) : 0;
}

}  // namespace

Brick brick(Vec3f p, const BrickSettings& settings) {
    const std::int32_t row = whole(p.y / settings.row_height);
    float width = settings.width, shift = 0;
    if (settings.offset_every != 0 && settings.squash_every != 0) {
        if (row % settings.squash_every == 0)
            width *= settings.squash;
        if (row % settings.offset_every == 0)
            shift = width * settings.offset;
    }
    const std::int32_t column = whole((p.x + shift) / width);
    const float x = p.x + shift - width * static_cast<float>(column),
                y = p.y - settings.row_height * static_cast<float>(row);
    const std::uint32_t number =
        (static_cast<std::uint32_t>(row) << 16) + (static_cast<std::uint32_t>(column) & 0xffffu);
    Brick out;
    out.tint = clamp01(brick_random(number) + settings.bias);
    const float edge = std::min(std::min(x, y), std::min(width - x, settings.row_height - y));
    if (edge < settings.mortar_size) {
        const float depth = 1 - edge / settings.mortar_size;
        const float t = settings.mortar_smooth > 0 ? clamp01(depth / settings.mortar_smooth) : 1;
        out.mortar = t * t * (3 - 2 * t);
    }
    return out;
}

}  // namespace nephele
