// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes and their instances, as the scene description gives them (addon/description.py states shapes and
// meanings).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "math/transform.h"

namespace nephele {

/// A triangle mesh in object space. Per-corner arrays hold 3 entries a triangle.
struct Mesh {
    std::string name;
    Buffer<float> positions;                ///< 3 a vertex
    Buffer<std::int32_t> triangles;         ///< 3 a triangle
    Buffer<float> corner_normals;           ///< 9 a triangle, or empty: flat
    std::vector<Buffer<float>> uvs;         ///< 6 a triangle
    std::vector<Buffer<float>> attributes;  ///< 12 a triangle: RGBA a corner
    Buffer<std::int32_t> material_index;    ///< 1 a triangle, or empty: slot 0
    Vec3f generated_min, generated_size;

    std::size_t triangle_count() const { return triangles.size() / 3; }
    Vec3f vertex(std::uint32_t triangle, int corner) const {
        const float* p = positions.data() +
                         3 * static_cast<std::size_t>(
                                 triangles[3 * std::size_t{triangle} + static_cast<std::size_t>(corner)]);
        return {p[0], p[1], p[2]};
    }
    std::int32_t slot(std::uint32_t triangle) const {
        return material_index.empty() ? 0 : material_index[triangle];
    }
};

/// A mesh placed in the world.
struct Instance {
    std::string name;
    std::uint32_t mesh = 0;
    Transform world_from_object, object_from_world;
    std::vector<std::int32_t> materials;  ///< by slot; -1: the default grey diffuse
    std::uint32_t visibility = ~0u;       ///< bits of RayKind
    float random = 0;
    std::array<float, 4> color{1, 1, 1, 1};
    float pass_index = 0;
    int dielectric_priority = 0;  ///< see scene/nesting.h; 0: takes no part

    /// Material of a triangle; slots beyond the list use the last one, as in Blender.
    std::int32_t material_of(const Mesh& m, std::uint32_t triangle) const {
        const auto slot = static_cast<std::size_t>(std::max(m.slot(triangle), 0));
        return materials[std::min(slot, materials.size() - 1)];
    }
    bool mirrored() const { return world_from_object.determinant() < 0; }
};

}  // namespace nephele
