// SPDX-License-Identifier: GPL-3.0-or-later
// The lobes that surfaces are mixed from. Directions are unit vectors in the lobe's own frame, z its normal;
// wo is on the side of +z. Weights (colours, mixing) are the Bsdf's; a lobe is the bare scattering function.
#pragma once

#include <concepts>
#include <optional>
#include <variant>

#include "base/surface.h"
#include "surfaces/fresnel.h"
#include "surfaces/microfacet.h"

namespace nephele {

/// f |cos wi| and the density of the lobe's own sampling, per solid angle.
struct LobeValue {
    Rgb f;
    float pdf = 0;
};

/// A direction drawn from a lobe. weight: f |cos wi| / pdf; for a specular lobe the pdf is a point mass and
/// left 0.
struct LobeSample {
    Vec3f wi;
    Rgb weight;
    float pdf = 0;
    std::uint32_t kind = kDiffuseRay;
};

/// What every lobe offers. kind(wi): of the ray that it scatters along wi. A specular lobe (a discrete set of
/// directions) has eval() = 0.
template <typename L>
concept LobeLike = requires(const L lobe, Vec3f wo, Vec3f wi, float choice, Vec2f u) {
    { lobe.specular() } -> std::same_as<bool>;
    { lobe.kind(wi) } -> std::same_as<std::uint32_t>;
    { lobe.eval(wo, wi) } -> std::same_as<LobeValue>;
    { lobe.sample(wo, choice, u) } -> std::same_as<std::optional<LobeSample>>;
    {
        lobe.albedo(wo)
        } -> std::same_as<Rgb>;  ///< share of light from wo that the lobe scatters; may be estimated
};

/// Lambert's diffuse reflection.
struct Lambert {
    bool specular() const { return false; }
    std::uint32_t kind(Vec3f) const { return kDiffuseRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f) const { return Rgb(1); }
};

/// Lambert's diffuse transmission.
struct Translucent {
    bool specular() const { return false; }
    std::uint32_t kind(Vec3f) const { return kTransmissionRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f) const { return Rgb(1); }
};

/// Rough diffuse reflection that keeps its energy: Fujii's Oren-Nayar with multiple scattering (Portsmouth,
/// Kutz and Hill 2024, "EON: a practical energy-preserving rough diffuse BRDF"). color is part of the lobe,
/// since light that bounces between facets takes it up more than once; as in Cycles, the paper's colour of
/// those bounces counts once more.
struct RoughDiffuse {
    Rgb color{1};
    float roughness = 0;  ///< [0,1]

    bool specular() const { return false; }
    std::uint32_t kind(Vec3f) const { return kDiffuseRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f wo) const;
};

/// The diffuse base of a plastic: Lambert's surface below a smooth or rough dielectric coat. Light is dimmed
/// by the coat's transmittance on its way in and out; what the coat throws back from below adds up with the
/// base's colour (the "plastic" of Mitsuba 3, Jakob et al. 2022). The coat's own reflection is a lobe of its
/// own. A rough coat scatters once, and loses the light that would need more.
struct PlasticBase {
    Rgb color;            ///< of the base, with all reflections between it and the coat
    float eta = 1.5f;     ///< ior of the coat / ior on wo's side
    float roughness = 0;  ///< of the coat, sqrt(alpha) of GGX

    /// nonlinear: light that the coat throws back takes up `color` anew each time; else it counts as if the
    /// base were white for it, so that all of the result is proportional to the colour.
    PlasticBase(Rgb base_color, float eta, float roughness, bool nonlinear);

    bool specular() const { return false; }
    std::uint32_t kind(Vec3f) const { return kDiffuseRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f wo) const;

  private:
    float transmitted(float mu) const;
    float mean_transmitted() const;
};

/// Microfacet reflection with any Fresnel curve: glossy, metal, coat, the reflecting part of a plastic.
struct Reflection {
    Microfacet facets;
    Fresnel fresnel;
    Rgb scale{1};  ///< compensates the energy that single scattering loses; 1 for none

