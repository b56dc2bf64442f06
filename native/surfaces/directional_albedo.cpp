// SPDX-License-Identifier: GPL-3.0-or-later
// Grids: mu = x^2 (finer towards grazing angles), roughness and sheen alpha linear, eta by t = |eta - 1| /
// (eta + 1), so that t^2 is the reflectance at normal incidence. Interpolated linearly along x, roughness and
// t.
#include "surfaces/directional_albedo.h"

#include <array>
#include <vector>

#include "math/warp.h"
#include "surfaces/fresnel.h"
#include "surfaces/lobes.h"
#include "surfaces/microfacet.h"

namespace nephele {
namespace {

constexpr int kFine = 32, kCoarse = 16;  // nodes an axis of the tables of two and of three parameters

float node(int i, int count) {
    return static_cast<float>(i) / static_cast<float>(count - 1);
}
Vec3f direction(float mu) {
    return {std::sqrt(std::max(0.0f, 1 - mu * mu)), 0, mu};
}
/// mu of node i; grazing itself has no albedo, so the first node stands a little above.
float node_mu(int i, int count) {
    return std::max(sqr(node(i, count)), 1e-3f);
}

/// Points that fill the unit square evenly (the additive recurrence of the plastic number, Roberts 2018).
Vec2f even_point(int i) {
    const double x = 0.5 + 0.7548776662466927 * i, y = 0.5 + 0.5698402909980532 * i;
    return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

/// Calls visit(h, wi, weight) for reflections at GGX normals; weight: G2 / G1, the estimator of the white
/// albedo.
template <typename F>
void visit_normals(Vec3f wo, Microfacet facets, int count, F visit) {
    for (int i = 0; i < count; ++i)
        visit(facets.sample_normal(wo, even_point(i)));
}
float shadowing(Microfacet facets, Vec3f wo, Vec3f wi) {
    const float lambda_o = facets.Lambda(wo);
    return (1 + lambda_o) / (1 + lambda_o + facets.Lambda(wi));
}

/// Position among `count` nodes: lower node and fraction.
struct Place {
    int i;
    float t;

    Place(float x, int count) {
        const float scaled = (x > 0 ? std::min(x, 1.0f) : 0) * static_cast<float>(count - 1);  // NaN goes low
        i = std::min(static_cast<int>(scaled), count - 2);
        t = scaled - static_cast<float>(i);
    }
};

template <int size>
struct Table2 {
    std::array<float, size * size> values{};

    float& at(int x, int y) { return values[static_cast<std::size_t>(x + size * y)]; }
    float at(int x, int y) const { return values[static_cast<std::size_t>(x + size * y)]; }
    float operator()(float x, float y) const {
        const Place px(x, size), py(y, size);
        const auto row = [&](int j) { return lerp(at(px.i, j), at(px.i + 1, j), px.t); };
        return lerp(row(py.i), row(py.i + 1), py.t);
    }
};

// --- Reflection
// --------------------------------------------------------------------------------------------------

struct ReflectionTable {
    Table2<kFine> albedo;
    std::array<float, kFine> mean{};

    ReflectionTable() {
        constexpr int kSamples = 1024;
        for (int j = 0; j < kFine; ++j) {
            const Microfacet facets{sqr(node(j, kFine)), false};
            for (int i = 0; i < kFine; ++i)
                albedo.at(i, j) = integrate(direction(node_mu(i, kFine)), facets, kSamples);
            mean[static_cast<std::size_t>(j)] = integrate_mean(j);
        }
    }
    static float integrate(Vec3f wo, Microfacet facets, int samples) {
        if (facets.specular())
            return 1;
        double sum = 0;
        visit_normals(wo, facets, samples, [&](Vec3f h) {
            const Vec3f wi = 2 * dot(wo, h) * h - wo;
            if (wi.z > 0)
                sum += static_cast<double>(shadowing(facets, wo, wi));
        });
        return static_cast<float>(sum / samples);
    }
    /// 2 integral of albedo mu dmu, with mu = x^2: 4 integral of albedo x^3 dx.
    float integrate_mean(int j) const {
        constexpr int kSteps = 256;
        double sum = 0, norm = 0;
        for (int i = 0; i < kSteps; ++i) {
            const double x = (i + 0.5) / kSteps, weight = x * x * x;
            sum += weight * static_cast<double>(albedo(static_cast<float>(x), node(j, kFine)));
            norm += weight;
        }
        return static_cast<float>(sum / norm);
    }
};
const ReflectionTable& reflection_table() {
    static const ReflectionTable table;
    return table;
}

// --- Dielectric interface
// ----------------------------------------------------------------------------------------

float eta_of(float t, bool denser) {
    return denser ? (1 + t) / (1 - t) : (1 - t) / (1 + t);
}

struct DielectricTable {
    std::vector<DielectricAlbedo> values;  ///< [denser][t][roughness][mu]
    std::vector<DielectricAlbedo> means;   ///< the same, every mu holding the mean over the hemisphere

    static std::size_t index(bool denser, int t, int roughness, int mu) {
        return static_cast<std::size_t>(((denser ? kCoarse : 0) + t) * kCoarse * kCoarse +
                                        roughness * kCoarse + mu);
    }
    DielectricTable() : values(2 * kCoarse * kCoarse * kCoarse), means(values.size()) {
        for (int j = 0; j < kCoarse; ++j) {
            for (int i = 0; i < kCoarse; ++i)
                integrate(j, i);
        }
        for (std::size_t first = 0; first < values.size(); first += kCoarse)
            average(first);
    }
    /// Weights of the nodes: 4 x^3 dx by the trapezoidal rule.
    void average(std::size_t first) {
        DielectricAlbedo sum;
        float norm = 0;
        for (int i = 0; i < kCoarse; ++i) {
            const float x = node(i, kCoarse), weight = x * x * x * (i + 1 == kCoarse ? 0.5f : 1.0f);
            const DielectricAlbedo& value = values[first + static_cast<std::size_t>(i)];
            sum.reflected += weight * value.reflected;
            sum.transmitted += weight * value.transmitted;
            norm += weight;
        }
        const DielectricAlbedo mean{sum.reflected / norm, sum.transmitted / norm};
        std::fill_n(means.begin() + static_cast<std::ptrdiff_t>(first), kCoarse, mean);
    }
    /// Fills all indices of refraction for one direction and roughness.
    void integrate(int j, int i) {
        constexpr int kSamples = 512;
        const Microfacet facets{std::max(sqr(node(j, kCoarse)), 2 * Microfacet::kSpecularAlpha), false};
        const Vec3f wo = direction(node_mu(i, kCoarse));
        visit_normals(wo, facets, kSamples, [&](Vec3f h) {
            const float c = dot(wo, h);
            const Vec3f mirrored = 2 * c * h - wo;
            const float reflected = mirrored.z > 0 ? shadowing(facets, wo, mirrored) / kSamples : 0;
            for (int k = 0; k < 2 * kCoarse; ++k) {
                const bool denser = k >= kCoarse;
                const float eta = eta_of(std::min(node(k % kCoarse, kCoarse), 0.999f), denser);
                float cos_t;
                const float F = eta == 1 ? (cos_t = c, 0.0f) : fresnel_dielectric(c, eta, cos_t);
                const Vec3f refracted = (c / eta - cos_t) * h - wo / eta;
                DielectricAlbedo& out = values[index(denser, k % kCoarse, j, i)];
                out.reflected += F * reflected;
                if (F < 1 && refracted.z < 0)
                    out.transmitted += (1 - F) * shadowing(facets, wo, refracted) / kSamples;
            }
        });
    }
    static DielectricAlbedo lookup(const std::vector<DielectricAlbedo>& table, float x, float roughness,
                                   float eta) {
        const float t = std::fabs(eta - 1) / (eta + 1);
        const bool denser = eta >= 1;
        const Place px(x, kCoarse), pr(roughness, kCoarse), pt(t, kCoarse);
        DielectricAlbedo sum;
        for (int corner = 0; corner < 8; ++corner) {
            const int dx = corner & 1, dr = corner >> 1 & 1, dt = corner >> 2;
            const float weight = (dx ? px.t : 1 - px.t) * (dr ? pr.t : 1 - pr.t) * (dt ? pt.t : 1 - pt.t);
            const DielectricAlbedo& value = table[index(denser, pt.i + dt, pr.i + dr, px.i + dx)];
            sum.reflected += weight * value.reflected;
            sum.transmitted += weight * value.transmitted;
        }
        return sum;
    }
};

const DielectricTable& dielectric_table() {
    static const DielectricTable table;
    return table;
}

// --- Sheen
// -------------------------------------------------------------------------------------------------------

struct SheenTable {
    Table2<kFine> albedo;

    SheenTable() {
        constexpr int kSamples = 1024;
        for (int j = 0; j < kFine; ++j) {
            const Sheen sheen{node(j, kFine), 1};
            for (int i = 0; i < kFine; ++i) {
                const Vec3f wo = direction(node_mu(i, kFine));
                double sum = 0;
                for (int k = 0; k < kSamples; ++k) {
                    const Vec2f u =
                        even_point(k);  // uniform in solid angle: the lobe is strongest at grazing angles
                    sum += static_cast<double>(sheen.eval(wo, spherical(u.x, u.y)).f.x);
                }
                albedo.at(i, j) = static_cast<float>(sum * 2 * static_cast<double>(kPi) / kSamples);
            }
        }
    }
};

}  // namespace

float reflection_albedo(float mu, float roughness) {
    return reflection_table().albedo(std::sqrt(std::max(mu, 0.0f)), roughness);
}

float mean_reflection_albedo(float roughness) {
    const auto& mean = reflection_table().mean;
    const Place p(roughness, kFine);
    const auto i = static_cast<std::size_t>(p.i);
    return lerp(mean[i], mean[i + 1], p.t);
}

DielectricAlbedo dielectric_albedo(float mu, float roughness, float eta) {
    return DielectricTable::lookup(dielectric_table().values, std::sqrt(std::max(mu, 0.0f)), roughness, eta);
}

DielectricAlbedo mean_dielectric_albedo(float roughness, float eta) {
    return DielectricTable::lookup(dielectric_table().means, 1, roughness, eta);
}

float sheen_albedo(float mu, float alpha) {
    static const SheenTable table;
    return table.albedo(std::sqrt(std::max(mu, 0.0f)), alpha);
}

}  // namespace nephele
