// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/mesh_hierarchy.h"

#include <algorithm>

namespace nephele::embree {

namespace {

RTCGeometry watertight_triangles(RTCDevice device, const Mesh& mesh, const Vertices& vertices,
                                 OwnFaces* own) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(vertices.steps));
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(mesh.triangle_count()));
    rtcSetGeometryUserData(geometry, own);
    rtcSetGeometryBoundsFunction(geometry, bound_face, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect_face);
    return geometry;
}

/// Whether the vertices are somebody else's array, past whose end Embree must not read.
bool is_own(const Mesh& mesh, const Vertices& vertices) {
    return vertices.data == mesh.positions.data() || vertices.data == mesh.motion_positions.data();
}

}  // namespace

RTCGeometry triangles(RTCDevice device, const Mesh& mesh, const Vertices& vertices, OwnFaces* own) {
    if (own != nullptr)
        return watertight_triangles(device, mesh, vertices, own);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(vertices.steps));
    for (std::size_t i = 0; i < vertices.steps; ++i) {
        const float* step = vertices.data + i * vertices.floats;
        const auto slot = static_cast<unsigned>(i);
        if (is_own(mesh, vertices)) {  // Embree may read 16 bytes at the last vertex: copy
            void* copy = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, slot, RTC_FORMAT_FLOAT3,
                                                 12, vertices.floats / 3);
            if (copy != nullptr)
                std::copy(step, step + vertices.floats, static_cast<float*>(copy));
        } else {
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, slot, RTC_FORMAT_FLOAT3, step, 0, 12,
                                       vertices.floats / 3);
        }
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                               12, mesh.triangle_count());
#if NEPHELE_EMBREE_MAJOR >= 4
    rtcSetGeometryEnableFilterFunctionFromArguments(geometry, true);
#endif
    return geometry;
}

MeshHierarchy::MeshHierarchy(std::shared_ptr<const Device> device, const Mesh& mesh,
                             std::optional<float> slack)
    : device_(std::move(device)),
      positions_(mesh.positions),
      motion_(mesh.motion_positions),
      indices_(mesh.triangles),
      own_{own_vertices(mesh), mesh.triangles.data(), slack.value_or(0)},
      scene_(device_->new_scene()) {
    attach(scene_.get(), triangles(device_->handle(), mesh, own_.vertices, slack ? &own_ : nullptr), 0);
    bytes_ = device_->commit(scene_.get());
}

std::shared_ptr<const MeshHierarchy> MeshHierarchy::shared(PartScope& parts,
                                                           const std::shared_ptr<const Device>& device,
                                                           const Mesh& mesh, std::optional<float> slack) {
    PartKey key;
    key.add(device).add(mesh.positions).add(mesh.triangles).add(mesh.motion_positions).add(mesh.motion_steps);
    key.add(slack.has_value()).add(slack.value_or(0));
    return parts.share<MeshHierarchy>(key,
                                      [&] { return std::make_shared<MeshHierarchy>(device, mesh, slack); });
}

}  // namespace nephele::embree
