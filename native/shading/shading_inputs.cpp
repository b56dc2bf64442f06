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

Vec3f object_input(Op op, const ShadingPoint& point, const TextureContext& context) {
    const Instance& instance = *point.instance;
    switch (op) {
        case Op::object_location:
            return instance.world_from_object_at(point.time).translation + context.origin;
        case Op::object_color:
            return {instance.color[0], instance.color[1], instance.color[2]};
        case Op::object_random:
            return Vec3f(instance.random);
        default:
            return Vec3f(instance.pass_index);
    }
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
        default:
            return point.instance ? object_input(op, point, context) : Vec3f(0);
    }
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
    if (!point.mesh || !point.instance || uv_map < 0)
        return point.ns;
    const auto& layers = point.mesh->uvs;
    if (static_cast<std::size_t>(uv_map) >= layers.size())
        return point.ns;
    const float* uv = layers[static_cast<std::size_t>(uv_map)].data() + 6 * std::size_t{point.triangle};
    const float u1 = uv[2] - uv[0], v1 = uv[3] - uv[1], u2 = uv[4] - uv[0], v2 = uv[5] - uv[1];
    const float area = u1 * v2 - u2 * v1;  // of the triangle in uv, signed: its sign is the map's handedness
    if (area == 0)
        return point.ns;
    const Vec3f p0 = point.mesh->vertex(point.triangle, 0, point.time);
    const Vec3f e1 = point.mesh->vertex(point.triangle, 1, point.time) - p0,
                e2 = point.mesh->vertex(point.triangle, 2, point.time) - p0;
    const Transform world_from_object = point.instance->world_from_object_at(point.time);
    const Vec3f along_u = world_from_object.vector(e1 * v2 - e2 * v1),
                along_v = world_from_object.vector(e2 * u1 - e1 * u2);

    const Vec3f n = point.backfacing ? -point.ns : point.ns;  // the map belongs to the front
    const Vec3f u = along_u * (area > 0 ? 1.0f : -1.0f), v = along_v * (area > 0 ? 1.0f : -1.0f);
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
