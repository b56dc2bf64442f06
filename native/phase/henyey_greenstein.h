// SPDX-License-Identifier: GPL-3.0-or-later
// Henyey-Greenstein phase function (Henyey and Greenstein 1941), isotropic at g = 0. wo and wi both point away from the
// scattering point, so forward scattering is wi = -wo. Sampling is exact: pdf == eval.
#pragma once

#include "math/transform.h"
#include "math/warp.h"

namespace nephele {

struct HenyeyGreenstein {
    float g = 0;  ///< mean cosine of the scattering angle, in (-1, 1)

    /// Density of scattering from wo to wi, 1/sr.
    float eval(Vec3f wo, Vec3f wi) const {
        const float c = -dot(wo, wi);  // cosine between the directions of travel
        const float d = 1 + g * g - 2 * g * c;
        return kInv4Pi * (1 - g * g) / (d * std::sqrt(std::max(d, 1e-12f)));
    }

    Vec3f sample(Vec3f wo, Vec2f u) const {
        const float xi = 2 * u.x - 1;
        float c;
        if (std::fabs(g) > 1e-3f) {
            const float s = (1 - g * g) / (1 + g * xi);
            c = (1 + g * g - s * s) / (2 * g);
        } else {  // the series around g = 0, where the closed form cancels
            c = xi + 1.5f * g * (1 - xi * xi);
        }
        return Frame(-wo).to_world(spherical(std::clamp(c, -1.0f, 1.0f), u.y));
    }
};

}  // namespace nephele
