// SPDX-License-Identifier: GPL-3.0-or-later
// The ray tracing hierarchy of one mesh in its own space, for any number of instances. Immutable; it keeps
// what it is built of, so that it outlives the scene that built it.
#pragma once

#include <optional>

#include "base/part_cache.h"
#include "scene/embree_device.h"
#include "scene/embree_faces.h"

namespace nephele::embree {

/// The triangles of a mesh with these vertices, which have 4 bytes to spare behind the last where they are
/// not the mesh's own. own: tests the faces, and must live as long; null: Embree does.
RTCGeometry triangles(RTCDevice device, const Mesh& mesh, const Vertices& vertices, OwnFaces* own);

class MeshHierarchy {
  public:
    /// slack: of boxes, in the mesh's own space; none: Embree's own test of faces. Throws std::runtime_error.
    MeshHierarchy(std::shared_ptr<const Device> device, const Mesh& mesh, std::optional<float> slack);

    RTCScene scene() const { return scene_.get(); }
    /// Memory that Embree holds, bytes.
    std::ptrdiff_t bytes() const { return bytes_; }

    /// The one of this mesh that is there, or a new one.
    static std::shared_ptr<const MeshHierarchy> shared(PartScope& parts,
                                                       const std::shared_ptr<const Device>& device,
                                                       const Mesh& mesh, std::optional<float> slack);

  private:
    std::shared_ptr<const Device> device_;
    Buffer<float> positions_, motion_;
    Buffer<std::int32_t> indices_;
    OwnFaces own_;
    SceneHandle scene_;
    std::ptrdiff_t bytes_;
};

}  // namespace nephele::embree
