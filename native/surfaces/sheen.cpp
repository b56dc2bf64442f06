// SPDX-License-Identifier: GPL-3.0-or-later
// Sheen as Zeltner, Burley and Chiang 2022 have it, "Practical Multiple-Scattering Sheen Using Linearly
// Transformed Cosines": f cos = R D(M wi / |M wi|) |M| / |M wi|^3, D the cosine lobe, M = [A 0 B; 0 A 0; 0 0
// 1] with wo over the x axis. A, B and R depend on roughness and wo's cosine. The table holds what Cycles 5.0
// has, found from the brightness of 32 x 32 white planes under 13 suns each, which such lobes explain to 0.2
// %: roughness i / 31 by cosine j / 31, interpolated linearly. Rows and columns where next to nothing is
// reflected have their neighbours' A and B; at grazing angles the table is extrapolated. Velvet: Ashikhmin,
// Premoze and Shirley 2000, "A Microfacet-based BRDF Generator".
#include <array>

#include "math/warp.h"
#include "surfaces/lobes.h"

namespace nephele {
namespace {

constexpr int kNodes = 32;
constexpr std::array<Vec3f, kNodes * kNodes> kTable{{
#include "surfaces/sheen_table.inc"
}};

Vec3f fitted(float roughness, float mu) {
    const float x = clamp01(mu) * (kNodes - 1), y = clamp01(roughness) * (kNodes - 1);
    const int i = std::min(static_cast<int>(x), kNodes - 2), j = std::min(static_cast<int>(y), kNodes - 2);
    const auto at = [&](int di, int dj) {
        return kTable[static_cast<std::size_t>((j + dj) * kNodes + i + di)];
    };
    const float u = x - static_cast<float>(i), v = y - static_cast<float>(j);
    return lerp(lerp(at(0, 0), at(1, 0), u), lerp(at(0, 1), at(1, 1), u), v);
}

/// The frame whose x axis wo stands over.
Frame frame_of(Vec3f wo) {
    return {Vec3f(0, 0, 1), Vec3f(wo.x, wo.y, 0)};
}

}  // namespace

Sheen::Sheen(float roughness, float mu) {
    const Vec3f fit = fitted(roughness, mu);
    a = fit.x, b = fit.y, reflected = fit.z;
}

LobeValue Sheen::eval(Vec3f wo, Vec3f wi) const {
    if (wo.z <= 0 || wi.z <= 0)
        return {};
    const Vec3f w = frame_of(wo).to_local(wi);
    const float x = a * w.x + b * w.z, y = a * w.y, length2 = x * x + y * y + w.z * w.z;
    const float pdf = kInvPi * w.z * sqr(a / length2);
    return {Rgb(reflected * pdf), pdf};
}

std::optional<LobeSample> Sheen::sample(Vec3f wo, float, Vec2f u) const {
    const Vec3f drawn = sample_cosine_hemisphere(u);
    const Vec3f w = normalize(Vec3f((drawn.x - b * drawn.z) / a, drawn.y / a, drawn.z));
    const Vec3f wi = frame_of(wo).to_world(w);
    const LobeValue value = eval(wo, wi);
    if (!(value.pdf > 0))
        return std::nullopt;
    return LobeSample{wi, Rgb(reflected), value.pdf, kDiffuseRay};
}

// --- Velvet

LobeValue Velvet::eval(Vec3f wo, Vec3f wi) const {
    if (wo.z <= 0 || wi.z <= 0)
        return {};
    const Vec3f h = normalize(wo + wi);
    const float cos_o = dot(wo, h), sin2 = h.x * h.x + h.y * h.y;
    const float pdf = 0.5f * kInvPi;
    if (!(sin2 > 0) || !(cos_o > 0))
        return {Rgb(0), pdf};
    const float inverse = 1 / sqr(std::max(roughness, 0.01f));
    const float D = std::exp(-h.z * h.z / sin2 * inverse) * inverse * kInvPi / (sin2 * sin2);
    const float G = std::min(1.0f, 2 * h.z / cos_o * std::min(wo.z, wi.z));
    const float f = 0.25f * D * G / wo.z;
    return {Rgb(std::isfinite(f) ? f : 0), pdf};
}

std::optional<LobeSample> Velvet::sample(Vec3f wo, float, Vec2f u) const {
    const Vec3f wi = spherical(1 - u.x, u.y);
    const LobeValue value = eval(wo, wi);
    if (!(wi.z > 0))
        return std::nullopt;
    return LobeSample{wi, value.f / value.pdf, value.pdf, kDiffuseRay};
}

}  // namespace nephele
