// SPDX-License-Identifier: GPL-3.0-or-later
// The world's mist settings.
#pragma once

#include <algorithm>

#include "math/vec.h"

namespace nephele {

struct Mist {
    float start = 5, depth = 25;  ///< m
    enum class Falloff { linear, quadratic, inverse_quadratic } falloff = Falloff::quadratic;

    /// How much of it there is at a distance: 0 before it starts, 1 from start + depth on.
    float at(float distance) const {
        const float x = clamp01((distance - start) / std::max(depth, 1e-6f));
        switch (falloff) {
            case Falloff::linear:
                return x;
            case Falloff::quadratic:
                return x * x;
            case Falloff::inverse_quadratic:
                break;
        }
        return std::sqrt(x);
    }
};

}  // namespace nephele
