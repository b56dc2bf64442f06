// SPDX-License-Identifier: GPL-3.0-or-later
#include "surfaces/principled.h"

#include "surfaces/bsdf.h"
#include "surfaces/directional_albedo.h"

namespace nephele {
namespace {

/// A Principled closure at a shading point.
struct Principled {
    const ClosureRow& row;
    const RegisterFile& registers;
    const ShadingPoint& point;

    Rgb color(int input) const {
        return non_negative(registers[row.inputs[static_cast<std::size_t>(input)]]);
    }
    float value(int input) const { return color(input).x; }
    float unit(int input) const { return std::min(value(input), 1.0f); }
    Distribution distribution() const { return static_cast<Distribution>(row.mode); }
    Vec3f normal(int input) const {
        return bent_normal(closure_normal(row.inputs[static_cast<std::size_t>(input)], registers, point),
                           point.ng, point.wo);
    }
};

/// What is left of `weight` under a layer of this albedo.
Rgb under_layer(Rgb weight, Rgb layer_albedo) {
    return weight * clamp01(1 - max_component(layer_albedo));
}

/// Adds the sheen and returns the weight of what lies beneath. bsdf: null to compute the weight alone.
Rgb add_sheen(const Principled& p, Rgb weight, Bsdf* bsdf) {
    const float amount = p.unit(principled_input::sheen_weight);
    if (amount == 0)
        return weight;
    const Vec3f n = p.normal(principled_input::normal);
    const float mu = dot(n, p.point.wo);
    const Sheen sheen = make_sheen(p.unit(principled_input::sheen_roughness), mu);
    const Rgb tint = amount * p.color(principled_input::sheen_tint);
    if (bsdf)
        bsdf->add(sheen, weight * tint, n);
    return under_layer(weight, tint * sheen.albedo({0, 0, mu}));
}

/// Adds the coat and returns the weight of what lies beneath, tinted by the light's way through the coat and
/// back.
Rgb add_coat(const Principled& p, Rgb weight, Bsdf* bsdf) {
    const float amount = p.unit(principled_input::coat_weight);
    if (amount == 0)
        return weight;
    const Vec3f n = p.normal(principled_input::coat_normal);
    const float mu = dot(n, p.point.wo),
                ior = std::max(bounded_ior(p.value(principled_input::coat_ior)), 1.0f);
    const float roughness = p.unit(principled_input::coat_roughness);
    const Reflection coat = make_reflection(p.distribution(), roughness, Fresnel::dielectric(ior), mu);
    if (bsdf)
        bsdf->add(coat, weight * amount, n);
    const Rgb beneath = under_layer(weight, amount * coat.albedo({0, 0, mu}));

    const Rgb tint = min(p.color(principled_input::coat_tint), Rgb(1));
    if (tint == Rgb(1))
        return beneath;
    const float depth = path_through_coat(mu, ior);
    const Rgb absorbed(std::pow(tint.x, depth), std::pow(tint.y, depth), std::pow(tint.z, depth));
    constexpr float kMost = 1e6f;  // of tints above 1, which grow without bound towards grazing angles
    return beneath * lerp(Rgb(1), min(absorbed, Rgb(kMost)), amount);
}

Rgb add_metal(const Principled& p, Rgb weight, Rgb base, Bsdf& bsdf) {
    const float metallic = p.unit(principled_input::metallic);
    if (metallic == 0)
        return weight;
    const Vec3f n = p.normal(principled_input::normal);
    const Rgb tint = min(p.color(principled_input::specular_tint), Rgb(1));
    const Fresnel fresnel = Fresnel::metal(min(base, Rgb(1)), tint);
    const float roughness = p.unit(principled_input::roughness);
    bsdf.add(make_reflection(p.distribution(), roughness, fresnel, dot(n, p.point.wo)), weight * metallic, n);
    return weight * (1 - metallic);
}

Rgb add_glass(const Principled& p, Rgb weight, Rgb base, Bsdf& bsdf) {
    const float amount = p.unit(principled_input::transmission_weight);
    if (amount == 0)
        return weight;
    const float ior = bounded_ior(p.value(principled_input::ior)) / p.point.outside_ior;
    const auto [n, eta] =
        seen_interface(closure_normal(p.row.inputs[principled_input::normal], p.registers, p.point),
                       p.point.backfacing ? 1 / ior : ior, p.point.wo);
    const Rgb tint = min(p.color(principled_input::specular_tint), Rgb(1));
    const Fresnel fresnel = Fresnel::dielectric(eta, tint * f0_from_ior(eta));
    const float roughness = p.unit(principled_input::roughness);
    // Light passes two interfaces, one on the way in and one on the way out.
    const Rgb transmitted(std::sqrt(base.x), std::sqrt(base.y), std::sqrt(base.z));
    const float mu = dot(n, p.point.wo);
    bsdf.add(make_dielectric(p.distribution(), roughness, eta, fresnel, Rgb(1), transmitted, mu),
             weight * amount, n);
    return weight * (1 - amount);
}

/// The dielectric reflection over the diffuse base.
Rgb add_specular(const Principled& p, Rgb weight, Bsdf& bsdf) {
    float ior = bounded_ior(p.value(principled_input::ior)) / p.point.outside_ior, f0 = f0_from_ior(ior);
    const float level = p.value(principled_input::specular_ior_level);
    if (level != 0.5f) {  // scales the reflectance, and bends the curve to match
        f0 = std::min(f0 * 2 * level, 0.99f);
        ior = ior < 1 ? 1 / ior_from_f0(f0) : ior_from_f0(f0);
    }
    if (f0 == 0)
        return weight;
    const Vec3f n = p.normal(principled_input::normal);
    const float mu = dot(n, p.point.wo), roughness = p.unit(principled_input::roughness);
    const Fresnel fresnel =
        Fresnel::dielectric(ior, min(p.color(principled_input::specular_tint) * f0, Rgb(1)));
    const Reflection specular = make_reflection(p.distribution(), roughness, fresnel, mu);
    bsdf.add(specular, weight, n);
    return under_layer(weight, specular.albedo({0, 0, mu}));
}

Rgb opaque_weight(const Principled& p) {
    return non_negative(p.registers[p.row.weight]) * p.unit(principled_input::alpha);
}
Rgb emitted(const Principled& p) {
    return finite(p.registers[p.row.inputs[principled_input::emission_color]]) *
           finite(p.registers[p.row.inputs[principled_input::emission_strength]]).x;
}

/// Kulla and Conty 2017: what single scattering loses comes back, coloured by its further bounces. albedo,
/// mean: of the white lobe towards the viewer and over the hemisphere; bounce: mean colour of one bounce.
Rgb compensation(float albedo, float mean, Rgb bounce) {
    const Rgb further = bounce * mean / (Rgb(1) - bounce * (1 - mean));
    return Rgb(1) + further * ((1 - albedo) / albedo);
}

}  // namespace

Reflection make_reflection(Distribution distribution, float roughness, const Fresnel& fresnel, float mu) {
    Reflection lobe{{sqr(roughness), distribution == Distribution::beckmann}, fresnel, Rgb(1)};
    if (distribution != Distribution::multi_ggx || lobe.specular())
        return lobe;
    lobe.scale =
        compensation(reflection_albedo(mu, roughness), mean_reflection_albedo(roughness), fresnel.mean());
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
    return dot(n, wo) < 0 ? SeenInterface{-n, 1 / eta} : SeenInterface{n, eta};
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

void add_principled(Bsdf& bsdf, const ClosureRow& row, const RegisterFile& registers,
                    const ShadingPoint& point) {
    const Principled p{row, registers, point};
    bsdf.transparency += principled_transparency(row, registers);
    Rgb weight = opaque_weight(p);
    if (is_zero(weight))
        return;
    const Rgb base = p.color(principled_input::base_color);
    weight = add_coat(p, add_sheen(p, weight, &bsdf), &bsdf);
    bsdf.emission += emitted(p) * weight;
    weight = add_metal(p, weight, base, bsdf);
    weight = add_glass(p, weight, base, bsdf);
    if (is_zero(weight))
        return;
    weight = add_specular(p, weight, bsdf);
    bsdf.add(Lambert{}, weight * base,
             closure_normal(row.inputs[principled_input::normal], registers, point));
}

Rgb principled_emission(const ClosureRow& row, const RegisterFile& registers, const ShadingPoint& point) {
    const Principled p{row, registers, point};
    const Rgb emission = emitted(p);
    if (is_zero(emission))
        return Rgb(0);
    return emission * add_coat(p, add_sheen(p, opaque_weight(p), nullptr), nullptr);
}

Rgb principled_transparency(const ClosureRow& row, const RegisterFile& registers) {
    const float alpha = clamp01(finite(registers[row.inputs[principled_input::alpha]]).x);
    return non_negative(registers[row.weight]) * (1 - alpha);
}

}  // namespace nephele
