// SPDX-License-Identifier: GPL-3.0-or-later
// The lights of a scene, and the features that specialise the integrator.
#include <algorithm>

#include "scene/naming.h"
#include "scene/part_keys.h"
#include "scene/scene.h"

namespace nephele {

namespace {

/// Cells of the world's sampling grid, by the largest image behind it.
std::pair<int, int> world_resolution(const Program& program, const std::vector<Image>& images) {
    int width = 256, height = 128;
    for (const Instruction& i : program.code) {
        if (i.op != static_cast<int>(Op::environment) &&
            i.op != static_cast<int>(Op::environment_mirror_ball))
            continue;
        const Image& image =
            images[static_cast<std::size_t>(program.parameters[static_cast<std::size_t>(i.parameter)])];
        width = std::clamp(image.width, width, 4096);
        height = std::clamp(image.height, height, 2048);
    }
    return {width, height};
}

}  // namespace

void Scene::add_lights() {
    std::vector<Lamp> lamps;
    for (const LampDescription& d : source_.lamps) {
        lamps.push_back(prepare_lamp(d));
        add_lamp_shader(d);
    }

    std::vector<MeshLight> mesh_lights;
    add_lights_of_meshes(mesh_lights, lamps.size());

    std::shared_ptr<const EnvironmentLight> world;
    if (source_.world.background) {
        const auto [width, height] = world_resolution(*source_.world.background, source_.images);
        PartKey key;
        add_to(key, *source_.world.background, textures_);
        key.add(source_.world.visibility).add(width).add(height);
        naming("world", [&, w = width, h = height] {
            world = parts_->share<EnvironmentLight>(key, [&] {
                return std::make_shared<EnvironmentLight>([&](Vec3f d) { return background(d, kDiffuseRay); },
                                                          w, h);
            });
        });
    }
    lights_ = LightSet(std::move(lamps), std::move(mesh_lights), std::move(world));
}

void Scene::add_lamp_shader(const LampDescription& lamp) {
    lamp_shaders_.emplace_back();
    if (!lamp.program)
        return;
    naming("light '" + lamp.name + "'", [&] { validate(*lamp.program, source_.images.size()); });
    auto shader = std::make_shared<LampShader>();
    shader->program = *lamp.program;
    shader->instance.name = lamp.name;
    if (lamp.scale(0) * lamp.scale(1) * lamp.scale(2) > 0) {  // else it has no space of its own
        shader->instance.world_from_object = transform_of(lamp.world_from_light);
        shader->instance.object_from_world = inverse_of(lamp.world_from_light);
    }
    shader->instance.random = lamp.random;
    shader->mesh.generated_min = Vec3f(0);
    shader->mesh.generated_size = Vec3f(1);
    lamp_shaders_.back() = std::move(shader);
}

/// The instances whose materials emit, numbered after the lamps.
void Scene::add_lights_of_meshes(std::vector<MeshLight>& lights, std::size_t lamps) {
    mesh_light_of_instance_.assign(source_.instances.size(), kNoLight);
    for (std::size_t i = 0; i < source_.instances.size(); ++i) {
        const Instance& instance = source_.instances[i];
        const Mesh& mesh = source_.meshes[instance.mesh];
        std::vector<float> radiance;  // estimate, by slot
        for (const std::int32_t m : instance.materials) {
            float estimate = 0;
            if (m >= 0 && traits_[static_cast<std::size_t>(m)].emissive) {
                const auto& known = traits_[static_cast<std::size_t>(m)].constant_emission;
                estimate = known ? luminance(*known) : 1.0f;
            }
            radiance.push_back(estimate);
        }
        if (std::none_of(radiance.begin(), radiance.end(), [](float r) { return r > 0; }))
            continue;
        if (instance.motion.moves() || mesh.deforms()) {  // light sampling aims at what stands still
            warnings_.push_back("object '" + instance.name +
                                "': it glows and moves; its light is found by chance alone, with more noise");
            continue;
        }
        PartKey key;
        key.add(mesh.positions).add(mesh.triangles).add(mesh.material_index);
        key.add(instance.world_from_object).add(std::span(radiance));
        const auto choice = parts_->get_or_make<MeshLight::Choice>(key, [&] {
            std::vector<float> of_triangle(mesh.triangle_count());
            for (std::uint32_t t = 0; t < of_triangle.size(); ++t)
                of_triangle[t] = radiance[instance.slot_of(mesh, t)];
            return MeshLight::choice_of(mesh, instance, of_triangle);
        });
        mesh_light_of_instance_[i] = static_cast<std::uint32_t>(lamps + lights.size());
        lights.emplace_back(mesh, instance, choice);
    }
}

void Scene::decide_features() {
    SceneFeatures& f = features_;
    for (const Region& r : regions_)
        f.mesh_media |= r.kind == Region::Kind::mesh;
    for (const Medium& m : media_) {
        f.grids |= m.grid != nullptr;
        f.programs |= m.program != nullptr;
        f.chromatic |= m.program || m.sigma_t != Rgb(m.sigma_t.x) || m.sigma_s != Rgb(m.sigma_s.x);
        f.volume_emission |= m.emits();
    }
    f.media = !media_.empty();
    f.overlap = media_.size() > 1;
    f.surfaces = !surfaces_->empty() || !dielectrics_->empty();
    f.nested_dielectrics = !dielectrics_->empty();
    for (const Instance& instance : source_.instances) {
        const bool any = std::any_of(
            instance.materials.begin(), instance.materials.end(),
            [&](std::int32_t m) { return m < 0 || source_.materials[static_cast<std::size_t>(m)].surface; });
        if (!any && instance.dielectric_priority == 0)
            continue;  // it bounds a volume, and no ray looks for its faces
        f.hidden_surfaces |= (~instance.visibility & 0x3fu) != 0;
        for (const std::int32_t m : instance.materials) {
            if (m < 0)
                continue;
            f.hidden_surfaces |= !source_.materials[static_cast<std::size_t>(m)].surface;
            f.transparent_surfaces |= traits_[static_cast<std::size_t>(m)].may_transmit_straight;
        }
    }
    f.motion |= camera_->moves();  // and where a volume moves or has velocities
    for (const Instance& instance : source_.instances) {
        f.motion |= instance.motion.moves() || source_.meshes[instance.mesh].deforms();
        f.holdouts |= instance.holdout;
    }
    f.lamps = !lights_.lamps().empty();
    for (std::uint32_t i = 0; i < lights_.lamps().size(); ++i) {
        const Lamp& lamp = lights_.lamp(i);
        f.camera_lamps |= (lamp.visibility & kCameraRay) != 0 && !lamp.delta();
        f.lamp_shaders |= lamp_shaders_[i] != nullptr;
        f.motion |= lamp.motion.moves();
    }
    for (std::uint32_t i = 0; lights_.linked() && i < lights_.size(); ++i) {
        f.light_linking |= lights_.linking(i).receivers != Linking::kAll;
        f.shadow_linking |= lights_.linking(i).blockers != Linking::kAll;
    }
    f.mesh_lights = !lights_.meshes().empty();
    f.background = lights_.world() != nullptr && !lights_.world()->black();
}

namespace {

struct FeatureName {
    const char* name;
    bool SceneFeatures::*flag;
};
constexpr FeatureName kFeatureNames[] = {
    {"media", &SceneFeatures::media},
    {"grids", &SceneFeatures::grids},
    {"mesh media", &SceneFeatures::mesh_media},
    {"overlap", &SceneFeatures::overlap},
    {"volume programs", &SceneFeatures::programs},
    {"chromatic", &SceneFeatures::chromatic},
    {"volume emission", &SceneFeatures::volume_emission},
    {"surfaces", &SceneFeatures::surfaces},
    {"transparent surfaces", &SceneFeatures::transparent_surfaces},
    {"hidden surfaces", &SceneFeatures::hidden_surfaces},
    {"nested dielectrics", &SceneFeatures::nested_dielectrics},
    {"lamps", &SceneFeatures::lamps},
    {"mesh lights", &SceneFeatures::mesh_lights},
    {"background", &SceneFeatures::background},
    {"lamps that the camera sees", &SceneFeatures::camera_lamps},
    {"lamp shaders", &SceneFeatures::lamp_shaders},
    {"light linking", &SceneFeatures::light_linking},
    {"shadow linking", &SceneFeatures::shadow_linking},
    {"holdouts", &SceneFeatures::holdouts},
    {"motion", &SceneFeatures::motion},
};

}  // namespace

std::vector<std::string> SceneFeatures::list(bool present) const {
    std::vector<std::string> names;
    for (const FeatureName& f : kFeatureNames) {
        if (this->*f.flag == present)
            names.emplace_back(f.name);
    }
    return names;
}

}  // namespace nephele
