// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/textures.h"

namespace nephele {
namespace {

/// Place of t in a table of `entries`: index of the lower neighbour and the fraction beyond it.
struct Place {
    std::size_t index;
    float fraction;

    Place(float t, std::size_t entries) {
        const float x = (t > 0 ? std::min(t, 1.0f) : 0) * static_cast<float>(entries - 1);  // NaN goes low
        index = std::min(static_cast<std::size_t>(x), entries - 2);
        fraction = x - static_cast<float>(index);
    }
};

}  // namespace

bool checker_is_odd(Vec3f p) {
    const auto odd = [](float x) {
        // Moves faces that lie exactly between two cells off the border.
        return std::fmod(std::fabs(std::floor((x + 1e-6f) * 0.999999f)), 2.0f) == 1;
    };
    return (odd(p.x) != odd(p.y)) != odd(p.z);
}

float gradient_value(Gradient kind, Vec3f p) {
    switch (kind) {
        case Gradient::linear:
            return clamp01(p.x);
        case Gradient::quadratic:
            return clamp01(sqr(std::max(p.x, 0.0f)));
        case Gradient::easing: {
            const float r = clamp01(p.x);
            return r * r * (3 - 2 * r);
        }
        case Gradient::diagonal:
            return clamp01(0.5f * (p.x + p.y));
        case Gradient::radial:
            return clamp01(std::atan2(p.y, p.x) / (2 * kPi) + 0.5f);
        case Gradient::spherical:
            break;
        case Gradient::quadratic_sphere:
            break;
    }
    const float r = std::max(0.999999f - length(p), 0.0f);  // a hair below 1, so that dark stays exactly dark
    return kind == Gradient::spherical ? r : r * r;
}

float table_scalar(std::span<const float> table, float t) {
    const Place place(t, table.size());
    return lerp(table[place.index], table[place.index + 1], place.fraction);
}

Rgb table_rgb(std::span<const float> table, float t) {
    const Place place(t, table.size() / 3);
    const float* low = table.data() + 3 * place.index;
    return lerp(Rgb(low[0], low[1], low[2]), Rgb(low[3], low[4], low[5]), place.fraction);
}

Vec2f mirror_ball_from_direction(Vec3f d) {
    // The ball's normal is halfway between d and the direction to the camera, (0, -1, 0).
    const Vec3f n = safe_normalize(safe_normalize(d) + Vec3f(0, -1, 0));
    return {0.5f * (n.x + 1), 0.5f * (n.z + 1)};
}

}  // namespace nephele
