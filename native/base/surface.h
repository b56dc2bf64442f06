// SPDX-License-Identifier: GPL-3.0-or-later
// What a surface is to the integrator: the point where a ray meets it and the samples that its BSDF hands
// out. Directions wo and wi are unit vectors that point away from the surface, in world space.
#pragma once

#include <cstdint>
#include <optional>

#include "math/transform.h"

namespace nephele {

/// Bits of a ray's kind, in the order of opcodes.py's RAY_KINDS.
enum RayKind : std::uint32_t {
    kCameraRay = 1,
    kDiffuseRay = 2,
    kGlossyRay = 4,
    kTransmissionRay = 8,
    kVolumeRay = 16,
    kShadowRay = 32
};

struct Instance;  // scene/scene.h
struct Mesh;
struct Subsurface;   // surfaces/lobes.h
class VolumeFields;  // grids/volume_fields.h

/// What led a ray to the point: bounces by kind, and how far it came since the last of them.
struct RayHistory {
    float length = 0;  ///< of the camera's rays from the near clipping distance on
    std::uint16_t depth = 0, diffuse = 0, glossy = 0, transmission = 0;
    std::uint16_t transparent = 0;  ///< surfaces that the path went straight through
    bool singular = false;          ///< the last bounce was off a perfectly sharp lobe

    /// After one more bounce, which sends a ray of this kind.
    RayHistory after(std::uint32_t kind, bool sharp) const {
        RayHistory out = *this;
        out.length = 0;
        ++out.depth;
        out.diffuse = static_cast<std::uint16_t>(diffuse + ((kind & kDiffuseRay) ? 1 : 0));
        out.glossy = static_cast<std::uint16_t>(glossy + ((kind & kGlossyRay) ? 1 : 0));
        out.transmission = static_cast<std::uint16_t>(transmission + ((kind & kTransmissionRay) ? 1 : 0));
        out.singular = sharp;
        return out;
    }
};

/// Everything a shading program can ask about a point. For the world's background `p`, `ng` and `ns` hold the
/// direction.
struct ShadingPoint {
    Vec3f p;         ///< world space
    Vec3f ng, ns;    ///< unit geometric and shading normals, world space, on wo's side (ng); ns never faces
                     ///< away from wo's side of ng
    Vec3f wo;        ///< towards the viewer
    Vec3f object_p;  ///< p in object space (direction for the world)
    Vec3f barycentric;
    float reach = 1;  ///< a share of the triangle's largest world coordinate; see offset_point()
    std::uint32_t triangle = 0;
    const Instance* instance = nullptr;  ///< null for the world
    const Mesh* mesh = nullptr;
    const VolumeFields* volume = nullptr;  ///< grids that a volume's program reads; null elsewhere
    bool backfacing = false;
    float outside_ior = 1;  ///< index of refraction around the surface: 1 but for nested dielectrics
    std::uint32_t ray_kind = kCameraRay;
    RayHistory history;
    float time = 0;  ///< of the shutter, in [0, 1]
    /// At `time`, to the world where the moving object whose volume this is stands as at the frame; null: it
    /// stands still.
    const Transform* rest_from_world = nullptr;

    /// p moved off the surface along n.
    Vec3f off(Vec3f n) const { return offset_point(p, n, reach); }
    /// Whether p is a point; the background's is a direction.
    bool is_place() const { return instance || volume; }
    Vec3f at_rest(Vec3f p_world) const { return rest_from_world ? rest_from_world->point(p_world) : p_world; }
};

/// A direction drawn from a BSDF.
struct BsdfSample {
    Vec3f wi;
    Rgb weight;             ///< f |cos| / pdf
    float pdf = 0;          ///< solid angle, of the whole mixture; unused where `specular`
    bool specular = false;  ///< the direction has a discrete probability: light sampling cannot find it
    std::uint32_t kind = kDiffuseRay;  ///< the scattered ray's kind
    bool crosses = false;              ///< leaves on the side of the surface where wo is not
    const Subsurface* below =
        nullptr;  ///< the light enters along wi and scatters there: a lobe of the BSDF's
};

}  // namespace nephele
