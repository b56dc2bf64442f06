// SPDX-License-Identifier: GPL-3.0-or-later
#include "media/program_medium.h"

#include <algorithm>
#include <stdexcept>

#include "scene/mesh.h"

namespace nephele {

namespace {

/// The instructions that the outputs depend on.
Program without_unused(const Program& program, std::span<const std::int16_t> outputs) {
    std::array<bool, kMaxRegisters> used{};
    for (const std::int16_t r : outputs)
        used[static_cast<std::size_t>(r)] = true;
    Program out = program;
    out.code.clear();
    for (auto i = program.code.rbegin(); i != program.code.rend(); ++i) {
        if (!used[static_cast<std::size_t>(i->dst)])
            continue;
        used[static_cast<std::size_t>(i->dst)] = false;
        for (const std::int32_t r : {i->a, i->b, i->c, i->d})
            used[static_cast<std::size_t>(r)] = true;
        out.code.push_back(*i);
    }
    std::reverse(out.code.begin(), out.code.end());
    return out;
}

const ClosureRow& medium_row(const Program& program) {
    if (program.closures.size() != 1 || program.closures.front().kind != ClosureKind::medium)
        throw std::invalid_argument("a volume's program must have one closure of kind medium");
    return program.closures.front();
}

}  // namespace

template <class Registers>
PhaseFunction ProgramMedium::phase_of(const Registers& registers) const {
    const auto parameter = [&](int input) {
        return registers[row_.inputs[static_cast<std::size_t>(input)]].x;
    };
    return make_phase(static_cast<PhaseKind>(row_.mode), parameter(medium_input::phase_a),
                      parameter(medium_input::phase_b));
}

ProgramMedium::ProgramMedium(const Program& program, const PhaseFunction* phase, VolumeFields fields,
                             float scale, const ShadingPoint& place, const TextureContext& textures,
                             std::span<const ImageBounds> images)
    : row_(medium_row(program)),
      fields_(std::move(fields)),
      place_(place),
      textures_(textures),
      images_(images),
      scale_(scale) {
    using namespace medium_input;
    const auto input = [&](int i) { return row_.inputs[static_cast<std::size_t>(i)]; };
    const std::int16_t extinction[] = {row_.weight, input(sigma_s), input(sigma_a), input(phase_a),
                                       input(phase_b)};
    const std::int16_t emission[] = {row_.weight, input(medium_input::emission)};
    extinction_ = without_unused(program, extinction);
    emission_ = without_unused(program, emission);
    place_.volume = &fields_;
    if (place_.instance) {
        for (const Transform& step : place_.instance->motion.steps())
            world_from_rest_.push_back(step * place_.instance->object_from_world);
    }
    const auto constant = [&](std::int16_t r) {
        return std::none_of(extinction_.code.begin(), extinction_.code.end(),
                            [&](const Instruction& i) { return i.dst == r; });
    };
    if (phase) {
        phase_ = *phase;
    } else if (constant(input(phase_a)) && constant(input(phase_b))) {
        phase_ = phase_of(extinction_.registers.data());
    }
    const MediumRange everywhere = range(Vec3f(-kInfinity), Vec3f(kInfinity));
    interacts_ = everywhere.sigma_t_max > 0;
    emits_ = everywhere.emission_max > 0;
}

ShadingPoint ProgramMedium::shading_point(const VolumePoint& at) const {
    ShadingPoint point = place_;
    point.p = at.p;
    point.rest_from_world = at.rest_from_world;
    point.object_p = place_.instance ? place_.instance->object_from_world.point(point.at_rest(at.p))
                                     : at.p + textures_.origin;
    point.wo = point.ng = point.ns = at.wo;
    point.ray_kind = at.ray_kind;
    point.time = at.time;
    return point;
}

Rgb ProgramMedium::coefficient(const RegisterFile& registers, int input) const {
    return non_negative(registers[row_.inputs[static_cast<std::size_t>(input)]]) *
           (non_negative(registers[row_.weight]) * scale_);
}

MediumPoint ProgramMedium::coefficients(const VolumePoint& at) const {
    const RegisterFile registers(extinction_, shading_point(at), textures_);
    const Rgb sigma_s = coefficient(registers, medium_input::sigma_s);
    return {sigma_s, sigma_s + coefficient(registers, medium_input::sigma_a),
            phase_ ? *phase_ : phase_of(registers)};
}

Rgb ProgramMedium::emission(const VolumePoint& at) const {
    const RegisterFile registers(emission_, shading_point(at), textures_);
    return coefficient(registers, medium_input::emission);
}

namespace {

/// Of bounds: what they bound is finite, so that nothing times anything is nothing.
Vec3f product(Vec3f a, Vec3f b) {
    const auto of = [](float x, float y) { return x == 0 || y == 0 ? 0.0f : x * y; };
    return {of(a.x, b.x), of(a.y, b.y), of(a.z, b.z)};
}

}  // namespace

MediumRange ProgramMedium::range(Vec3f lo, Vec3f hi) const {
    const BoundsInput input{lo,
                            hi,
                            place_,
                            textures_,
                            images_,
                            [&](std::int32_t number, Vec3f from, Vec3f to) {
                                const std::array<Bounds, 3> b = fields_.range(number, from, to);
                                Interval3 out;
                                out.lo = {b[0].min, b[1].min, b[2].min};
                                out.hi = {b[0].max, b[1].max, b[2].max};
                                return out;
                            },
                            world_from_rest_};
    std::array<Interval3, kMaxRegisters> registers;
    const auto of = [&](int i) {
        return non_negative(registers[static_cast<std::size_t>(row_.inputs[static_cast<std::size_t>(i)])]);
    };
    const auto scaled = [&](const Interval3& v) {
        const Interval3 weight = non_negative(registers[static_cast<std::size_t>(row_.weight)]);
        return std::pair(product(v.lo, weight.lo) * scale_, product(v.hi, weight.hi) * scale_);
    };
    constexpr float kRounding = 1 + 4e-6f;  // of the sums and products here and in coefficients()
    MediumRange out;
    bound(extinction_, input, registers.data());
    const auto [s_lo, s_hi] = scaled(of(medium_input::sigma_s));
    const auto [a_lo, a_hi] = scaled(of(medium_input::sigma_a));
    out.sigma_t_min = min_component(s_lo + a_lo) / kRounding;
    out.sigma_t_max = max_component(s_hi + a_hi) * kRounding;
    bound(emission_, input, registers.data());
    out.emission_max = max_component(scaled(of(medium_input::emission)).second) * kRounding;
    return out;
}

}  // namespace nephele
