// SPDX-License-Identifier: GPL-3.0-or-later
// Grids: mu = x^2 (finer towards grazing angles), roughness linear, eta by t = |eta - 1| /
// (eta + 1), so that t^2 is the reflectance at normal incidence. Interpolated linearly along x, roughness and
// t. What belongs to one roughness is made when it is first asked for: a surface of constant roughness needs
// two nodes of it.
#include "surfaces/directional_albedo.h"

#include <array>
#include <atomic>
#include <memory>
#include <mutex>

#include "surfaces/fresnel.h"
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

/// Parts of a table, each made from its number when it is first asked for, by whichever thread is there
/// first.
template <class Part, int count>
class OnDemand {
  public:
    const Part& operator[](int number) {
        const auto i = static_cast<std::size_t>(number);
        if (const Part* part = ready_[i].load(std::memory_order_acquire))
            return *part;
        const std::scoped_lock lock(making_);
        if (!made_[i]) {
            made_[i] = std::make_unique<const Part>(number);
            ready_[i].store(made_[i].get(), std::memory_order_release);
        }
        return *made_[i];
    }

  private:
    std::array<std::atomic<const Part*>, count> ready_{};
    std::array<std::unique_ptr<const Part>, count> made_;
    std::mutex making_;
};

// --- Reflection
// --------------------------------------------------------------------------------------------------

/// White reflection at node j of the roughness.
struct ReflectionRow {
    std::array<float, kFine> albedo{};
    float mean = 0;

    explicit ReflectionRow(int j) {
        const Microfacet facets{sqr(node(j, kFine)), false};
        for (int i = 0; i < kFine; ++i)
            albedo[static_cast<std::size_t>(i)] = integrate(direction(node_mu(i, kFine)), facets);
        mean = integrate_mean();
    }
    float at(float x) const {
        const Place p(x, kFine);
        const auto i = static_cast<std::size_t>(p.i);
        return lerp(albedo[i], albedo[i + 1], p.t);
    }

  private:
    static float integrate(Vec3f wo, Microfacet facets) {
        constexpr int kSamples = 1024;
        if (facets.specular())
            return 1;
        double sum = 0;
        visit_normals(wo, facets, kSamples, [&](Vec3f h) {
            const Vec3f wi = 2 * dot(wo, h) * h - wo;
            if (wi.z > 0)
                sum += static_cast<double>(shadowing(facets, wo, wi));
        });
        return static_cast<float>(sum / kSamples);
    }
    /// 2 integral of albedo mu dmu, with mu = x^2: 4 integral of albedo x^3 dx.
    float integrate_mean() const {
        constexpr int kSteps = 256;
        double sum = 0, norm = 0;
        for (int i = 0; i < kSteps; ++i) {
            const double x = (i + 0.5) / kSteps, weight = x * x * x;
            sum += weight * static_cast<double>(at(static_cast<float>(x)));
            norm += weight;
        }
        return static_cast<float>(sum / norm);
    }
};

const ReflectionRow& reflection_row(int j) {
    static OnDemand<ReflectionRow, kFine> rows;
    return rows[j];
}
/// value(row) between the two rows next to a roughness.
float between_rows(float roughness, const auto& value) {
    const Place p(roughness, kFine);
    return lerp(value(reflection_row(p.i)), value(reflection_row(p.i + 1)), p.t);
}

// --- Dielectric interface
// ----------------------------------------------------------------------------------------

float eta_of(float t, bool denser) {
    return denser ? (1 + t) / (1 - t) : (1 - t) / (1 + t);
}

/// An interface at node j of the roughness.
struct DielectricSlice {
    using Values = std::array<DielectricAlbedo, 2 * kCoarse * kCoarse>;
    Values values{};  ///< [denser][t][mu]
    Values means{};   ///< the same, every mu holding the mean over the hemisphere

    explicit DielectricSlice(int j) {
        for (int i = 0; i < kCoarse; ++i)
            integrate(j, i);
        for (std::size_t first = 0; first < values.size(); first += kCoarse)
            average(first);
    }
    static std::size_t index(bool denser, int t, int mu) {
        return static_cast<std::size_t>(((denser ? kCoarse : 0) + t) * kCoarse + mu);
    }

  private:
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
    /// Fills all indices of refraction for one direction.
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
                DielectricAlbedo& out = values[index(denser, k % kCoarse, i)];
                out.reflected += F * reflected;
                if (F < 1 && refracted.z < 0)
                    out.transmitted += (1 - F) * shadowing(facets, wo, refracted) / kSamples;
            }
        });
    }
};

DielectricAlbedo dielectric_lookup(DielectricSlice::Values DielectricSlice::*table, float x, float roughness,
                                   float eta) {
    static OnDemand<DielectricSlice, kCoarse> slices;
    const float t = std::fabs(eta - 1) / (eta + 1);
    const bool denser = eta >= 1;
    const Place px(x, kCoarse), pr(roughness, kCoarse), pt(t, kCoarse);
    const std::array<const DielectricSlice::Values*, 2> tables{&(slices[pr.i].*table),
                                                               &(slices[pr.i + 1].*table)};
    DielectricAlbedo sum;
    for (int corner = 0; corner < 8; ++corner) {
        const int dx = corner & 1, dr = corner >> 1 & 1, dt = corner >> 2;
        const float weight = (dx ? px.t : 1 - px.t) * (dr ? pr.t : 1 - pr.t) * (dt ? pt.t : 1 - pt.t);
        const DielectricAlbedo& value =
            (*tables[static_cast<std::size_t>(dr)])[DielectricSlice::index(denser, pt.i + dt, px.i + dx)];
        sum.reflected += weight * value.reflected;
        sum.transmitted += weight * value.transmitted;
    }
    return sum;
}

}  // namespace

float reflection_albedo(float mu, float roughness) {
    const float x = std::sqrt(std::max(mu, 0.0f));
    return between_rows(roughness, [x](const ReflectionRow& row) { return row.at(x); });
}

float mean_reflection_albedo(float roughness) {
    return between_rows(roughness, [](const ReflectionRow& row) { return row.mean; });
}

DielectricAlbedo dielectric_albedo(float mu, float roughness, float eta) {
    return dielectric_lookup(&DielectricSlice::values, std::sqrt(std::max(mu, 0.0f)), roughness, eta);
}

DielectricAlbedo mean_dielectric_albedo(float roughness, float eta) {
    return dielectric_lookup(&DielectricSlice::means, 1, roughness, eta);
}

}  // namespace nephele
