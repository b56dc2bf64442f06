// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/shading_inputs.h"

#include "scene/mesh.h"
#include "surfaces/fresnel.h"

namespace nephele {
namespace {

/// Values of `width` floats a corner, of number `index` among a mesh's, interpolated; null where there is
/// none.
template <int width>
bool interpolate(const std::vector<Buffer<float>>& layers, std::int32_t index, const ShadingPoint& point,
                 float (&out)[width]) {
    if (index < 0 || static_cast<std::size_t>(index) >= layers.size())
        return false;
    const float* corner =
        layers[static_cast<std::size_t>(index)].data() + 3 * std::size_t{width} * point.triangle;
    for (int k = 0; k < width; ++k) {
        out[k] = corner[k] * point.barycentric.x + corner[width + k] * point.barycentric.y +
                 corner[2 * width + k] * point.barycentric.z;
    }
    return true;
}

Vec3f uv_of(std::int32_t index, const ShadingPoint& point) {
    float uv[2];
    if (!point.mesh || !interpolate(point.mesh->uvs, index, point, uv))
        return Vec3f(0);
    return {uv[0], uv[1], 0};
}

Vec3f attribute_of(std::int32_t index, const ShadingPoint& point, bool alpha) {
    float rgba[4];
    if (!point.mesh || !interpolate(point.mesh->attributes, index, point, rgba))
        return Vec3f(0);
    return alpha ? Vec3f(rgba[3]) : Vec3f(rgba[0], rgba[1], rgba[2]);
}

Vec3f generated(const ShadingPoint& point) {
    if (!point.mesh)
        return point.object_p;
    const Vec3f size = point.mesh->generated_size, from = point.object_p - point.mesh->generated_min;
    return {size.x != 0 ? from.x / size.x : 0, size.y != 0 ? from.y / size.y : 0,
            size.z != 0 ? from.z / size.z : 0};
}

/// Whether the point lies on a triangle: the mesh of a volume has none.
bool on_triangle(const ShadingPoint& point) {
    return point.instance && point.mesh && point.triangle < point.mesh->triangle_count();
}

/// The point in the space of the camera's own axes (it looks along -z); for the world, the direction.
Vec3f camera_point(const ShadingPoint& point, const TextureContext& context) {
    return point.is_place() ? context.camera_from_world.point(point.p)
                            : context.camera_from_world.vector(point.p);
}

Vec3f window(const ShadingPoint& point, const TextureContext& context) {
    const Vec3f p = camera_point(point, context);
    const auto [left, right, bottom, top] = context.viewplane;
    const float depth = context.orthographic || p.z == 0 ? 1 : -p.z;
    return {(p.x / depth - left) / (right - left), (p.y / depth - bottom) / (top - bottom), 0};
}

Vec3f ray_history(std::int32_t what, const RayHistory& history) {
    const float values[] = {history.length,
                            static_cast<float>(history.depth),
                            static_cast<float>(history.diffuse),
                            static_cast<float>(history.glossy),
                            static_cast<float>(history.transmission),
                            static_cast<float>(history.transparent),
                            history.singular ? 1.0f : 0.0f};
    return Vec3f(values[what]);
}

Vec3f property_of(const Instance& instance, std::int32_t number, bool alpha) {
    if (static_cast<std::size_t>(number) >= instance.properties.size())
        return Vec3f(0);
    const auto& [r, g, b, a] = instance.properties[static_cast<std::size_t>(number)];
    return alpha ? Vec3f(a) : Vec3f(r, g, b);
}

Vec3f object_input(Op op, std::int32_t mode, const ShadingPoint& point, const TextureContext& context) {
    const Instance& instance = *point.instance;
    switch (op) {
        case Op::object_location:
            return instance.world_from_object_at(point.time).translation + context.origin;
        case Op::object_color:
            return {instance.color[0], instance.color[1], instance.color[2]};
        case Op::object_alpha:
            return Vec3f(instance.color[3]);
        case Op::object_random:
            return Vec3f(instance.random);
        case Op::object_attribute:
            return property_of(instance, mode, false);
        case Op::object_attribute_alpha:
            return property_of(instance, mode, true);
        default:
            return Vec3f(instance.pass_index);
    }
}

/// Directions in which u and v grow over a triangle, world space, not of unit length; their signs are those
/// of the map's handedness. False where the mesh lacks the map or it is flat there.
bool uv_directions(std::int32_t uv_map, const ShadingPoint& point, Vec3f& along_u, Vec3f& along_v) {
    if (!on_triangle(point) || uv_map < 0)
        return false;
    const auto& layers = point.mesh->uvs;
    if (static_cast<std::size_t>(uv_map) >= layers.size())
        return false;
    const float* uv = layers[static_cast<std::size_t>(uv_map)].data() + 6 * std::size_t{point.triangle};
    const float u1 = uv[2] - uv[0], v1 = uv[3] - uv[1], u2 = uv[4] - uv[0], v2 = uv[5] - uv[1];
    const float area = u1 * v2 - u2 * v1;  // of the triangle in uv, signed: its sign is the map's handedness
    if (area == 0)
        return false;
    const Vec3f p0 = point.mesh->vertex(point.triangle, 0, point.time);
    const Vec3f e1 = point.mesh->vertex(point.triangle, 1, point.time) - p0,
                e2 = point.mesh->vertex(point.triangle, 2, point.time) - p0;
    const Transform world_from_object = point.instance->world_from_object_at(point.time);
    const float sign = area > 0 ? 1.0f : -1.0f;
    along_u = world_from_object.vector(e1 * v2 - e2 * v1) * sign;
    along_v = world_from_object.vector(e2 * u1 - e1 * u2) * sign;
    return true;
}

Vec3f uv_tangent(std::int32_t uv_map, const ShadingPoint& point) {
    Vec3f u, v;
    return uv_directions(uv_map, point, u, v) ? safe_normalize(u - point.ns * dot(point.ns, u)) : Vec3f(0);
}

/// Axes of the tangent plane along which bump steps, as in Cycles: what finite steps see depends on them.
struct TangentPlane {
    Vec3f x, y;

