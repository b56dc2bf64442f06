// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes, instances and scene sources for tests.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace nephele::test {

inline Mesh mesh_of(std::string name, std::vector<float> positions, std::vector<std::int32_t> triangles) {
    Mesh mesh;
    mesh.name = std::move(name);
    mesh.positions = Buffer<float>(std::move(positions));
    mesh.triangles = Buffer<std::int32_t>(std::move(triangles));
    mesh.generated_size = Vec3f(1);
    return mesh;
}

/// A closed box, faces outwards (inwards where `inwards`); each side is two triangles.
inline Mesh box_mesh(Vec3f low, Vec3f high, bool inwards = false) {
    std::vector<float> positions;
    for (int i = 0; i < 8; ++i) {
        for (int a = 0; a < 3; ++a)
            positions.push_back((i >> a & 1) != 0 ? high[a] : low[a]);
    }
    const int quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    std::vector<std::int32_t> triangles;
    for (const auto& q : quads) {
        for (const int corner : {0, inwards ? 2 : 1, inwards ? 1 : 2, 0, inwards ? 3 : 2, inwards ? 2 : 3})
            triangles.push_back(q[corner]);
    }
    return mesh_of("box", positions, triangles);
}

/// A closed ball of radius 1 around the origin, faces outwards, poles on z.
inline Mesh ball_mesh(int rows, int columns) {
    std::vector<float> positions{0, 0, 1};
    std::vector<std::int32_t> triangles;
    for (int i = 1; i < rows; ++i) {
        for (int j = 0; j < columns; ++j) {
            const double theta = M_PI * i / rows, phi = 2 * M_PI * j / columns;
            for (const double x :
                 {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)})
                positions.push_back(static_cast<float>(x));
        }
    }
    positions.insert(positions.end(), {0, 0, -1});
    const auto at = [&](int i, int j) {
        return i == 0 ? 0 : i == rows ? 1 + (rows - 1) * columns : 1 + (i - 1) * columns + j % columns;
    };
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < columns; ++j) {
            if (i + 1 < rows)
                triangles.insert(triangles.end(), {at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            if (i > 0)
                triangles.insert(triangles.end(), {at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
    return mesh_of("ball", positions, triangles);
}

/// Appends b to a.
inline Mesh joined(const Mesh& a, const Mesh& b) {
    std::vector<float> positions(a.positions.begin(), a.positions.end());
    std::vector<std::int32_t> triangles(a.triangles.begin(), a.triangles.end());
    const auto offset = static_cast<std::int32_t>(positions.size() / 3);
    positions.insert(positions.end(), b.positions.begin(), b.positions.end());
    for (const std::int32_t i : b.triangles)
        triangles.push_back(i + offset);
    return mesh_of("joined", positions, triangles);
}

/// Places a mesh by scale, then translation.
inline Instance instance_of(std::uint32_t mesh, Vec3f scale = Vec3f(1), Vec3f move = Vec3f(0)) {
    const double m[16] = {double{scale.x},
                          0,
                          0,
                          double{move.x},
                          0,
                          double{scale.y},
                          0,
                          double{move.y},
                          0,
                          0,
                          double{scale.z},
                          double{move.z},
                          0,
                          0,
                          0,
                          1};
    Instance out;
    out.name = "instance";
    out.mesh = mesh;
    out.world_from_object = transform_of(m);
    out.object_from_world = inverse_of(m);
    out.materials = {-1};
    return out;
}

/// A scene of one mesh that bounds a medium without surface.
inline SceneSource fog_in(Mesh mesh, Vec3f scale = Vec3f(1)) {
    SceneSource source;
    source.meshes.push_back(std::move(mesh));
    source.instances.push_back(instance_of(0, scale));
    source.instances.front().materials = {0};
    Material fog;
    fog.name = "fog";
    fog.volume.emplace_back().sigma_s = Rgb(1);
    source.materials.push_back(fog);
    return source;
}

/// Fog in a box on a floor under a lamp, seen from above: all that a render learns is learned here.
inline SceneSource lit_fog() {
    SceneSource source = fog_in(box_mesh(Vec3f(-1), Vec3f(1)));
    source.meshes.push_back(box_mesh(Vec3f(-4, -4, -1.2f), Vec3f(4, 4, -1)));
    source.instances.push_back(instance_of(1));
    LampDescription lamp;
    lamp.name = "lamp";
    lamp.kind = LampDescription::Kind::point;
    lamp.power = Rgb(100);
    lamp.radius = 0.1f;
    const double at_the_side[16] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 3, 0, 0, 0, 1};
    std::copy(std::begin(at_the_side), std::end(at_the_side), lamp.world_from_light);
    source.lamps.push_back(lamp);
    const double above[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5, 0, 0, 0, 1};
    std::copy(std::begin(above), std::end(above), source.camera.world_from_camera);
    source.camera.left = source.camera.bottom = -0.5;
    source.camera.right = source.camera.top = 0.5;
    return source;
}

}  // namespace nephele::test
