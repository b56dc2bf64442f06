// SPDX-License-Identifier: GPL-3.0-or-later
// Any phase function: its kind and parameters (addon/opcodes.py, PHASES). wo and wi point away from the
// scattering point, so forward scattering is wi = -wo.
#pragma once

#include "opcodes_table.h"
#include "phase/henyey_greenstein.h"

namespace nephele {

struct PhaseFunction {
    PhaseKind kind = PhaseKind::henyey_greenstein;
    float a = 0, b = 0;  ///< parameters, as the kind means them

    bool operator==(const PhaseFunction&) const = default;

    /// Density of scattering from wo to wi, 1/sr.
    float eval(Vec3f wo, Vec3f wi) const { return HenyeyGreenstein{a}.eval(wo, wi); }
    /// A direction of density eval().
    Vec3f sample(Vec3f wo, Vec2f u) const { return HenyeyGreenstein{a}.sample(wo, u); }
};

}  // namespace nephele
