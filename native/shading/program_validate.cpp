// SPDX-License-Identifier: GPL-3.0-or-later
// Checks a shading program once, so that run() and make_bsdf() need not.
#include <stdexcept>
#include <string>

#include "shading/procedural.h"
#include "shading/program.h"
#include "shading/shading_inputs.h"

namespace nephele {
namespace {

[[noreturn]] void refuse(const std::string& where, const std::string& what) {
    throw std::invalid_argument("shading program, " + where + ": " + what +
                                "; the scene description is corrupt");
}

void check_range(const std::string& where, const char* name, long long value, long long low, long long high) {
    if (value >= low && value <= high)
        return;
    refuse(where, std::string(name) + " is " + std::to_string(value) + ", outside [" + std::to_string(low) +
                      ", " + std::to_string(high) + "]");
}

/// Largest mode of an operation; the smallest is 0.
long long largest_mode(Op op) {
    if (reads_uv(op) || reads_attribute(op) || reads_property(op) || op == Op::grid)
        return kShift - 1;  // a number of the mesh's, the object's or the volume's; absent ones read as 0
    if (reads_image(op))
        return 3 << 2 | 2;
    switch (op) {
        case Op::ray_is:
            return (1 << kRayKindCount) - 1;
        case Op::noise:
            return kLargestNoiseMode;
        case Op::voronoi:
            return kLargestVoronoiMode;
        case Op::white_noise:
            return 7;
        case Op::gabor:
            return 6;
        case Op::gradient:
            return 6;
        case Op::ramp:
        case Op::ramp_alpha:
            return 1 << 20;
        case Op::ray_history:
            return kRayHistoryCount - 1;
        case Op::convert_space:
            return 2 << 4 | 2 << 2 | 2;
        case Op::map_range:
        case Op::box_projection:
        case Op::channel:
            return 2;
        case Op::blend:
            return kBlendModeCount - 1;
        case Op::transform:
        case Op::wireframe:
        case Op::layer_weight:
            return 1;
        default:
            return 0;
    }
}

/// Whether bits of a mode hold a number that means nothing: of three values, the fourth.
bool has_spare_bits(Op op, std::int32_t mode) {
    if (reads_image(op) || op == Op::gabor)
        return (mode & 3) == 3;
    return op == Op::convert_space && ((mode & 3) == 3 || (mode >> 2 & 3) == 3);
}

/// How many parameters an operation reads.
long long parameters_read(Op op, long long mode) {
    if (is_shiftable(op))
        return mode >= kShift ? 1 : 0;
    if (reads_image(op))
        return 1;
    switch (op) {
        case Op::ramp:
            return 3 * (mode + 1);
        case Op::ramp_alpha:
            return mode + 1;
        case Op::transform:
            return 12;
        case Op::brick:
            return 4;
        case Op::box_projection:
            return 1;
        default:
            return 0;
    }
}

void check_image(const Program& program, const std::string& where, std::int32_t parameter,
                 std::size_t image_count) {
    const float number = program.parameters[static_cast<std::size_t>(parameter)];
    if (!(number >= 0 && number < static_cast<float>(image_count))) {
        refuse(where, "there is no image number " + std::to_string(number));
    }
}

void check_instruction(const Program& program, std::size_t index, std::size_t image_count) {
    const Instruction& i = program.code[index];
    std::string where = "instruction " + std::to_string(index);
    check_range(where, "the operation", i.op, 0, kOpCount - 1);
    where += std::string(" (") + kOpNames[i.op] + ")";
    const auto last = static_cast<long long>(program.registers.size()) - 1;
    check_range(where, "the destination register", i.dst, 0, last);
    for (const std::int32_t r : {i.a, i.b, i.c, i.d})
        check_range(where, "an operand's register", r, 0, last);
    const Op op = static_cast<Op>(i.op);
    const bool table = op == Op::ramp || op == Op::ramp_alpha;
    const std::int32_t shift = is_shiftable(op) && i.mode > 0 ? i.mode / kShift : 0;
    check_range(where, "the shift", shift, 0, 2);
    check_range(where, "the mode", i.mode - shift * kShift, table ? 1 : 0, largest_mode(op));
    if (has_spare_bits(op, i.mode))
        refuse(where, "the mode is " + std::to_string(i.mode) + ", which means nothing");
    const long long read = parameters_read(op, i.mode);
    if (read == 0)
        return;
    check_range(where, "the parameter offset", i.parameter, 0,
                static_cast<long long>(program.parameters.size()) - read);
    if (reads_image(op))
        check_image(program, where, i.parameter, image_count);
}

/// Whether an input may be left unconnected: normals and tangents.
bool is_optional(ClosureKind kind, int input) {
    switch (kind) {
        case ClosureKind::diffuse:
            return input == diffuse_input::normal;
        case ClosureKind::glossy:
            return input == glossy_input::normal;
        case ClosureKind::glass:
            return input == glass_input::normal;
        case ClosureKind::refraction:
            return input == refraction_input::normal;
        case ClosureKind::translucent:
            return input == translucent_input::normal;
        case ClosureKind::plastic:
            return input == plastic_input::normal;
        case ClosureKind::principled:
            return input == principled_input::normal || input == principled_input::coat_normal ||
                   input == principled_input::tangent;
        case ClosureKind::brushed:
            return input == brushed_input::normal || input == brushed_input::tangent;
        case ClosureKind::metal:
            return input == metal_input::normal || input == metal_input::tangent;
        case ClosureKind::conductor:
            return input == conductor_input::normal || input == conductor_input::tangent;
        case ClosureKind::filmed_glass:
            return input == filmed_glass_input::normal;
        case ClosureKind::sheen:
            return input == sheen_input::normal;
        case ClosureKind::velvet:
            return input == velvet_input::normal;
        case ClosureKind::toon_diffuse:
            return input == toon_diffuse_input::normal;
        case ClosureKind::toon_glossy:
            return input == toon_glossy_input::normal;
        case ClosureKind::subsurface:
            return input == subsurface_input::normal;
        default:
            return false;
    }
}

void check_closure(const Program& program, std::size_t index) {
    const ClosureRow& row = program.closures[index];
    std::string where = "closure " + std::to_string(index);
    const int kind = static_cast<int>(row.kind);
    check_range(where, "the kind", kind, 0, kClosureKindCount - 1);
    where += std::string(" (") + kClosureNames[kind] + ")";
    const auto last = static_cast<long long>(program.registers.size()) - 1;
    check_range(where, "the weight's register", row.weight, 0, last);
    if (row.kind == ClosureKind::medium) {
        check_range(where, "the phase function", row.mode, 0, kPhaseKindCount - 1);
    } else if (row.kind == ClosureKind::subsurface) {
        check_range(where, "the method", row.mode, 0, kSubsurfaceMethodCount - 1);
    } else if (row.kind == ClosureKind::principled) {
        check_range(where, "the distribution and method", row.mode, 0,
                    kDistributionCount * kSubsurfaceMethodCount - 1);
    } else {
        check_range(where, "the distribution", row.mode, 0, kDistributionCount - 1);
    }
    for (int k = 0; k < kClosureInputCounts[kind]; ++k) {
        const int low = is_optional(row.kind, k) ? -1 : 0;
        check_range(where, "an input's register", row.inputs[static_cast<std::size_t>(k)], low, last);
    }
}

}  // namespace

int lobe_count(ClosureKind kind) {
    switch (kind) {
        case ClosureKind::transparent:
        case ClosureKind::emission:
        case ClosureKind::holdout:
        case ClosureKind::medium:
            return 0;
        case ClosureKind::principled:
            return kPrincipledLobes;
        case ClosureKind::plastic:
            return kPlasticLobes;
        case ClosureKind::subsurface:
            return kSubsurfaceLobes;
        default:
            return 1;
    }
}

void validate(const Program& program, std::size_t image_count) {
    if (program.registers.empty() || program.registers.size() > kMaxRegisters) {
        refuse("registers", "there are " + std::to_string(program.registers.size()) + ", not 1 to 256");
    }
    for (std::size_t i = 0; i < program.code.size(); ++i)
        check_instruction(program, i, image_count);
    int lobes = 0;
    for (std::size_t i = 0; i < program.closures.size(); ++i) {
        check_closure(program, i);
        lobes += lobe_count(program.closures[i].kind);
    }
    if (lobes > kMaxLobes) {
        throw std::invalid_argument("shading program: it mixes " + std::to_string(lobes) +
                                    " scattering lobes, more than " + std::to_string(kMaxLobes) +
                                    "; mix fewer shaders in one material");
    }
}

}  // namespace nephele
