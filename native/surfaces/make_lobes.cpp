// SPDX-License-Identifier: GPL-3.0-or-later
#include "surfaces/make_lobes.h"

#include "surfaces/bsdf.h"
#include "surfaces/directional_albedo.h"

namespace nephele {
namespace {

/// Kulla and Conty 2017: what single scattering loses comes back, coloured by its further bounces. albedo,
/// mean: of the white lobe towards the viewer and over the hemisphere; bounce: mean colour of one bounce.
Rgb compensation(float albedo, float mean, Rgb bounce) {
    const Rgb further = bounce * mean / (Rgb(1) - bounce * (1 - mean));
    return Rgb(1) + further * ((1 - albedo) / albedo);
}

}  // namespace

Reflection make_reflection(Distribution distribution, float roughness, const Fresnel& fresnel, float mu,
                           float stretch) {
    Reflection lobe{Microfacet::brushed(sqr(roughness), distribution == Distribution::beckmann, stretch),
                    fresnel, Rgb(1)};
    if (distribution != Distribution::multi_ggx || lobe.specular())
        return lobe;
    const float seen = stretch == 1 ? roughness : lobe.facets.ggx_roughness();
    lobe.scale = compensation(reflection_albedo(mu, seen), mean_reflection_albedo(seen), fresnel.mean());
    return lobe;
}

Dielectric make_dielectric(Distribution distribution, float roughness, float eta, const Fresnel& fresnel,
                           Rgb reflection_tint, Rgb transmission_tint, float mu) {
    Dielectric lobe{{sqr(roughness), distribution == Distribution::beckmann},
                    fresnel,
                    eta,
                    reflection_tint,
                    transmission_tint,
                    Rgb(1)};
    if (std::fabs(eta - 1) < 1e-4f)
        lobe.facets.alpha = 0;  // no interface: light goes straight on
    if (distribution != Distribution::multi_ggx || lobe.specular())
        return lobe;
    const auto [reflected, transmitted] = dielectric_albedo(mu, roughness, eta);
    const auto [mean_reflected, mean_transmitted] = mean_dielectric_albedo(roughness, eta);
    const Rgb F = fresnel.mean();
    lobe.scale = compensation(reflected + transmitted, mean_reflected + mean_transmitted,
                              min(reflection_tint * F + transmission_tint * (Rgb(1) - F), Rgb(1)));
    return lobe;
}

SeenInterface seen_interface(Vec3f n, float eta, Vec3f wo) {
    return dot(n, wo) < 0 ? SeenInterface{-n, 1 / eta, true} : SeenInterface{n, eta, false};
}

Vec3f bent_normal(Vec3f n, Vec3f ng, Vec3f wo) {
    const float cos_o = dot(wo, ng);
    const Vec3f mirrored = 2 * dot(wo, n) * n - wo;
    const float height = dot(mirrored, ng), least = std::min(0.9f * cos_o, 0.01f);
    if (height >= least && dot(n, wo) > 0)
        return n;
    const Vec3f lifted = safe_normalize(mirrored + std::max(0.0f, least - height) * ng);
    const Vec3f half = lifted + wo;
    return dot(half, half) > 1e-8f ? normalize(half) : ng;
}

Vec3f closure_normal(std::int16_t input, const RegisterFile& registers, const ShadingPoint& point) {
    if (input < 0)
        return point.ns;
    const Vec3f n = safe_normalize(registers[input]);
    return is_zero(n) || !is_finite(n) ? point.ns : n;
}

Frame Brush::frame(Vec3f n) const {
    const Frame straight(n, tangent);
    if (turn == 0)
        return straight;
    const float angle = 2 * kPi * turn;
    return {n, straight.x * std::cos(angle) + straight.y * std::sin(angle)};
}

Rgb add_reflection(Bsdf& bsdf, Distribution distribution, float roughness, const Fresnel& fresnel, Rgb weight,
                   Vec3f n, const Brush& brush, Vec3f wo) {
    const float mu = dot(n, wo);
    const Reflection lobe = make_reflection(distribution, roughness, fresnel, mu, brush.stretch);
    bsdf.add(lobe, weight, brush.stretch == 1 ? Frame(n) : brush.frame(n));
    return lobe.albedo({0, 0, mu});
}

}  // namespace nephele
