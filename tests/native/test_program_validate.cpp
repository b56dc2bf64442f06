// SPDX-License-Identifier: GPL-3.0-or-later
// Shading programs that must be refused: files may be corrupt.
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "shading/program.h"
#include "surface_fixtures.h"

namespace nephele {
namespace {

using testing::ConstantProgram;

Vec3f s(float v) {
    return Vec3f(v);
}

Program sound_program() {
    Program program =
        ConstantProgram().add(ClosureKind::diffuse, {s(0.8f), s(0), testing::kNoNormal}).program;
    program.code = {{static_cast<std::int32_t>(Op::image), 1, 0, 0, 0, 0, 0, 0}};
    program.parameters = {0};
    return program;
}

Instruction of(Op op, std::int32_t mode) {
    return {static_cast<std::int32_t>(op), 1, 0, 0, 0, 0, 0, mode};
}

TEST(Validate, AcceptsASoundProgram) {
    EXPECT_NO_THROW(validate(sound_program(), 1));
}

TEST(Validate, RefusesWhatIsOutOfRangeAndSaysWhat) {
    const std::vector<std::pair<std::string, std::function<void(Program&)>>> faults = {
        {"registers", [](Program& p) { p.registers.clear(); }},
        {"registers", [](Program& p) { p.registers.resize(257); }},
        {"the operation", [](Program& p) { p.code[0].op = kOpCount; }},
        {"the operation", [](Program& p) { p.code[0].op = -1; }},
        {"destination register", [](Program& p) { p.code[0].dst = 99; }},
        {"operand's register", [](Program& p) { p.code[0].a = -1; }},
        {"operand's register", [](Program& p) { p.code[0].d = 1 << 30; }},
        {"the mode", [](Program& p) { p.code[0].mode = 16; }},
        {"the mode is 7", [](Program& p) { p.code[0].mode = 1 << 2 | 3; }},
        {"the mode is 3", [](Program& p) { p.code[0] = of(Op::gabor, 3); }},
        {"the mode is 3", [](Program& p) { p.code[0] = of(Op::convert_space, 3); }},
        {"the mode", [](Program& p) { p.code[0] = of(Op::voronoi, 5 << 7); }},
        {"the mode", [](Program& p) { p.code[0] = of(Op::ray_history, kRayHistoryCount); }},
        {"the shift", [](Program& p) { p.code[0] = of(Op::position, 3 * kShift); }},
        {"the mode", [](Program& p) { p.code[0] = of(Op::normal, kShift); }},
        {"parameter offset",
         [](Program& p) {
             p.code[0] = of(Op::uv, kShift);
             p.code[0].parameter = 1;
         }},
        {"parameter offset", [](Program& p) { p.code[0] = of(Op::brick, 0); }},
        {"the mode", [](Program& p) { p.code[0].mode = -1; }},
        {"parameter offset", [](Program& p) { p.code[0].parameter = 1; }},
        {"parameter offset", [](Program& p) { p.code[0].parameter = -1; }},
        {"parameter offset", [](Program& p) { p.parameters.clear(); }},
        {"image number 1", [](Program& p) { p.parameters[0] = 1; }},
        {"image number", [](Program& p) { p.parameters[0] = -1; }},
        {"image number", [](Program& p) { p.parameters[0] = NAN; }},
        {"parameter offset",
         [](Program& p) {
             p.code[0].op = static_cast<std::int32_t>(Op::ramp);
             p.code[0].mode = 256;
         }},
        {"the mode", [](Program& p) { p.code[0].op = static_cast<std::int32_t>(Op::ramp_alpha); }},
        {"the mode",
         [](Program& p) {
             p.code[0].op = static_cast<std::int32_t>(Op::blend);
             p.code[0].mode = kBlendModeCount;
         }},
        {"parameter offset", [](Program& p) { p.code[0].op = static_cast<std::int32_t>(Op::transform); }},
        {"the kind", [](Program& p) { p.closures[0].kind = static_cast<ClosureKind>(kClosureKindCount); }},
        {"weight's register", [](Program& p) { p.closures[0].weight = -1; }},
        {"input's register", [](Program& p) { p.closures[0].inputs[diffuse_input::color] = 200; }},
        {"input's register", [](Program& p) { p.closures[0].inputs[diffuse_input::roughness] = -1; }},
        {"input's register", [](Program& p) { p.closures[0].inputs[diffuse_input::normal] = -2; }},
        {"the distribution", [](Program& p) { p.closures[0].mode = kDistributionCount; }},
        {"lobes", [](Program& p) { p.closures.resize(kMaxLobes + 1, p.closures[0]); }},
    };
    for (std::size_t i = 0; i < faults.size(); ++i) {
        Program program = sound_program();
        faults[i].second(program);
        try {
            validate(program, 1);
            ADD_FAILURE() << "fault " << i << " (" << faults[i].first << ") was accepted";
        } catch (const std::invalid_argument& error) {
            EXPECT_NE(std::string(error.what()).find(faults[i].first), std::string::npos)
                << i << ": " << error.what();
        }
    }
}

TEST(Validate, NormalsMayBeUnconnectedOthersNot) {
    Program program = testing::PrincipledInputs{}.program();
    EXPECT_NO_THROW(validate(program, 0));
    program.closures[0].inputs[principled_input::coat_weight] = -1;
    EXPECT_THROW(validate(program, 0), std::invalid_argument);
}

}  // namespace
}  // namespace nephele
