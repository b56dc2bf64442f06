// SPDX-License-Identifier: GPL-3.0-or-later
// Cellular textures: one feature point in every cell of a lattice (Worley 1996), in one to four dimensions,
// with the features, metrics and fractal sum of Blender's Voronoi Texture, so that pictures agree.
#pragma once

#include <array>

#include "math/vec.h"

namespace nephele {

enum class VoronoiFeature { f1, f2, smooth_f1, distance_to_edge, n_sphere_radius };
enum class VoronoiMetric { euclidean, manhattan, chebychev, minkowski };

struct VoronoiSettings {
    VoronoiFeature feature = VoronoiFeature::f1;
    VoronoiMetric metric = VoronoiMetric::euclidean;
    int dimensions = 3;      ///< 1 to 4: the first so many coordinates count; in 1D the only one is W
    bool normalize = false;  ///< divide by the largest distance that is possible
    float detail = 0;        ///< octaves beyond the first; [0, 15]
    float roughness = 0.5f, lacunarity = 2;
    float smoothness = 1;   ///< of smooth_f1, [0, 1]
    float exponent = 0.5f;  ///< of the Minkowski metric
    float randomness = 1;   ///< how far feature points leave the corners of their cells, [0, 1]
};

struct Voronoi {
    float distance = 0;  ///< or the radius of the n-sphere
    Rgb color;
    std::array<float, 4> position{};  ///< of the feature point, in the scaled space
};

/// The texture at an already scaled point.
Voronoi voronoi(const std::array<float, 4>& p, const VoronoiSettings& settings);

/// Largest distance to a feature that counts as 1 where the texture is normalized (one octave).
float voronoi_largest_distance(const VoronoiSettings& settings);

}  // namespace nephele
