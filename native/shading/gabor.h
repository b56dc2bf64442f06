// SPDX-License-Identifier: GPL-3.0-or-later
// Gabor noise by sparse convolution (Lagae et al. 2009), with a fixed number of impulses a cell and random
// signs (Tavernier et al. 2019), as a phasor (Tricard et al. 2019); settings and hash as Blender's Gabor
// Texture.
#pragma once

#include "math/vec.h"

namespace nephele {

struct GaborSettings {
    float frequency = 2;       ///< of the waves, per cell
    float anisotropy = 1;      ///< 1: all waves run along the orientation; 0: along any
    float orientation = 0;     ///< in 2D: angle of the waves' direction
    Vec3f direction{1, 0, 0};  ///< in 3D; any length
    bool solid = false;        ///< 3D
};

struct Gabor {
    float value = 0.5f;  ///< about [0, 1]
    float phase = 0;     ///< [0, 1]
    float intensity = 0;
};

/// The noise at an already scaled point.
Gabor gabor_noise(Vec3f p, const GaborSettings& settings);

}  // namespace nephele
