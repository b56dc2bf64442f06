// SPDX-License-Identifier: GPL-3.0-or-later
// What a path tells about the decision between volume and surface on its camera ray.
#pragma once

namespace nephele {

/// What one sample teaches. Light: mean over RGB.
struct VspRecord {
    bool known = false;                           ///< false: the camera ray met no medium
    bool scattered = false;                       ///< which branch it took
    float probability = 1;                        ///< of that branch
    float volume_weight = 0, surface_weight = 0;  ///< of both, before division by probabilities
    float light = 0;                              ///< what the branch brought, divided by its probability
    float cost = 0;                               ///< work of the whole path
    float transmittance = 1, majorant_depth = 0;
    float distance = 1e10f;  ///< to what is behind, m
    // Where the segment was walked to its end before the decision:
    bool walked = false;
    bool weighed = false;  ///< by a light estimate: the weights tell nothing of plain delta tracking
    float volume_square = 0, surface_square = 0, both = 0;  ///< of the weights, and their product
    float extra_work = 0;  ///< that plain delta tracking would have saved on the segment itself
};

}  // namespace nephele
