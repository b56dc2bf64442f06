// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps against pixel values of Cycles 5.0.1.
//
// Recorded with bpy 5.0.1 on the CPU: one lamp at (0, 0, 2) of 1000 W (sun: 1000 W/m^2), shining down on a
// white diffuse plane z = 0 with bounces off, seen by an orthographic camera from (x, 0, 1) whose frame of 8
// x 8 pixels is 0.02 m wide; 1024 samples, box filter. `pixel` is the mean of the 64 pixels: irradiance / pi.
// Its noise and the plane's slope within the frame stay below the tolerance of 0.2 %.
#include <gtest/gtest.h>

#include "light_fixtures.h"

namespace nephele::test {
namespace {

constexpr double kPid = 3.14159265358979323846;
constexpr Vec3f kUp(0, 0, 1);

struct CyclesCase {
    const char* name;
    double pixel;
    float x;
    LampSetter set;
    Kind kind;
};

void PrintTo(const CyclesCase& c, std::ostream* os) {
    *os << c.name;
}

const auto nothing = [](LampDescription&) {};

const CyclesCase kCycles[] = {
    {"point", 6.332437, 0, nothing, Kind::point},
    {"point_unnormalised", 25.329747, 0, ball(0, false, false), Kind::point},
    {"sphere", 6.332456, 0, ball(0.5f), Kind::point},
    {"sphere_scaled", 6.332456, 0,
     [](LampDescription& d) {
         d.radius = 0.5f;
         place(d, {0, 0, 2}, {}, Vec3f(2));
     },
     Kind::point},
    {"sphere_soft", 5.960012, 0, ball(0.5f, true), Kind::point},
    {"sphere_unnormalised", 19.893997, 0, ball(0.5f, false, false), Kind::point},
    {"sphere_large_aside", 4.530237, 1, ball(1.5f), Kind::point},
    {"sphere_large_aside_soft", 3.124784, 1, ball(1.5f, true), Kind::point},
    {"sphere_inside", 2.814456, 0, ball(3), Kind::point},
    {"sphere_inside_soft", 1.672680, 0.9f, ball(3, true), Kind::point},
    {"sun_0", 318.311859, 0, sun(0), Kind::sun},
    {"sun_0_unnormalised", 318.311859, 0, sun(0, false), Kind::sun},
    {"sun_60", 318.308668, 0, sun(60), Kind::sun},
    {"sun_60_unnormalised", 249.999068, 0, sun(60, false), Kind::sun},
    {"sun_170_tilted", 291.460972, 0, sun(170, true, 0.5f), Kind::sun},
    {"sun_180", 318.313632, 0, sun(180), Kind::sun},
    {"area_1x1", 23.388581, 0, area(1, 1), Kind::area},
    {"area_1x2", 21.065901, 0, area(1, 2), Kind::area},
    {"area_1x2_unnormalised", 42.131803, 0, area(1, 2, false, 180, false), Kind::area},
    {"area_disk", 23.839956, 0, area(1, 1, true), Kind::area},
    {"area_ellipse", 21.979902, 0, area(1, 2, true), Kind::area},
    {"area_scaled", 16.636804, 0, area(1, 1, false, 180, true, {3, 2, 5}), Kind::area},
    {"area_tilted", 22.305853, 0.7f, tilted_area(), Kind::area},
    {"area_spread_0", 318.311859, 0, area(1, 1, false, 0), Kind::area},
    {"area_spread_1", 318.307365, 0, area(1, 1, false, 1), Kind::area},
    {"area_spread_30", 317.319473, 0, area(1, 1, false, 30), Kind::area},
    {"area_spread_90", 88.514446, 0, area(1, 1, false, 90), Kind::area},
    {"area_spread_90_aside", 37.377558, 1, area(1, 1, false, 90), Kind::area},
    {"area_spread_150", 34.210614, 0, area(1, 1, false, 150), Kind::area},
    {"area_spread_ellipse", 58.310761, 0.7f, area(1, 2, true, 60), Kind::area},
    {"area_spread_unnormalised", 104.002619, 0.7f, area(1, 2, false, 60, false), Kind::area},
    {"spot_axis", 6.332437, 0, spot(0), Kind::spot},
    {"spot_in_cone", 5.782001, 0.5f, spot(0), Kind::spot},
    {"spot_edge", 3.672584, 0.9f, spot(0), Kind::spot},
    {"spot_hard_edge", 4.260006, 1.1f, spot(0, 0), Kind::spot},
    {"spot_blend_1", 5.048006, 0.5f, spot(0, 1), Kind::spot},
    {"spot_wide", 1.080831, 3, spot(0, 0.5f, 170), Kind::spot},
    {"spot_scaled_evenly", 3.672584, 0.9f, spot(0, 0.5f, 60, false, Vec3f(3)), Kind::spot},
    {"spot_scaled_x", 1.989254, 1.8f, spot(0, 0.5f, 60, false, {2, 1, 1}), Kind::spot},
    {"spot_scaled_z", 2.237776, 0.5f, spot(0, 0.5f, 60, false, {1, 1, 2}), Kind::spot},
    {"spot_sphere", 2.629160, 0.9f, spot(0.5f), Kind::spot},
    {"spot_sphere_soft", 2.511970, 0.9f, spot(0.5f, 0.5f, 60, true), Kind::spot},
    {"spot_inside_soft", 0.536484, 0.9f, spot(3, 0.5f, 60, true), Kind::spot},
};

class CyclesPixel : public ::testing::TestWithParam<CyclesCase> {};

TEST_P(CyclesPixel, HasTheSameIrradiance) {
    const CyclesCase& c = GetParam();
    const Lamp lamp = hanging(c.kind, c.set);
    // The frame is averaged as the camera does, by a grid of points.
    constexpr int kGrid = 5;
    Estimate mean;
    for (int i = 0; i < kGrid; ++i) {
        const float x = c.x + 0.02f * ((static_cast<float>(i) + 0.5f) / kGrid - 0.5f);
        const Estimate e = irradiance(lamp, {x, 0, 0}, kUp, 100000, static_cast<std::uint64_t>(i + 1));
        mean.mean += e.mean / kGrid;
        mean.error += e.error * e.error / (kGrid * kGrid);
    }
    mean.error = std::sqrt(mean.error);
    EXPECT_NEAR(mean.mean / kPid, c.pixel, 0.002 * c.pixel + 6 * mean.error / kPid);
    EXPECT_LT(mean.error, 0.004 * mean.mean) << "the estimate is too noisy to say anything";
}

INSTANTIATE_TEST_SUITE_P(Lamps, CyclesPixel, ::testing::ValuesIn(kCycles),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace nephele::test
