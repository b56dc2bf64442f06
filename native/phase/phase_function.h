// SPDX-License-Identifier: GPL-3.0-or-later
// Any phase function (addon/opcodes.py, PHASES). wo and wi point away from the scattering point, so forward
// scattering is wi = -wo. Densities integrate to 1 and are finite for every parameter.
#pragma once

#include "opcodes_table.h"
#include "phase/draine.h"
#include "phase/fournier_forand.h"
#include "phase/henyey_greenstein.h"
#include "phase/mie.h"
#include "phase/rayleigh.h"

namespace nephele {

/// What make_phase() derived from the parameters; without parameters isotropic. Two are equal where they
/// scatter alike.
struct PhaseFunction {
    PhaseKind kind = PhaseKind::henyey_greenstein;
    float p0 = 0, p1 = 0, p2 = 0, p3 = 0;  ///< the members of the kind's class, in order

    bool operator==(const PhaseFunction&) const = default;

    /// Calls f with an object of the kind's class.
    template <typename F>
    auto visit(F&& f) const {
        if (kind == PhaseKind::henyey_greenstein)
            return f(HenyeyGreenstein{p0});
        switch (kind) {
            case PhaseKind::rayleigh:
                return f(Rayleigh{});
            case PhaseKind::draine:
                return f(Draine{p0, p1});
            case PhaseKind::fournier_forand:
                return f(FournierForand{p0, p1, p2, p3});
            case PhaseKind::mie:
                return f(Mie{{p0}, {p1, p2}, p3});
            case PhaseKind::henyey_greenstein:
                break;
        }
        return f(HenyeyGreenstein{p0});
    }

    /// Density of scattering from wo to wi, 1/sr.
    float eval(Vec3f wo, Vec3f wi) const {
        return visit([&](const auto& phase) { return phase.eval(wo, wi); });
    }
    /// A direction of density eval().
    Vec3f sample(Vec3f wo, Vec2f u) const {
        return visit([&](const auto& phase) { return phase.sample(wo, u); });
    }
};

/// The phase function of a kind with the parameters that opcodes.py names. They are clamped, as Blender does:
/// |g| <= 0.999; alpha to [0, 1e4]; ior to [1.001, 10]; backscatter to [1e-6, 0.499]; diameter >= 0. What is
/// not a number counts as 0.
inline PhaseFunction make_phase(PhaseKind kind, float a = 0, float b = 0) {
    const auto clamped = [](float x, float low, float high) {
        return std::clamp(std::isnan(x) ? 0.0f : x, low, high);
    };
    constexpr float kMaxG = 0.999f;
    switch (kind) {
        case PhaseKind::henyey_greenstein:
            return {kind, clamped(a, -kMaxG, kMaxG)};
        case PhaseKind::rayleigh:
            return {kind};
        case PhaseKind::draine:
            return {kind, clamped(a, -kMaxG, kMaxG), clamped(b, 0, 1e4f)};
        case PhaseKind::fournier_forand: {
            const auto f =
                FournierForand::make(double{clamped(a, 1.001f, 10)}, double{clamped(b, 1e-6f, 0.499f)});
            return {kind, f.scale, f.v, f.back, f.cap};
        }
        case PhaseKind::mie: {
            const Mie m = Mie::make(double{clamped(a, 0, 1e9f)});
            return {kind, m.narrow.g, m.wide.g, m.wide.alpha, m.wide_share};
        }
    }
    return {};
}

}  // namespace nephele
