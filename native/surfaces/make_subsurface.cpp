// SPDX-License-Identifier: GPL-3.0-or-later
// What an artist's radius of subsurface scattering means. Random walk: the diffusion length 1 / sigma_tr, by
// which light fades with the distance (Jensen et al. 2001, "A Practical Model for Subsurface Light
// Transport"); the mean free path is then sqrt(3 (1 - a')) of it, a' the reduced albedo that lets the dipole
// reflect the colour (Jensen and Buhler 2002, equation 15). Burley: 4 pi mean free paths. Random walk (skin):
// 4 pi times the distance d of Chiang, Kutz and Burley 2016, "Practical and Controllable Subsurface
// Scattering for Production Path Tracing", of which the mean free path is 1.9 - A + 3.5 (A - 0.8)^2 for a
// colour A.
#include "surfaces/bsdf.h"
#include "surfaces/make_lobes.h"

namespace nephele {
namespace {

/// sqrt(3 (1 - a')) where the dipole reflects `color`. Falls from sqrt(3) to 0.
float diffusion_rate(float color, float ior) {
    const float inverse = 1 / ior;
    const float inside = -1.440f * inverse * inverse + 0.710f * inverse + 0.668f + 0.0636f * ior;
    const float boundary = 4.0f / 3 * (1 + inside) / (1 - inside);
    float low = 0, high = 1.7320508f;
    for (int i = 0; i < 16; ++i) {
        const float rate = 0.5f * (low + high);
        const float reflected =
            0.5f * (1 - rate * rate / 3) * (1 + std::exp(-boundary * rate)) * std::exp(-rate);
        (reflected > color ? low : high) = rate;
    }
    return 0.5f * (low + high);
}

/// Mean free paths in a radius.
float path_in_radius(SubsurfaceMethod method, float color, float ior) {
    if (method == SubsurfaceMethod::random_walk)
        return diffusion_rate(color, ior);
    const bool skin = method == SubsurfaceMethod::random_walk_skin;
    return 0.25f * kInvPi * (skin ? 1.9f - color + 3.5f * sqr(color - 0.8f) : 1);
}

}  // namespace

Rgb add_subsurface(Bsdf& bsdf, const SubsurfaceLook& look, Rgb weight, Vec3f n) {
    constexpr float kLeast = 1e-6f, kMost = 1e6f;  // m
    constexpr float kMostAnisotropy = 0.99f;
    const float ior = std::clamp(look.ior, 1.01f, 3.8f);
    Subsurface lobe;
    lobe.color = min(look.color, Rgb(1));
    lobe.anisotropy = std::min(look.anisotropy, kMostAnisotropy);
    lobe.eta = ior;
    lobe.alpha = sqr(look.roughness);
    lobe.diffuse_entry = look.method == SubsurfaceMethod::random_walk_skin;
    Rgb below(0), at_once(0);
    for (int c = 0; c < 3; ++c) {
        const float path = std::min(look.radius[c] * path_in_radius(look.method, lobe.color[c], ior), kMost);
        (path > kLeast ? below : at_once)[c] = 1;
        lobe.mean_free_path[c] = std::max(path, kLeast);
    }
    if (!is_zero(lobe.color))
        bsdf.add(lobe, weight * below, n);
    return weight * look.color * at_once;
}

}  // namespace nephele
