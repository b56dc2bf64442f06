// SPDX-License-Identifier: GPL-3.0-or-later
// The interpreter of bounds: the same groups of operations as in program.cpp, over intervals.
#include "shading/program_bounds.h"

#include "shading/channel_bounds.h"
#include "shading/color_bounds.h"
#include "shading/input_bounds.h"
#include "shading/procedural_bounds.h"
#include "shading/texture_bounds.h"

namespace nephele {
namespace {

template <typename F>
Interval3 each(F f, const Interval3& a) {
    return {f(a[0]), f(a[1]), f(a[2])};
}
template <typename F>
Interval3 each(F f, const Interval3& a, const Interval3& b) {
    return {f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])};
}
template <typename F>
Interval3 each(F f, const Interval3& a, const Interval3& b, const Interval3& c) {
    return {f(a[0], b[0], c[0]), f(a[1], b[1], c[1]), f(a[2], b[2], c[2])};
}

float rounded_down(double v) {
    const auto f = static_cast<float>(v);
    return f > v ? std::nextafter(f, -kInfinity) : f;
}

// --- Groups of operations
// ----------------------------------------------------------------------------------------

/// What one instruction needs besides its operands.
struct Step {
    const Instruction& instruction;
    const Program& program;
    const BoundsInput& input;

    const float* parameters() const { return program.parameters.data() + instruction.parameter; }
    Interval1 table(std::size_t channels, std::size_t channel, Interval1 t) const {
        return table_bounds({parameters(), channels * static_cast<std::size_t>(instruction.mode + 1)},
                            channels, channel, t);
    }
    const ImageBounds& image() const { return input.images[static_cast<std::size_t>(parameters()[0])]; }
};

Interval3 image_bounds(const Step& step, Op op, const Interval3& at) {
    const ImageBounds& image = step.image();
    const Interval3 texels = op == Op::image_alpha ? Interval3(image.alpha) : image.rgb;
    const bool clipped = static_cast<Image::Extension>(step.instruction.mode >> 2) == Image::Extension::clip;
    const auto outside = [](Interval1 x) { return x.nan || !x.bounded(); };
    // Directions have any length; that of 0 gives black.
    const bool direction = op == Op::environment || op == Op::environment_mirror_ball;
    if (!clipped && !direction && !outside(at[0]) && !outside(at[1]))
        return texels;
    return each([](Interval1 x) { return join(x, Interval1(0)); }, texels);
}

/// Whether an operand of an instruction is the point itself.
bool is_position(const Program& program, const Instruction& instruction, std::int32_t operand) {
    const Instruction* writer = &instruction;
    while (writer != program.code.data()) {
        --writer;
        if (writer->dst == operand)
            return writer->op == static_cast<std::int32_t>(Op::position);
    }
    return false;
}

Interval3 grid(const Step& step, const Interval3& p) {
    const BoundsInput& input = step.input;
    if (!input.point.volume)
        return Interval3(Interval1(0));
    const std::int32_t number = step.instruction.mode;
    if (!input.world_from_rest.empty()) {  // grids move with the box; what else is read may be anywhere
        return is_position(step.program, step.instruction, step.instruction.a)
                   ? input.grid_range(number, input.lo, input.hi)
                   : input.grid_range(number, Vec3f(-kInfinity), Vec3f(kInfinity));
    }
    if (p.nan)
        return Interval3(everything());
    const Interval3 here = moved(p, -input.context.origin);
    return input.grid_range(number, here.lo, here.hi);
}

Interval3 texture_bounds(Op op, const Step& step, const Interval3& a, const Interval3& b, const Interval3& c,
                         const Interval3& d) {
    const auto odd = [&] { return checker_bounds(each([&](Interval1 x) { return x * d[0]; }, a)); };
    switch (op) {
        case Op::image:
        case Op::image_alpha:
        case Op::environment:
        case Op::environment_mirror_ball:
            return image_bounds(step, op, a);
        case Op::sphere_projection:
        case Op::tube_projection: {
            const Interval1 unit(-kIntervalRounding, 1 + kIntervalRounding, !tame(a[0], a[1], a[2]));
            return {unit, op == Op::tube_projection ? join(a[2], Interval1(0)) : unit, Interval1(0)};
        }
        case Op::checker: {
            const Interval1 known = odd();
            return known.is(1)   ? b
                   : known.is(0) ? c
                                 : each([](Interval1 x, Interval1 y) { return join(x, y); }, b, c);
        }
        case Op::checker_fac:
            return Interval3(odd());
        case Op::grid:
            return grid(step, a);
        case Op::noise:
            return noise_operation_bounds(step.instruction.mode, a, b, c, d);
        case Op::voronoi:
            return voronoi_operation_bounds(step.instruction.mode, a, b, c, d);
        case Op::white_noise:
            return Interval3(Interval1(0, 1));
        case Op::gabor:
            return gabor_operation_bounds(step.instruction.mode, b, c);
        case Op::brick:
            return brick_operation_bounds(a, b, c);
        case Op::gradient:
            return Interval3(gradient_bounds(static_cast<Gradient>(step.instruction.mode), a));
        case Op::ramp:
            return {step.table(3, 0, a[0]), step.table(3, 1, a[0]), step.table(3, 2, a[0])};
        case Op::ramp_alpha:
            return Interval3(step.table(1, 0, a[0]));
        default:
            return Interval3(everything());
    }
}

