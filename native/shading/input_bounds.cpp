// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/input_bounds.h"

#include "scene/mesh.h"
#include "shading/channel_bounds.h"
#include "shading/shading_inputs.h"

namespace nephele {
namespace {

Interval3 transformed(const Transform& t, const Interval3& p, bool vector) {
    const Vec3f move = vector ? Vec3f(0) : t.translation;
    return {row_bounds(t.row[0], move.x, p), row_bounds(t.row[1], move.y, p),
            row_bounds(t.row[2], move.z, p)};
}

/// The box as at the frame.
Interval3 rest_box(const BoundsInput& input) {
    return {{input.lo.x, input.hi.x}, {input.lo.y, input.hi.y}, {input.lo.z, input.hi.z}};
}

/// Where the box is at all times: between two placements every point goes straight.
Interval3 box_of(const BoundsInput& input) {
    const Interval3 rest = rest_box(input);
    if (input.world_from_rest.empty())
        return rest;
    Interval3 out = transformed(input.world_from_rest.front(), rest, false);
    for (const Transform& step : input.world_from_rest.subspan(1)) {
        const Interval3 there = transformed(step, rest, false);
        out = {join(out[0], there[0]), join(out[1], there[1]), join(out[2], there[2])};
    }
    return out;
}

Interval3 object_box(const BoundsInput& input) {
    const Interval3 p = rest_box(input);
    if (input.point.instance)
        return transformed(input.point.instance->object_from_world, p, false);
    return input.point.is_place() ? moved(p, input.context.origin) : p;
}

Interval3 object_location(const BoundsInput& input) {
    if (!input.point.instance)
        return Interval3(Vec3f(0));
    Vec3f lo = input.point.instance->world_from_object.translation, hi = lo;
    for (const Transform& step : input.point.instance->motion.steps()) {
        lo = min(lo, step.translation);
        hi = max(hi, step.translation);
    }
    return moved({Interval1(lo.x, hi.x), Interval1(lo.y, hi.y), Interval1(lo.z, hi.z)}, input.context.origin);
}

Interval3 generated(const BoundsInput& input) {
    const Interval3 p = object_box(input);
    if (!input.point.mesh)
        return p;
    const Mesh& mesh = *input.point.mesh;
    const auto channel = [&](int c) {
        return divide(p[c] - mesh.generated_min[c], Interval1(mesh.generated_size[c]));
    };
    return {channel(0), channel(1), channel(2)};
}

Interval3 camera_box(const BoundsInput& input) {
    return transformed(input.context.camera_from_world, box_of(input), !input.point.is_place());
}

Interval3 window(const BoundsInput& input) {
    const Interval3 p = camera_box(input);
    const auto [left, right, bottom, top] = input.context.viewplane;
    const auto projected = [&](Interval1 x) {
        if (input.context.orthographic)
            return x;
        return p[2].contains(0) ? join(divide(x, -p[2]), x) : quotient(x, -p[2]);
    };
    const Interval1 x = projected(p[0]), y = projected(p[1]);
    return {quotient(x - left, Interval1(right) - left), quotient(y - bottom, Interval1(top) - bottom),
            Interval1(0)};
}

}  // namespace

Interval1 row_bounds(Vec3f row, double translation, const Interval3& p) {
    return p[0] * row.x + p[1] * row.y + p[2] * row.z + translation;
}

Interval3 converted_bounds(std::int32_t mode, const Interval3& a, const BoundsInput& input) {
    const int from = mode & 3, to = mode >> 2 & 3, kind = mode >> 4;
    if (from == to)
        return a;
    const bool normal = kind == 2;
    if (normal)
        return Interval3(Interval1(kDirection.lo, kDirection.hi, !tame(a[0], a[1], a[2])));
    const Instance* instance = input.point.instance;
    if (instance && instance->motion.moves() && (from == 1 || to == 1))
        return Interval3(everything());
    const bool vector = kind == 1;
    const auto flipped = [](const Interval3& v) { return Interval3(v[0], v[1], -v[2]); };
    const Vec3f origin = vector ? Vec3f(0) : input.context.origin;
    Interval3 w = a;
    if (from == 0)
        w = moved(a, -origin);
    else if (from == 1 && instance)
        w = transformed(instance->world_from_object, a, vector);
    else if (from == 2)
        w = transformed(inverse_of(input.context.camera_from_world), flipped(a), vector);
    if (to == 0)
        return moved(w, origin);
    if (to == 1)
        return instance ? transformed(inverse_of(instance->world_from_object), w, vector) : moved(w, origin);
    return to == 2 ? flipped(transformed(input.context.camera_from_world, w, vector)) : moved(w, origin);
}

Interval3 input_bounds(Op op, std::int32_t mode, const BoundsInput& input) {
    if (mode >= kShift)  // of surfaces alone: volumes have no bump
        return Interval3(everything());
    switch (op) {
        case Op::object_location:
            return object_location(input);
        case Op::generated:
            return generated(input);
        case Op::object_coordinate:
            return object_box(input);
        case Op::camera_coordinate: {
            const Interval3 p = camera_box(input);
            return {p[0], p[1], -p[2]};
        }
        case Op::window_coordinate:
            return window(input);
        case Op::position:
            return input.point.is_place() ? moved(box_of(input), input.context.origin) : box_of(input);
        case Op::normal:
        case Op::normal_object:
        case Op::geometric_normal:
        case Op::incoming:
        case Op::reflection:
            return Interval3(kDirection);
        case Op::uv_tangent:
            return Interval3(kDirection);
        case Op::ray_history:  // volumes are told nothing of their rays, so that they are the same for all
            return Interval3(shading_input(op, mode, input.point, input.context));
        case Op::backfacing:
            return Interval3({0, 1});
        case Op::ray_is:
            return Interval3(mode == 0 ? Interval1(0) : Interval1(0, 1));
        case Op::uv:
        case Op::object_color:
        case Op::object_random:
        case Op::object_index:
        case Op::object_alpha:
        case Op::object_attribute:
        case Op::object_attribute_alpha:
        case Op::parametric:
        case Op::attribute:
        case Op::attribute_alpha:  // the same all over the box
            return Interval3(shading_input(op, mode, input.point, input.context));
        default:
            return Interval3(everything());
    }
}

}  // namespace nephele