    explicit TangentPlane(Vec3f n) {
        const Vec3f across = cross(Vec3f(1), n);
        x = safe_normalize(is_zero(across) ? cross(Vec3f(1, 1, -1), n) : across);
        y = cross(n, x);
    }
};

/// Width of a pixel of the image at the point: how far apart the samples of neighbouring pixels lie on a
/// surface that faces the camera.
float footprint(const ShadingPoint& point, const TextureContext& context) {
    return context.pixel_width * (context.orthographic ? 1 : length(camera_point(point, context)));
}

/// The point moved in the plane of its triangle, which goes on beyond its edges.
ShadingPoint moved(const ShadingPoint& point, Vec3f by) {
    ShadingPoint out = point;
    const Vec3f local = inverse_of(point.instance->world_from_object_at(point.time)).vector(by);
    out.p = point.p + by;
    out.object_p = point.object_p + local;
    const Vec3f a = point.mesh->vertex(point.triangle, 0, point.time),
                e1 = point.mesh->vertex(point.triangle, 1, point.time) - a,
                e2 = point.mesh->vertex(point.triangle, 2, point.time) - a;
    const float d11 = dot(e1, e1), d12 = dot(e1, e2), d22 = dot(e2, e2), size = d11 * d22 - d12 * d12;
    if (size > 0) {
        const float q1 = dot(local, e1), q2 = dot(local, e2);
        const float u = (d22 * q1 - d12 * q2) / size, v = (d11 * q2 - d12 * q1) / size;
        out.barycentric += Vec3f(-u - v, u, v);
    }
    return out;
}

}  // namespace

Vec3f shading_input(Op op, std::int32_t mode, const ShadingPoint& point, const TextureContext& context) {
    switch (op) {
        case Op::uv:
            return uv_of(mode, point);
        case Op::generated:
            return generated(point);
        case Op::object_coordinate:
            return point.object_p;
        case Op::camera_coordinate:
            return camera_point(point, context) * Vec3f(1, 1, -1);
        case Op::window_coordinate:
            return window(point, context);
        case Op::position:
            return point.is_place() ? point.p + context.origin : point.p;
        // The world's normals face the viewer, as in Cycles.
        case Op::normal:
            return point.instance ? point.ns : point.wo;
        case Op::normal_object:
            return point.instance
                       ? safe_normalize(
                             point.instance->world_from_object_at(point.time).transposed_vector(point.ns))
                       : point.wo;
        case Op::geometric_normal:
            return point.instance ? point.ng : point.wo;
        case Op::incoming:
            return point.wo;
        case Op::reflection:
            return point.instance ? 2 * dot(point.ns, point.wo) * point.ns - point.wo : point.wo;
        case Op::backfacing:
            return Vec3f(point.backfacing ? 1.0f : 0.0f);
        case Op::ray_is:
            return Vec3f(point.ray_kind & static_cast<std::uint32_t>(mode) ? 1.0f : 0.0f);
        case Op::attribute:
            return attribute_of(mode, point, false);
        case Op::attribute_alpha:
            return attribute_of(mode, point, true);
        case Op::ray_history:
            return ray_history(mode, point.history);
        case Op::parametric:
            return {point.barycentric.x, point.barycentric.y, 0};
        case Op::uv_tangent:
            return uv_tangent(mode, point);
        default:
            return point.instance ? object_input(op, mode, point, context) : Vec3f(0);
    }
}

Vec3f shifted_input(Op op, std::int32_t mode, float pixels, const ShadingPoint& point,
                    const TextureContext& context) {
    const std::int32_t rest = mode & (kShift - 1);
    if (!on_triangle(point))
        return shading_input(op, rest, point, context);
    const TangentPlane plane(point.ng);
    const Vec3f axis = mode / kShift == 1 ? plane.x : plane.y;
    return shading_input(op, rest, moved(point, axis * (pixels * footprint(point, context))), context);
}

Vec3f bump_normal(Vec3f heights, float strength, float distance, float pixels, Vec3f n,
                  const ShadingPoint& point, const TextureContext& context) {
    const TangentPlane plane(point.ng);
    const float step = pixels * footprint(point, context);
    const Vec3f slope =
        (cross(plane.y, n) * (heights.y - heights.x) + cross(n, plane.x) * (heights.z - heights.x));
    const float det = dot(plane.x, cross(plane.y, n));
    const Vec3f bent =
        safe_normalize(n * (step * std::fabs(det)) - slope * (distance * std::copysign(1.0f, det)));
    const float s = std::max(strength, 0.0f);
    const Vec3f out = is_zero(bent) ? n : safe_normalize(bent * s + n * (1 - s));
    return is_zero(out) ? n : out;
}

bool on_wire(float size, bool pixels, const ShadingPoint& point, const TextureContext& context) {
    if (!on_triangle(point))
        return false;
    const float half = 0.5f * size * (pixels ? footprint(point, context) : 1);
    const Transform world_from_object = point.instance->world_from_object_at(point.time);
    for (int corner = 0; corner < 3; ++corner) {
        const Vec3f a = world_from_object.point(point.mesh->vertex(point.triangle, corner, point.time)),
                    b = world_from_object.point(
                        point.mesh->vertex(point.triangle, (corner + 1) % 3, point.time));
        const Vec3f along = safe_normalize(b - a), from = point.p - a;
        if (length(from - along * dot(along, from)) < half)
            return true;
    }
    return false;
}

Vec3f convert_space(std::int32_t mode, Vec3f a, const ShadingPoint& point, const TextureContext& context) {
    enum Space { world, object, camera };
    enum Kind { place, direction, normal };
    const int from = mode & 3, to = mode >> 2 & 3, kind = mode >> 4;
    if (from == to)
        return a;
    // By way of the world. Where it is the background's, or has no object, object space is the world.
    const Transform world_from_object =
        point.instance ? point.instance->world_from_object_at(point.time) : Transform{};
    const Transform object_from_world = point.instance ? inverse_of(world_from_object) : Transform{};
    const Transform world_from_camera = inverse_of(context.camera_from_world);
    const auto applied = [&](const Transform& t, const Transform& inverse, Vec3f v) {
        return kind == place ? t.point(v) : kind == direction ? t.vector(v) : inverse.transposed_vector(v);
    };
    const Vec3f flip(1, 1, -1);  // shading's camera space looks along z
    const Vec3f origin = kind == place ? context.origin : Vec3f(0);
    Vec3f w = a - (from == world ? origin : Vec3f(0));
    if (from == object)
        w = applied(world_from_object, object_from_world, a);
    else if (from == camera)
        w = applied(world_from_camera, context.camera_from_world, a * flip);
    Vec3f out = w + origin;
    if (to == object)
        out = applied(object_from_world, world_from_object, w);
    else if (to == camera)
        out = applied(context.camera_from_world, world_from_camera, w) * flip;
    return kind == normal ? safe_normalize(out) : out;
}

float fresnel_node(float ior, Vec3f n, const ShadingPoint& point) {
    const float eta = std::max(ior, 1e-5f) / point.outside_ior;
    return fresnel_dielectric(std::min(1.0f, std::fabs(dot(point.wo, n))), point.backfacing ? 1 / eta : eta);
}

float layer_weight_fresnel(float blend, Vec3f n, const ShadingPoint& point) {
    return fresnel_node(1 / std::max(1 - blend, 1e-5f), n, point);
}

float layer_weight_facing(float blend, Vec3f n, const ShadingPoint& point) {
    float facing = std::min(1.0f, std::fabs(dot(point.wo, n)));
    if (blend != 0.5f) {
        const float b = std::clamp(blend, 0.0f, 1 - 1e-5f);
        facing = std::pow(facing, b < 0.5f ? 2 * b : 0.5f / (1 - b));
    }
    return 1 - facing;
}

Vec3f tangent_normal(Rgb color, float strength, std::int32_t uv_map, const ShadingPoint& point) {
    Vec3f u, v;
    if (!uv_directions(uv_map, point, u, v))
        return point.ns;
    const Vec3f n = point.backfacing ? -point.ns : point.ns;  // the map belongs to the front
    const Vec3f tangent = safe_normalize(u - n * dot(n, u));
    const Vec3f bitangent = cross(n, tangent) * (dot(cross(n, tangent), v) < 0 ? -1.0f : 1.0f);
    const float s = std::max(strength, 0.0f);
    const Vec3f local(s * (2 * color.x - 1), s * (2 * color.y - 1),
                      lerp(1.0f, 2 * color.z - 1, std::min(s, 1.0f)));
    const Vec3f mapped = safe_normalize(tangent * local.x + bitangent * local.y + n * local.z);
    if (is_zero(mapped))
        return point.ns;
    return point.backfacing ? -mapped : mapped;
}

}  // namespace nephele
