// SPDX-License-Identifier: GPL-3.0-or-later
// Builds the scene once: checks what came in, places meshes, loads grids, finds the lights.
#include "scene/scene.h"

#include <algorithm>
#include <stdexcept>

#include "scene/naming.h"
#include "scene/reach.h"

namespace nephele {

namespace {

constexpr std::uint32_t kNoRegion = ~0u;

void check_mesh(const Mesh& mesh) {
    const auto vertices = static_cast<std::int64_t>(mesh.positions.size() / 3);
    for (const std::int32_t i : mesh.triangles) {
        if (i < 0 || i >= vertices)
            throw std::invalid_argument("a triangle names a vertex that does not exist");
    }
    const auto check_finite = [](const Buffer<float>& values, const char* fault) {
        if (!std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); }))
            throw std::invalid_argument(fault);
    };
    for (const Buffer<float>* positions : {&mesh.positions, &mesh.motion_positions})
        check_finite(*positions, "a vertex is not finite; apply or mend its modifiers");
    for (const Buffer<float>* normals : {&mesh.corner_normals, &mesh.motion_normals})
        check_finite(*normals, "a normal is not finite; clear its custom normals");
    for (const Buffer<float>& uv : mesh.uvs)
        check_finite(uv, "a UV coordinate is not finite; unwrap it anew");
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

/// Refuses what no ray could reach: see Intersector.
void check_reach(const Instance& instance, float mesh_reach) {
    if (!(reach_of(instance, mesh_reach) < Intersector::kFarthest))
        throw std::invalid_argument(
            "it reaches further than 1e18 m from the camera; check its transform and its vertices");
}

}  // namespace

Scene::Scene(SceneSource source, const Settings& settings, PartCache* parts)
    : source_(std::move(source)), settings_(settings) {
    PartCache none;
    PartScope scope(parts != nullptr ? *parts : none);
    parts_ = &scope;
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
    parts_ = nullptr;
    scope.commit();
}

/// Returns how far each mesh reaches; see reach_of().
std::vector<float> Scene::check_meshes() {
    struct Checked {
        float reach;
    };
    std::vector<float> reaches;
    for (const Mesh& mesh : source_.meshes) {
        PartKey key;
        key.add(mesh.positions).add(mesh.triangles).add(mesh.corner_normals).add(mesh.material_index);
        key.add(mesh.motion_steps).add(mesh.motion_positions).add(mesh.motion_normals);
        for (const auto* layers : {&mesh.uvs, &mesh.attributes}) {
            key.add(layers->size());
            for (const Buffer<float>& layer : *layers)
                key.add(layer);
        }
        naming("mesh '" + mesh.name + "'", [&] {
            const auto checked = parts_->get_or_make<Checked>(key, [&] {
                check_mesh(mesh);
                return Checked{reach_of(mesh)};
            });
            reaches.push_back(checked->reach);
        });
    }
    return reaches;
}

void Scene::add_meshes() {
    const std::vector<float> reaches = check_meshes();
    for (const Instance& instance : source_.instances)
        naming("object '" + instance.name + "'", [&] { check_reach(instance, reaches[instance.mesh]); });
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
    const auto layout = settings_.hierarchy == Settings::Hierarchy::by_mesh ? Intersector::Layout::by_mesh
                                                                            : Intersector::Layout::whole;
    using Faces = Intersector::Faces;
    const auto build = [&](const char* role, std::span<const std::uint32_t> used, Faces faces) {
        return Intersector::shared(*parts_, role, source_.meshes, source_.instances, used, faces, layout);
    };
    surfaces_ = build("surfaces", surfaces, Faces::fast);
    dielectrics_ = build("dielectrics", dielectrics, Faces::watertight);
    boundaries_ = build("boundaries", boundaries, Faces::watertight);
}

}  // namespace nephele
