// SPDX-License-Identifier: GPL-3.0-or-later
// What a path carries along. It is a tree where it splits: each branch is a Walk of its own; the segments
// that a branch has opened stand on one stack until all that comes of them is known.
#pragma once

#include "base/field_sample.h"
#include "integrators/lamps_on_the_way.h"
#include "integrators/segment_guiding.h"

namespace nephele {

/// Where a branch stands: the start of its next segment, and how it came there.
struct Walk {
    Ray ray;
    std::uint32_t kind = kCameraRay;
    Rgb beta{1};
    int bounces = 0, surface_bounces = 0, volume_bounces = 0;
    enum class First { none, surface, volume } first = First::none;  ///< event of the path
    RayHistory history;         ///< its length: what is added to that of the way and the ray
    LampsOnTheWay way;          ///< from the last vertex
    std::uint8_t receiver = 0;  ///< set of receivers that the last vertex's object is in
    float previous_pdf = 0;
    float guided_weight = 1;        ///< what drawing directions by the field has made of beta so far
    bool previous_specular = true;  ///< the camera: nothing else could have found what it sees
    float clear = 1;                ///< of camera rays: what transparent surfaces on the way let through
    bool featured = false;          ///< the features of SampleParts are complete
    bool lit = false;               ///< direct light was taken where the path scatters
    bool weighed = false;           ///< the last vertex ended and split branches by what they bring
};

/// A segment that began at a vertex, while the path goes on.
struct OpenSegment {
    SegmentGuiding guiding;
    FieldSample vertex = {};  ///< of what it teaches; light, cost and vsp follow at its end
    Rgb before = {};          ///< light of the path when it began
    Rgb gathered = {};        ///< direct light at the last stream's candidate, taken in any case
    Rgb undecided = {};       ///< light of the volume that its decision had no part in, this included
};

}  // namespace nephele
