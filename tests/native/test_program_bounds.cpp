// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of programs: that no run of a program inside a box leaves them, operation by operation and for whole
// random programs; that every operation has some; and that they close in on small boxes.
#include <string>

#include "bounds_fixtures.h"

namespace nephele {
namespace {

using test::holds;
using test::Random;
using test::Volume;

/// Modes that exist for an operation.
int modes_of(Op op) {
    switch (op) {
        case Op::blend:
            return kBlendModeCount;
        case Op::image:
        case Op::image_alpha:
        case Op::environment:
        case Op::environment_mirror_ball:
            return 15;
        case Op::noise:
            return 5 * 16;
        case Op::voronoi:
            return 5 * 128;
        case Op::white_noise:
            return 8;
        case Op::gabor:
            return 7;
        case Op::gradient:
            return 7;
        case Op::map_range:
        case Op::box_projection:
        case Op::channel:
            return 3;
        case Op::convert_space:
            return 43;
        case Op::ray_history:
            return kRayHistoryCount;
        case Op::layer_weight:
        case Op::wireframe:
        case Op::object_attribute:
        case Op::transform:
        case Op::uv:
        case Op::attribute:
        case Op::grid:
            return 2;
        case Op::ray_is:
            return 64;
        default:
            return 1;
    }
}

/// Parameters that any operation finds its own among, and the offset where it does.
constexpr int kTableEntries = 17;
struct Parameters {
    std::vector<float> values;
    int zero = 0, matrix, wall, table;

    explicit Parameters(Random& random) {
        values.push_back(0);  // the image's number
        matrix = static_cast<int>(values.size());
        for (int i = 0; i < 12; ++i)
            values.push_back(random.between(-2, 2));
        wall = static_cast<int>(values.size());
        values.insert(values.end(), {0.5f, 0.8f, 2, 3});
        table = static_cast<int>(values.size());
        for (int i = 0; i < 3 * kTableEntries; ++i)
            values.push_back(random.below(3) == 0 ? 0 : random.between(-1, 3));
    }
    void place(Instruction& i, Random& random) const {
        const Op op = static_cast<Op>(i.op);
        const bool ramp = op == Op::ramp || op == Op::ramp_alpha;
        i.parameter = ramp ? table : op == Op::transform ? matrix : op == Op::brick ? wall : zero;
        i.mode = ramp ? kTableEntries - 1 : random.below(modes_of(op));
        if ((reads_image(op) || op == Op::gabor || op == Op::convert_space) && (i.mode & 3) == 3)
            i.mode -= 1;  // two bits that count to 2
        if (op == Op::convert_space && (i.mode >> 2 & 3) == 3)
            i.mode -= 1 << 2;
    }
};

/// Operands of which an operation is asked: settings of noise stay in their ranges more often than not.
Interval3 operands(Op op, int number, Random& random) {
    if ((op == Op::noise || op == Op::voronoi) && random.below(5) != 0) {
        if (number == 2)
            return Interval3(Vec3f(random.between(0, 4), random.between(0, 1), random.between(1.5f, 3)));
        if (number == 1)
            return Interval3(Vec3f(random.between(0.1f, 5)));
    }
    if (op == Op::blackbody)
        return Interval3(random.interval() * 3000);
    const Interval1 x = random.interval();
    return random.below(3) == 0 ? Interval3(x) : Interval3(x, random.interval(), random.interval());
}

std::string text(const Interval3& i) {
    std::string s;
    for (int c = 0; c < 3; ++c)
        s += " [" + std::to_string(i[c].lo) + ", " + std::to_string(i[c].hi) + (i[c].nan ? " nan]" : "]");
    return s;
}

/// A program that starts from operands drawn from intervals: the first registers are theirs.
struct Case {
    Program program;
    std::vector<Interval3> initial;

