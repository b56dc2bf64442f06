// SPDX-License-Identifier: GPL-3.0-or-later
#include "surfaces/bsdf.h"

#include <new>

namespace nephele {

void Bsdf::add(const LobeModel& model, Rgb weight, const Frame& frame) {
    if (is_zero(weight) || count_ == kMaxLobes)
        return;  // validate() has counted the lobes
    new (storage_ + static_cast<std::size_t>(count_) * sizeof(Lobe)) Lobe{frame, weight, 0, model};
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
        BsdfSample sample{wi,       weight,      chosen->probability * drawn->pdf,
                          specular, drawn->kind, leaves_beyond(*chosen, wi, drawn->wi.z)};
        sample.below = std::get_if<Subsurface>(&chosen->model);
        return sample;
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

}  // namespace nephele
