// SPDX-License-Identifier: GPL-3.0-or-later
// Media of the scene's regions: what the volume closures of the world, of meshes and of volume objects
// become.
#include <algorithm>

#include "scene/naming.h"
#include "scene/part_keys.h"
#include "scene/scene.h"

namespace nephele {

namespace {

void check_closure(const VolumeClosure& c) {
    for (const Rgb& v : {c.sigma_s, c.sigma_a, c.emission}) {
        if (!is_finite(v) || min_component(v) < 0) {
            throw std::invalid_argument("a coefficient of its volume shader is negative or not finite");
        }
    }
}

/// How far a volume of the world that varies reaches at most, m.
constexpr float kWorldReach = 1e4f;

/// Media that vary alike and scatter alike are one.
bool mergeable(const Medium& a, const Medium& b) {
    return !a.program && !b.program && a.grid == b.grid &&
           a.density_scales_emission == b.density_scales_emission && a.phase == b.phase;
}

/// The box of an instance as at the frame, whatever the shape of its mesh while the shutter is open.
void include_instance(const Instance& instance, const Mesh& mesh, Vec3f& lo, Vec3f& hi) {
    for (const Buffer<float>* positions : {&mesh.positions, &mesh.motion_positions}) {
        for (std::size_t i = 0; i + 2 < positions->size(); i += 3) {
            const Vec3f p =
                instance.world_from_object.point({(*positions)[i], (*positions)[i + 1], (*positions)[i + 2]});
            lo = min(lo, p);
            hi = max(hi, p);
        }
    }
}

}  // namespace

Medium Scene::constant_medium(const VolumeClosure& c, float scale) const {
    check_closure(c);
    Medium medium;
    medium.sigma_s = c.sigma_s * scale;
    medium.sigma_t = (c.sigma_s + c.sigma_a) * scale;
    medium.emission = c.emission * scale;
    medium.phase = c.phase;
    return medium;
}

Medium Scene::program_medium(const VolumeClosure& c, float scale, VolumeFields fields,
                             const ShadingPoint& place, const BoundsFrame& frame) {
    validate(*c.program, source_.images.size());
    PartKey key;
    add_to(key, *c.program, textures_);
    key.add(scale);
    fields.add_to(key);
    Medium medium;
    medium.program =
        std::make_shared<ProgramMedium>(*c.program, c.program_has_phase ? nullptr : &c.phase,
                                        std::move(fields), scale, place, textures_, image_bounds());
    if (medium.program->interacts() || medium.program->emits()) {
        add_to(key, place);
        add_to(key, frame, bounds_options());
        medium.bounds = parts_->share<MediumBounds>(
            key, [&] { return bounds_of_program(*medium.program, frame, bounds_options()); });
    }
    return medium;
}

BoundsOptions Scene::bounds_options() const {
    BoundsOptions options;
    if (settings_.majorant == Settings::Majorant::kdtree)
        options.accelerator = Accelerator::kdtree;
    options.minorants = settings_.tracking == Settings::Tracking::decomposition ||
                        settings_.transmittance != Settings::Transmittance::ratio;
    return options;
}

std::span<const ImageBounds> Scene::image_bounds() {
    if (image_bounds_.empty()) {
        for (const Image& image : source_.images) {
            PartKey key;
            add_to(key, image);
            image_bounds_.push_back(
                *parts_->get_or_make<ImageBounds>(key, [&] { return ImageBounds(image); }));
        }
    }
    return image_bounds_;
}

void Scene::add_region(Region region, std::vector<Medium> media) {
    region.media_begin = static_cast<std::uint32_t>(media_.size());
    for (Medium& medium : media) {
        if (!medium.interacts() && !medium.emits())
            continue;
        medium.name = region.name;
        medium.region = static_cast<std::uint32_t>(regions_.size());
        const auto same = std::find_if(media_.begin() + region.media_begin, media_.end(),
                                       [&](const Medium& m) { return mergeable(m, medium); });
        if (same == media_.end()) {
            media_.push_back(std::move(medium));
            continue;
        }
        same->sigma_s += medium.sigma_s;
        same->sigma_t += medium.sigma_t;
        same->emission += medium.emission;
    }
    region.media_end = static_cast<std::uint32_t>(media_.size());
    if (region.media_begin != region.media_end)
        regions_.push_back(std::move(region));
}

void Scene::add_mesh_region(const Instance& instance, const std::vector<VolumeClosure>& closures) {
    const Mesh& mesh = source_.meshes[instance.mesh];
    Region region(instance.name, Region::Kind::mesh, instance.visibility);
    region.receiver_set = instance.receiver_set;
    region.blocker_set = instance.blocker_set;
    std::vector<Medium> media;
    for (const VolumeClosure& c : closures) {  // a mesh has no grids: the factor is 1
        if (!c.program) {
            media.push_back(constant_medium(c, 1));
            continue;
        }
        ShadingPoint place;
        place.instance = &instance;
        place.mesh = &mesh;
        Vec3f lo(kInfinity), hi(-kInfinity);
        include_instance(instance, mesh, lo, hi);
        if (hi.x > lo.x && hi.y > lo.y && hi.z > lo.z)
            media.push_back(program_medium(c, 1, {}, place, frame_of_box(lo, hi)));
        if (instance.motion.moves())
            region.mover = &instance;
    }
    add_region(std::move(region), std::move(media));
}

/// Constant media of the world are endless. What varies is bounded over a box; beyond the camera's far end
/// nothing of it is left.
void Scene::add_world_region() {
    std::vector<Medium> constant;
    for (const VolumeClosure& c : source_.world.volume) {
        if (!c.program) {
            naming("world", [&] { constant.push_back(constant_medium(c, 1)); });
            continue;
        }
        const float reach = std::min(source_.camera.clip_end, kWorldReach);
        const Vec3f eye = camera_->position();
        Region region("world", Region::Kind::box, source_.world.visibility);
        const BoundsFrame frame = frame_of_box(eye - Vec3f(reach), eye + Vec3f(reach));
        region.set_box(frame.box, frame.index_from_world);
        naming("world", [&] { add_region(std::move(region), {program_medium(c, 1, {}, {}, frame)}); });
        warnings_.push_back("world: its volume varies from place to place, and ends " +
                            std::to_string(static_cast<int>(reach)) +
                            " m from the camera; bound it with a mesh instead");
    }
    add_region(Region("world", Region::Kind::world, source_.world.visibility), std::move(constant));
}

}  // namespace nephele
