// SPDX-License-Identifier: GPL-3.0-or-later
// Node programs as a corrupt description could hold them. What validate() lets pass must run without a fault,
// as values, as a BSDF and as a medium, and no value may leave the bounds of its box: a majorant below the
// extinction would be a wrong image.
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "bounds_fixtures.h"
#include "bytes.h"
#include "media/program_medium.h"
#include "shading/procedural.h"
#include "surfaces/bsdf.h"

namespace nephele::fuzz {

namespace {

using test::holds;
using test::Random;
using test::Volume;

/// A mode that the operation may have; most others are refused.
std::int32_t mode_of(Bytes& in, Op op) {
    const auto any = [&](std::size_t n) { return static_cast<std::int32_t>(in.below(n)); };
    if (op == Op::voronoi)
        return any(kLargestVoronoiMode + 1);
    if (op == Op::noise)
        return any(kLargestNoiseMode + 1);
    const std::int32_t mode = any(64);
    return is_shiftable(op) ? any(3) * kShift + mode : mode;
}

Instruction instruction_of(Bytes& in, std::size_t registers, std::size_t parameters, bool wild) {
    if (wild)
        return in.take<Instruction>();
    const auto any = [&](std::size_t n) { return static_cast<std::int32_t>(in.below(n)); };
    Instruction i;
    i.op = any(kOpCount);
    for (std::int32_t* r : {&i.dst, &i.a, &i.b, &i.c, &i.d})
        *r = any(registers);
    i.parameter = any(parameters + 1);
    i.mode = mode_of(in, static_cast<Op>(i.op));
    return i;
}

ClosureRow closure_of(Bytes& in, std::size_t registers, bool wild) {
    ClosureRow row;
    row.kind = static_cast<ClosureKind>(wild ? in.take<std::int16_t>()
                                             : static_cast<int>(in.below(kClosureKindCount)));
    const auto any = [&] {
        return wild ? in.take<std::int16_t>() : static_cast<std::int16_t>(in.below(registers));
    };
    row.weight = any();
    row.mode = wild ? in.take<std::int16_t>() : static_cast<std::int16_t>(in.below(kPhaseKindCount));
    for (std::int16_t& input : row.inputs)
        input = any();
    return row;
}

Program program_of(Bytes& in) {
    Program program;
    const bool wild = in.below(16) == 15;  // every number is any number: mostly refused
    const std::size_t registers = wild ? in.below(300) : 1 + in.below(16), parameters = in.below(48);
    const std::size_t length = in.below(24), closures = in.below(wild ? 80 : 4);
    for (std::size_t i = 0; i < registers; ++i) {
        const float x = in.real();
        const bool grey = in.below(2) == 0;
        program.registers.emplace_back(x, grey ? x : in.real(), grey ? x : in.real());
    }
    for (std::size_t i = 0; i < parameters; ++i)
        program.parameters.push_back(in.real());
    for (std::size_t i = 0; i < length; ++i)
        program.code.push_back(instruction_of(in, registers, parameters, wild));
    for (std::size_t i = 0; i < closures; ++i)
        program.closures.push_back(closure_of(in, registers, wild));
    return program;
}

std::string text(const Program& program) {
    std::string out;
    char line[160];
    for (std::size_t r = 0; r < program.registers.size(); ++r) {
        const Vec3f v = program.registers[r];
        std::snprintf(line, sizeof(line), "  register %zu = %.9g %.9g %.9g\n", r, double{v.x}, double{v.y},
                      double{v.z});
        out += line;
    }
    for (const Instruction& i : program.code) {
        std::snprintf(line, sizeof(line), "  %d = %s %d %d %d %d, parameter %d, mode %d\n", i.dst,
                      kOpNames[i.op], i.a, i.b, i.c, i.d, i.parameter, i.mode);
        out += line;
    }
    for (const ClosureRow& row : program.closures) {
        out += std::string("  closure ") + kClosureNames[static_cast<int>(row.kind)] + " weight " +
               std::to_string(row.weight) + " mode " + std::to_string(row.mode) + " inputs";
        for (const std::int16_t input : row.inputs)
            out += ' ' + std::to_string(input);
        out += '\n';
    }
    for (std::size_t p = 0; p < program.parameters.size(); ++p) {
        std::snprintf(line, sizeof(line), "  parameter %zu = %.9g\n", p, double{program.parameters[p]});
        out += line;
    }
    return out;
}

std::string text(Vec3f v) {
    char line[80];
    std::snprintf(line, sizeof(line), "(%.9g, %.9g, %.9g)", double{v.x}, double{v.y}, double{v.z});
    return line;
}

/// A box that programs are bounded in, and the points of it where they are run.
struct Box {
    Vec3f lo, hi;
    Vec3f at(Random& random) const { return min(max(lo + (hi - lo) * random.vector(0, 1), lo), hi); }
};

Box box_of(Bytes& in) {
    const auto number = [&] { return static_cast<float>(in.take<std::int16_t>()) / 4096; };
    const Vec3f lo(number(), number(), number());
    const float size = std::exp2(static_cast<float>(in.below(24)) - 20);
    return {lo, lo + Vec3f(size * static_cast<float>(in.below(3)), size, size)};
}

void check_registers(const Program& program, const Box& box, Volume& volume, Random& random) {
    std::vector<Interval3> bounds(program.registers.size());
    bound(program, volume.input(box.lo, box.hi), bounds.data());
    std::vector<Vec3f> values(program.registers.size());
    for (int n = 0; n < 6; ++n) {
        const Vec3f p = box.at(random);
        volume.set_point(p, random);
        run(program, volume.point, volume.context, values.data());
        for (std::size_t r = 0; r < values.size(); ++r) {
            if (!holds(bounds[r], values[r]))
                fail("at " + text(p) + " register " + std::to_string(r) + " holds " + text(values[r]) +
                     ", its bounds are " + text(bounds[r].lo) + " to " + text(bounds[r].hi) + ", of\n" +
                     text(program));
        }
    }
}

/// Whether a program's results are numbers as scenes have them: products of a few neither vanish nor
/// overflow.
bool usual(const Program& program, const Volume& volume) {
    std::vector<Vec3f> values(program.registers.size());
    run(program, volume.point, volume.context, values.data());
    return std::all_of(values.begin(), values.end(), [](Vec3f v) {
        return std::all_of(&v.x, &v.x + 3,
                           [](float x) { return x == 0 || (std::fabs(x) > 1e-6f && std::fabs(x) < 1e6f); });
    });
}

void check_surface(const Program& program, const Box& box, Volume& volume, Random& random) {
    traits_of(program);
    for (int n = 0; n < 3; ++n) {
        volume.set_point(box.at(random), random);
        const ShadingPoint& point = volume.point;
        const Bsdf bsdf = make_bsdf(&program, point, volume.context);
        evaluate_transparency(program, point, volume.context);
        evaluate_interior_ior(program, point, volume.context);
        bsdf.albedo(point.wo);
        const auto sample = bsdf.sample(point.wo, random.unit(), {random.unit(), random.unit()});
        float pdf = 0;
        bool crosses = false;
        bsdf.eval(point.wo, normalize(random.vector(-1, 1) + Vec3f(1e-3f)), pdf, crosses);
        if (!usual(program, volume))
            continue;  // dropped from the image as non-finite, if it comes to that
        if (!(pdf >= 0) || (sample && !sample->specular && !(sample->pdf >= 0)))
            fail("a BSDF has the density " + std::to_string(pdf) + ", its sample " +
                 std::to_string(sample ? sample->pdf : 0) + ", of\n" + text(program));
    }
}

void check_medium(const Program& program, const Box& box, const Mesh& mesh, Volume& volume, Random& random) {
    volume.set_point(box.lo, random);
    ShadingPoint place;
    place.instance = &volume.instance;
    place.mesh = &mesh;
    try {
        const ProgramMedium medium(program, nullptr, volume.fields, 1, place, volume.context,
                                   volume.image_bounds);
        const MediumRange range = medium.range(box.lo, box.hi);
        for (int n = 0; n < 4; ++n) {
            VolumePoint at;
            at.p = box.at(random);
            at.wo = normalize(random.vector(-1, 1) + Vec3f(1e-3f));
            const Rgb sigma_t = medium.coefficients(at).sigma_t, emission = medium.emission(at);
            for (int c = 0; c < 3; ++c) {
                if (!(sigma_t[c] >= range.sigma_t_min && sigma_t[c] <= range.sigma_t_max) ||
                    !(emission[c] >= 0 && emission[c] <= range.emission_max))
                    fail("at " + text(at.p) + " sigma_t is " + text(sigma_t) + " in bounds " +
                         text(Vec3f(range.sigma_t_min, range.sigma_t_max, 0)) + ", emission " +
                         text(emission) + " below " + std::to_string(range.emission_max) + ", of\n" +
                         text(program));
            }
        }
    } catch (const std::invalid_argument&) {  // no medium's program
    }
}

}  // namespace

void program(Data data) {
    static Volume volume;
    Bytes in(data);
    Random random(in.take<std::uint16_t>());
    const Box box = box_of(in);
    const Program program = program_of(in);
    try {
        validate(program, volume.images.size());
    } catch (const std::invalid_argument&) {
        return;
    }
    check_registers(program, box, volume, random);
    check_surface(program, box, volume, random);
    static const Mesh box_of_grids;  // has no triangles
    check_medium(program, box, volume.mesh, volume, random);
    check_medium(program, box, box_of_grids, volume, random);
}

}  // namespace nephele::fuzz
