// SPDX-License-Identifier: GPL-3.0-or-later
// The headers generated from the Python tables: defaults, setting by name, errors that name the remedy.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "opcodes_table.h"
#include "passes_table.h"
#include "settings_table.h"

namespace nephele {
namespace {

template <typename F>
std::string error_of(F f) {
    try {
        f();
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

TEST(Settings, AreSetByName) {
    Settings settings;
    set_field(settings, "samples", 7.0);
    set_field(settings, "clamp", 2.5);
    set_field(settings, "integrator", "plain");
    EXPECT_EQ(settings.samples, 7);
    EXPECT_EQ(settings.clamp, 2.5f);
    EXPECT_EQ(settings.integrator, Settings::Integrator::plain);
}

TEST(Settings, EveryFieldTakesItsOwnLimits) {
    Settings settings;
    for (const SettingsField& field : kSettingsFields) {
        if (field.items.empty()) {
            EXPECT_NO_THROW(set_field(settings, field.name, field.minimum)) << field.name;
            EXPECT_THROW(set_field(settings, field.name, field.maximum * 2 + 1), std::invalid_argument)
                << field.name;
        } else {
            EXPECT_NO_THROW(set_field(settings, field.name, field.items.substr(0, field.items.find('|'))))
                << field.name;
        }
    }
}

TEST(Settings, ErrorsNameTheRemedy) {
    Settings settings;
    EXPECT_NE(error_of([&] { set_field(settings, "sample", 1.0); }).find("valid names: samples"),
              std::string::npos);
    EXPECT_NE(error_of([&] { set_field(settings, "samples", 0.0); }).find("outside"), std::string::npos);
    EXPECT_NE(error_of([&] { set_field(settings, "samples", "many"); }).find("a number"), std::string::npos);
    EXPECT_NE(error_of([&] { set_field(settings, "integrator", "fast"); }).find("path|plain"),
              std::string::npos);
    EXPECT_NE(error_of([&] { set_field(settings, "integrator", 0.0); }).find("path|plain"),
              std::string::npos);
    EXPECT_NE(error_of([&] { set_field(settings, "integrator", ""); }).find("path|plain"), std::string::npos);
}

TEST(Passes, CombinedComesFirstWithItsAlpha) {
    EXPECT_EQ(static_cast<int>(PassId::combined), 0);
    EXPECT_STREQ(kPasses[0].name, "Combined");
    EXPECT_EQ(kPasses[0].channels, 4);
    EXPECT_STREQ(kPasses[static_cast<int>(PassId::sample_count)].identifier, "sample_count");
}

TEST(Opcodes, NamesAndInputsFollowTheEnums) {
    EXPECT_STREQ(kOpNames[static_cast<int>(Op::map_range)], "map_range");
    EXPECT_STREQ(kClosureNames[static_cast<int>(ClosureKind::principled)], "principled");
    EXPECT_EQ(kClosureInputCounts[static_cast<int>(ClosureKind::principled)],
              principled_input::thin_film_ior + 1);
    EXPECT_GE(kMaxClosureInputs, kClosureInputCounts[static_cast<int>(ClosureKind::principled)]);
}

}  // namespace
}  // namespace nephele
