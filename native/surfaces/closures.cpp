// SPDX-License-Identifier: GPL-3.0-or-later
// What can be told of a program's closures without building lobes: emission, transparency, traits.
#include "surfaces/bsdf.h"
#include "surfaces/principled.h"

namespace nephele {
namespace {

/// A register's value where no instruction writes it.
std::optional<Vec3f> constant_register(const Program& program, std::int16_t i) {
    for (const Instruction& step : program.code) {
        if (step.dst == i)
            return std::nullopt;
    }
    return program.registers[static_cast<std::size_t>(i)];
}

/// The register that holds the index of refraction inside; nothing where no closure has one.
std::optional<std::int16_t> ior_register(const Program& program) {
    for (const ClosureRow& row : program.closures) {
        switch (row.kind) {
            case ClosureKind::glass:
                return row.inputs[glass_input::ior];
            case ClosureKind::filmed_glass:
                return row.inputs[filmed_glass_input::ior];
            case ClosureKind::refraction:
                return row.inputs[refraction_input::ior];
            case ClosureKind::principled:
                return row.inputs[principled_input::ior];
            default:
                break;
        }
    }
    return std::nullopt;
}

float ior_of(Vec3f value) {
    return bounded_ior(finite(value).x);
}

class TraitsFinder {
  public:
    explicit TraitsFinder(const Program& program) : program_(program) {
        traits_.constant = program.code.empty();
        for (const ClosureRow& row : program.closures)
            visit(row);
        const auto ior = ior_register(program);
        if (!ior) {
            traits_.interior_ior = 1.0f;
        } else if (const auto value = constant_register(program, *ior)) {
            traits_.interior_ior = ior_of(*value);
        }
        if (emission_is_constant_)
            traits_.constant_emission = emission_;
    }
    const ProgramTraits& traits() const { return traits_; }

  private:
    std::optional<Vec3f> input(const ClosureRow& row, int i) const {
        return constant_register(program_, row.inputs[static_cast<std::size_t>(i)]);
    }
    bool is_always(const ClosureRow& row, int i, float value) const {
        const auto constant = input(row, i);
        return constant && constant->x == value;
    }

    void visit(const ClosureRow& row) {
        const auto weight = constant_register(program_, row.weight);
        if (weight && is_zero(non_negative(*weight)))
            return;
        switch (row.kind) {
            case ClosureKind::emission:
                return emits(row, weight, emission_input::color, emission_input::strength, true);
            case ClosureKind::holdout:
                return;
            case ClosureKind::transparent: {
                const auto color = input(row, transparent_input::color);
                if (!color || !is_zero(non_negative(*color)))
                    traits_.may_transmit_straight = true;
                return;
            }
            case ClosureKind::principled: {
                const auto alpha = input(row, principled_input::alpha);
                if (!alpha || alpha->x < 1)
                    traits_.may_transmit_straight = true;
                traits_.has_surface_lobes = true;
                const bool bare = is_always(row, principled_input::coat_weight, 0) &&
                                  is_always(row, principled_input::sheen_weight, 0) && alpha;
                const auto shown =
                    weight && alpha ? std::optional(non_negative(*weight) * clamp01(alpha->x)) : std::nullopt;
                return emits(row, shown, principled_input::emission_color,
                             principled_input::emission_strength, bare);
            }
            default:
                traits_.has_surface_lobes = true;
        }
    }

    /// bare: nothing that depends on the direction covers the emission.
    void emits(const ClosureRow& row, std::optional<Vec3f> weight, int color_input, int strength_input,
               bool bare) {
        const auto color = input(row, color_input), strength = input(row, strength_input);
        if ((color && is_zero(*color)) || (strength && strength->x == 0))
            return;
        traits_.emissive = true;
        if (color && strength && weight && bare) {
            emission_ += non_negative(*weight) * finite(*color) * finite(*strength).x;
        } else {
            emission_is_constant_ = false;
        }
    }

    const Program& program_;
    ProgramTraits traits_;
    Rgb emission_;
    bool emission_is_constant_ = true;
};

}  // namespace

Rgb closure_emission(const ClosureRow& row, const RegisterFile& registers, const ShadingPoint& point) {
    if (row.kind == ClosureKind::principled)
        return principled_emission(row, registers, point);
    if (row.kind != ClosureKind::emission)
        return Rgb(0);
    const float strength = finite(registers[row.inputs[emission_input::strength]]).x;
    return non_negative(registers[row.weight]) * finite(registers[row.inputs[emission_input::color]]) *
           strength;
}

Rgb evaluate_emission(const Program& program, const ShadingPoint& point, const TextureContext& context) {
    const RegisterFile registers(program, point, context);
    Rgb sum;
    for (const ClosureRow& row : program.closures)
        sum += closure_emission(row, registers, point);
    return sum;
}

Rgb evaluate_transparency(const Program& program, const ShadingPoint& point, const TextureContext& context) {
    const RegisterFile registers(program, point, context);
    Rgb sum;
    for (const ClosureRow& row : program.closures) {
        if (row.kind == ClosureKind::principled)
            sum += principled_transparency(row, registers);
        if (row.kind != ClosureKind::transparent)
            continue;
        sum += non_negative(registers[row.weight]) *
               non_negative(registers[row.inputs[transparent_input::color]]);
    }
    return sum;
}

float evaluate_interior_ior(const Program& program, const ShadingPoint& point,
                            const TextureContext& context) {
    const auto ior = ior_register(program);
    return ior ? ior_of(RegisterFile(program, point, context)[*ior]) : 1;
}

ProgramTraits traits_of(const Program& program) {
    return TraitsFinder(program).traits();
}

}  // namespace nephele
