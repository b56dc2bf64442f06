// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's Principled BSDF (version 2, Blender 4.0 and newer) as a stack of lobes, from the top: sheen,
// coat, then by weight metal, glass, and a dielectric reflection over diffuse. Each layer takes its albedo
// from what lies beneath. Subsurface, anisotropy, diffuse roughness and thin film are the exporter's to
// announce.
#pragma once

#include "base/surface.h"
#include "shading/program.h"
#include "surfaces/lobes.h"

namespace nephele {

class Bsdf;

/// A Reflection of GGX or Beckmann facets seen from cosine mu, with energy compensation where asked for.
Reflection make_reflection(Distribution distribution, float roughness, const Fresnel& fresnel, float mu);
/// Reflection and refraction; eta: ior beyond the surface / ior on wo's side.
Dielectric make_dielectric(Distribution distribution, float roughness, float eta, const Fresnel& fresnel,
                           Rgb reflection_tint, Rgb transmission_tint, float mu);

/// An interface between dielectrics on the side of its normal n. eta: ior beyond it / ior on that side.
struct SeenInterface {
    Vec3f n;
    float eta;
};
/// The interface of shading normal n and eta as wo sees it. Where n faces away from wo, wo is beyond the
/// smooth surface that n stands for, though not beyond the face, and sees it from its other side. Bending n
/// towards wo instead would trap light inside.
SeenInterface seen_interface(Vec3f n, float eta, Vec3f wo);

/// The normal n, bent just so far that a mirror in it sends wo off above the surface of geometric normal ng.
Vec3f bent_normal(Vec3f n, Vec3f ng, Vec3f wo);

/// The normal in a closure's input, or the shading normal where it is not connected.
Vec3f closure_normal(std::int16_t input, const RegisterFile& registers, const ShadingPoint& point);

/// Adds the lobes, emission and transparency of a Principled closure.
void add_principled(Bsdf& bsdf, const ClosureRow& row, const RegisterFile& registers,
                    const ShadingPoint& point);
Rgb principled_emission(const ClosureRow& row, const RegisterFile& registers, const ShadingPoint& point);
Rgb principled_transparency(const ClosureRow& row, const RegisterFile& registers);

}  // namespace nephele
