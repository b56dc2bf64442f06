// SPDX-License-Identifier: GPL-3.0-or-later
// How far the instances of a hierarchy reach while the shutter is open: what rounding near them is relative
// to.
#pragma once

#include <span>
#include <vector>

#include "scene/mesh.h"

namespace nephele {

/// Largest coordinate of a mesh in its own space.
inline float reach_of(const Mesh& mesh) {
    float reach = 0;
    for (const Buffer<float>* positions : {&mesh.positions, &mesh.motion_positions}) {
        for (const float x : *positions)
            reach = std::max(reach, std::fabs(x));
    }
    return reach;
}

/// Calls visit(world_from_object, object_from_world) for all placements that an instance's are between.
template <class Visit>
void for_each_placement(const Instance& instance, Visit&& visit) {
    visit(instance.world_from_object, instance.object_from_world);
    for (const Transform& step : instance.motion.steps())
        visit(step, inverse_of(step));
}

/// Bound on the coordinates in the world of what reaches `own` in the space of an object.
inline float reach_of(const Transform& world_from_object, float own) {
    float reach = 0;
    for (int a = 0; a < 3; ++a) {
        const Vec3f row = world_from_object.row[static_cast<std::size_t>(a)];
        reach = std::max(reach, std::fabs(world_from_object.translation[a]) +
                                    own * (std::fabs(row.x) + std::fabs(row.y) + std::fabs(row.z)));
    }
    return reach;
}

/// Bound on the coordinates of an instance in the world. mesh_reach: reach_of its mesh.
inline float reach_of(const Instance& instance, float mesh_reach) {
    float reach = 0;
    for_each_placement(instance, [&](const Transform& m, const Transform&) {
        reach = std::max(reach, reach_of(m, mesh_reach));
    });
    return reach;
}

/// Largest coordinate of the instances in the world.
inline float reach_of(std::span<const Mesh> meshes, std::span<const Instance> instances,
                      std::span<const std::uint32_t> used) {
    std::vector<float> of_mesh(meshes.size(), -1);
    float reach = 0;
    for (const std::uint32_t i : used) {
        float& own = of_mesh[instances[i].mesh];
        if (own < 0)
            own = reach_of(meshes[instances[i].mesh]);
        reach = std::max(reach, reach_of(instances[i], own));
    }
    return reach;
}

/// The most that a metre of the world measures in a mesh's own space, among its instances.
inline float object_scale(std::span<const Instance> instances, std::span<const std::uint32_t> used,
                          std::uint32_t mesh) {
    float scale = 0;
    for (const std::uint32_t i : used) {
        if (instances[i].mesh != mesh)
            continue;
        for_each_placement(instances[i], [&](const Transform&, const Transform& object_from_world) {
            for (const Vec3f row : object_from_world.row)
                scale = std::max(scale, length(row));
        });
    }
    return scale;
}

}  // namespace nephele
