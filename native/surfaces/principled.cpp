// SPDX-License-Identifier: GPL-3.0-or-later
#include "surfaces/principled.h"

#include "surfaces/bsdf.h"

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
    Distribution distribution() const { return static_cast<Distribution>(row.mode % kDistributionCount); }
    SubsurfaceMethod subsurface_method() const {
        return static_cast<SubsurfaceMethod>(row.mode / kDistributionCount);
    }
    Vec3f normal(int input) const {
        return bent_normal(closure_normal(row.inputs[static_cast<std::size_t>(input)], registers, point),
                           point.ng, point.wo);
    }
    Brush brush() const {
        const float anisotropy = unit(principled_input::anisotropic);
        if (anisotropy == 0)
            return {};
        const std::int16_t tangent = row.inputs[principled_input::tangent];
        return {anisotropic_stretch(anisotropy), tangent < 0 ? Vec3f(0) : finite(registers[tangent]),
                finite(registers[row.inputs[principled_input::anisotropic_rotation]]).x};
    }
    /// around: the index on wo's side.
    ThinFilm film(float around) const {
        const float thickness = value(principled_input::thin_film_thickness);
        return thickness == 0 ? ThinFilm{}
                              : film_seen(thickness, value(principled_input::thin_film_ior), around);
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
    const Sheen sheen(p.unit(principled_input::sheen_roughness), mu);
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
    const Fresnel fresnel = Fresnel::metal(min(base, Rgb(1)), tint).under(p.film(p.point.outside_ior));
    add_reflection(bsdf, p.distribution(), p.unit(principled_input::roughness), fresnel, weight * metallic, n,
                   p.brush(), p.point.wo);
    return weight * (1 - metallic);
}

Rgb add_glass(const Principled& p, Rgb weight, Rgb base, Bsdf& bsdf) {
    const float amount = p.unit(principled_input::transmission_weight);
    if (amount == 0)
        return weight;
    const float inside = bounded_ior(p.value(principled_input::ior)), ior = inside / p.point.outside_ior;
    const auto [n, eta, flipped] =
        seen_interface(closure_normal(p.row.inputs[principled_input::normal], p.registers, p.point),
                       p.point.backfacing ? 1 / ior : ior, p.point.wo);
    const Rgb tint = min(p.color(principled_input::specular_tint), Rgb(1));
    const Fresnel fresnel = Fresnel::dielectric(eta, tint * f0_from_ior(eta))
                                .under(p.film(flipped != p.point.backfacing ? inside : p.point.outside_ior));
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
    const Fresnel fresnel =
        Fresnel::dielectric(ior, min(p.color(principled_input::specular_tint) * f0, Rgb(1)))
            .under(p.film(p.point.outside_ior));
    return under_layer(
        weight, add_reflection(bsdf, p.distribution(), p.unit(principled_input::roughness), fresnel, weight,
                               p.normal(principled_input::normal), p.brush(), p.point.wo));
}

/// What scatters below the surface, and the diffuse rest.
void add_base(const Principled& p, Rgb weight, Rgb base, Bsdf& bsdf) {
    const Vec3f n = closure_normal(p.row.inputs[principled_input::normal], p.registers, p.point);
    Rgb diffuse = weight * base;
    const float below = p.unit(principled_input::subsurface_weight);
    if (below > 0) {
        const SubsurfaceMethod method = p.subsurface_method();
        const int ior = method == SubsurfaceMethod::random_walk_skin ? principled_input::subsurface_ior
                                                                     : principled_input::ior;
        const SubsurfaceLook look{
            base,
            p.value(principled_input::subsurface_scale) * p.color(principled_input::subsurface_radius),
            p.value(ior),
            p.unit(principled_input::roughness),
            p.unit(principled_input::subsurface_anisotropy),
            method};
        diffuse = diffuse * (1 - below) + add_subsurface(bsdf, look, weight * below, n);
    }
    const float roughness = p.unit(principled_input::diffuse_roughness);
    if (roughness == 0) {
        bsdf.add(Lambert{}, diffuse, n);
    } else if (!is_zero(diffuse)) {
        const Rgb color = min(base, Rgb(1));
        const auto share = [&](int c) { return color[c] > 0 ? diffuse[c] / color[c] : 0; };
        bsdf.add(RoughDiffuse{color, roughness}, {share(0), share(1), share(2)}, n);
    }
}

Rgb opaque_weight(const Principled& p) {
    return non_negative(p.registers[p.row.weight]) * p.unit(principled_input::alpha);
}
Rgb emitted(const Principled& p) {
    return finite(p.registers[p.row.inputs[principled_input::emission_color]]) *
           finite(p.registers[p.row.inputs[principled_input::emission_strength]]).x;
}

}  // namespace

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
    add_base(p, add_specular(p, weight, bsdf), base, bsdf);
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