/// Sum of three products; of squares where both are the same register.
Interval1 dot_bounds(const Interval3& a, const Interval3& b, bool same) {
    const auto product = [&](int i) { return same ? squared(a[i]) : a[i] * b[i]; };
    return product(0) + product(1) + product(2);
}

Interval3 normalized(const Interval3& v) {
    if (!tame(v[0], v[1], v[2]))
        return Interval3(Interval1(kDirection.lo, kDirection.hi, true));
    const Interval1 size = length(v);
    if (size.lo < 1e-15)  // also 0, of which 0 is made
        return Interval3(kDirection);
    // Each component grows with its own coordinate, and shrinks with the others'.
    const auto component = [&](int i) {
        const Interval1 rest = squared(v[(i + 1) % 3]) + squared(v[(i + 2) % 3]);
        const auto at = [&](double x, double r2) { return x == 0 ? 0 : x / std::sqrt(x * x + r2); };
        return rounded(
            {at(v[i].lo, v[i].lo < 0 ? rest.lo : rest.hi), at(v[i].hi, v[i].hi < 0 ? rest.hi : rest.lo)});
    };
    return {component(0), component(1), component(2)};
}

Interval3 vector_bounds(Op op, const Step& step, const Interval3& a, const Interval3& b, const Interval3& c) {
    const std::int32_t mode = step.instruction.mode;
    const auto difference = [](Interval1 x, Interval1 y) { return x - y; };
    switch (op) {
        case Op::dot:
            return Interval3(dot_bounds(a, b, step.instruction.a == step.instruction.b));
        case Op::cross:
            return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
        case Op::length:
            return Interval3(length(a));
        case Op::normalize:
            return normalized(a);
        case Op::distance:
            return Interval3(length(each(difference, a, b)));
        case Op::transform: {
            const float* m = step.parameters();
            const auto row = [&](int i) {
                const float* r = m + 4 * i;
                return row_bounds({r[0], r[1], r[2]}, mode == 1 ? 0 : r[3], a);
            };
            return {row(0), row(1), row(2)};
        }
        case Op::channel:
            return Interval3(a[mode]);
        case Op::combine:
            return {a[0], b[0], c[0]};
        case Op::average:
            return Interval3((a[0] + a[1] + a[2]) * (1.0 / 3));
        case Op::luminance:
            return Interval3(a[0] * 0.2126729 + a[1] * 0.7151522 + a[2] * 0.0721750);
        case Op::fresnel:
        case Op::layer_weight:
            return Interval3(Interval1(0, 1 + kIntervalRounding, !tame(a[0])));
        case Op::convert_space:
            return converted_bounds(mode, a, step.input);
        case Op::box_projection: {
            const auto either = [&](int k) { return join(a[k], 1 - a[k]); };  // flipped or not
            const Interval1 weight(-1e-3, 1 + 1e-3, !tame(b[0], b[1], b[2]));
            return mode == 0   ? Interval3(either(1), a[2], weight)
                   : mode == 1 ? Interval3(either(0), a[2], weight)
                               : Interval3(either(1), a[0], weight);
        }
        case Op::bump: {
            const bool known = tame(a[0], a[1], a[2]) && tame(b[0], b[1], b[2]) && tame(c[0], c[1], c[2]);
            const auto or_given = [&](int k) {
                return known ? join(Interval1(kDirection.lo, kDirection.hi), c[k]) : everything();
            };
            return {or_given(0), or_given(1), or_given(2)};
        }
        case Op::wireframe:
            return Interval3(Interval1(0, 1));
        case Op::normal_map:
            return Interval3(Interval1(kDirection.lo, kDirection.hi, !tame(a[0], a[1], a[2]) || !tame(b[0])));
        default:
            return Interval3(everything());
    }
}

