// SPDX-License-Identifier: GPL-3.0-or-later
// What a light is to the integrator. A light is anything that light sampling can aim at: lamps, emissive
// meshes, the world. Densities are per solid angle as seen from the receiving point.
#pragma once

#include "math/vec.h"

namespace nephele {

/// A direction towards a light, drawn at a receiving point.
struct LightSample {
    Vec3f wi;                    ///< unit, from the receiving point to the light
    float distance = kInfinity;  ///< m; infinity for sun and world
    Rgb Li;  ///< radiance (delta lights: radiance already multiplied so that Li / pdf is the irradiance's
             ///< integrand)
    float pdf = 0;       ///< solid angle, of this light alone (1 for delta lights)
    bool delta = false;  ///< no other technique can hit it: its MIS weight is 1
};

}  // namespace nephele
