// SPDX-License-Identifier: GPL-3.0-or-later
// Perlin's gradient noise and its fractal sums, with the hash, gradients and scales of Blender's Noise
// Texture, so that pictures agree. The fractals other than fBM: Musgrave, in Ebert et al. 2003, "Texturing
// and Modeling".
#pragma once

#include "math/vec.h"

namespace nephele {

/// Gradient noise in about [-1, 1]; 0 at lattice points. The pattern repeats every 100000 units.
float perlin(float x);
float perlin(float x, float y);
float perlin(Vec3f p);
float perlin(Vec3f p, float w);

/// How octaves make a fractal, in the order of opcodes.py's NOISE_TYPES.
enum class NoiseType { fbm, multifractal, hybrid_multifractal, ridged_multifractal, hetero_terrain };

struct NoiseSettings {
    float detail = 2;  ///< number of octaves beyond the first; a fraction blends the last one in; [0, 15]
    float roughness = 0.5f;  ///< amplitude of an octave relative to the one before
    float lacunarity = 2;    ///< frequency of an octave relative to the one before
    float distortion = 0;
    bool normalize = true;  ///< of fBM: map the sum from [-1, 1] to [0, 1]
    int dimensions = 3;     ///< 1 to 4: how many coordinates of the point count
    NoiseType type = NoiseType::fbm;
    float offset = 0, gain = 1;  ///< of the other types that have them
};

/// A point of as many dimensions as the settings have.
struct NoisePoint {
    Vec3f p;
    float w = 0;  ///< the fourth coordinate

    NoisePoint(Vec3f at, float fourth = 0) : p(at), w(fourth) {}  // NOLINT(google-explicit-constructor)
};

/// Value of Blender's Noise Texture at an already scaled point.
float noise_value(NoisePoint p, const NoiseSettings& settings);
/// Its colour output; the red channel is the value.
Rgb noise_color(NoisePoint p, const NoiseSettings& settings);
/// Offset that decorrelates the noise number `seed` of a node: hashed, each coordinate in [100, 200]. Seeds 0
/// to dimensions - 1 serve the distortion, the next two the colour's green and blue.
NoisePoint noise_offset(int seed, int dimensions);

/// Hash of a point as Blender's White Noise Texture: a number in [0, 1], or three.
float white_noise(NoisePoint p, int dimensions);
Rgb white_noise_color(NoisePoint p, int dimensions);

}  // namespace nephele