Interval3 evaluate(const Step& step, const Interval3& a, const Interval3& b, const Interval3& c,
                   const Interval3& d) {
    const Op op = static_cast<Op>(step.instruction.op);
    const std::int32_t mode = step.instruction.mode;
    const auto product = [&](Interval1 x, Interval1 y) {
        return step.instruction.a == step.instruction.b ? squared(x) : x * y;
    };
    switch (op) {
        case Op::copy:
            return a;
        case Op::add:
            return each([](Interval1 x, Interval1 y) { return x + y; }, a, b);
        case Op::subtract:
            return each([](Interval1 x, Interval1 y) { return x - y; }, a, b);
        case Op::multiply:
            return each(product, a, b);
        case Op::multiply_add:
            return each([&](Interval1 x, Interval1 y, Interval1 z) { return product(x, y) + z; }, a, b, c);
        case Op::clamp:
            return each([](Interval1 x, Interval1 low, Interval1 high) { return min(max(x, low), high); }, a,
                        b, c);
        case Op::mix:
            return each([](Interval1 x, Interval1 y, Interval1 t) { return lerp(x, y, t); }, a, b, c);
        case Op::map_range:
            return each([&](Interval1 x) { return map_range(x, b[0], b[1], c[0], c[1], mode); }, a);
        case Op::blend:
            return blend_bounds(static_cast<BlendMode>(mode), a, b, c[0]);
        default:
            break;
    }
    if (op < Op::image)
        return input_bounds(op, mode, step.input);
    if (op < Op::copy)
        return texture_bounds(op, step, a, b, c, d);
    if (op < Op::clamp)
        return each([&](Interval1 x, Interval1 y, Interval1 z) { return channel_bounds(op, x, y, z); }, a, b,
                    c);
    if (op < Op::rgb_to_hsv || op > Op::blackbody)
        return vector_bounds(op, step, a, b, c);
    return color_bounds(op, a, b, c);
}

}  // namespace

Interval3::Interval3(Vec3f v) {
    for (int c = 0; c < 3; ++c) {
        const bool number = !std::isnan(v[c]);
        lo[c] = number ? v[c] : -kInfinity;
        hi[c] = number ? v[c] : kInfinity;
        nan = static_cast<std::uint8_t>(nan | (number ? 0 : 1) << c);
    }
}

Interval3::Interval3(Interval1 x, Interval1 y, Interval1 z) {
    const Interval1 channels[] = {x, y, z};
    for (int c = 0; c < 3; ++c) {
        lo[c] = rounded_down(channels[c].lo);
        hi[c] = -rounded_down(-channels[c].hi);
        nan = static_cast<std::uint8_t>(nan | (channels[c].nan ? 1 : 0) << c);
    }
}

ImageBounds::ImageBounds(const Image& image) {
    Vec3f lo(kInfinity), hi(-kInfinity);
    alpha = {kInfinity, -kInfinity};
    bool finite = true;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const Image::Texel texel = image.texel(x, y);
            lo = min(lo, texel.rgb);
            hi = max(hi, texel.rgb);
            alpha = {std::min<double>(alpha.lo, texel.alpha), std::max<double>(alpha.hi, texel.alpha)};
            finite &= is_finite(texel.rgb) && std::isfinite(texel.alpha);
        }
    }
    // Filtering rounds: three blends, each of two numbers of this size.
    const auto filtered = [&](double low, double high) {
        return finite ? rounded({low, high}, high - low) : everything();
    };
    rgb = {filtered(lo.x, hi.x), filtered(lo.y, hi.y), filtered(lo.z, hi.z)};
    alpha = filtered(alpha.lo, alpha.hi);
}

void bound(const Program& program, const BoundsInput& input, Interval3* registers) {
    for (std::size_t i = 0; i < program.registers.size(); ++i)
        registers[i] = Interval3(program.registers[i]);
    const auto at = [&](std::int32_t i) -> Interval3& { return registers[static_cast<std::size_t>(i)]; };
    for (const Instruction& i : program.code)
        at(i.dst) = evaluate({i, program, input}, at(i.a), at(i.b), at(i.c), at(i.d));
}

Interval3 finite(const Interval3& v) {
    return each([](Interval1 x) { return x.nan || !x.bounded() ? join({x.lo, x.hi}, Interval1(0)) : x; }, v);
}
Interval3 non_negative(const Interval3& v) {
    return each([](Interval1 x) { return Interval1(std::max(x.lo, 0.0), std::max(x.hi, 0.0)); }, finite(v));
}

}  // namespace nephele
