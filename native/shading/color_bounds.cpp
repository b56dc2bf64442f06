// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/color_bounds.h"

#include "shading/channel_bounds.h"
#include "shading/color_math.h"

namespace nephele {
namespace {

Interval1 max_component(const Interval3& c) {
    return max(c[0], max(c[1], c[2]));
}
Interval1 min_component(const Interval3& c) {
    return min(c[0], min(c[1], c[2]));
}
bool tame(const Interval3& c) {
    return tame(c[0], c[1], c[2]);
}
Interval3 lerp(const Interval3& a, const Interval3& b, Interval1 t) {
    return {lerp(a[0], b[0], t), lerp(a[1], b[1], t), lerp(a[2], b[2], t)};
}
Interval3 join(const Interval3& a, const Interval3& b) {
    return {join(a[0], b[0]), join(a[1], b[1]), join(a[2], b[2])};
}

// --- HSV and HSL
// ------------------------------------------------------------------------------------------------

constexpr Interval1 kAnyHue(0, 1);

Interval3 hsv_from_rgb(const Interval3& c) {
    if (!tame(c))
        return Interval3(everything());
    const Interval1 high = max_component(c), low = min_component(c);
    if (low.lo >= 0)
        return {kAnyHue, {0, 1}, high};
    // (high - low) / high is 1 - low / high, in which each appears once.
    const Interval1 ratio =
        high.contains(0) ? divide(max(high - low, Interval1(0)), high) : rounded(1 - quotient(low, high), 1);
    const Interval1 saturation = join(ratio, Interval1(0));
    return {kAnyHue, saturation, high};
}

Interval3 hsl_from_rgb(const Interval3& c) {
    if (!tame(c))
        return Interval3(everything());
    const Interval1 high = max_component(c), low = min_component(c), lightness = (high + low) * 0.5;
    Interval1 saturation(0, 1);
    if (low.lo < 0 || high.hi > 1) {
        const double size = 2 + high.magnitude() + low.magnitude();
        const Interval1 range = max(high - low, Interval1(0));
        const Interval1 dark = quotient(range, rounded(high + low, size)),
                        light = quotient(range, rounded(2 - high - low, size));
        if (lightness.lo > 0.5)
            saturation = join(light, Interval1(0));
        else
            saturation = join(lightness.hi <= 0.5 ? dark : join(dark, light), Interval1(0));
    }
    return {kAnyHue, saturation, lightness};
}

/// One channel of the fully saturated colour of a hue: 1 for a third of the circle around `center`, 0 for the
/// third across, linear between.
Interval1 pure_channel(Interval1 hue, double center) {
    if (!tame(hue) || hue.width() >= 1)
        return {0, 1, !tame(hue)};
    const auto value = [&](double h) {
        const double turn = h - center,
                     distance = std::fabs(turn - std::round(turn));  // of the circle: 0 to 1/2
        return std::clamp(2 - 6 * distance, 0.0, 1.0);
    };
    const auto holds = [&](double place) { return std::floor(hue.hi - place) >= std::ceil(hue.lo - place); };
    const double p = value(hue.lo), q = value(hue.hi);
    const Interval1 ends = rounded({std::min(p, q), std::max(p, q)}, 8);
    return {holds(center + 0.5) ? 0 : std::max(0.0, ends.lo), holds(center) ? 1 : std::min(1.0, ends.hi)};
}
Interval3 pure_hue(Interval1 hue) {
    return {pure_channel(hue, 0), pure_channel(hue, 1.0 / 3), pure_channel(hue, 2.0 / 3)};
}

Interval3 rgb_from_hsv(const Interval3& hsv) {
    const Interval3 rgb = lerp(Interval3(Vec3f(1)), pure_hue(hsv[0]), hsv[1]);
    return {rgb[0] * hsv[2], rgb[1] * hsv[2], rgb[2] * hsv[2]};
}

Interval3 rgb_from_hsl(const Interval3& hsl) {
    const Interval1 chroma = (1 - absolute(hsl[2] * 2 - 1)) * hsl[1];
    const Interval3 pure = pure_hue(hsl[0]);
    const auto channel = [&](int i) { return (pure[i] - 0.5) * chroma + hsl[2]; };
    return {channel(0), channel(1), channel(2)};
}

Interval3 adjust_hue_saturation(const Interval3& a, const Interval3& by, Interval1 t) {
    const Interval3 hsv = hsv_from_rgb(a);
    const Interval1 hue = hsv[0] + (by[0] + 0.5), saturation = clamp01(hsv[1] * by[1]),
                    value = hsv[2] * by[2];
    const Interval3 mixed = lerp(a, rgb_from_hsv({hue, saturation, value}), t);
    const Interval1 zero(0);
    return {max(mixed[0], zero), max(mixed[1], zero), max(mixed[2], zero)};
}

// --- Blend modes
// ------------------------------------------------------------------------------------------------

Interval1 overlay(Interval1 a, Interval1 b, Interval1 t) {
    constexpr double kMiddle = 0.5;
    Interval1 value = everything();
    const bool low = a.lo < kMiddle, high = a.hi >= kMiddle;
    const auto dark = [](double x, double y, double w) { return x * (1 - w + 2 * w * y); };
    const auto light = [](double x, double y, double w) { return 1 - (1 - w + 2 * w * (1 - y)) * (1 - x); };
    const auto dark_size = [](double x, double y, double w) { return x * (1 + w + 2 * w * y); };
    const auto light_size = [](double x, double y, double w) {
        return 1 + (1 + w + 2 * w * (1 + y)) * (1 + x);
    };
    if (low)
        value = multilinear({a.lo, std::min(a.hi, kMiddle)}, b, t, dark, dark_size);
    if (high) {
        const Interval1 bright = multilinear({std::max(a.lo, kMiddle), a.hi}, b, t, light, light_size);
        value = low ? join(value, bright) : bright;
    }
    return value;
}

Interval1 positive_part(Interval1 a) {
    return {std::max<double>(a.lo, std::numeric_limits<float>::denorm_min()), a.hi};
}
/// 1 - t + t b and 1 - t b.
Interval1 burn_divisor(Interval1 b, Interval1 t) {
    return multilinear(
        b, t, Interval1(0), [](double y, double w, double) { return 1 - w + w * y; },
        [](double y, double w, double) { return 1 + w + w * y; });
}
Interval1 dodge_divisor(Interval1 b, Interval1 t) {
    return multilinear(
        b, t, Interval1(0), [](double y, double w, double) { return 1 - w * y; },
        [](double y, double w, double) { return 1 + w * y; });
}

/// A blend mode that acts on each channel alone, of operands that are tame.
Interval1 blend_channel(BlendMode mode, Interval1 a, Interval1 b, Interval1 t) {
    switch (mode) {
        case BlendMode::darken:
            return lerp(a, min(a, b), t);
        case BlendMode::multiply:
            return multilinear(
                a, b, t, [](double x, double y, double w) { return x + (x * y - x) * w; },
                [](double x, double y, double w) { return x + (x * y + x) * w; });
        case BlendMode::lighten:
            return lerp(a, max(a, b), t);
        case BlendMode::screen:
            return multilinear(
                a, b, t, [](double x, double y, double w) { return 1 - (1 - w * y) * (1 - x); },
                [](double x, double y, double w) { return 1 + (1 + w + w * (1 + y)) * (1 + x); });
        case BlendMode::add:
            return a + t * b;
        case BlendMode::subtract:
            return a - t * b;
        case BlendMode::difference:
            return lerp(a, absolute(a - b), t);
        case BlendMode::exclusion:
            return max(Interval1(0),
                       multilinear(
                           a, b, t, [](double x, double y, double w) { return x + (y - 2 * x * y) * w; },
                           [](double x, double y, double w) { return x + (2 * x + y + 2 * x * y) * w; }));
        case BlendMode::divide: {
            const Interval1 value = lerp(a, divide(a, b), t);
            return b.contains(0) ? join(value, a) : value;
        }
        case BlendMode::linear_light:
            return a + t * (b * 2 - 1);
        case BlendMode::soft_light: {
            // (1 - a) b a + a (1 - (1 - b) (1 - a)) is a (2 b (1 - a) + a).
            const double x = a.magnitude(), y = b.magnitude();
            const Interval1 target = rounded(a * (b * 2 * (1 - a) + a), x * (2 + 3 * (1 + x) * (1 + y)));
            return lerp(a, target, t);
        }
        case BlendMode::overlay:
            return overlay(a, b, t);
        case BlendMode::burn: {
            const Interval1 divisor = burn_divisor(b, t);
            if (divisor.hi <= 0)
                return Interval1(0);
            const Interval1 value = clamp01(1 - quotient(1 - a, positive_part(divisor)));
            return divisor.lo <= 0 ? join(value, Interval1(0)) : value;
        }
        case BlendMode::dodge: {
            const Interval1 divisor = dodge_divisor(b, t);
            Interval1 value(1);
            if (divisor.hi > 0) {
                value = min(Interval1(1), quotient(a, positive_part(divisor)));
                value = divisor.lo <= 0 ? join(value, Interval1(1)) : value;
            }
            return a.contains(0) ? join(value, Interval1(0)) : value;
        }
        default:
            return lerp(a, b, t);  // mix
    }
}

Interval3 blend_hsv(BlendMode mode, const Interval3& a, const Interval3& b, Interval1 t) {
    const Interval3 target = hsv_from_rgb(a), source = hsv_from_rgb(b);
    if (mode == BlendMode::value)
        return rgb_from_hsv({target[0], target[1], lerp(target[2], source[2], t)});
    if (mode == BlendMode::saturation) {
        const Interval3 value = rgb_from_hsv({target[0], lerp(target[1], source[1], t), target[2]});
        return target[1].contains(0) ? join(value, a) : value;
    }
    const Interval1 saturation = mode == BlendMode::color ? source[1] : target[1];
    const Interval3 value = lerp(a, rgb_from_hsv({source[0], saturation, target[2]}), t);
    return source[1].contains(0) ? join(value, a) : value;
}

// --- Others
// -----------------------------------------------------------------------------------------------------

Interval1 gamma(Interval1 x, Interval1 exponent) {
    if (!(x.hi > 0))
        return x;
    const Interval1 power = positive_power({std::max(x.lo, 0.0), x.hi, x.nan}, exponent);
    return x.lo <= 0 ? join(power, {x.lo, std::min(x.hi, 0.0)}) : power;
}

Interval3 blackbody(Interval1 kelvin) {
    // Linear between entries of a table: extremes are at its entries, or at the ends of the range.
    constexpr double kLow = 800, kStep = 25, kHigh = 12000;
    const Interval1 range = rounded(narrowed({kelvin.nan ? kLow : kelvin.lo, kelvin.hi}, kLow, kHigh));
    const auto at = [](double k) { return Interval3(blackbody_color(static_cast<float>(k))); };
    Interval3 value = join(at(range.lo), at(range.hi));
    for (double k = kLow + kStep * std::ceil((range.lo - kLow) / kStep); k < range.hi; k += kStep)
        value = join(value, at(k));
    const auto channel = [&](int c) { return rounded(value[c], 4 * value[c].magnitude()); };
    return {channel(0), channel(1), channel(2)};
}

}  // namespace

Interval3 blend_bounds(BlendMode mode, const Interval3& a, const Interval3& b, Interval1 t) {
    if (!tame(a) || !tame(b) || !tame(t))
        return Interval3(everything());
    const bool hsv = mode == BlendMode::hue || mode == BlendMode::saturation || mode == BlendMode::color ||
                     mode == BlendMode::value;
    if (hsv)
        return blend_hsv(mode, a, b, t);
    return {blend_channel(mode, a[0], b[0], t), blend_channel(mode, a[1], b[1], t),
            blend_channel(mode, a[2], b[2], t)};
}

Interval3 color_bounds(Op op, const Interval3& a, const Interval3& b, const Interval3& c) {
    const auto each = [&](auto f) { return Interval3(f(a[0]), f(a[1]), f(a[2])); };
    switch (op) {
        case Op::rgb_to_hsv:
            return hsv_from_rgb(a);
        case Op::hsv_to_rgb:
            return rgb_from_hsv(a);
        case Op::rgb_to_hsl:
            return hsl_from_rgb(a);
        case Op::hsl_to_rgb:
            return rgb_from_hsl(a);
        case Op::hue_saturation:
            return adjust_hue_saturation(a, b, c[0]);
        case Op::bright_contrast:
            return each([&](Interval1 x) { return max(x * (c[0] + 1) + (b[0] - c[0] * 0.5), Interval1(0)); });
        case Op::gamma:
            return each([&](Interval1 x) { return gamma(x, b[0]); });
        case Op::invert:
            return each([&](Interval1 x) {
                return tame(x) && tame(b[0])
                           ? multilinear(
                                 x, b[0], Interval1(0),
                                 [](double v, double t, double) { return v + (1 - 2 * v) * t; },
                                 [](double v, double t, double) { return v + (1 + 2 * v) * t; })
                           : everything();
            });
        case Op::blackbody:
            return blackbody(a[0]);
        default:
            return Interval3(everything());
    }
}

}  // namespace nephele
