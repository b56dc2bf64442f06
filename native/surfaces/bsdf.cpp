// SPDX-License-Identifier: GPL-3.0-or-later
#include "surfaces/bsdf.h"

#include <new>

#include "surfaces/principled.h"

namespace nephele {

// --- The mixture
// -------------------------------------------------------------------------------------------------

void Bsdf::add(const LobeModel& model, Rgb weight, Vec3f n) {
    if (is_zero(weight) || count_ == kMaxLobes)
        return;  // validate() has counted the lobes
    new (storage_ + static_cast<std::size_t>(count_) * sizeof(Lobe)) Lobe{Frame(n), weight, 0, model};
    ++count_;
}

void Bsdf::finish(Vec3f wo) {
    float total = mean(transparency);
    for (int i = 0; i < count_; ++i) {
        Lobe& l = lobe(i);
        const auto choose = [&](const auto& model) {
            const bool specular = model.specular();
            if (!specular)
                has_smooth_ = true;
            if (count_ == 1 && total == 0)
                return 1.0f;  // no choice, no need for its albedo
            const Rgb albedo = model.albedo(l.frame.to_local(wo));
            // The albedo of a rough lobe is an estimate: never so small that a lobe which scatters is
            // starved.
            return mean(l.weight * (specular ? albedo : max(albedo, Rgb(0.02f))));
        };
        l.probability = std::visit(choose, l.model);
    }
    for (int i = 0; i < count_; ++i)
        total += lobe(i).probability;
    const float scale = total > 0 ? 1 / total : 0;
    transparent_probability_ = mean(transparency) * scale;
    for (int i = 0; i < count_; ++i)
        lobe(i).probability *= scale;
}

Rgb Bsdf::eval(Vec3f wo, Vec3f wi, float& pdf, bool& crosses, std::uint32_t kinds) const {
    constexpr std::uint32_t kScattered = kDiffuseRay | kGlossyRay | kTransmissionRay;
    const bool all = (kinds & kScattered) == kScattered;
    pdf = 0;
    crosses = false;
    Rgb same_side, beyond;
    if (!has_smooth_)
        return same_side;
    for (int i = 0; i < count_; ++i) {
        const Lobe& l = lobe(i);
        const Vec3f local_wi = l.frame.to_local(wi);
        const Vec3f local_wo = l.frame.to_local(wo);
        const LobeValue value =
            std::visit([&](const auto& m) { return m.eval(local_wo, local_wi); }, l.model);
        const bool counts =
            all || (std::visit([&](const auto& m) { return m.kind(local_wi); }, l.model) & kinds) != 0;
        if (counts)
            (leaves_beyond(l, wi, local_wi.z) ? beyond : same_side) += l.weight * value.f;
        pdf += l.probability * value.pdf;
    }
    // Lobes may disagree about a direction near the horizon: the greater share decides.
    crosses = mean(beyond) > mean(same_side);
    return same_side + beyond;
}

std::optional<BsdfSample> Bsdf::sample(Vec3f wo, float lobe_u, Vec2f u) const {
    if (lobe_u < transparent_probability_) {
        return BsdfSample{-wo, transparency / transparent_probability_, 0, true, 0, true};
    }
    float rest = lobe_u - transparent_probability_;
    const Lobe* chosen = nullptr;
    for (int i = 0; i < count_; ++i) {
        if (lobe(i).probability == 0)
            continue;
        if (chosen)
            rest -= chosen->probability;
        chosen = &lobe(i);
        if (rest < chosen->probability)
            break;  // rounding may leave a rest: the last lobe takes it
    }
    if (!chosen)
        return std::nullopt;
    const float choice = std::min(rest / chosen->probability, kOneMinusEpsilon);
    const Vec3f local_wo = chosen->frame.to_local(wo);
    const auto drawn =
        std::visit([&](const auto& m) { return m.sample(local_wo, choice, u); }, chosen->model);
    if (!drawn)
        return std::nullopt;
    const Vec3f wi = normalize(chosen->frame.to_world(drawn->wi));
    const bool specular = std::visit([](const auto& m) { return m.specular(); }, chosen->model);
    if (specular || count_ == 1) {
        const Rgb weight = chosen->weight * drawn->weight / chosen->probability;
        return BsdfSample{wi,       weight,      chosen->probability * drawn->pdf,
                          specular, drawn->kind, leaves_beyond(*chosen, wi, drawn->wi.z)};
    }
    float pdf;
    bool crosses;
    const Rgb f = eval(wo, wi, pdf, crosses);
    if (!(pdf > 0))
        return std::nullopt;
    return BsdfSample{wi, f / pdf, pdf, false, drawn->kind, crosses};
}

std::optional<BsdfSample> Bsdf::at(Vec3f wo, Vec3f wi, float u) const {
    BsdfSample out{wi, Rgb(0)};
    const Rgb f = eval(wo, wi, out.pdf, out.crosses);
    if (is_zero(f) || !(out.pdf > 0))
        return std::nullopt;
    out.weight = f / out.pdf;
    float rest = u * out.pdf;
    for (int i = 0; i < count_ && rest >= 0; ++i) {
        const Lobe& l = lobe(i);
        const Vec3f local_wi = l.frame.to_local(wi);
        const float pdf =
            std::visit([&](const auto& m) { return m.eval(l.frame.to_local(wo), local_wi).pdf; }, l.model);
        if (!(l.probability * pdf > 0))
            continue;
        out.kind = std::visit([&](const auto& m) { return m.kind(local_wi); }, l.model);
        rest -= l.probability * pdf;
    }
    return out;
}

Rgb Bsdf::albedo(Vec3f wo) const {
    Rgb sum;
    for (int i = 0; i < count_; ++i) {
        const Lobe& l = lobe(i);
        sum += l.weight * std::visit([&](const auto& m) { return m.albedo(l.frame.to_local(wo)); }, l.model);
    }
    return sum;
}

// --- Building from closures
// --------------------------------------------------------------------------------------

namespace {

/// A closure's inputs at a shading point.
struct Inputs {
    const ClosureRow& row;
    const RegisterFile& registers;
    const ShadingPoint& point;

