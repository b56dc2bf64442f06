// SPDX-License-Identifier: GPL-3.0-or-later
// Lobes made of what artists set: microfacets with their energy compensation, brushed metals, interfaces,
// films, what scatters below a surface; and the normals that they stand on.
#pragma once

#include "base/surface.h"
#include "shading/program.h"
#include "surfaces/lobes.h"

namespace nephele {

class Bsdf;

/// A Reflection of GGX or Beckmann facets seen from cosine mu, with energy compensation where asked for.
/// stretch: see Microfacet.
Reflection make_reflection(Distribution distribution, float roughness, const Fresnel& fresnel, float mu,
                           float stretch = 1);
/// Reflection and refraction; eta: ior beyond the surface / ior on wo's side.
Dielectric make_dielectric(Distribution distribution, float roughness, float eta, const Fresnel& fresnel,
                           Rgb reflection_tint, Rgb transmission_tint, float mu);

/// An interface between dielectrics on the side of its normal n. eta: ior beyond it / ior on that side.
struct SeenInterface {
    Vec3f n;
    float eta;
    bool flipped;  ///< n is not the one that was asked about but its opposite
};
/// The interface of shading normal n and eta as wo sees it. Where n faces away from wo, wo is beyond the
/// smooth surface that n stands for, though not beyond the face, and sees it from its other side. Bending n
/// towards wo instead would trap light inside.
SeenInterface seen_interface(Vec3f n, float eta, Vec3f wo);

/// The normal n, bent just so far that a mirror in it sends wo off above the surface of geometric normal ng.
Vec3f bent_normal(Vec3f n, Vec3f ng, Vec3f wo);

/// The normal in a closure's input, or the shading normal where it is not connected.
Vec3f closure_normal(std::int16_t input, const RegisterFile& registers, const ShadingPoint& point);

/// How a surface is brushed. turn: of the tangent around the normal, in full turns.
struct Brush {
    float stretch = 1;
    Vec3f tangent;
    float turn = 0;

    Frame frame(Vec3f n) const;
};
/// The stretch that an anisotropy in [0,1] stands for (Burley 2012, "Physically Based Shading at Disney").
inline float anisotropic_stretch(float anisotropy) {
    return 1 / std::sqrt(1 - 0.9f * anisotropy);
}

/// Adds a brushed reflection and returns its albedo towards wo.
Rgb add_reflection(Bsdf& bsdf, Distribution distribution, float roughness, const Fresnel& fresnel, Rgb weight,
                   Vec3f n, const Brush& brush, Vec3f wo);

/// A film of this index as the side of an interface sees it that has the index `around`.
inline ThinFilm film_seen(float thickness, float ior, float around) {
    return {thickness, bounded_ior(ior) / around};
}

/// Subsurface scattering as artists set it. radius: metres, by channel; its meaning depends on the method.
struct SubsurfaceLook {
    Rgb color, radius;
    float ior = 1.4f, roughness = 1, anisotropy = 0;
    SubsurfaceMethod method = SubsurfaceMethod::random_walk;
};
/// Adds what scatters below the surface of normal n. Returns the weight of what is left: channels whose
/// radius is 0 scatter where light enters, as from a diffuse surface.
Rgb add_subsurface(Bsdf& bsdf, const SubsurfaceLook& look, Rgb weight, Vec3f n);

}  // namespace nephele
