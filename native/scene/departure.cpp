// SPDX-License-Identifier: GPL-3.0-or-later
// Where rays leave surfaces.
//
// The shading normal decides on which side of the face a ray starts, but for dielectrics
// (Bsdf::leaves_beyond). Near the horizon of a smooth normal the ray may point back at the face. Then it
// starts from the smooth surface that the normals stand for, lifted off the face as in Hanika 2021, "Hacking
// the Shadow Terminator" (Ray Tracing Gems II, chapter 4). A ray that meets its own face all the same is
// scattered there once more. So no direction has to be refused, which would lose light, and none leads
// through an opaque surface.
#include "scene/scene.h"

namespace nephele {
namespace {

/// Rays whose cosine with the face's normal is below this start lifted, fully so from 0 down.
constexpr float kGrazing = 0.1f;

/// The vector from the point to the smooth surface on the side of n, the face's normal or its opposite:
/// planes through the corners, as the corners' normals have them, mixed by the barycentric coordinates. Zero
/// where that surface is behind the face.
Vec3f lift(const ShadingPoint& point, bool crosses) {
    const Instance& instance = *point.instance;
    const Mesh& mesh = *point.mesh;
    const Transform world_from_object = instance.world_from_object_at(point.time);
    const Transform object_from_world =
        instance.motion.moves() ? inverse_of(world_from_object) : instance.object_from_world;
    const float side = point.backfacing != crosses ? -1.0f : 1.0f;
    Vec3f sum;
    for (int i = 0; i < 3; ++i) {
        const Vec3f corner = world_from_object.point(mesh.vertex(point.triangle, i, point.time));
        const Vec3f normal = mesh.corner_normal(point.triangle, i, point.time);
        const Vec3f n = side * safe_normalize(object_from_world.transposed_vector(normal));
        sum += n * (point.barycentric[i] * std::max(0.0f, dot(corner - point.p, n)));
    }
    return sum;
}

}  // namespace

Scene::Departure Scene::departure(const ShadingPoint& point, Vec3f wi, bool crosses) const {
    const Vec3f n = crosses ? -point.ng : point.ng, o = point.off(n);
    const float cosine = dot(wi, n);
    if (cosine >= kGrazing || point.mesh->corner_normals.empty())
        return {point.p, o};
    const Vec3f up = lift(point, crosses) * std::min(1.0f, 1 - cosine / kGrazing);
    const float height = length(up);
    // Not through what lies close above.
    if (height == 0 || is_zero(surface_transmittance({o, up / height, 0, height, point.time})))
        return {point.p, o};
    return {point.p + up, offset_point(point.p + up, n, point.reach)};
}

}  // namespace nephele
