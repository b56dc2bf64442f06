// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's Principled BSDF (version 2, Blender 4.0 and newer) as a stack of lobes, from the top: sheen,
// coat, then by weight metal, glass, and a dielectric reflection over what scatters below the surface and a
// diffuse rest. Each layer takes its albedo from what lies beneath.
#pragma once

#include "base/surface.h"
#include "shading/program.h"
#include "surfaces/make_lobes.h"

namespace nephele {

/// Adds the lobes, emission and transparency of a Principled closure.
void add_principled(Bsdf& bsdf, const ClosureRow& row, const RegisterFile& registers,
                    const ShadingPoint& point);
Rgb principled_emission(const ClosureRow& row, const RegisterFile& registers, const ShadingPoint& point);
Rgb principled_transparency(const ClosureRow& row, const RegisterFile& registers);

}  // namespace nephele
