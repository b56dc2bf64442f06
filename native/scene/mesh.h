// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes and their instances, as the scene description gives them (addon/description.py states shapes and
// meanings).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "base/light.h"
#include "math/motion.h"

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
    /// Vertices, and corner normals where there are any, at equally spaced times of the shutter; 0 steps: it
    /// keeps its shape.
    std::size_t motion_steps = 0;
    Buffer<float> motion_positions, motion_normals;
    Buffer<float> neighbours;  ///< vertices at the frames before and after; empty: it keeps its shape

    std::size_t triangle_count() const { return triangles.size() / 3; }
    bool deforms() const { return compiled::motion && motion_steps > 0; }
    Vec3f vertex(std::uint32_t triangle, int corner) const {
        return at(positions, 3 * vertex_number(triangle, corner));
    }
    /// At a time in [0, 1] of the shutter.
    Vec3f vertex(std::uint32_t triangle, int corner, float time) const {
        if (!deforms())
            return vertex(triangle, corner);
        return moving(motion_positions, positions.size(), 3 * vertex_number(triangle, corner), time);
    }
    /// A corner's normal, where it has one.
    Vec3f corner_normal(std::uint32_t triangle, int corner) const {
        return at(corner_normals, normal_number(triangle, corner));
    }
    Vec3f corner_normal(std::uint32_t triangle, int corner, float time) const {
        if (!compiled::motion || motion_normals.empty())
            return corner_normal(triangle, corner);
        return moving(motion_normals, corner_normals.size(), normal_number(triangle, corner), time);
    }
    /// At the frame before (0) or after (1).
    Vec3f neighbour(std::uint32_t triangle, int corner, std::size_t which) const {
        return neighbours.empty()
                   ? vertex(triangle, corner)
                   : at(neighbours, which * positions.size() + 3 * vertex_number(triangle, corner));
    }
    std::int32_t slot(std::uint32_t triangle) const {
        return material_index.empty() ? 0 : material_index[triangle];
    }

  private:
    static std::size_t normal_number(std::uint32_t triangle, int corner) {
        return 9 * std::size_t{triangle} + 3 * static_cast<std::size_t>(corner);
    }
    std::size_t vertex_number(std::uint32_t triangle, int corner) const {
        return static_cast<std::size_t>(
            triangles[3 * std::size_t{triangle} + static_cast<std::size_t>(corner)]);
    }
    static Vec3f at(const Buffer<float>& values, std::size_t i) {
        return {values[i], values[i + 1], values[i + 2]};
    }
    /// values: `size` floats a step.
    Vec3f moving(const Buffer<float>& values, std::size_t size, std::size_t i, float time) const {
        const MotionPlace place(time, motion_steps);
        return lerp(at(values, place.step * size + i), at(values, (place.step + 1) * size + i),
                    place.fraction);
    }
};

/// A mesh placed in the world.
struct Instance {
    std::string name;
    std::uint32_t mesh = 0;
    Transform world_from_object, object_from_world;  ///< of the frame itself
    Motion motion;                                   ///< of world_from_object over the shutter
    std::vector<std::int32_t> materials;             ///< by slot; -1: the default grey diffuse
    std::uint32_t visibility = ~0u;                  ///< bits of RayKind
    float random = 0;
    std::array<float, 4> color{1, 1, 1, 1};
    float pass_index = 0;
    std::optional<std::array<Transform, 2>> neighbours;  ///< world_from_object at the frames before and after
    std::uint32_t object_matte = 0, asset_matte = 0;     ///< ids, see film/matte.h
    std::vector<std::array<float, 4>> properties;        ///< RGBA, numbered as attributes of objects are
    int dielectric_priority = 0;                         ///< see scene/nesting.h; 0: takes no part
    std::uint8_t receiver_set = 0, blocker_set = 0;      ///< see Linking
    Linking linking;                                     ///< of the light that its emissive faces are
    bool holdout = false;                                ///< the camera sees a hole where it is

    /// Material of a triangle; slots beyond the list use the last one, as in Blender.
    std::int32_t material_of(const Mesh& m, std::uint32_t triangle) const {
        return materials[slot_of(m, triangle)];
    }
    std::size_t slot_of(const Mesh& m, std::uint32_t triangle) const {
        return std::min(static_cast<std::size_t>(std::max(m.slot(triangle), 0)), materials.size() - 1);
    }
    /// At the frame before (0) or after (1).
    const Transform& neighbour(std::size_t which) const {
        return neighbours ? (*neighbours)[which] : world_from_object;
    }
    Transform world_from_object_at(float time) const {
        return motion.moves() ? motion.at(time) : world_from_object;
    }
    bool mirrored() const { return world_from_object.determinant() < 0; }
};

}  // namespace nephele
