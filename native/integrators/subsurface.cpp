// SPDX-License-Identifier: GPL-3.0-or-later
// Albedo inversion. With s = sqrt((1 - a) / (1 - g a)) for an albedo a and a mean cosine g, a half-space
// returns
//   (1 - s) (1 - 0.139 s) / (1 + 1.17 s)    of light that enters by a cosine (van de Hulst 1980), and
//   (1 - s) (1 - s^2 (0.11 + 0.54 g)) times the mean of 1 / (1 + 2 mu s)    of light that enters at cosines
//   mu
// (Hapke 1981; the middle factor is a fit to our own walks of g up to 0.9, to 0.01), for refracted light
// mu = sqrt(1 - t), t from 0 to 1 / eta^2. The walk's channel is chosen anew at each step by
// what is left of each, and its density is that of all (the balance heuristic).
#include "integrators/subsurface.h"

#include "phase/henyey_greenstein.h"

namespace nephele {
namespace {

/// What a half-space of this s returns. eta: 0 for entry by a cosine.
float returned(float s, float g, float eta) {
    if (eta == 0)
        return (1 - s) * (1 - 0.139f * s) / (1 + 1.17f * s);
    const float least = std::sqrt(std::max(0.0f, 1 - 1 / (eta * eta)));
    // Of 2 mu / (1 + 2 mu s) over mu by Simpson's rule: smooth, where the closed form cancels for small s.
    const auto value = [&](float mu) { return 2 * mu / (1 + 2 * mu * s); };
    const float integral = (value(least) + 4 * value(0.5f * (least + 1)) + value(1)) * (1 - least) / 6;
    return (1 - s) * (1 - s * s * (0.11f + 0.54f * g)) * eta * eta * integral;
}

float albedo_of(float color, float g, float eta) {
    float low = 0, high = 1;  // returned() falls with s
    for (int i = 0; i < 14; ++i) {
        const float s = 0.5f * (low + high);
        (returned(s, g, eta) > color ? low : high) = s;
    }
    const float s2 = sqr(0.5f * (low + high));
    return (1 - s2) / (1 - g * s2);
}

/// exp(-sigma_t t), 0 and not NaN where both factors are extreme.
Rgb transmittance(Rgb sigma_t, float t) {
    return {std::exp(-sigma_t.x * t), std::exp(-sigma_t.y * t), std::exp(-sigma_t.z * t)};
}

}  // namespace

SubsurfaceMedium::SubsurfaceMedium(const Subsurface& lobe) : g(lobe.anisotropy) {
    for (int c = 0; c < 3; ++c) {
        sigma_t[c] = 1 / (lobe.mean_free_path[c] * (1 - g));
        albedo[c] = lobe.color[c] > 0 ? albedo_of(lobe.color[c], g, lobe.diffuse_entry ? 0 : lobe.eta) : 0;
    }
}

std::optional<Emergence> walk_below(const Scene& scene, const ShadingPoint& point, const Subsurface& lobe,
                                    Vec3f wi, Rng& rng, Counters& counters) {
    constexpr int kMostSteps = 1024, kFreeSteps = 8;
    const SubsurfaceMedium medium(lobe);
    const HenyeyGreenstein phase{medium.g};
    const std::uint32_t instance = scene.number_of(*point.instance);
    const Vec3f within = dot(wi, point.ng) < 0 ? -point.ng : point.ng;
    Ray ray{point.off(within), wi, 0, kInfinity, point.time};
    // Channels that the path has lost, or that the lobe does not have, are not followed.
    Rgb weight(lobe.color.x > 0 ? 1.0f : 0.0f, lobe.color.y > 0 ? 1.0f : 0.0f,
               lobe.color.z > 0 ? 1.0f : 0.0f);
    for (int step = 0; step < kMostSteps; ++step) {
        const Rgb chances = weight * (1 / (weight.x + weight.y + weight.z));
        const float u = rng.next();
        const int channel = u < chances.x ? 0 : u < chances.x + chances.y ? 1 : 2;
        const float t = rng.next_exponential() / medium.sigma_t[channel];
        ray.t_max = t;
        ++counters.rays;
        const Hit hit = scene.intersect_within(ray, instance);
        const Rgb T = transmittance(medium.sigma_t, hit.valid() ? hit.t : t);
        const Rgb densities = hit.valid() ? T : T * medium.sigma_t;
        const float pdf = dot(chances, densities);
        if (!(pdf > 0))
            return std::nullopt;
        if (hit.valid()) {
            // As seen along the way out, from outside.
            const Ray back{ray.o, -ray.d, 0, kInfinity, ray.time};
            return Emergence{scene.shading_point(hit, back, kDiffuseRay), weight * densities / pdf};
        }
        weight *= medium.albedo * densities / pdf;
        if (step >= kFreeSteps) {
            const float survive = std::min(1.0f, max_component(weight));
            if (!rng.chance(survive))
                return std::nullopt;
            weight *= 1 / survive;
        }
        ray.o = ray.at(t);
        ray.d = phase.sample(-ray.d, {rng.next(), rng.next()});
    }
    return std::nullopt;
}

}  // namespace nephele
