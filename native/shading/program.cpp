// SPDX-License-Identifier: GPL-3.0-or-later
// The interpreter of shading programs. addon/opcodes.py states each operation; where it says "each channel by
// itself" the operation is a function of floats below.
#include "shading/program.h"

#include "grids/volume_fields.h"
#include "math/warp.h"
#include "shading/color_math.h"
#include "shading/procedural.h"
#include "shading/shading_inputs.h"
#include "shading/textures.h"

namespace nephele {
namespace {

template <typename F>
Vec3f each(F f, Vec3f a) {
    return {f(a.x), f(a.y), f(a.z)};
}
template <typename F>
Vec3f each(F f, Vec3f a, Vec3f b) {
    return {f(a.x, b.x), f(a.y, b.y), f(a.z, b.z)};
}
template <typename F>
Vec3f each(F f, Vec3f a, Vec3f b, Vec3f c) {
    return {f(a.x, b.x, c.x), f(a.y, b.y, c.y), f(a.z, b.z, c.z)};
}

// --- Operations on one channel
// -----------------------------------------------------------------------------------

float finite_or_zero(float x) {
    return std::isfinite(x) ? x : 0;
}
float one_if(bool condition) {
    return condition ? 1.0f : 0.0f;
}

float divide(float a, float b) {
    return b != 0 ? a / b : 0;
}
float power(float a, float b) {
    return finite_or_zero(std::pow(a, b));
}
float logarithm(float a, float b) {
    return a > 0 && b > 0 ? finite_or_zero(std::log(a) / std::log(b)) : 0;
}
float inverse_sqrt(float a) {
    return a > 0 ? 1 / std::sqrt(a) : 0;
}
float sign(float a) {
    return a > 0 ? 1.0f : a < 0 ? -1.0f : 0.0f;
}
float smooth_min(float a, float b, float distance) {
    if (distance == 0)
        return std::min(a, b);
    const float h = std::max(distance - std::fabs(a - b), 0.0f) / distance;
    return std::min(a, b) - h * h * h * distance * (1.0f / 6);
}
float smooth_max(float a, float b, float distance) {
    return -smooth_min(-a, -b, distance);
}
float modulo(float a, float b) {
    return b != 0 ? std::fmod(a, b) : 0;
}
float floored_modulo(float a, float b) {
    return b != 0 ? a - std::floor(a / b) * b : 0;
}
float wrap(float a, float high, float low) {
    const float span = high - low;
    return span != 0 ? a - span * std::floor((a - low) / span) : low;
}
float snap(float a, float b) {
    return b != 0 ? std::floor(a / b) * b : 0;
}
float pingpong(float a, float b) {
    if (b == 0)
        return 0;
    const float t = (a - b) / (2 * b);
    return std::fabs((t - std::floor(t)) * 2 * b - b);
}
float compare(float a, float b, float tolerance) {
    return one_if(std::fabs(a - b) <= std::max(tolerance, 1e-5f));
}
float map_range(float a, Vec3f from, Vec3f to, std::int32_t mode) {
    float t = divide(a - from.x, from.y - from.x);
    if (mode != 0)
        t = clamp01(t);
    if (mode == 1)
        t = t * t * (3 - 2 * t);
    if (mode == 2)
        t = t * t * t * (t * (t * 6 - 15) + 10);
    return to.x + (to.y - to.x) * t;
}

Vec3f transform(const float* m, Vec3f a, bool vector) {
    const auto row = [&](const float* r) {
        return r[0] * a.x + r[1] * a.y + r[2] * a.z + (vector ? 0 : r[3]);  // which may be no number
    };
    return {row(m), row(m + 4), row(m + 8)};
}

// --- Textures
// ----------------------------------------------------------------------------------------------------

/// What one instruction needs besides its operands.
struct Step {
    const Instruction& instruction;
    const Program& program;
    const ShadingPoint& point;
    const TextureContext& context;

