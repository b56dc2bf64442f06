// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/convert.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

namespace nb = nanobind;

namespace nephele::bindings {

namespace {

template <class T>
T value(nb::handle object, const char* attribute) {
    return nb::cast<T>(object.attr(attribute));
}

std::string text(nb::handle object, const char* attribute) {
    return value<std::string>(object, attribute);
}

Rgb rgb(nb::handle object, const char* attribute) {
    const nb::object v = object.attr(attribute);
    return {nb::cast<float>(v[0]), nb::cast<float>(v[1]), nb::cast<float>(v[2])};
}

[[noreturn]] void bad_array(const char* what, const char* wanted) {
    throw std::invalid_argument(std::string(what) + " must be a C-contiguous numpy array of " + wanted);
}

/// A numpy array as a buffer that keeps it alive. Its memory is not copied; releasing it takes the GIL.
template <class T>
Buffer<T> buffer(nb::handle array, const char* what, const char* wanted) {
    if (array.is_none())
        return {};
    nb::ndarray<const T, nb::c_contig, nb::device::cpu> view;
    if (!nb::try_cast(array, view, false))
        bad_array(what, wanted);
    auto* held = new nb::object(nb::borrow(array));
    const std::shared_ptr<const void> owner(held, [](nb::object* o) {
        const nb::gil_scoped_acquire gil;
        delete o;
    });
    return Buffer<T>(view.data(), view.size(), owner);
}
Buffer<float> floats(nb::handle object, const char* attribute) {
    return buffer<float>(object.attr(attribute), attribute, "float32");
}
Buffer<std::int32_t> integers(nb::handle object, const char* attribute) {
    return buffer<std::int32_t>(object.attr(attribute), attribute, "int32");
}

void matrix(nb::handle object, const char* attribute, double (&out)[16]) {
    nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu> view;  // small: a copy will do
    if (!nb::try_cast(object.attr(attribute), view, true))
        bad_array(attribute, "4 x 4 float64");
    std::copy(view.data(), view.data() + 16, out);
}
/// A matrix world_from_...: `origin` becomes the origin of the world.
void placement(nb::handle object, const char* attribute, const std::array<double, 3>& origin,
               double (&out)[16]) {
    matrix(object, attribute, out);
    for (std::size_t a = 0; a < 3; ++a)
        out[4 * a + 3] -= origin[a];
}

template <class Enum>
Enum choice(nb::handle object, const char* attribute,
            std::initializer_list<std::pair<std::string_view, Enum>> items) {
    const std::string given = text(object, attribute);
    for (const auto& [name, item] : items) {
        if (name == given)
            return item;
    }
    throw std::invalid_argument(std::string(attribute) + ": '" + given + "' is not known");
}

/// Applies `convert` to each element, naming the one at fault.
template <class T, class F>
std::vector<T> list(nb::handle object, const char* attribute, F&& convert) {
    std::vector<T> out;
    for (nb::handle item : nb::borrow<nb::object>(object.attr(attribute))) {
        try {
            out.push_back(convert(item));
        } catch (const std::exception& e) {
            const std::string name = nb::hasattr(item, "name") ? " '" + text(item, "name") + "'" : "";
            throw std::invalid_argument(std::string(attribute) + name + ": " + e.what());
        }
    }
    return out;
}

ClosureRow closure_row(nb::handle c) {
    const std::string kind = text(c, "kind");
    const auto* end = kClosureNames + kClosureKindCount;
    const auto* found = std::find(kClosureNames, end, kind);
    if (found == end)
        throw std::invalid_argument("closure '" + kind + "' is not known");
    ClosureRow row;
    row.kind = static_cast<ClosureKind>(found - kClosureNames);
    row.weight = value<std::int16_t>(c, "weight");
    row.mode = value<std::int16_t>(c, "mode");
    const nb::object inputs = c.attr("inputs");
    if (nb::len(inputs) != static_cast<std::size_t>(kClosureInputCounts[found - kClosureNames])) {
        throw std::invalid_argument("closure '" + kind + "' has the wrong number of inputs");
    }
    std::size_t i = 0;
    for (nb::handle input : inputs)
        row.inputs[i++] = nb::cast<std::int16_t>(input);
    return row;
}

std::optional<Program> program(nb::handle p) {
    if (p.is_none())
        return std::nullopt;
    Program out;
    const Buffer<float> registers = floats(p, "registers");
    for (std::size_t i = 0; i + 2 < registers.size(); i += 3) {
        out.registers.emplace_back(registers[i], registers[i + 1], registers[i + 2]);
    }
    const Buffer<std::int32_t> code = integers(p, "code");
    if (code.size() % 8 != 0)
        throw std::invalid_argument("a program's code must have 8 columns");
    for (std::size_t i = 0; i < code.size(); i += 8) {
        out.code.push_back({code[i], code[i + 1], code[i + 2], code[i + 3], code[i + 4], code[i + 5],
                            code[i + 6], code[i + 7]});
    }
    const Buffer<float> parameters = floats(p, "parameters");
    out.parameters.assign(parameters.begin(), parameters.end());
    out.closures = list<ClosureRow>(p, "closures", closure_row);
    return out;
}

PhaseFunction phase_function(nb::handle p) {
    const std::string kind = text(p, "kind");
    const auto* end = kPhaseKindNames + kPhaseKindCount;
    const auto* found = std::find(kPhaseKindNames, end, kind);
    if (found == end)
        throw std::invalid_argument("phase function '" + kind + "' is not known");
    const float a = value<float>(p, "a"), b = value<float>(p, "b");
    if (!std::isfinite(a) || !std::isfinite(b))
        throw std::invalid_argument("a parameter of phase function '" + kind + "' is not finite");
    return make_phase(static_cast<PhaseKind>(found - kPhaseKindNames), a, b);
}

VolumeClosure volume_closure(nb::handle c) {
    const auto grid = [&](const char* attribute) {
        const nb::object name = c.attr(attribute);
        return name.is_none() ? std::string() : nb::cast<std::string>(name);
    };
    VolumeClosure out{rgb(c, "sigma_s"),          rgb(c, "sigma_a"),
                      rgb(c, "emission"),         phase_function(c.attr("phase")),
                      grid("density_grid"),       grid("emission_grid"),
                      program(c.attr("program")), {}};
    for (nb::handle name : nb::borrow<nb::object>(c.attr("grids")))
        out.grids.push_back(nb::cast<std::string>(name));
    return out;
}

/// The closures of a volume; one whose sigma and emission are scaled differently becomes two.
std::vector<VolumeClosure> volume_closures(nb::handle object) {
    std::vector<VolumeClosure> out;
    for (VolumeClosure& c : list<VolumeClosure>(object, "volume", volume_closure)) {
        if (c.program) {
            out.push_back(std::move(c));
            continue;
        }
        const bool emits = !is_zero(c.emission), extinguishes = !is_zero(c.sigma_s) || !is_zero(c.sigma_a);
        if (emits && extinguishes && !(c.density_grid.empty() && c.emission_grid.empty())) {
            out.push_back({{}, {}, c.emission, c.phase, {}, c.emission_grid, {}, {}});
            c.emission = {};
        }
        if (is_zero(c.emission)) {
            c.emission_grid.clear();
        } else {
            c.density_grid.clear();
        }
        out.push_back(std::move(c));
    }
    return out;
}

Mesh mesh(nb::handle m) {
    Mesh out;
    out.name = text(m, "name");
    out.positions = floats(m, "positions");
    out.triangles = integers(m, "triangles");
    out.corner_normals = floats(m, "corner_normals");
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

std::array<float, 4> color(nb::handle object) {
    const nb::object rgba = object.attr("color");
    return {nb::cast<float>(rgba[0]), nb::cast<float>(rgba[1]), nb::cast<float>(rgba[2]),
            nb::cast<float>(rgba[3])};
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
    out.dielectric_priority = value<int>(i, "dielectric_priority");
    return out;
}

VolumeSource volume(nb::handle v, std::size_t material_count, const std::array<double, 3>& origin) {
    VolumeSource out;
    out.name = text(v, "name");
    out.path = text(v, "path");
    placement(v, "world_from_object", origin, out.world_from_object);
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
    return out;
}

CameraDescription camera(nb::handle c) {
    using Kind = CameraDescription::Kind;
    CameraDescription out;
    out.name = text(c, "name");
    out.kind =
        choice<Kind>(c, "kind", {{"perspective", Kind::perspective}, {"orthographic", Kind::orthographic}});
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
    std::array<double, 3> origin{};
    double* m = camera.world_from_camera;
    if (std::max({std::fabs(m[3]), std::fabs(m[7]), std::fabs(m[11])}) < kFar)
        return origin;
    for (std::size_t a = 0; a < 3; ++a) {
        origin[a] = std::round(m[4 * a + 3]);
        m[4 * a + 3] -= origin[a];
    }
    return origin;
}

}  // namespace

SceneSource scene_source_of(nb::handle scene) {
    SceneSource out;
    out.camera = camera(scene.attr("camera"));
    out.origin = move_origin(out.camera);
    out.meshes = list<Mesh>(scene, "meshes", mesh);
    out.materials = list<Material>(scene, "materials", [](nb::handle m) {
        return Material{text(m, "name"), program(m.attr("surface")), volume_closures(m)};
    });
    out.instances = list<Instance>(scene, "instances", [&](nb::handle i) {
        return instance(i, out.meshes.size(), out.materials.size(), out.origin);
    });
    out.volumes = list<VolumeSource>(
        scene, "volumes", [&](nb::handle v) { return volume(v, out.materials.size(), out.origin); });
    out.images = list<Image>(scene, "images", image);
    out.lamps = list<LampDescription>(scene, "lights", [&](nb::handle l) { return lamp(l, out.origin); });
    const nb::object world = scene.attr("world");
    out.world.background = program(world.attr("background"));
    out.world.volume = volume_closures(world);
    out.world.visibility = value<std::uint32_t>(world, "visibility");
    const nb::object shutter = scene.attr("shutter");
    out.shutter_open = nb::cast<float>(shutter[0]);
    out.shutter_close = nb::cast<float>(shutter[1]);
    return out;
}

PassId pass_of(std::string_view name) {
    for (int p = 0; p < kPassCount; ++p) {
        if (name == kPasses[p].name || name == kPasses[p].identifier)
            return static_cast<PassId>(p);
    }
    throw std::invalid_argument("no pass is called '" + std::string(name) + "'");
}

FilmSource film_source_of(nb::handle film) {
    using Falloff = FilmSource::MistFalloff;
    FilmSource out;
    out.width = value<int>(film, "width");
    out.height = value<int>(film, "height");
    out.x1 = out.width;
    out.y1 = out.height;
    if (const nb::object crop = film.attr("crop"); !crop.is_none()) {
        out.x0 = nb::cast<int>(crop[0]);
        out.y0 = nb::cast<int>(crop[1]);
        out.x1 = nb::cast<int>(crop[2]);
        out.y1 = nb::cast<int>(crop[3]);
    }
    out.transparent = value<bool>(film, "transparent");
    for (nb::handle pass : nb::borrow<nb::object>(film.attr("passes")))
        out.passes.push_back(pass_of(nb::cast<std::string>(pass)));
    const nb::object mist = film.attr("mist");
    out.mist_start = nb::cast<float>(mist[0]);
    out.mist_depth = nb::cast<float>(mist[1]);
    const auto falloff = nb::cast<std::string>(mist[2]);
    out.mist_falloff = falloff == "linear"      ? Falloff::linear
                       : falloff == "quadratic" ? Falloff::quadratic
                                                : Falloff::inverse_quadratic;
    return out;
}

Settings settings_of(nb::handle settings) {
    Settings out;
    for (auto [key, item] : nb::cast<nb::dict>(settings)) {
        const auto name = nb::cast<std::string>(key);
        if (nb::isinstance<nb::str>(item)) {
            set_field(out, name, std::string_view(nb::cast<std::string>(item)));
        } else {
            set_field(out, name, nb::cast<double>(nb::float_(nb::borrow(item))));
        }
    }
    return out;
}

}  // namespace nephele::bindings
