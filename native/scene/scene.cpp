// SPDX-License-Identifier: GPL-3.0-or-later
// Builds the scene once: checks what came in, places meshes, loads grids, finds the lights.
#include "scene/scene.h"

#include <algorithm>
#include <stdexcept>

#include "scene/naming.h"

namespace nephele {

namespace {

constexpr std::uint32_t kNoRegion = ~0u;

void check_mesh(const Mesh& mesh) {
    const auto vertices = static_cast<std::int64_t>(mesh.positions.size() / 3);
    for (const std::int32_t i : mesh.triangles) {
        if (i < 0 || i >= vertices)
            throw std::invalid_argument("a triangle names a vertex that does not exist");
    }
    for (const Buffer<float>* positions : {&mesh.positions, &mesh.motion_positions}) {
        for (const float x : *positions) {
            if (!std::isfinite(x))
                throw std::invalid_argument("a vertex is not finite; apply or mend its modifiers");
        }
    }
    const std::size_t n = mesh.triangle_count();
    const auto fits = [](std::size_t size, std::size_t wanted) { return size == 0 || size == wanted; };
    bool good = fits(mesh.corner_normals.size(), 9 * n) && fits(mesh.material_index.size(), n);
    for (const auto& uv : mesh.uvs)
        good &= uv.size() == 6 * n;
    for (const auto& attribute : mesh.attributes)
        good &= attribute.size() == 12 * n;
    if (!mesh.motion_positions.empty() || !mesh.motion_normals.empty()) {
        const std::size_t steps = mesh.motion_steps;
        if (mesh.motion_positions.size() != steps * mesh.positions.size() ||
            !fits(mesh.motion_normals.size(), steps * mesh.corner_normals.size()))
            throw std::invalid_argument("its motion has another number of vertices");
        if (steps < 2 || steps > kMaxMotionSteps)
            throw std::invalid_argument("its motion must have 2 to 129 steps");
    }
    if (!good)
        throw std::invalid_argument("an array does not have one entry per triangle corner");
}

}  // namespace

Scene::Scene(SceneSource source, const Settings& settings) : source_(std::move(source)), settings_(settings) {
    camera_.emplace(source_.camera);
    textures_ = {source_.images,
                 inverse_of(source_.camera.world_from_camera),
                 {static_cast<float>(source_.camera.left), static_cast<float>(source_.camera.right),
                  static_cast<float>(source_.camera.bottom), static_cast<float>(source_.camera.top)},
                 !camera_->perspective(),
                 Vec3f(static_cast<float>(source_.origin[0]), static_cast<float>(source_.origin[1]),
                       static_cast<float>(source_.origin[2])),
                 source_.pixel_width};
    for (const Material& m : source_.materials) {
        if (m.surface)
            naming("material '" + m.name + "'", [&] { validate(*m.surface, source_.images.size()); });
        traits_.push_back(m.surface ? traits_of(*m.surface) : ProgramTraits{});
    }
    if (source_.world.background)
        naming("world", [&] { validate(*source_.world.background, source_.images.size()); });
    add_meshes();
    add_world_region();
    add_volumes();
    add_lights();
    decide_features();
}

void Scene::add_meshes() {
    for (const Mesh& mesh : source_.meshes)
        naming("mesh '" + mesh.name + "'", [&] { check_mesh(mesh); });
    std::vector<std::uint32_t> surfaces, boundaries, dielectrics;
    region_of_instance_.assign(source_.instances.size(), kNoRegion);
    for (std::uint32_t i = 0; i < source_.instances.size(); ++i) {
        drop_priority_of_emitter(source_.instances[i]);
        const Instance& instance = source_.instances[i];
        const auto has = [&](auto test) {
            return std::any_of(instance.materials.begin(), instance.materials.end(), [&](std::int32_t m) {
                return test(m < 0 ? nullptr : &source_.materials[static_cast<std::size_t>(m)]);
            });
        };
        if (instance.dielectric_priority > 0)
            dielectrics.push_back(i);
        else if (has([](const Material* m) { return m == nullptr || m->surface; }))
            surfaces.push_back(i);
        if (!has([](const Material* m) { return m != nullptr && !m->volume.empty(); }))
            continue;
        const auto slot =
            std::find_if(instance.materials.begin(), instance.materials.end(), [&](std::int32_t m) {
                return m >= 0 && !source_.materials[static_cast<std::size_t>(m)].volume.empty();
            });
        const std::vector<VolumeClosure>& closures =
            source_.materials[static_cast<std::size_t>(*slot)].volume;
        const std::size_t before = regions_.size();
        naming("object '" + instance.name + "'", [&] { add_mesh_region(instance, closures); });
        if (regions_.size() == before)
            continue;
        region_of_instance_[i] = static_cast<std::uint32_t>(before);
        boundaries.push_back(i);
    }
    surfaces_.emplace(source_.meshes, source_.instances, surfaces);
    dielectrics_.emplace(source_.meshes, source_.instances, dielectrics, Intersector::Faces::watertight);
    boundaries_.emplace(source_.meshes, source_.instances, boundaries, Intersector::Faces::watertight);
}

}  // namespace nephele