    const float* parameters() const { return program.parameters.data() + instruction.parameter; }
    std::span<const float> table(std::size_t channels) const {
        return {parameters(), channels * static_cast<std::size_t>(instruction.mode + 1)};
    }
    const Image& image() const { return context.images[static_cast<std::size_t>(parameters()[0])]; }
    Image::Texel texel(Vec2f uv) const {
        return image().sample(uv, static_cast<Image::Filter>(instruction.mode & 3),
                              static_cast<Image::Extension>(instruction.mode >> 2));
    }
};

/// Environment map in direction d. The poles are not filtered with each other.
Rgb environment(const Step& step, Vec3f d) {
    if (is_zero(d) || !is_finite(d))
        return Rgb(0);
    Vec2f uv = equirectangular_from_direction(d);
    const float half_texel = 0.5f / static_cast<float>(step.image().height);
    uv.y = std::clamp(uv.y, half_texel, 1 - half_texel);
    return step.texel(uv).rgb;
}

// --- Groups of operations
// ----------------------------------------------------------------------------------------

Vec3f grid(const Step& step, Vec3f a) {
    if (!step.point.volume || !is_finite(a))
        return Vec3f(0);  // a grid is nowhere out there
    // Far from the world's origin a position is coarse; a grid that is read at the point itself is not.
    const Vec3f origin = step.context.origin;
    const Vec3f p = a == step.point.p + origin ? step.point.p : a - origin;
    return step.point.volume->value(step.instruction.mode, step.point.at_rest(p), step.point.time);
}

Vec3f flat(Vec2f v) {
    return {v.x, v.y, 0};
}

Vec3f texture_operation(Op op, const Step& step, Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
    const std::int32_t mode = step.instruction.mode;
    switch (op) {
        case Op::image:
            return step.texel({a.x, a.y}).rgb;
        case Op::image_alpha:
            return Vec3f(step.texel({a.x, a.y}).alpha);
        case Op::environment:
            return environment(step, a);
        case Op::environment_mirror_ball:
            return step.texel(mirror_ball_from_direction(a)).rgb;
        case Op::sphere_projection:
            return flat(sphere_projection(a));
        case Op::tube_projection:
            return flat(tube_projection(a));
        case Op::checker:
            return checker_is_odd(a * d.x) ? b : c;
        case Op::checker_fac:
            return Vec3f(one_if(checker_is_odd(a * d.x)));
        case Op::grid:
            return grid(step, a);
        case Op::noise:
            return noise_operation(mode, a, b, c, d);
        case Op::voronoi:
            return voronoi_operation(mode, a, b, c, d);
        case Op::white_noise:
            return white_noise_operation(mode, a, b);
        case Op::gabor:
            return gabor_operation(mode, a, b, c);
        case Op::brick:
            return brick_operation(step.parameters(), a, b, c);
        case Op::gradient:
            return Vec3f(gradient_value(static_cast<Gradient>(mode), a));
        case Op::ramp:
            return table_rgb(step.table(3), a.x);
        default:
            return Vec3f(table_scalar(step.table(1), a.x));  // ramp_alpha
    }
}

Vec3f channel_operation(Op op, Vec3f a, Vec3f b, Vec3f c) {
    switch (op) {
        case Op::divide:
            return each(divide, a, b);
        case Op::power:
            return each(power, a, b);
        case Op::logarithm:
            return each(logarithm, a, b);
        case Op::sqrt:
            return each([](float x) { return std::sqrt(std::max(x, 0.0f)); }, a);
        case Op::inverse_sqrt:
            return each(inverse_sqrt, a);
        case Op::absolute:
            return each([](float x) { return std::fabs(x); }, a);
        case Op::exponent:
            return exp(a);
        case Op::minimum:
            return min(a, b);
        case Op::maximum:
            return max(a, b);
        case Op::less_than:
            return each([](float x, float y) { return one_if(x < y); }, a, b);
        case Op::greater_than:
            return each([](float x, float y) { return one_if(x > y); }, a, b);
        case Op::sign:
            return each(sign, a);
        case Op::compare:
            return each(compare, a, b, c);
        case Op::smooth_min:
            return each(smooth_min, a, b, c);
        case Op::smooth_max:
            return each(smooth_max, a, b, c);
        case Op::round:
            return each([](float x) { return std::floor(x + 0.5f); }, a);
        case Op::floor:
            return each([](float x) { return std::floor(x); }, a);
        case Op::ceil:
            return each([](float x) { return std::ceil(x); }, a);
        case Op::truncate:
            return each([](float x) { return std::trunc(x); }, a);
        case Op::fraction:
            return each([](float x) { return x - std::floor(x); }, a);
        case Op::modulo:
            return each(modulo, a, b);
        case Op::floored_modulo:
            return each(floored_modulo, a, b);
        case Op::wrap:
            return each(wrap, a, b, c);
        case Op::snap:
            return each(snap, a, b);
        case Op::pingpong:
            return each(pingpong, a, b);
        case Op::sine:
            return each([](float x) { return std::sin(x); }, a);
        case Op::cosine:
            return each([](float x) { return std::cos(x); }, a);
        case Op::tangent:
            return each([](float x) { return std::tan(x); }, a);
        case Op::arcsine:
            return each([](float x) { return std::asin(std::clamp(x, -1.0f, 1.0f)); }, a);
        case Op::arccosine:
            return each([](float x) { return std::acos(std::clamp(x, -1.0f, 1.0f)); }, a);
        case Op::arctangent:
            return each([](float x) { return std::atan(x); }, a);
        case Op::arctan2:
            return each([](float y, float x) { return std::atan2(y, x); }, a, b);
        case Op::sinh:
            return each([](float x) { return std::sinh(x); }, a);
        case Op::cosh:
            return each([](float x) { return std::cosh(x); }, a);
        default:
            return each([](float x) { return std::tanh(x); }, a);  // tanh
    }
}

Vec3f vector_operation(Op op, const Step& step, Vec3f a, Vec3f b, Vec3f c) {
    const std::int32_t mode = step.instruction.mode;
    switch (op) {
        case Op::dot:
            return Vec3f(dot(a, b));
        case Op::cross:
            return cross(a, b);
        case Op::length:
            return Vec3f(length(a));
        case Op::normalize:
            return safe_normalize(a);
        case Op::distance:
            return Vec3f(length(a - b));
        case Op::transform:
            return transform(step.parameters(), a, mode == 1);
        case Op::channel:
            return Vec3f(a[mode]);
        case Op::combine:
            return {a.x, b.x, c.x};
        case Op::average:
            return Vec3f(mean(a));
        case Op::luminance:
            return Vec3f(luminance(a));
        case Op::fresnel:
            return Vec3f(fresnel_node(a.x, b, step.point));
        case Op::layer_weight:
            return Vec3f(mode == 0 ? layer_weight_fresnel(a.x, b, step.point)
                                   : layer_weight_facing(a.x, b, step.point));
        case Op::convert_space:
            return convert_space(mode, a, step.point, step.context);
        case Op::box_projection:
            return box_projection(a, b, mode, step.parameters()[0]);
        case Op::bump:
            return bump_normal(a, b.x, b.y, b.z, c, step.point, step.context);
        case Op::wireframe:
            return Vec3f(one_if(on_wire(a.x, mode == 1, step.point, step.context)));
        default:
            return tangent_normal(a, b.x, mode, step.point);  // normal_map
    }
}

Vec3f color_operation(Op op, std::int32_t mode, Vec3f a, Vec3f b, Vec3f c) {
    switch (op) {
        case Op::blend:
            return blend(static_cast<BlendMode>(mode), a, b, c.x);
        case Op::rgb_to_hsv:
            return hsv_from_rgb(a);
        case Op::hsv_to_rgb:
            return rgb_from_hsv(a);
        case Op::rgb_to_hsl:
            return hsl_from_rgb(a);
        case Op::hsl_to_rgb:
            return rgb_from_hsl(a);
        case Op::hue_saturation:
            return adjust_hue_saturation(a, b.x, b.y, b.z, c.x);
        case Op::bright_contrast:
            return max(a * (1 + c.x) + Vec3f(b.x - 0.5f * c.x), Vec3f(0));
        case Op::gamma:
            return each([&](float x) { return x > 0 ? std::pow(x, b.x) : x; }, a);
        case Op::invert:
            return lerp(a, Vec3f(1) - a, b.x);
        default:
            return blackbody_color(a.x);  // blackbody
    }
}

/// The value of one instruction. Operations of one group are neighbours in opcodes.py; the common ones come
/// first.
Vec3f evaluate(const Step& step, Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
    const Op op = static_cast<Op>(step.instruction.op);
    const std::int32_t mode = step.instruction.mode;
    switch (op) {
        case Op::copy:
            return a;
        case Op::add:
            return a + b;
        case Op::subtract:
            return a - b;
        case Op::multiply:
            return a * b;
        case Op::multiply_add:
            return a * b + c;
        case Op::clamp:
            return min(max(a, b), c);
        case Op::mix:
            return a + (b - a) * c;
        case Op::map_range:
            return each([&](float x) { return map_range(x, b, c, mode); }, a);
        case Op::blend:
            return color_operation(op, mode, a, b, c);
        default:
            break;
    }
    if (op < Op::image) {
        return mode < kShift ? shading_input(op, mode, step.point, step.context)
                             : shifted_input(op, mode, step.parameters()[0], step.point, step.context);
    }
    if (op < Op::copy)
        return texture_operation(op, step, a, b, c, d);
    if (op < Op::clamp)
        return channel_operation(op, a, b, c);
    if (op < Op::rgb_to_hsv || op > Op::blackbody)
        return vector_operation(op, step, a, b, c);
    return color_operation(op, mode, a, b, c);
}

}  // namespace

void run(const Program& program, const ShadingPoint& point, const TextureContext& context, Vec3f* registers) {
    std::copy(program.registers.begin(), program.registers.end(), registers);
    const auto at = [&](std::int32_t i) -> Vec3f& { return registers[static_cast<std::size_t>(i)]; };
    for (const Instruction& i : program.code) {
        at(i.dst) = evaluate({i, program, point, context}, at(i.a), at(i.b), at(i.c), at(i.d));
    }
}

}  // namespace nephele
