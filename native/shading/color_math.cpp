// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/color_math.h"

#include <array>

namespace nephele {
namespace {

/// Hue in [0, 1) of a colour whose largest channel is `high` and whose range is `range` > 0.
float hue_of(Rgb c, float high, float range) {
    const float sixth = c.x == high   ? (c.y - c.z) / range
                        : c.y == high ? 2 + (c.z - c.x) / range
                                      : 4 + (c.x - c.y) / range;
    return sixth < 0 ? sixth / 6 + 1 : sixth / 6;
}

/// The fully saturated colour of a hue.
Rgb pure_hue(float hue) {
    const float h = 6 * hue;
    return {clamp01(std::fabs(h - 3) - 1), clamp01(2 - std::fabs(h - 2)), clamp01(2 - std::fabs(h - 4))};
}

/// A blend mode that acts on each channel alone: b over a by t, s = 1 - t.
float blend_channel(BlendMode mode, float a, float b, float t) {
    const float s = 1 - t;
    switch (mode) {
        case BlendMode::darken:
            return lerp(a, std::min(a, b), t);
        case BlendMode::multiply:
            return lerp(a, a * b, t);
        case BlendMode::lighten:
            return lerp(a, std::max(a, b), t);
        case BlendMode::screen:
            return 1 - (s + t * (1 - b)) * (1 - a);
        case BlendMode::add:
            return a + t * b;
        case BlendMode::subtract:
            return a - t * b;
        case BlendMode::difference:
            return lerp(a, std::fabs(a - b), t);
        case BlendMode::exclusion:
            return std::max(0.0f, lerp(a, a + b - 2 * a * b, t));
        case BlendMode::divide:
            return b != 0 ? lerp(a, a / b, t) : a;
        case BlendMode::linear_light:
            return a + t * (2 * b - 1);
        case BlendMode::soft_light:
            return s * a + t * ((1 - a) * b * a + a * (1 - (1 - b) * (1 - a)));
        case BlendMode::overlay:
            return a < 0.5f ? a * (s + 2 * t * b) : 1 - (s + 2 * t * (1 - b)) * (1 - a);
        case BlendMode::burn: {
            const float divisor = s + t * b;
            return divisor <= 0 ? 0 : clamp01(1 - (1 - a) / divisor);
        }
        case BlendMode::dodge: {
            const float divisor = 1 - t * b;
            return a == 0 ? 0 : divisor <= 0 ? 1 : std::min(1.0f, a / divisor);
        }
        default:
            return lerp(a, b, t);  // mix
    }
}

/// The modes that take part of b's hue, saturation and value; a colour without hue leaves a's.
Rgb blend_hsv(BlendMode mode, Rgb a, Rgb b, float t) {
    Vec3f target = hsv_from_rgb(a);
    const Vec3f source = hsv_from_rgb(b);
    if (mode == BlendMode::value) {
        target.z = lerp(target.z, source.z, t);
        return rgb_from_hsv(target);
    }
    if (mode == BlendMode::saturation) {
        if (target.y == 0)
            return a;
        target.y = lerp(target.y, source.y, t);
        return rgb_from_hsv(target);
    }
    if (source.y == 0)
        return a;
    target.x = source.x;
    if (mode == BlendMode::color)
        target.y = source.y;
    return lerp(a, rgb_from_hsv(target), t);
}

/// CIE 1931 colour matching functions of the 2 degree observer from 380 nm in steps of 10 nm. (Their usual
/// fits by sums of Gaussians are too coarse in the far red, where the fires of 1000 to 1500 K shine.)
constexpr double kObserver[][3] = {
    {0.0014, 0.0000, 0.0065},  {0.0042, 0.0001, 0.0201},  {0.0143, 0.0004, 0.0679},
    {0.0435, 0.0012, 0.2074},  {0.1344, 0.0040, 0.6456},  {0.2839, 0.0116, 1.3856},
    {0.3483, 0.0230, 1.7471},  {0.3362, 0.0380, 1.7721},  {0.2908, 0.0600, 1.6692},
    {0.1954, 0.0910, 1.2876},  {0.0956, 0.1390, 0.8130},  {0.0320, 0.2080, 0.4652},
    {0.0049, 0.3230, 0.2720},  {0.0093, 0.5030, 0.1582},  {0.0633, 0.7100, 0.0782},
    {0.1655, 0.8620, 0.0422},  {0.2904, 0.9540, 0.0203},  {0.4334, 0.9950, 0.0087},
    {0.5945, 0.9950, 0.0039},  {0.7621, 0.9520, 0.0021},  {0.9163, 0.8700, 0.0017},
    {1.0263, 0.7570, 0.0011},  {1.0622, 0.6310, 0.0008},  {1.0026, 0.5030, 0.0003},
    {0.8544, 0.3810, 0.0002},  {0.6424, 0.2650, 0.0000},  {0.4479, 0.1750, 0.0000},
    {0.2835, 0.1070, 0.0000},  {0.1649, 0.0610, 0.0000},  {0.0874, 0.0320, 0.0000},
    {0.0468, 0.0170, 0.0000},  {0.0227, 0.0082, 0.0000},  {0.0114, 0.0041, 0.0000},
    {0.0058, 0.0021, 0.0000},  {0.0029, 0.00105, 0.0000}, {0.0014, 0.00052, 0.0000},
    {0.0007, 0.00025, 0.0000}, {0.0003, 0.00012, 0.0000}, {0.0002, 0.00006, 0.0000}};

Rgb integrate_blackbody(double kelvin) {
    double xyz[3] = {}, nm = 380;
    for (const auto& response : kObserver) {
        const double planck = std::pow(560 / nm, 5) / std::expm1(1.438776877e7 / (nm * kelvin));
        for (int k = 0; k < 3; ++k)
            xyz[k] += planck * response[k];
        nm += 10;
    }
    const double x = xyz[0] / xyz[1], z = xyz[2] / xyz[1];
    const Rgb rgb(static_cast<float>(3.2404542 * x - 1.5371385 - 0.4985314 * z),
                  static_cast<float>(-0.9692660 * x + 1.8760108 + 0.0415560 * z),
                  static_cast<float>(0.0556434 * x - 0.2040259 + 1.0572252 * z));
    return max(rgb, Rgb(0));
}

}  // namespace

Vec3f hsv_from_rgb(Rgb c) {
    const float high = max_component(c), range = high - min_component(c);
    if (range <= 0)
        return {0, 0, high};
    return {hue_of(c, high, range), high != 0 ? range / high : 0, high};
}

Rgb rgb_from_hsv(Vec3f hsv) {
    return lerp(Rgb(1), pure_hue(hsv.x - std::floor(hsv.x)), hsv.y) * hsv.z;
}

Vec3f hsl_from_rgb(Rgb c) {
    const float high = max_component(c), low = min_component(c), range = high - low,
                lightness = 0.5f * (high + low);
    if (range <= 0)
        return {0, 0, lightness};
    const float most = lightness > 0.5f ? 2 - high - low : high + low;  // may be 0 outside of [0, 1]
    return {hue_of(c, high, range), most != 0 ? range / most : 0, lightness};
}

Rgb rgb_from_hsl(Vec3f hsl) {
    const float chroma = (1 - std::fabs(2 * hsl.z - 1)) * hsl.y;
    return (pure_hue(hsl.x - std::floor(hsl.x)) - Rgb(0.5f)) * chroma + Rgb(hsl.z);
}

Rgb blend(BlendMode mode, Rgb a, Rgb b, float t) {
    const bool hsv = mode == BlendMode::hue || mode == BlendMode::saturation || mode == BlendMode::color ||
                     mode == BlendMode::value;
    if (hsv)
        return blend_hsv(mode, a, b, t);
    return {blend_channel(mode, a.x, b.x, t), blend_channel(mode, a.y, b.y, t),
            blend_channel(mode, a.z, b.z, t)};
}

Rgb adjust_hue_saturation(Rgb a, float hue, float saturation, float value, float t) {
    Vec3f hsv = hsv_from_rgb(a);
    hsv.x += hue + 0.5f;  // rgb_from_hsv takes whole turns away
    hsv.y = clamp01(hsv.y * saturation);
    hsv.z *= value;
    return max(lerp(a, rgb_from_hsv(hsv), t), Rgb(0));
}

Rgb blackbody_color(float kelvin) {
    constexpr float kLow = 800, kStep = 25;
    static const std::array<Rgb, 449> table = [] {
        std::array<Rgb, 449> colors;
        for (std::size_t i = 0; i < colors.size(); ++i) {
            colors[i] = integrate_blackbody(kLow + kStep * static_cast<double>(i));
        }
        return colors;
    }();
    constexpr float kLast = 448;
    const float place = kelvin > kLow ? std::min((kelvin - kLow) / kStep, kLast) : 0;  // NaN goes low
    const auto i = static_cast<std::size_t>(std::min(place, kLast - 1));
    return lerp(table[i], table[i + 1], place - static_cast<float>(i));
}

}  // namespace nephele
