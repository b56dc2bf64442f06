// SPDX-License-Identifier: GPL-3.0-or-later
// The BSDF of one shading point: the lobes that a shading program's closures stand for, mixed by weight.
// Built on the stack, without heap. Directions are unit vectors in world space that point away from the
// surface; wo is the one that the BSDF was made for.
#pragma once

#include <optional>
#include <type_traits>

#include "base/surface.h"
#include "shading/program.h"
#include "surfaces/lobes.h"

namespace nephele {

/// By class of lobe, per channel: see surfaces/bsdf_shares.cpp.
struct LobeShares {
    Rgb diffuse, glossy, transmission;
};

class Bsdf {
  public:
    explicit Bsdf(const ShadingPoint& point) : ng_(point.ng) {}

    Rgb emission;      ///< radiance that leaves along wo
    Rgb transparency;  ///< weight of the straight-through lobe (Transparent BSDF, alpha)
    Rgb holdout;       ///< weight of holes in a transparent film

    /// Whether any lobe is neither specular nor straight-through, so that light sampling can serve it.
    bool has_smooth() const { return has_smooth_; }

    /// f |cos| summed over the smooth lobes. pdf: of sample() to return wi as a smooth sample, per solid
    /// angle; it holds the probability of choosing each smooth lobe among all lobes, specular and
    /// straight-through ones included. crosses: whether wi leaves on the other side of the surface than wo;
    /// see leaves_beyond.
    /// kinds: of rays whose lobes count in f; the density is that of all.
    Rgb eval(Vec3f wo, Vec3f wi, float& pdf, bool& crosses, std::uint32_t kinds = ~0u) const;

    /// Draws a direction. Straight-through samples have wi = -wo, specular = true and kind = 0: the ray keeps
    /// its kind and has not bounced. Returns nothing where the chosen lobe absorbs.
    std::optional<BsdfSample> sample(Vec3f wo, float lobe_u, Vec2f u) const;

    /// The smooth sample that wi stands for where something else drew it; u picks its kind among the lobes as
    /// sample() would have. Returns nothing where no lobe scatters there.
    std::optional<BsdfSample> at(Vec3f wo, Vec3f wi, float u) const;

    /// Directional albedo (estimated for the rough lobes), without the straight-through share.
    Rgb albedo(Vec3f wo) const;

    /// Of the light that the sample brings from its wi, the share of each class; they add up to 1 where there
    /// is any.
    LobeShares shares(Vec3f wo, const BsdfSample& sample) const;
    /// The albedo of each class.
    LobeShares colors(Vec3f wo) const;

    /// Adds a lobe around the unit normal n. Building only; call finish() after the last.
    void add(const LobeModel& model, Rgb weight, Vec3f n) { add(model, weight, Frame(n)); }
    void add(const LobeModel& model, Rgb weight, const Frame& frame);
    /// Sets the probabilities of choosing each lobe, by their albedos.
    void finish(Vec3f wo);

  private:
    struct Lobe {
        Frame frame;
        Rgb weight;
        float probability = 0;
        LobeModel model;
    };
    const Lobe& lobe(int i) const { return reinterpret_cast<const Lobe*>(storage_)[i]; }
    Lobe& lobe(int i) { return reinterpret_cast<Lobe*>(storage_)[i]; }

    /// Whether a ray along wi leaves this lobe on the other side of the surface than wo. Light that is
    /// reflected or diffused stays on the side that the lobe's normal says, wherever wi points; its ray may
    /// then meet the face once more (scene/departure.cpp). An interface between dielectrics lets light
    /// through either way, so there wi's side of the face decides and nothing meets the face twice.
    bool leaves_beyond(const Lobe& lobe, Vec3f wi, float local_z) const {
        return std::holds_alternative<Dielectric>(lobe.model) ? dot(wi, ng_) < 0 : local_z < 0;
    }

    Vec3f ng_;  // on wo's side
    int count_ = 0;
    bool has_smooth_ = false;
    float transparent_probability_ = 0;
    static_assert(std::is_trivially_destructible_v<LobeModel>);
    alignas(Lobe) std::byte storage_[kMaxLobes * sizeof(Lobe)];  // lobes 0 to count_ - 1 live here
};

/// A white diffuse surface of normal n: what light leaves by that has scattered below.
Bsdf diffuse_bsdf(const ShadingPoint& point, Vec3f n);

/// The normal of the first closure that scatters below the surface, where light leaves that did.
Vec3f subsurface_normal(const Program* program, const ShadingPoint& point, const TextureContext& context);

/// Runs the program and builds its lobes. program: validated, or null for the default, grey diffuse 0.8.
Bsdf make_bsdf(const Program* program, const ShadingPoint& point, const TextureContext& context);

/// Radiance that leaves along wo, or that the background sends along -wo; no lobes are built.
Rgb evaluate_emission(const Program& program, const ShadingPoint& point, const TextureContext& context);

/// The emission of one closure.
Rgb closure_emission(const ClosureRow& row, const RegisterFile& registers, const ShadingPoint& point);

/// Share of light that goes straight through, for shadow rays; no lobes are built.
Rgb evaluate_transparency(const Program& program, const ShadingPoint& point, const TextureContext& context);

/// Index of refraction of what the surface bounds: that of the program's first glass, refraction or
/// Principled closure, 1 where it has none.
float evaluate_interior_ior(const Program& program, const ShadingPoint& point, const TextureContext& context);

/// What a program can do at all, so that the integrator can skip the rest.
struct ProgramTraits {
    bool emissive = false;               ///< may emit
    bool may_transmit_straight = false;  ///< has a transparent closure, or an alpha that may be below 1
    bool has_surface_lobes = false;      ///< has a closure that scatters
    bool constant = false;               ///< no code: the same everywhere
    std::optional<float> interior_ior;   ///< see evaluate_interior_ior, where it is constant
    std::optional<Rgb>
        constant_emission;  ///< the emission, where it is the same at every point and direction
};
ProgramTraits traits_of(const Program& program);
/// Traits of the default material, which has no program.
inline ProgramTraits default_traits() {
    return {.has_surface_lobes = true, .constant = true, .interior_ior = 1.0f, .constant_emission = Rgb(0)};
}

}  // namespace nephele
