// SPDX-License-Identifier: GPL-3.0-or-later
// What stands in the scene: meshes, instances, volumes, lamps, the camera.
#include "bindings/convert.h"

#include <tuple>

#include "bindings/attributes.h"
#include "film/matte.h"

namespace nephele::bindings {

namespace {

Mesh mesh(nb::handle m) {
    Mesh out;
    out.name = text(m, "name");
    out.positions = floats(m, "positions");
    out.triangles = integers(m, "triangles");
    out.corner_normals = floats(m, "corner_normals");
    out.motion_positions = floats(m, "motion");
    out.motion_normals = floats(m, "motion_normals");
    out.neighbours = floats(m, "neighbours");
    if (!out.neighbours.empty() && out.neighbours.size() != 2 * out.positions.size())
        throw std::invalid_argument("neighbours must be (2, N, 3), N its number of vertices");
    if (!out.positions.empty())
        out.motion_steps = out.motion_positions.size() / out.positions.size();
    const auto arrays = [&](const char* attribute) {
        return list<Buffer<float>>(m, attribute,
                                   [&](nb::handle a) { return buffer<float>(a, attribute, "float32"); });
    };
    out.uvs = arrays("uvs");
    out.attributes = arrays("attributes");
    out.material_index = integers(m, "material_index");
    out.generated_min = rgb(m, "generated_min");
    out.generated_size = rgb(m, "generated_size");
    return out;
}

std::array<float, 4> four(const nb::object& rgba) {
    return {nb::cast<float>(rgba[0]), nb::cast<float>(rgba[1]), nb::cast<float>(rgba[2]),
            nb::cast<float>(rgba[3])};
}
std::uint8_t set_number(nb::handle object, const char* attribute) {
    const int number = value<int>(object, attribute);
    if (number < 0 || number > 63)
        throw std::invalid_argument(std::string("'") + attribute + "' must be 0 to 63");
    return static_cast<std::uint8_t>(number);
}
Linking linking(nb::handle light) {
    return {value<std::uint64_t>(light, "receivers"), value<std::uint64_t>(light, "blockers")};
}
std::array<float, 4> color(nb::handle object) {
    return four(object.attr("color"));
}

std::optional<std::array<Transform, 2>> neighbours(nb::handle object, const std::array<double, 3>& origin) {
    const auto matrices = motion_matrices(object, origin, "neighbours");
    if (matrices.empty())
        return std::nullopt;
    if (matrices.size() != 2)
        throw std::invalid_argument("neighbours must be 2 x 4 x 4: of the frames before and after");
    std::array<Transform, 2> out;
    for (std::size_t n = 0; n < 2; ++n) {
        double m[16];
        std::copy(matrices[n].begin(), matrices[n].end(), m);
        out[n] = transform_of(m);
    }
    return out;
}

Instance instance(nb::handle i, std::size_t mesh_count, std::size_t material_count,
                  const std::array<double, 3>& origin) {
    Instance out;
    out.name = text(i, "name");
    out.mesh = value<std::uint32_t>(i, "mesh");
    if (out.mesh >= mesh_count)
        throw std::invalid_argument("its mesh does not exist");
    double m[16];
    placement(i, "world_from_object", origin, m);
    out.world_from_object = transform_of(m);
    out.object_from_world = inverse_of(m);
    if (const auto motion = motion_matrices(i, origin); !motion.empty())
        out.motion = Motion(motion);
    for (nb::handle material : nb::borrow<nb::object>(i.attr("materials"))) {
        const auto number = nb::cast<std::int32_t>(material);
        if (number < -1 || number >= static_cast<std::int32_t>(material_count)) {
            throw std::invalid_argument("its material does not exist");
        }
        out.materials.push_back(number);
    }
    if (out.materials.empty())
        out.materials.push_back(-1);
    out.visibility = value<std::uint32_t>(i, "visibility");
    out.random = value<float>(i, "random");
    out.color = color(i);
    out.pass_index = value<float>(i, "pass_index");
    out.neighbours = neighbours(i, origin);
    const std::string asset = text(i, "asset");
    out.object_matte = matte_id(out.name);
    out.asset_matte = asset.empty() ? out.object_matte : matte_id(asset);
    out.properties = list<std::array<float, 4>>(
        i, "properties", [](nb::handle rgba) { return four(nb::borrow<nb::object>(rgba)); });
    out.dielectric_priority = value<int>(i, "dielectric_priority");
    out.receiver_set = set_number(i, "receiver_set");
    out.blocker_set = set_number(i, "blocker_set");
    out.linking = linking(i);
    out.holdout = value<bool>(i, "holdout");
    return out;
}

VolumeSource volume(nb::handle v, std::size_t material_count, const std::array<double, 3>& origin) {
    VolumeSource out;
    out.name = text(v, "name");
    out.path = text(v, "path");
    placement(v, "world_from_object", origin, out.world_from_object);
    if (const auto motion = motion_matrices(v, origin); !motion.empty())
        out.motion = Motion(motion);
    out.material = value<std::uint32_t>(v, "material");
    if (out.material >= material_count)
        throw std::invalid_argument("its material does not exist");
    out.density_scale = value<float>(v, "density_scale");
    out.visibility = value<std::uint32_t>(v, "visibility");
    using Precision = GridOptions::Precision;
    out.options.precision = choice<Precision>(
        v, "precision", {{"file", Precision::file}, {"half", Precision::half}, {"full", Precision::full}});
    out.options.clipping = value<float>(v, "clipping");
    for (nb::handle name : nb::borrow<nb::object>(v.attr("velocity_grids")))
        out.velocity_grids.push_back(nb::cast<std::string>(name));
    out.velocity_scale = value<float>(v, "velocity_scale");
    out.generated_min = rgb(v, "generated_min");
    out.generated_size = rgb(v, "generated_size");
    out.random = value<float>(v, "random");
    out.color = color(v);
    out.pass_index = value<float>(v, "pass_index");
    out.receiver_set = set_number(v, "receiver_set");
    out.blocker_set = set_number(v, "blocker_set");
    return out;
}

Image image(nb::handle i) {
    Image out;
    out.name = text(i, "name");
    const nb::object pixels = i.attr("pixels");
    const nb::object shape = pixels.attr("shape");
    if (nb::len(shape) != 3 || nb::cast<int>(shape[2]) != 4)
        throw std::invalid_argument("pixels must be (height, width, 4)");
    out.height = nb::cast<int>(shape[0]);
    out.width = nb::cast<int>(shape[1]);
    nb::ndarray<const std::uint8_t, nb::c_contig, nb::device::cpu> bytes;
    if (nb::try_cast(pixels, bytes, false)) {
        out.bytes = buffer<std::uint8_t>(pixels, "pixels", "uint8");
    } else {
        out.floats = buffer<float>(pixels, "pixels", "uint8 or float32");
    }
    out.srgb = value<bool>(i, "srgb");
    return out;
}

LampDescription lamp(nb::handle l, const std::array<double, 3>& origin) {
    using Kind = LampDescription::Kind;
    LampDescription out;
    out.name = text(l, "name");
    out.kind = choice<Kind>(
        l, "kind", {{"point", Kind::point}, {"sun", Kind::sun}, {"spot", Kind::spot}, {"area", Kind::area}});
    placement(l, "world_from_light", origin, out.world_from_light);
    out.power = rgb(l, "power");
    out.normalize = value<bool>(l, "normalize");
    out.radius = value<float>(l, "radius");
    out.soft_falloff = value<bool>(l, "soft_falloff");
    out.angle = value<float>(l, "angle");
    out.spot_size = value<float>(l, "spot_size");
    out.spot_blend = value<float>(l, "spot_blend");
    out.ellipse = choice<bool>(l, "shape", {{"rectangle", false}, {"ellipse", true}});
    const nb::object size = l.attr("size");
    out.size_x = nb::cast<float>(size[0]);
    out.size_y = nb::cast<float>(size[1]);
    out.spread = value<float>(l, "spread");
    out.visibility = value<std::uint32_t>(l, "visibility");
    out.cast_shadow = value<bool>(l, "cast_shadow");
    out.max_bounces = value<int>(l, "max_bounces");
    out.random = value<float>(l, "random");
    out.linking = linking(l);
    out.program = program_of(l.attr("program"));
    out.motion = motion_matrices(l, origin);
    return out;
}

Panorama panorama(nb::handle c) {
    using Lens = Panorama::Lens;
    Panorama out;
    out.lens = choice<Lens>(c, "lens",
                            {{"equirectangular", Lens::equirectangular},
                             {"fisheye_equidistant", Lens::fisheye_equidistant},
                             {"fisheye_equisolid", Lens::fisheye_equisolid},
                             {"fisheye_polynomial", Lens::fisheye_polynomial},
                             {"mirror_ball", Lens::mirror_ball},
                             {"equiangular_cubemap", Lens::equiangular_cubemap},
                             {"central_cylindrical", Lens::central_cylindrical}});
    std::size_t count = 0;
    for (nb::handle v : nb::borrow<nb::object>(c.attr("lens_values"))) {
        if (count == out.values.size())
            throw std::invalid_argument("'lens_values' are more than a lens has");
        out.values[count++] = nb::cast<double>(v);
    }
    return out;
}

CameraDescription camera(nb::handle c) {
    using Kind = CameraDescription::Kind;
    CameraDescription out;
    out.name = text(c, "name");
    out.kind = choice<Kind>(c, "kind",
                            {{"perspective", Kind::perspective},
                             {"orthographic", Kind::orthographic},
                             {"panoramic", Kind::panoramic}});
    if (out.kind == Kind::panoramic)
        out.panorama = panorama(c);
    matrix(c, "world_from_camera", out.world_from_camera);
    const nb::object viewplane = c.attr("viewplane");
    out.left = nb::cast<double>(viewplane[0]);
    out.right = nb::cast<double>(viewplane[1]);
    out.bottom = nb::cast<double>(viewplane[2]);
    out.top = nb::cast<double>(viewplane[3]);
    out.clip_start = value<float>(c, "clip_start");
    out.clip_end = value<float>(c, "clip_end");
    out.aperture_radius = value<float>(c, "aperture_radius");
    out.blades = value<int>(c, "blades");
    out.blades_rotation = value<float>(c, "blades_rotation");
    out.aperture_ratio = value<float>(c, "aperture_ratio");
    out.focus_distance = value<float>(c, "focus_distance");
    return out;
}

/// Far from the origin single precision is coarse (6 cm at 1000 km): there the world is moved, so that the
/// camera is near its origin. Returns what became the origin.
std::array<double, 3> move_origin(CameraDescription& camera) {
    constexpr double kFar = 4096;
    constexpr double kCell = 1024;  // as the camera moves about in one, nothing else does
    std::array<double, 3> origin{};
    double* m = camera.world_from_camera;
    if (!std::isfinite(m[3] + m[7] + m[11]))
        return origin;  // which is refused later
    if (std::max({std::fabs(m[3]), std::fabs(m[7]), std::fabs(m[11])}) < kFar)
        return origin;
    for (std::size_t a = 0; a < 3; ++a) {
        origin[a] = kCell * std::round(m[4 * a + 3] / kCell);
        m[4 * a + 3] -= origin[a];
    }
    return origin;
}

}  // namespace

namespace {

WorldSource world_of(nb::handle world) {
    WorldSource out;
    out.background = program_of(world.attr("background"));
    out.volume = volume_closures_of(world);
    out.visibility = value<std::uint32_t>(world, "visibility");
    return out;
}

}  // namespace

SceneSource scene_source_of(nb::handle scene) {
    SceneSource out;
    out.camera = reading("camera", [&] { return camera(scene.attr("camera")); });
    out.origin = move_origin(out.camera);
    const int columns = std::max(1, reading("film", [&] { return value<int>(scene.attr("film"), "width"); }));
    out.pixel_width = static_cast<float>((out.camera.right - out.camera.left) / columns);
    if (out.camera.kind == CameraDescription::Kind::panoramic)
        out.pixel_width *= 2 * kPi;  // an angle: its picture is a square of 1, and shows all round or less
    out.camera.neighbours =
        reading("neighbours", [&] { return neighbours(scene.attr("camera"), out.origin); });
    out.camera.motion = reading("motion", [&] { return motion_matrices(scene.attr("camera"), out.origin); });
    out.meshes = list<Mesh>(scene, "meshes", mesh);
    out.materials = list<Material>(scene, "materials", [](nb::handle m) {
        std::string name = text(m, "name");
        const std::uint32_t matte = matte_id(name);
        return Material{std::move(name), program_of(m.attr("surface")), volume_closures_of(m),
                        value<float>(m, "pass_index"), matte};
    });
    out.instances = list<Instance>(scene, "instances", [&](nb::handle i) {
        return instance(i, out.meshes.size(), out.materials.size(), out.origin);
    });
    out.volumes = list<VolumeSource>(
        scene, "volumes", [&](nb::handle v) { return volume(v, out.materials.size(), out.origin); });
    out.images = list<Image>(scene, "images", image);
    out.lamps = list<LampDescription>(scene, "lights", [&](nb::handle l) { return lamp(l, out.origin); });
    out.world = reading("world", [&] { return world_of(scene.attr("world")); });
    out.shutter_curve = reading("shutter_curve", [&] {
        std::vector<float> curve;
        for (nb::handle time : nb::borrow<nb::object>(scene.attr("shutter_curve")))
            curve.push_back(std::clamp(nb::cast<float>(time), 0.0f, 1.0f));
        if (curve.size() == 1)
            throw std::invalid_argument("'shutter_curve' must have no value, or two or more");
        return curve;
    });
    std::tie(out.shutter_open, out.shutter_close) = reading("shutter", [&] {
        const nb::object shutter = scene.attr("shutter");
        return std::pair(nb::cast<float>(shutter[0]), nb::cast<float>(shutter[1]));
    });
    return out;
}

}  // namespace nephele::bindings
