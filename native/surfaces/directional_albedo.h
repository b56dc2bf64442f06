// SPDX-License-Identifier: GPL-3.0-or-later
// Directional albedos of the rough lobes: the share of light from a direction that single scattering returns.
// They serve energy compensation (Kulla and Conty 2017; Turquin 2019, "Practical multiple scattering
// compensation for microfacet models"), layering and the choice of lobes. Tabulated at first use by numerical
// integration of the very functions in microfacet.h; GGX throughout. mu: cosine of the direction, roughness =
// sqrt(alpha).
#pragma once

#include "math/vec.h"

namespace nephele {

/// White microfacet reflection; its cosine-weighted mean over the hemisphere.
float reflection_albedo(float mu, float roughness);
float mean_reflection_albedo(float roughness);

/// Reflected and transmitted share at a rough dielectric interface. eta: ior beyond / ior on the direction's
/// side.
struct DielectricAlbedo {
    float reflected = 0, transmitted = 0;
};
DielectricAlbedo dielectric_albedo(float mu, float roughness, float eta);
DielectricAlbedo mean_dielectric_albedo(float roughness, float eta);

}  // namespace nephele
