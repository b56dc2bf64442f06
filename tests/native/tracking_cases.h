// SPDX-License-Identifier: GPL-3.0-or-later
// Lines through media, thin and dense, grey and chromatic, one and several, for tests of flights and
// transmittance.
#pragma once

#include <string>

#include "cell_counts.h"
#include "media_fixtures.h"

namespace nephele::test {

inline constexpr int kVoxels = 40;
/// A slanted ray through the field of kVoxels^3.
inline Ray slanted() {
    return {{-3, 7, 30}, normalize(Vec3f(1, 0.45f, -0.3f)), 0, 50};
}

/// Two bumps of different widths along x, wavy across.
inline float bumps(int i, int j, int k) {
    const double x = i / 10.0;
    const double bump =
        std::exp(-std::pow((x - 1.2) / 0.3, 2)) + 0.6 * std::exp(-std::pow((x - 2.9) / 0.15, 2));
    return static_cast<float>(bump * (1 + 0.3 * std::sin(j + 0.5 * k)));
}
/// Nearly nothing but for one thin wall: the global majorant is 2000 times the usual density.
inline float spiky(int i, int, int) {
    return i == 20 ? 1.0f : 0.0005f;
}
inline float noisy(int i, int j, int k) {
    return Rng(static_cast<std::uint64_t>((i * 64 + j) * 64 + k)).next();
}

/// A line, made anew by each test, which may change it.
struct Case {
    std::string name;
    std::function<Line()> line;
};

inline Line grid_line(const Voxels& voxels, Rgb sigma_s, Rgb sigma_a,
                      Accelerator accelerator = Accelerator::grid) {
    Line line(slanted());
    line.add(sigma_s, sigma_a, 0, 50, field_of(kVoxels, voxels, accelerator));
    return line;
}

inline std::vector<Case> cases() {
    return {
        {"homogeneous",
         [] {
             Line line(slanted());
             line.add({0.03f, 0.03f, 0.03f}, {0.01f, 0.01f, 0.01f}, 5, 45);
             return line;
         }},
        {"absorbers",
         [] {
             Line line(slanted());
             line.add(Rgb(0), {0.01f, 0.03f, 0.1f}, 5, 45);
             line.add(Rgb(0), Rgb(0.02f), 0, 20);
             line.add(Rgb(0.01f), Rgb(0.01f), 10, 30);
             line.add(Rgb(0), {0.05f, 0.02f, 0}, 0, 50, field_of(kVoxels, bumps));
             return line;
         }},
        {"homogeneous_chromatic",
         [] {
             Line line(slanted());
             line.add({0.001f, 0.03f, 0.2f}, {0.05f, 0, 0.01f}, 5, 45);
             return line;
         }},
        {"bumps", [] { return grid_line(bumps, Rgb(0.2f), Rgb(0.02f)); }},
        {"bumps_chromatic",
         [] {
             return grid_line(bumps, {0.3f, 0.1f, 0}, {0, 0.05f, 0.02f});
         }},
        {"spiky", [] { return grid_line(spiky, Rgb(0.8f), Rgb(0.2f)); }},
        {"bumps_kdtree",
         [] {
             return grid_line(bumps, {0.3f, 0.1f, 0}, {0, 0.05f, 0.02f}, Accelerator::kdtree);
         }},
        {"spiky_kdtree", [] { return grid_line(spiky, Rgb(0.8f), Rgb(0.2f), Accelerator::kdtree); }},
        {"noisy_thin", [] { return grid_line(noisy, Rgb(1e-3f), Rgb(1e-3f)); }},
        {"noisy_dense", [] { return grid_line(noisy, Rgb(1.0f), Rgb(0.1f)); }},
        {"program",
         [] {
             Line line(slanted());
             line.add_program(squared_grid({0.3f, 0.1f, 0}, {0, 0.05f, 0.02f}, {0.1f, 0.3f, 0}), 0, 50,
                              kVoxels, bumps);
             return line;
         }},
        {"overlapping_grids",
         [] {
             Line line(slanted());
             line.add({0.3f, 0.1f, 0}, {0, 0.05f, 0.02f}, 0, 50, field_of(kVoxels, bumps));
             line.add({0.02f, 0.01f, 0.05f}, {0.01f, 0, 0}, 12, 22);
             line.add({0.01f, 0.01f, 0.03f}, Rgb(0.01f), 0, 30, field_of(kVoxels, noisy));
             return line;
         }},
        {"overlapping",
         [] {
             Line line(slanted());
             line.add({0.3f, 0.1f, 0}, {0, 0.05f, 0.02f}, 0, 50, field_of(kVoxels, bumps));
             line.add({0.02f, 0.01f, 0.05f}, {0.01f, 0, 0}, 12, 22);
             line.add({0, 0.02f, 0}, Rgb(0), 17, 50);
             line.add({0.01f, 0.01f, 0.03f}, Rgb(0.01f), 0, 30, field_of(kVoxels, noisy));
             line.add_program(squared_grid({0.1f, 0.2f, 0.3f}, Rgb(0.1f), {0.1f, 0.3f, 0}), 5, 50, kVoxels,
                              bumps);
             return line;
         }},
    };
}

inline Settings settings_of(Settings::Tracking tracking, bool global) {
    Settings s;
    s.tracking = tracking;
    s.majorant = global ? Settings::Majorant::global : Settings::Majorant::grid;
    return s;
}

}  // namespace nephele::test
