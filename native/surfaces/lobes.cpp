// SPDX-License-Identifier: GPL-3.0-or-later
// The lobes without microfacet normals: diffuse ones, the base of plastics, cartoons' and
// what scatters below.
#include "surfaces/lobes.h"

#include "math/warp.h"
#include "surfaces/directional_albedo.h"

namespace nephele {
namespace {

std::optional<LobeSample> sample_cosine(const auto& lobe, Vec3f wo, Vec2f u) {
    const Vec3f wi = sample_cosine_hemisphere(u);
    const LobeValue value = lobe.eval(wo, wi);
    if (!(value.pdf > 0))
        return std::nullopt;
    return LobeSample{wi, value.f / value.pdf, value.pdf, kDiffuseRay};
}

}  // namespace

// --- Lambert
// -----------------------------------------------------------------------------------------------------

LobeValue Lambert::eval(Vec3f, Vec3f wi) const {
    const float p = std::max(wi.z, 0.0f) * kInvPi;
    return {Rgb(p), p};
}
std::optional<LobeSample> Lambert::sample(Vec3f wo, float, Vec2f u) const {
    return sample_cosine(*this, wo, u);
}

LobeValue Translucent::eval(Vec3f, Vec3f wi) const {
    const float p = std::max(-wi.z, 0.0f) * kInvPi;
    return {Rgb(p), p};
}
std::optional<LobeSample> Translucent::sample(Vec3f, float, Vec2f u) const {
    const Vec3f wi = sample_cosine_hemisphere(u);
    if (!(wi.z > 0))
        return std::nullopt;
    return LobeSample{{wi.x, wi.y, -wi.z}, Rgb(1), wi.z * kInvPi, kTransmissionRay};
}

// --- Rough diffuse
// -----------------------------------------------------------------------------------------------

namespace {

/// Fujii's normalisation, and albedos of his white surface: towards a cosine, and their mean (EON, section
/// 3).
struct FujiiAlbedo {
    float r, a;

