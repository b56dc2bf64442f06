// SPDX-License-Identifier: GPL-3.0-or-later
// How light passes tell a BSDF's lobes apart, as Cycles does: diffuse (diffuse transmission too), glossy
// (what glass reflects too), transmission.
#include "surfaces/bsdf.h"

namespace nephele {

namespace {

template <class Model>
std::uint32_t class_of(const Model& model, Vec3f local_wi) {
    return std::is_same_v<Model, Translucent> ? std::uint32_t{kDiffuseRay} : model.kind(local_wi);
}

Rgb& part(LobeShares& shares, std::uint32_t kind) {
    return kind == kDiffuseRay ? shares.diffuse : kind == kGlossyRay ? shares.glossy : shares.transmission;
}

}  // namespace

LobeShares Bsdf::shares(Vec3f wo, const BsdfSample& sample) const {
    LobeShares out;
    if (sample.specular) {
        part(out, sample.kind) = Rgb(1);
        return out;
    }
    for (int i = 0; i < count_; ++i) {
        const Lobe& l = lobe(i);
        const Vec3f local_wi = l.frame.to_local(sample.wi);
        const auto add = [&](const auto& m) {
            part(out, class_of(m, local_wi)) += l.weight * m.eval(l.frame.to_local(wo), local_wi).f;
        };
        std::visit(add, l.model);
    }
    const Rgb total = out.diffuse + out.glossy + out.transmission;
    const auto divide = [&](Rgb& share) {
        for (int c = 0; c < 3; ++c)
            share[c] = total[c] > 0 ? share[c] / total[c] : 0;
    };
    divide(out.diffuse);
    divide(out.glossy);
    divide(out.transmission);
    return out;
}

LobeShares Bsdf::colors(Vec3f wo) const {
    LobeShares out;
    for (int i = 0; i < count_; ++i) {
        const Lobe& l = lobe(i);
        const Vec3f local_wo = l.frame.to_local(wo);
        const auto add = [&](const auto& m) {
            using Model = std::decay_t<decltype(m)>;
            if constexpr (std::is_same_v<Model, Dielectric>) {
                const auto [reflected, transmitted] = m.albedos(local_wo);
                out.glossy += l.weight * reflected;
                out.transmission += l.weight * transmitted;
            } else if constexpr (std::is_same_v<Model, RoughDiffuse>) {
                out.diffuse += l.weight * m.color;  // the artist's colour, as Cycles has it
            } else {
                part(out, class_of(m, {0, 0, 1})) += l.weight * m.albedo(local_wo);
            }
        };
        std::visit(add, l.model);
    }
    return out;
}

}  // namespace nephele
