// SPDX-License-Identifier: GPL-3.0-or-later
// What closures read of a shading point's registers.
#pragma once

#include "base/surface.h"
#include "shading/program.h"
#include "surfaces/make_lobes.h"

namespace nephele {

/// A closure's inputs at a shading point.
struct ClosureInputs {
    const ClosureRow& row;
    const RegisterFile& registers;
    const ShadingPoint& point;

    Rgb weight() const { return non_negative(registers[row.weight]); }
    Rgb color(int i) const { return non_negative(registers[row.inputs[static_cast<std::size_t>(i)]]); }
    float unit(int i) const { return std::min(color(i).x, 1.0f); }
    /// ior beyond the surface / ior on wo's side, where the input is that of the inside.
    float eta(int i) const {
        const float ior = bounded_ior(color(i).x) / point.outside_ior;
        return point.backfacing ? 1 / ior : ior;
    }
    Distribution distribution() const { return static_cast<Distribution>(row.mode); }
    Vec3f normal(int i) const {
        return closure_normal(row.inputs[static_cast<std::size_t>(i)], registers, point);
    }
    SeenInterface interface_of(int normal_input, int ior_input) const {
        return seen_interface(normal(normal_input), eta(ior_input), point.wo);
    }
    Vec3f bent(int i) const { return bent_normal(normal(i), point.ng, point.wo); }
    Vec3f tangent(int i) const {
        const std::int16_t input = row.inputs[static_cast<std::size_t>(i)];
        return input < 0 ? Vec3f(0) : finite(registers[input]);
    }
    float turn(int i) const { return finite(registers[row.inputs[static_cast<std::size_t>(i)]]).x; }
};

}  // namespace nephele