    explicit FujiiAlbedo(float roughness) : r(clamp01(roughness)), a(1 / (1 + (0.5f - 2 * kInvPi / 3) * r)) {}
    float towards(float mu) const {
        mu = clamp01(mu);
        const float s = std::sqrt(1 - mu * mu), theta = std::acos(mu);
        // tan(theta) (1 - s^3) with the pole at grazing angles divided out
        const float tangent_term = s * mu * (1 + s + s * s) / (1 + s);
        const float g = s * (theta - s * mu) + 2.0f / 3 * (tangent_term - s);
        return a * (1 + r * kInvPi * g);
    }
    float mean() const { return a * (1 + (2.0f / 3 - 28 * kInvPi / 15) * r); }
};

/// Colour of the light that left after more than one bounce between facets. The paper has color^2; Cycles
/// scales its whole lobe by the colour and so has color^3, measured as 0.879 against 0.896 of albedo 0.2 at
/// roughness 0.5.
Rgb multiple_scattering_color(Rgb color, float mean_albedo) {
    return color * color * color * mean_albedo / (Rgb(1) - color * (1 - mean_albedo));
}

}  // namespace

LobeValue RoughDiffuse::eval(Vec3f wo, Vec3f wi) const {
    if (wi.z <= 0)
        return {};
    const FujiiAlbedo albedo_of(roughness);
    const float cos_o = std::max(wo.z, 0.0f), s = dot(wo, wi) - cos_o * wi.z;
    const float single = albedo_of.a * (1 + albedo_of.r * (s > 0 ? s / std::max(cos_o, wi.z) : s));
    const float mean = albedo_of.mean(),
                lost = (1 - albedo_of.towards(cos_o)) * (1 - albedo_of.towards(wi.z));
    // A smooth surface loses nothing; there `lost` and 1 - mean vanish together.
    const float multiple = mean < 1 ? std::max(0.0f, lost) / (1 - mean) : 0;
    const float p = wi.z * kInvPi;
    return {(color * std::max(0.0f, single) + multiple_scattering_color(color, mean) * multiple) * p, p};
}
std::optional<LobeSample> RoughDiffuse::sample(Vec3f wo, float, Vec2f u) const {
    return sample_cosine(*this, wo, u);
}
Rgb RoughDiffuse::albedo(Vec3f wo) const {
    const FujiiAlbedo albedo_of(roughness);
    const float single = albedo_of.towards(wo.z);
    return color * single + multiple_scattering_color(color, albedo_of.mean()) * (1 - single);
}

// --- Plastic
// -----------------------------------------------------------------------------------------------------

namespace {

/// Indices so near to 1 have no coat, and nothing that its roughness could change: the tables' ratios are 0 /
/// 0.
constexpr float kNoInterface = 1e-4f;

}  // namespace

PlasticBase::PlasticBase(Rgb base_color, float eta_, float roughness_, bool nonlinear)
    : eta(eta_), roughness(std::fabs(eta_ - 1) < kNoInterface ? 0 : roughness_) {
    float thrown_back = exact_fresnel_dielectric_mean(1 / eta);  // share of light from below
    if (roughness > 0 && thrown_back > 0) {                      // a coat of index 1 throws nothing back
        thrown_back *= mean_dielectric_albedo(roughness, 1 / eta).reflected /
                       mean_dielectric_albedo(0, 1 / eta).reflected;
        // Never more than does not get out: the tables are coarse where total reflection begins.
        thrown_back = std::min(thrown_back, 1 - mean_transmitted() / (eta * eta));
    }
    const Rgb once_more = nonlinear ? base_color : Rgb(1);
    color = base_color / (Rgb(1) - once_more * thrown_back);
}

/// Share of light from a cosine that gets through the coat: exact where it is smooth; the tables say by how
/// much roughness changes it.
float PlasticBase::transmitted(float mu) const {
    const float smooth = 1 - fresnel_dielectric(clamp01(mu), eta);
    if (roughness == 0)
        return smooth;
    const float at_0 = dielectric_albedo(mu, 0, eta).transmitted;
    return std::min(smooth * dielectric_albedo(mu, roughness, eta).transmitted / std::max(at_0, 1e-4f), 1.0f);
}
float PlasticBase::mean_transmitted() const {
    const float smooth = 1 - exact_fresnel_dielectric_mean(eta);
    if (roughness == 0)
        return smooth;
    return smooth * mean_dielectric_albedo(roughness, eta).transmitted /
           mean_dielectric_albedo(0, eta).transmitted;
}

LobeValue PlasticBase::eval(Vec3f wo, Vec3f wi) const {
    if (wo.z <= 0 || wi.z <= 0)
        return {};
    const float p = wi.z * kInvPi;
    return {color * (transmitted(wo.z) * transmitted(wi.z) / (eta * eta) * p), p};
}
std::optional<LobeSample> PlasticBase::sample(Vec3f wo, float, Vec2f u) const {
    return sample_cosine(*this, wo, u);
}
Rgb PlasticBase::albedo(Vec3f wo) const {
    return color * (transmitted(wo.z) * mean_transmitted() / (eta * eta));
}

// --- Toon
// --------------------------------------------------------------------------------------------------------

Vec3f Toon::axis(Vec3f wo) const {
    return glossy ? Vec3f(-wo.x, -wo.y, wo.z) : Vec3f(0, 0, 1);
}
float Toon::one_minus_cos() const {
    return 2 * sqr(std::sin(0.5f * std::min(size + smooth, 0.5f * kPi)));
}

LobeValue Toon::eval(Vec3f wo, Vec3f wi) const {
    const float share = one_minus_cos();
    if (wo.z <= 0 || wi.z <= 0 || !(share > 0))
        return {};
    const float cosine = dot(axis(wo), wi);
    if (cosine < 0)
        return {};
    const float outside = std::acos(std::min(cosine, 1.0f)) - size;
    const float value = outside < 0 ? 1 : outside < smooth ? 1 - outside / smooth : 0;
    const float pdf = value > 0 ? cone_pdf(share) : 0;
    return {Rgb(value * pdf), pdf};
}

std::optional<LobeSample> Toon::sample(Vec3f wo, float, Vec2f u) const {
    const Vec3f wi = Frame(axis(wo)).to_world(sample_cone(u, one_minus_cos()));
    const LobeValue value = eval(wo, wi);
    if (!(value.pdf > 0))
        return std::nullopt;
    return LobeSample{wi, value.f / value.pdf, value.pdf, kind(wi)};
}

Rgb Toon::albedo(Vec3f) const {
    const float share = one_minus_cos(), edge = std::min(size + smooth, 0.5f * kPi), border = edge - size;
    if (!(share > 0) || !(smooth > 0))
        return Rgb(1);
    // The integral of value(angle) sin(angle), by parts over the border.
    const float full =
        std::cos(size) - (1 - border / smooth) * std::cos(edge) - (std::sin(edge) - std::sin(size)) / smooth;
    return Rgb(clamp01((1 - std::cos(size) + full) / share));
}

// --- Subsurface
// --------------------------------------------------------------------------------------------------

std::optional<LobeSample> Subsurface::sample(Vec3f wo, float, Vec2f u) const {
    if (diffuse_entry || wo.z <= 0) {  // bent normals may face away
        const Vec3f w = sample_cosine_hemisphere(u);
        return LobeSample{{w.x, w.y, -w.z}, Rgb(1), 0, kDiffuseRay};
    }
    const auto refracted = [&](Vec3f h) {
        const float cos_o = dot(wo, h), cos_t = std::sqrt((eta - 1) * (eta + 1) + cos_o * cos_o) / eta;
        return normalize((cos_o / eta - cos_t) * h - wo / eta);
    };
    const Microfacet facets{alpha};
    Vec3f wi(0);
    if (!facets.specular())
        wi = refracted(facets.sample_normal(wo, u));
    if (!(wi.z < 0))  // steep facets may refract out of the surface: all light enters
        wi = refracted({0, 0, 1});
    return LobeSample{wi, Rgb(1), 0, kDiffuseRay};
}

}  // namespace nephele
