// SPDX-License-Identifier: GPL-3.0-or-later
// From a program's closures to the lobes of a BSDF.
#include "surfaces/bsdf.h"
#include "surfaces/closure_inputs.h"
#include "surfaces/principled.h"

namespace nephele {
namespace {

using Inputs = ClosureInputs;

void add_diffuse(Bsdf& bsdf, const Inputs& in) {
    const float roughness = in.unit(diffuse_input::roughness);
    const Rgb color = in.color(diffuse_input::color);
    const Vec3f n = in.normal(diffuse_input::normal);
    if (roughness == 0) {
        bsdf.add(Lambert{}, in.weight() * color, n);
    } else if (!is_zero(color)) {
        bsdf.add(RoughDiffuse{min(color, Rgb(1)), roughness}, in.weight(), n);
    }
}

void add_glossy(Bsdf& bsdf, const Inputs& in) {
    const Rgb color = in.color(glossy_input::color);
    if (is_zero(color))
        return;
    const Vec3f n = in.bent(glossy_input::normal);
    const Fresnel fresnel = Fresnel::constant(min(color, Rgb(1)));
    const float mu = dot(n, in.point.wo);
    bsdf.add(make_reflection(in.distribution(), in.unit(glossy_input::roughness), fresnel, mu), in.weight(),
             n);
}

void add_glass(Bsdf& bsdf, const Inputs& in) {
    const auto [n, eta, flipped] = in.interface_of(glass_input::normal, glass_input::ior);
    const float roughness = in.unit(glass_input::roughness), mu = dot(n, in.point.wo);
    const Rgb color = in.color(glass_input::color);
    if (is_zero(color))
        return;
    bsdf.add(make_dielectric(in.distribution(), roughness, eta, Fresnel::dielectric(eta), color, color, mu),
             in.weight(), n);
}

void add_brushed(Bsdf& bsdf, const Inputs& in) {
    using namespace brushed_input;
    const Rgb tint = in.color(color);
    if (is_zero(tint))
        return;
    const float amount = std::clamp(finite(in.registers[in.row.inputs[anisotropy]]).x, -0.99f, 0.99f);
    const Brush brush{amount < 0 ? 1 / (1 + amount) : 1 - amount, in.tangent(tangent), in.turn(rotation)};
    add_reflection(bsdf, in.distribution(), in.unit(roughness), Fresnel::constant(min(tint, Rgb(1))),
                   in.weight(), in.bent(normal), brush, in.point.wo);
}

void add_metal(Bsdf& bsdf, const Inputs& in) {
    using namespace metal_input;
    const Fresnel fresnel =
        Fresnel::metal(min(in.color(base_color), Rgb(1)), min(in.color(edge_tint), Rgb(1)));
    const ThinFilm film =
        film_seen(in.color(thin_film_thickness).x, in.color(thin_film_ior).x, in.point.outside_ior);
    const Brush brush{anisotropic_stretch(in.unit(anisotropy)), in.tangent(tangent), in.turn(rotation)};
    add_reflection(bsdf, in.distribution(), in.unit(roughness), fresnel.under(film), in.weight(),
                   in.bent(normal), brush, in.point.wo);
}

void add_conductor(Bsdf& bsdf, const Inputs& in) {
    using namespace conductor_input;
    constexpr float kMost = 1e3f;  // whose square, times itself, is a float
    const Fresnel fresnel = Fresnel::conductor(min(max(in.color(ior), Rgb(1e-3f)), Rgb(kMost)),
                                               min(in.color(extinction), Rgb(kMost)));
    const ThinFilm film =
        film_seen(in.color(thin_film_thickness).x, in.color(thin_film_ior).x, in.point.outside_ior);
    const Brush brush{anisotropic_stretch(in.unit(anisotropy)), in.tangent(tangent), in.turn(rotation)};
    add_reflection(bsdf, in.distribution(), in.unit(roughness), fresnel.under(film), in.weight(),
                   in.bent(normal), brush, in.point.wo);
}

void add_filmed_glass(Bsdf& bsdf, const Inputs& in) {
    using namespace filmed_glass_input;
    const auto [n, eta, flipped] = in.interface_of(normal, ior);
    const Rgb tint = in.color(color);
    if (is_zero(tint))
        return;
    const bool inside = flipped != in.point.backfacing;
    const float around = inside ? bounded_ior(in.color(ior).x) : in.point.outside_ior;
    const Fresnel fresnel = Fresnel::dielectric(eta).under(
        film_seen(in.color(thin_film_thickness).x, in.color(thin_film_ior).x, around));
    bsdf.add(
        make_dielectric(in.distribution(), in.unit(roughness), eta, fresnel, tint, tint, dot(n, in.point.wo)),
        in.weight(), n);
}

void add_sheen(Bsdf& bsdf, const Inputs& in) {
    const Vec3f n = in.bent(sheen_input::normal);
    bsdf.add(Sheen(in.unit(sheen_input::roughness), dot(n, in.point.wo)),
             in.weight() * in.color(sheen_input::color), n);
}

void add_velvet(Bsdf& bsdf, const Inputs& in) {
    bsdf.add(Velvet{in.unit(velvet_input::roughness)}, in.weight() * in.color(velvet_input::color),
             in.bent(velvet_input::normal));
}

void add_toon(Bsdf& bsdf, const Inputs& in, bool glossy) {
    using namespace toon_diffuse_input;  // the other's are the same
    const float quarter = 0.5f * kPi;
    bsdf.add(Toon{quarter * in.unit(size), quarter * in.unit(smooth), glossy}, in.weight() * in.color(color),
             glossy ? in.bent(normal) : in.normal(normal));
}

void add_subsurface_closure(Bsdf& bsdf, const Inputs& in) {
    using namespace subsurface_input;
    const SubsurfaceLook look{in.color(color),     in.color(scale).x * in.color(radius),
                              in.color(ior).x,     in.unit(roughness),
                              in.unit(anisotropy), static_cast<SubsurfaceMethod>(in.row.mode)};
    const Vec3f n = in.normal(normal);
    bsdf.add(Lambert{}, add_subsurface(bsdf, look, in.weight(), n), n);
}

void add_refraction(Bsdf& bsdf, const Inputs& in) {
    const auto [n, eta, flipped] = in.interface_of(refraction_input::normal, refraction_input::ior);
    const auto distribution =
        in.distribution() == Distribution::beckmann ? Distribution::beckmann : Distribution::ggx;
    const float roughness = in.unit(refraction_input::roughness), mu = dot(n, in.point.wo);
    bsdf.add(make_dielectric(distribution, roughness, eta, Fresnel::constant(Rgb(0)), Rgb(0), Rgb(1), mu),
             in.weight() * in.color(refraction_input::color), n);
}

void add_plastic(Bsdf& bsdf, const Inputs& in) {
    // Opaque: either side has the coat outside.
    const float eta = bounded_ior(in.color(plastic_input::ior).x) / in.point.outside_ior;
    const float roughness = in.unit(plastic_input::roughness);
    const Vec3f n = in.bent(plastic_input::normal);
    const Reflection coat =
        make_reflection(in.distribution(), roughness, Fresnel::dielectric(eta), dot(n, in.point.wo));
    if (eta != 1)
        bsdf.add(coat, in.weight(), n);
    const Rgb color = min(in.color(plastic_input::color), Rgb(1));
    if (is_zero(color))
        return;
    const float seen_roughness = coat.specular() ? 0 : coat.facets.ggx_roughness();
    const bool nonlinear = in.color(plastic_input::nonlinear).x > 0;
    bsdf.add(PlasticBase(color, eta, seen_roughness, nonlinear), in.weight(), n);
}

void add_closure(Bsdf& bsdf, const ClosureRow& row, const RegisterFile& registers,
                 const ShadingPoint& point) {
    const Inputs in{row, registers, point};
    switch (row.kind) {
        case ClosureKind::diffuse:
            return add_diffuse(bsdf, in);
        case ClosureKind::glossy:
            return add_glossy(bsdf, in);
        case ClosureKind::glass:
            return add_glass(bsdf, in);
        case ClosureKind::refraction:
            return add_refraction(bsdf, in);
        case ClosureKind::translucent:
            return bsdf.add(Translucent{}, in.weight() * in.color(translucent_input::color),
                            in.normal(translucent_input::normal));
        case ClosureKind::transparent:
            bsdf.transparency += in.weight() * in.color(transparent_input::color);
            return;
        case ClosureKind::emission:
            bsdf.emission += closure_emission(row, registers, point);
            return;
        case ClosureKind::principled:
            return add_principled(bsdf, row, registers, point);
        case ClosureKind::plastic:
            return add_plastic(bsdf, in);
        case ClosureKind::brushed:
            return add_brushed(bsdf, in);
        case ClosureKind::metal:
            return add_metal(bsdf, in);
        case ClosureKind::conductor:
            return add_conductor(bsdf, in);
        case ClosureKind::filmed_glass:
            return add_filmed_glass(bsdf, in);
        case ClosureKind::sheen:
            return add_sheen(bsdf, in);
        case ClosureKind::velvet:
            return add_velvet(bsdf, in);
        case ClosureKind::toon_diffuse:
            return add_toon(bsdf, in, false);
        case ClosureKind::toon_glossy:
            return add_toon(bsdf, in, true);
        case ClosureKind::holdout:
            bsdf.holdout += in.weight();
            return;
        case ClosureKind::subsurface:
            return add_subsurface_closure(bsdf, in);
        case ClosureKind::medium:
            return;  // of volumes: see media/program_medium.h
    }
}

}  // namespace

Bsdf diffuse_bsdf(const ShadingPoint& point, Vec3f n) {
    Bsdf bsdf(point);
    bsdf.add(Lambert{}, Rgb(1), n);
    bsdf.finish(point.wo);
    return bsdf;
}

Vec3f subsurface_normal(const Program* program, const ShadingPoint& point, const TextureContext& context) {
    if (!program)
        return point.ns;
    for (const ClosureRow& row : program->closures) {
        const bool principled = row.kind == ClosureKind::principled;
        if (!principled && row.kind != ClosureKind::subsurface)
            continue;
        const int input = principled ? int{principled_input::normal} : int{subsurface_input::normal};
        const std::int16_t normal = row.inputs[static_cast<std::size_t>(input)];
        if (normal >= 0)
            return closure_normal(normal, RegisterFile(*program, point, context), point);
    }
    return point.ns;
}

Bsdf make_bsdf(const Program* program, const ShadingPoint& point, const TextureContext& context) {
    Bsdf bsdf(point);
    if (program) {
        const RegisterFile registers(*program, point, context);
        for (const ClosureRow& row : program->closures)
            add_closure(bsdf, row, registers, point);
    } else {
        bsdf.add(Lambert{}, Rgb(0.8f), point.ns);
    }
    bsdf.finish(point.wo);
    return bsdf;
}

}  // namespace nephele