    Rgb weight() const { return non_negative(registers[row.weight]); }
    Rgb color(int i) const { return non_negative(registers[row.inputs[static_cast<std::size_t>(i)]]); }
    float unit(int i) const { return std::min(color(i).x, 1.0f); }
    /// ior beyond the surface / ior on wo's side, where the input is that of the inside.
    float eta(int i) const {
        const float ior = bounded_ior(color(i).x) / point.outside_ior;
        return point.backfacing ? 1 / ior : ior;
    }
    Distribution distribution() const { return static_cast<Distribution>(row.mode); }
    Vec3f normal(int i) const {
        return closure_normal(row.inputs[static_cast<std::size_t>(i)], registers, point);
    }
    SeenInterface interface_of(int normal_input, int ior_input) const {
        return seen_interface(normal(normal_input), eta(ior_input), point.wo);
    }
    Vec3f bent(int i) const { return bent_normal(normal(i), point.ng, point.wo); }
};

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
    const auto [n, eta] = in.interface_of(glass_input::normal, glass_input::ior);
    const float roughness = in.unit(glass_input::roughness), mu = dot(n, in.point.wo);
    const Rgb color = in.color(glass_input::color);
    if (is_zero(color))
        return;
    bsdf.add(make_dielectric(in.distribution(), roughness, eta, Fresnel::dielectric(eta), color, color, mu),
             in.weight(), n);
}

void add_refraction(Bsdf& bsdf, const Inputs& in) {
    const auto [n, eta] = in.interface_of(refraction_input::normal, refraction_input::ior);
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
        case ClosureKind::medium:
            return;  // of volumes: see media/program_medium.h
    }
}

}  // namespace

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
