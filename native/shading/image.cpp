// SPDX-License-Identifier: GPL-3.0-or-later
// Texel access and bilinear filtering. Bytes become linear before they are filtered.
#include "shading/image.h"

#include <array>

namespace nephele {
namespace {

/// Linear value of every sRGB byte (IEC 61966-2-1).
const std::array<float, 256>& linear_from_srgb_byte() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> values{};
        for (std::size_t i = 0; i < values.size(); ++i) {
            const double c = static_cast<double>(i) / 255;
            values[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
        }
        return values;
    }();
    return table;
}

/// Index i brought into [0, size) as the extension has it; clip is handled before.
int wrapped(int i, int size, Image::Extension extension) {
    if (extension == Image::Extension::repeat) {
        i %= size;
        return i < 0 ? i + size : i;
    }
    if (extension == Image::Extension::mirror) {
        i %= 2 * size;
        if (i < 0)
            i += 2 * size;
        return i < size ? i : 2 * size - 1 - i;
    }
    return std::clamp(i, 0, size - 1);
}

Image::Texel mix(const Image::Texel& a, const Image::Texel& b, float t) {
    return {lerp(a.rgb, b.rgb, t), lerp(a.alpha, b.alpha, t)};
}

/// Weights of the uniform cubic B-spline for the four texels around a place, t past the second.
std::array<float, 4> spline_weights(float t) {
    const float s = 1 - t, before = s * s * s / 6, after = t * t * t / 6;
    const float near = (4 - 6 * t * t + 3 * t * t * t) / 6;
    return {before, near, 1 - before - near - after, after};
}

/// u with its whole tiles taken away (a tile and its mirror image), so that texel numbers stay exact far out.
float within_tiles(float u) {
    return u - 2 * std::floor(u / 2);
}

}  // namespace

Image::Texel Image::texel(int x, int y) const {
    const std::size_t i =
        4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
    if (!floats.empty())
        return {{floats[i], floats[i + 1], floats[i + 2]}, floats[i + 3]};
    const auto unit = [&](std::size_t k) { return static_cast<float>(bytes[k]) * (1.0f / 255); };
    if (!srgb)
        return {{unit(i), unit(i + 1), unit(i + 2)}, unit(i + 3)};
    const auto& linear = linear_from_srgb_byte();
    return {{linear[bytes[i]], linear[bytes[i + 1]], linear[bytes[i + 2]]}, unit(i + 3)};
}

Image::Texel Image::sample(Vec2f uv, Filter filter, Extension extension) const {
    const bool tiled = extension == Extension::repeat || extension == Extension::mirror;
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
        return {Rgb(0), 0};
    if (extension == Extension::clip && (uv.x < 0 || uv.x > 1 || uv.y < 0 || uv.y > 1))
        return {Rgb(0), 0};
    uv = tiled ? Vec2f{within_tiles(uv.x), within_tiles(uv.y)} : Vec2f{clamp01(uv.x), clamp01(uv.y)};
    const auto at = [&](int x, int y) {
        return texel(wrapped(x, width, extension), wrapped(y, height, extension));
    };
    const float offset = filter == Filter::closest ? 0 : 0.5f;  // texel centres are at half texels
    const float x = uv.x * static_cast<float>(width) - offset, y = uv.y * static_cast<float>(height) - offset;
    const float x0 = std::floor(x), y0 = std::floor(y);
    const int ix = static_cast<int>(x0), iy = static_cast<int>(y0);
    if (filter == Filter::closest)
        return at(ix, iy);
    const float tx = x - x0, ty = y - y0;
    if (filter == Filter::linear)
        return mix(mix(at(ix, iy), at(ix + 1, iy), tx), mix(at(ix, iy + 1), at(ix + 1, iy + 1), tx), ty);
    const auto wx = spline_weights(tx), wy = spline_weights(ty);
    Texel sum{Rgb(0), 0};
    for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
            const float w = wx[static_cast<std::size_t>(i)] * wy[static_cast<std::size_t>(j)];
            const Texel t = at(ix + i - 1, iy + j - 1);
            sum.rgb += t.rgb * w;
            sum.alpha += t.alpha * w;
        }
    }
    return sum;
}

}  // namespace nephele