    /// Bounds of the registers: those of run(), with the initial registers' intervals in place of numbers.
    std::vector<Interval3> bounds(const Volume& volume, Vec3f lo, Vec3f hi) const {
        // Registers are numbers; intervals enter through boxes. A fourth of a box's position per register
        // would tie them together, so they come in as grids, whose ranges the caller states.
        Program from_grids = program;
        std::vector<Instruction> reads;
        for (std::size_t r = 0; r < initial.size(); ++r)
            reads.push_back({static_cast<std::int32_t>(Op::grid), static_cast<std::int32_t>(r), 0, 0, 0, 0, 0,
                             static_cast<std::int32_t>(100 + r)});
        from_grids.code.insert(from_grids.code.begin(), reads.begin(), reads.end());
        BoundsInput input = volume.input(lo, hi);
        const auto fields = input.grid_range;
        input.grid_range = [&](std::int32_t number, Vec3f from, Vec3f to) {
            return number >= 100 ? initial[static_cast<std::size_t>(number - 100)] : fields(number, from, to);
        };
        std::vector<Interval3> registers(program.registers.size());
        bound(from_grids, input, registers.data());
        return registers;
    }
    std::vector<Vec3f> values(Volume& volume, Vec3f p, Random& random) const {
        volume.set_point(p, random);
        Program drawn = program;
        for (std::size_t r = 0; r < initial.size(); ++r)
            drawn.registers[r] = random.inside(initial[r]);
        std::vector<Vec3f> registers(program.registers.size());
        run(drawn, volume.point, volume.context, registers.data());
        return registers;
    }
};

Case case_of(Op op, const Parameters& parameters, Random& random) {
    Case c;
    c.program.registers.resize(5);
    Instruction i{static_cast<std::int32_t>(op), 4, 0, random.below(8) == 0 ? 0 : 1, 2, 3, 0, 0};
    parameters.place(i, random);
    c.program.code = {i};
    c.program.parameters = parameters.values;
    for (int k = 0; k < 4; ++k)
        c.initial.push_back(operands(op, k, random));
    return c;
}

TEST(ProgramBounds, HoldEveryOperation) {
    Volume volume;
    Random random(2);
    const Parameters parameters(random);
    for (int op = 0; op < kOpCount; ++op) {
        const int cases = static_cast<Op>(op) == Op::blend ? 6000 : 1500;
        int failures = 0;
        for (int k = 0; k < cases && failures < 3; ++k) {
            const Case c = case_of(static_cast<Op>(op), parameters, random);
            validate(c.program, volume.images.size());
            const Vec3f lo = random.vector(-5, 5), hi = lo + random.vector(0, 2);
            const Interval3 bounds = c.bounds(volume, lo, hi)[4];
            for (int sample = 0; sample < 20; ++sample) {
                const Vec3f p = min(max(lo + (hi - lo) * random.vector(0, 1), lo), hi);
                const Vec3f value = c.values(volume, p, random)[4];
                if (!holds(bounds, value)) {
                    ++failures;
                    ADD_FAILURE() << kOpNames[op] << " mode " << c.program.code[0].mode << " of"
                                  << text(c.initial[0]) << "," << text(c.initial[1]) << ","
                                  << text(c.initial[2]) << "," << text(c.initial[3]) << " gives " << value.x
                                  << " " << value.y << " " << value.z << ", outside" << text(bounds);
                    break;
                }
            }
        }
    }
}

/// Bounds of an operation that the interpreter does not know are the whole line.
TEST(ProgramBounds, EveryOperationHasThem) {
    Volume volume;
    Random random(3);
    const Parameters parameters(random);
    for (int op = 0; op < kOpCount; ++op) {
        for (int mode = 0; mode < modes_of(static_cast<Op>(op)); ++mode) {
            Case c = case_of(static_cast<Op>(op), parameters, random);
            if (static_cast<Op>(op) != Op::ramp && static_cast<Op>(op) != Op::ramp_alpha)
                c.program.code[0].mode = mode;
            c.initial = {Interval3({0.2, 0.3}), Interval3({0.4, 0.5}, {0.8, 0.9}, {0.4, 0.5}),
                         Interval3({0.6, 0.7}), Interval3({1, 2})};
            const Interval3 bounds = c.bounds(volume, Vec3f(1), Vec3f(1.5f))[4];
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_TRUE(bounds[channel].bounded() && !bounds[channel].nan)
                    << kOpNames[op] << " mode " << mode << text(bounds);
        }
    }
}

TEST(ProgramBounds, HoldWholePrograms) {
    Volume volume;
    Random random(4);
    int bounded = 0, all = 0;
    for (int k = 0; k < 6000; ++k) {
        const Parameters parameters(random);
        Case c;
        const int registers = 6 + random.below(6), length = 5 + random.below(26);
        c.program.registers.resize(static_cast<std::size_t>(registers));
        c.program.parameters = parameters.values;
        for (Vec3f& v : c.program.registers)
            v = Vec3f(static_cast<float>(random.interval().lo));
        for (int i = 0; i < length; ++i) {
            const auto any = [&] { return random.below(registers); };
            Instruction instruction{random.below(kOpCount), any(), any(), any(), any(), any(), 0, 0};
            parameters.place(instruction, random);
            c.program.code.push_back(instruction);
        }
        validate(c.program, volume.images.size());
        const Vec3f lo = random.vector(-5, 5),
                    hi = lo + random.vector(0, 1) * std::exp(random.between(-6, 2));
        const std::vector<Interval3> bounds = c.bounds(volume, lo, hi);
        for (int sample = 0; sample < 20; ++sample) {
            const Vec3f p = min(max(lo + (hi - lo) * random.vector(0, 1), lo), hi);
            const std::vector<Vec3f> values = c.values(volume, p, random);
            for (std::size_t r = 0; r < values.size(); ++r) {
                ASSERT_TRUE(holds(bounds[r], values[r]))
                    << "program " << k << ", register " << r << " holds " << values[r].x << " " << values[r].y
                    << " " << values[r].z << ", outside" << text(bounds[r]);
                bounded += bounds[r][0].bounded();
                ++all;
            }
        }
    }
    EXPECT_GT(bounded, all / 2);  // the test means little where most bounds are the whole line
}

TEST(ProgramBounds, CloseInOnLinearPrograms) {
    Volume volume;
    Program program;  // 0.25 * (2 * object position + 1) mixed with world position by 0.3
    program.registers = {Vec3f(0), Vec3f(2), Vec3f(1), Vec3f(0.25f), Vec3f(0), Vec3f(0.3f)};
    const auto op = [](Op o, int dst, int a, int b, int c) {
        return Instruction{static_cast<std::int32_t>(o), dst, a, b, c, 0, 0, 0};
    };
    program.code = {op(Op::object_coordinate, 0, 0, 0, 0), op(Op::multiply_add, 0, 0, 1, 2),
                    op(Op::multiply, 0, 0, 3, 0), op(Op::position, 4, 0, 0, 0), op(Op::mix, 0, 0, 4, 5)};
    double last = 0;
    for (const float size : {1.0f, 0.1f, 0.01f, 0.001f, 0.0f}) {
        std::vector<Interval3> registers(program.registers.size());
        bound(program, volume.input(Vec3f(0.5f), Vec3f(0.5f + size)), registers.data());
        const double width =
            std::max({registers[0][0].width(), registers[0][1].width(), registers[0][2].width()});
        EXPECT_LT(width, 2 * static_cast<double>(size) + 2e-5) << "box of " << size;
        if (last > 0) {
            EXPECT_LT(width, 0.11 * last + 2e-5);
        }
        last = width;
    }
    EXPECT_LT(last, 2e-5);
}

TEST(ProgramBounds, KnowWhereARampIsDark) {
    Volume volume;
    Program program;  // a ramp that is 0 up to 0.5 of the world's x
    program.registers = {Vec3f(0)};
    program.parameters = {0, 0, 1};
    program.code = {{static_cast<std::int32_t>(Op::position), 0, 0, 0, 0, 0, 0, 0},
                    {static_cast<std::int32_t>(Op::ramp_alpha), 0, 0, 0, 0, 0, 0, 2}};
    const auto highest = [&](float from, float to) {
        Interval3 registers[1];
        bound(program, volume.input({from, 0, 0}, {to, 1, 1}), registers);
        return registers[0][0].hi;
    };
    EXPECT_EQ(highest(-1, 0.49f), 0);
    EXPECT_NEAR(highest(0.25f, 0.75f), 0.5, 1e-5);
    EXPECT_NEAR(highest(0.25f, 7), 1, 1e-5);
}

TEST(ProgramBounds, AGridInfinitelyFarIsItsBackground) {
    Volume volume;
    Random random(5);
    volume.set_point(Vec3f(0), random);
    Program program;
    program.code = {{static_cast<std::int32_t>(Op::grid), 0, 0, 0, 0, 0, 0, 0}};
    for (const Vec3f place : {Vec3f(0, -kInfinity, 0), Vec3f(NAN), Vec3f(3e38f)}) {
        program.registers = {place};
        Vec3f value;
        run(program, volume.point, volume.context, &value);
        EXPECT_EQ(value, Vec3f(0)) << place.y;
    }
}

TEST(ProgramBounds, NaNCountsAsZeroInClosures) {
    const Interval3 open({1, kInfinity}, {2, 3, true}, {-4, -1});
    const Interval3 v = non_negative(open);
    EXPECT_EQ(v.lo, Vec3f(0, 0, 0));
    EXPECT_EQ(v.hi, Vec3f(kInfinity, 3, 0));
    EXPECT_EQ(finite(open).lo, Vec3f(0, 0, -4));
    EXPECT_EQ(finite(open).hi, Vec3f(kInfinity, 3, -1));
}

}  // namespace
}  // namespace nephele
