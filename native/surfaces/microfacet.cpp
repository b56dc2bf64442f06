// SPDX-License-Identifier: GPL-3.0-or-later
// Reflection at and refraction through microfacets: equations 20, 21, 14 and 17 of Walter et al. 2007,
// "Microfacet Models for Refraction through Rough Surfaces", with G2 height-correlated.
#include "surfaces/microfacet.h"

#include "surfaces/directional_albedo.h"
#include "surfaces/lobes.h"

namespace nephele {
namespace {

constexpr Vec3f kMacroNormal{0, 0, 1};

Vec3f mirrored(Vec3f w, Vec3f h) {
    return 2 * dot(w, h) * h - w;
}

/// What eval and sample share at a microfacet normal h.
struct Facet {
    float D, lambda_o, pdf_over_cosine;

    Facet(const Microfacet& facets, Vec3f wo, Vec3f h)
        : D(facets.D(h)),
          lambda_o(facets.Lambda(wo)),
          pdf_over_cosine(facets.normal_pdf_over_cosine(wo, h, D, lambda_o)) {}
};

/// White reflection: f |cos wi| and density.
LobeValue reflection_value(const Microfacet& facets, Vec3f wo, Vec3f wi, Vec3f h) {
    const Facet facet(facets, wo, h);
    const float f = facet.D / (4 * wo.z * (1 + facet.lambda_o + facets.Lambda(wi)));
    return {Rgb(f), 0.25f * facet.pdf_over_cosine};
}

/// White refraction: f |cos wi| without (1 - F), and density; h is the facet that refracts wo into wi.
LobeValue refraction_value(const Microfacet& facets, float eta, Vec3f wo, Vec3f wi, Vec3f h) {
    const Facet facet(facets, wo, h);
    const float cos_o = dot(wo, h), cos_i = dot(wi, h), denominator = cos_o + eta * cos_i;
    const float jacobian = eta * eta * -cos_i / (denominator * denominator);
    const float f = facet.D * cos_o * jacobian / (wo.z * (1 + facet.lambda_o + facets.Lambda(wi)));
    return {Rgb(f), facet.pdf_over_cosine * cos_o * jacobian};
}

LobeSample sample_of(Vec3f wi, const LobeValue& value, Rgb color, float probability, std::uint32_t kind) {
    return {wi, color * value.f / (probability * value.pdf), probability * value.pdf, kind};
}

/// Albedo of a dielectric-like Fresnel curve, given the real interface's reflected share and the white one's.
Rgb curve_albedo(const Fresnel& fresnel, float reflected, float white) {
    const float real_f0 = f0_from_ior(fresnel.eta), range = range_from_ior(fresnel.eta);
    const float above = range > 0 ? std::max(0.0f, (reflected - real_f0 * white) / range) : 0;
    return fresnel.f0 * white + (Rgb(1) - fresnel.f0) * std::min(above, 1.0f);
}

}  // namespace

// --- Reflection
// --------------------------------------------------------------------------------------------------

LobeValue Reflection::eval(Vec3f wo, Vec3f wi) const {
    if (specular() || wo.z <= 0 || wi.z <= 0)
        return {};
    const Vec3f h = normalize(wo + wi);
    const float cos_o = dot(wo, h);
    if (!(cos_o > 0))  // opposite directions, both at the horizon: their sum has no digits
        return {};
    const LobeValue value = reflection_value(facets, wo, wi, h);
    return {value.f * fresnel.at(cos_o) * scale, value.pdf};
}

std::optional<LobeSample> Reflection::sample(Vec3f wo, float, Vec2f u) const {
    if (wo.z <= 0)
        return std::nullopt;
    if (specular())
        return LobeSample{mirrored(wo, kMacroNormal), fresnel.at(wo.z), 0, kGlossyRay};
    const Vec3f h = facets.sample_normal(wo, u), wi = mirrored(wo, h);
    if (dot(wo, h) <= 0 || wi.z <= 0)
        return std::nullopt;
    return sample_of(wi, reflection_value(facets, wo, wi, h), fresnel.at(dot(wo, h)) * scale, 1, kGlossyRay);
}

Rgb Reflection::albedo(Vec3f wo) const {
    if (specular())
        return fresnel.at(wo.z);
    const float roughness = facets.ggx_roughness(), white = reflection_albedo(wo.z, roughness);
    if (fresnel.kind == Fresnel::Kind::constant)
        return fresnel.f0 * white * scale;
    if (fresnel.kind == Fresnel::Kind::f82 || fresnel.is_peculiar())
        return lerp(fresnel.at(wo.z), fresnel.mean(), roughness) * white * scale;
    return curve_albedo(fresnel, dielectric_albedo(wo.z, roughness, fresnel.eta).reflected, white) * scale;
}

// --- Dielectric
// --------------------------------------------------------------------------------------------------

Rgb Dielectric::reflectance(float cosine) const {
    return fresnel.at(cosine);
}

/// Probability of sampling the reflection at a facet with reflectance F.
float Dielectric::reflect_probability(Rgb F) const {
    const float reflected = mean(reflection_tint * F), transmitted = mean(transmission_tint * (Rgb(1) - F));
    return reflected > 0 ? reflected / (reflected + transmitted) : 0;
}

LobeValue Dielectric::eval(Vec3f wo, Vec3f wi) const {
    if (specular() || wo.z <= 0 || wi.z == 0)
        return {};
    const bool reflects = wi.z > 0;
    Vec3f h = reflects ? normalize(wo + wi) : safe_normalize(wo + wi * eta);
    if (h.z < 0)
        h = -h;
    const float cos_o = dot(wo, h);
    if (cos_o <= 0 || h.z == 0 || (!reflects && dot(wi, h) >= 0))
        return {};
    const Rgb F = reflectance(cos_o);
    const float p = reflect_probability(F);
    if (reflects) {
        const LobeValue value = reflection_value(facets, wo, wi, h);
        return {value.f * reflection_tint * F * scale, p * value.pdf};
    }
    const LobeValue value = refraction_value(facets, eta, wo, wi, h);
    return {value.f * transmission_tint * (Rgb(1) - F) * scale, (1 - p) * value.pdf};
}

std::optional<LobeSample> Dielectric::sample(Vec3f wo, float choice, Vec2f u) const {
    if (wo.z <= 0)
        return std::nullopt;
    const Vec3f h = specular() ? kMacroNormal : facets.sample_normal(wo, u);
    const float cos_o = dot(wo, h);
    if (cos_o <= 0)
        return std::nullopt;
    const Rgb F = reflectance(cos_o);
    const float p = reflect_probability(F);
    if (choice < p) {
        const Vec3f wi = mirrored(wo, h);
        if (wi.z <= 0)
            return std::nullopt;
        const Rgb color = reflection_tint * F * scale;
        if (specular())
            return LobeSample{wi, color / p, 0, kGlossyRay};
        return sample_of(wi, reflection_value(facets, wo, wi, h), color, p, kGlossyRay);
    }
    float cos_t = 0;
    const bool total = fresnel_dielectric(cos_o, eta, cos_t) >= 1 && cos_t == 0;
    const Vec3f wi = normalize((cos_o / eta - cos_t) * h - wo / eta);
    if (total || wi.z >= 0)
        return std::nullopt;
    const Rgb color = transmission_tint * (Rgb(1) - F) * scale;
    if (specular())
        return LobeSample{wi, color / (1 - p), 0, kTransmissionRay};
    return sample_of(wi, refraction_value(facets, eta, wo, wi, h), color, 1 - p, kTransmissionRay);
}

std::pair<Rgb, Rgb> Dielectric::albedos(Vec3f wo) const {
    if (specular()) {
        const Rgb F = reflectance(wo.z);
        const bool total = fresnel_dielectric(wo.z, eta) >= 1;
        return {reflection_tint * F, total ? Rgb(0) : transmission_tint * (Rgb(1) - F)};
    }
    const float roughness = facets.ggx_roughness();
    const auto [reflected, transmitted] = dielectric_albedo(wo.z, roughness, eta);
    const float white = reflection_albedo(wo.z, roughness);
    if (fresnel.kind == Fresnel::Kind::constant) {  // refraction only: no share is lost to reflection
        return {Rgb(0),
                transmission_tint * std::min(1.0f, transmitted / std::max(0.05f, 1 - reflected / white))};
    }
    if (fresnel.is_peculiar()) {
        const Rgb share = min(lerp(fresnel.at(wo.z), fresnel.mean(), roughness), Rgb(1));
        const Rgb kept = (reflected + transmitted) * scale;
        return {reflection_tint * share * kept, transmission_tint * (Rgb(1) - share) * kept};
    }
    const Rgb back = curve_albedo(fresnel, reflected, white);
    const float range = range_from_ior(fresnel.eta);
    const Rgb through = (Rgb(1) - fresnel.f0) * (range > 0 ? std::min(transmitted / range, 1.0f) : 0);
    return {reflection_tint * back * scale, transmission_tint * through * scale};
}

}  // namespace nephele
