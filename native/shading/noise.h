// SPDX-License-Identifier: GPL-3.0-or-later
// Perlin's gradient noise and its fractal sum (fBM), with the hash, gradients and scales of Blender's Noise
// Texture, so that pictures agree: lattice points are hashed by the final mix of Bob Jenkins' lookup3 (2006).
#pragma once

#include "math/vec.h"

namespace nephele {

/// Gradient noise in about [-1, 1]; 0 at lattice points. The pattern repeats every 100000 units.
float perlin(float x);
float perlin(float x, float y);
float perlin(Vec3f p);

struct NoiseSettings {
    float detail = 2;  ///< number of octaves beyond the first; a fraction blends the last one in; [0, 15]
    float roughness = 0.5f;  ///< amplitude of an octave relative to the one before
    float lacunarity = 2;    ///< frequency of an octave relative to the one before
    float distortion = 0;
    bool normalize = true;  ///< map the sum from [-1, 1] to [0, 1]
    int dimensions = 3;     ///< 1, 2 or 3: how many coordinates of the point count
};

/// Value of Blender's Noise Texture (type fBM) at an already scaled point, in all channels.
float noise_value(Vec3f p, const NoiseSettings& settings);
/// Offset that decorrelates the noise number `seed` of a node: hashed, each coordinate in [100, 200]. Seeds 0
/// to dimensions - 1 serve the distortion, the next two the colour's green and blue.
Vec3f noise_offset(int seed, int dimensions);
/// Its colour output; the red channel is the value.
Rgb noise_color(Vec3f p, const NoiseSettings& settings);

}  // namespace nephele
