// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles that Embree asks us about, met by a watertight test (watertight.h): what a query carries to the
// callbacks, and the callbacks.
#pragma once

#include <vector>

#include "scene/embree_device.h"
#include "scene/intersector.h"

namespace nephele::embree {

#if NEPHELE_EMBREE_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

/// What the callbacks need; the Embree context comes first, so that its address is ours.
struct Query {
    QueryContext context;
    HitFilter* filter;
    const std::vector<bool>* flipped;
};

inline Hit hit_of(const RTCRay& ray, const RTCHit& hit) {
    const bool instanced = hit.instID[0] != RTC_INVALID_GEOMETRY_ID;
    return {ray.tfar, instanced ? hit.instID[0] : hit.geomID, hit.primID, hit.u, hit.v};
}

/// Vertices of a mesh at equally spaced times of the shutter; one step where they stand still.
struct Vertices {
    const float* data;
    std::size_t steps, floats;  ///< floats: of one step
};
inline Vertices own_vertices(const Mesh& mesh) {
    return mesh.deforms() ? Vertices{mesh.motion_positions.data(), mesh.motion_steps, mesh.positions.size()}
                          : Vertices{mesh.positions.data(), 1, mesh.positions.size()};
}

/// Triangles that Embree asks us about.
struct OwnFaces {
    Vertices vertices;
    const std::int32_t* triangles;
    float slack;  ///< of boxes, for the rounding of vertices as the ray sees them

    /// At one of the vertices' steps.
    Vec3f corner(unsigned face, unsigned i, std::size_t step) const {
        const float* p = vertices.data + step * vertices.floats +
                         3 * static_cast<std::size_t>(triangles[3 * std::size_t{face} + i]);
        return {p[0], p[1], p[2]};
    }
    Vec3f corner_at(unsigned face, unsigned i, float time) const {
        if (vertices.steps == 1)
            return corner(face, i, 0);
        const MotionPlace place(time, vertices.steps);
        return lerp(corner(face, i, place.step), corner(face, i, place.step + 1), place.fraction);
    }
};

/// Callbacks of a user geometry whose user data are OwnFaces; the context of its queries is in a Query.
void bound_face(const RTCBoundsFunctionArguments* args);
void intersect_face(const RTCIntersectFunctionNArguments* args);

}  // namespace nephele::embree