    bool specular() const { return facets.specular(); }
    std::uint32_t kind(Vec3f) const { return kGlossyRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f wo) const;
};

/// Microfacet reflection and refraction (Walter et al. 2007). Radiance is not scaled by the squared index, as
/// in Cycles.
struct Dielectric {
    Microfacet facets;
    Fresnel fresnel;   ///< constant 0 makes the lobe refract only
    float eta = 1.5f;  ///< ior beyond the surface / ior on wo's side
    Rgb reflection_tint{1}, transmission_tint{1};
    Rgb scale{1};  ///< as Reflection's

    bool specular() const { return facets.specular(); }
    std::uint32_t kind(Vec3f wi) const { return wi.z > 0 ? kGlossyRay : kTransmissionRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    /// Shares reflected and transmitted.
    std::pair<Rgb, Rgb> albedos(Vec3f wo) const;
    Rgb albedo(Vec3f wo) const {
        const auto [reflected, transmitted] = albedos(wo);
        return reflected + transmitted;
    }

  private:
    Rgb reflectance(float cosine) const;
    float reflect_probability(Rgb reflected) const;
};

/// Reflection off microfibres that stand on the surface, see sheen.cpp. It is sampled exactly.
struct Sheen {
    float a = 1, b = 0;   ///< of the linear map
    float reflected = 0;  ///< the albedo

    /// Seen from cosine mu: eval() and sample() are to be given a wo that has it.
    Sheen(float roughness, float mu);

    bool specular() const { return false; }
    std::uint32_t kind(Vec3f) const { return kDiffuseRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f) const { return Rgb(reflected); }
};

/// Velvet by an inverted Gaussian of normals, see sheen.cpp.
struct Velvet {
    float roughness = 0.5f;

    bool specular() const { return false; }
    std::uint32_t kind(Vec3f) const { return kDiffuseRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f) const { return Rgb(0.5f); }
};

/// A cartoon's reflection, of constant value in a cone around the normal or the mirrored direction and
/// falling off around it; f |cos| over the cone has no cosine. Not reciprocal.
struct Toon {
    float size = 0, smooth = 0;  ///< angles of the cone and of its border
    bool glossy = false;

    bool specular() const { return false; }
    std::uint32_t kind(Vec3f) const { return glossy ? kGlossyRay : kDiffuseRay; }
    LobeValue eval(Vec3f wo, Vec3f wi) const;
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f wo) const;  ///< as if the horizon cut nothing off

  private:
    Vec3f axis(Vec3f wo) const;
    float one_minus_cos() const;
};

/// Where light goes below the surface and comes back elsewhere (integrators/subsurface.h). As a lobe it only
/// draws the direction of entry, which no light sampling can stand for.
struct Subsurface {
    Rgb color;                   ///< share of the light that a flat surface returns
    Rgb mean_free_path;          ///< by reduced scattering, m
    float anisotropy = 0;        ///< mean cosine of its phase function
    float eta = 1.4f;            ///< ior below / ior on wo's side, by which light is bent that enters
    float alpha = 1;             ///< of the GGX facets that bend it
    bool diffuse_entry = false;  ///< light enters by a cosine instead

    bool specular() const { return true; }
    std::uint32_t kind(Vec3f) const { return kDiffuseRay; }
    LobeValue eval(Vec3f, Vec3f) const { return {}; }
    std::optional<LobeSample> sample(Vec3f wo, float choice, Vec2f u) const;
    Rgb albedo(Vec3f) const { return color; }
};

using LobeModel = std::variant<Lambert, Translucent, RoughDiffuse, PlasticBase, Reflection, Dielectric, Sheen,
                               Velvet, Toon, Subsurface>;

static_assert(LobeLike<Lambert> && LobeLike<Translucent> && LobeLike<RoughDiffuse> && LobeLike<PlasticBase> &&
              LobeLike<Reflection> && LobeLike<Dielectric> && LobeLike<Sheen> && LobeLike<Velvet> &&
              LobeLike<Toon> && LobeLike<Subsurface>);

}  // namespace nephele
