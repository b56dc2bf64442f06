// SPDX-License-Identifier: GPL-3.0-or-later
// Pooling of sparse, heavy-tailed statistics over the image: each pixel gets an estimate from as few pixels
// around it as say enough.
//
// Sums are widened level by level (a-trous tent kernels; Dammertz, Sewtz, Hanika, Lensch, HPG 2010), not
// across edges of a feature. A level's ratio is trusted as far as its effective number of samples goes,
// (sum x)^2 / sum x^2 (Kish 1965), which one firefly cannot raise; the rest of the trust goes to the next
// wider level. With few samples that is a wide average, with many the pixel's own.
#pragma once

#include <cmath>
#include <span>
#include <vector>

namespace nephele {

/// Sums over samples of one branch (volume or surface) of a pixel.
struct BranchSums {
    float weight = 0;               ///< the branch's weights, taken or not
    float light = 0, light2 = 0;    ///< radiance times weight; squares of these; all finite
    float square = 0, square2 = 0;  ///< radiance squared times weight; squares of these
    float cost = 0, taken = 0;
};

/// Whether sums that were read from a file can be some.
inline bool sound(const BranchSums& s) {
    return s.weight >= 0 && std::isfinite(s.weight) && s.taken >= 0 && std::isfinite(s.taken) &&
           std::isfinite(s.light) && std::isfinite(s.light2) && std::isfinite(s.square) &&
           std::isfinite(s.square2) && std::isfinite(s.cost);
}

/// Adds a sample's light, and its square, both per unit of weight.
void add_light(BranchSums& sums, float light, float square);

/// The sums as if of `share` as many samples, in (0, 1].
BranchSums thinned(BranchSums sums, float share);

/// Estimates for one pixel.
struct Pooled {
    float light = 0;  ///< per unit of weight
    float cost = 0;   ///< per sample that took the branch
    float known = 0;  ///< in [0, 1]: share of the light that samples enough stand for
    float noise = 0;  ///< variance of the light, relative to its square
};

/// The estimates of one set of sums by itself, noise included.
Pooled pooled_alone(const BranchSums& sums);

/// `sums`, `feature`: of width x height pixels. Differences of the feature well below 0.1 are none, well
/// above are edges; empty: there are no edges. Never NaN: without any sample the light is 0.
std::vector<Pooled> pool(int width, int height, std::vector<BranchSums> sums, std::span<const float> feature);
/// The same, with the noise. Squares are pooled relative to the pixel's mean: as they are, the brightest
/// pixels around would outweigh all others.
std::vector<Pooled> pool_with_noise(int width, int height, std::vector<BranchSums> sums,
                                    std::span<const float> feature);

}  // namespace nephele
