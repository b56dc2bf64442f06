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

/// Weight of each of a cube's faces: all of the one that the normal faces clearly, and blends of two or three
/// between them.
Vec3f box_weights(Vec3f normal, float blend) {
    Vec3f n(std::fabs(normal.x), std::fabs(normal.y), std::fabs(normal.z));
    n = n / std::max(n.x + n.y + n.z, 1e-20f);
    const float limit = 0.5f * (1 + blend);
    for (int i = 0; i < 3; ++i) {
        const float a = n[(i + 1) % 3], b = n[(i + 2) % 3];
        if (n[i] > limit * (n[i] + a) && n[i] > limit * (n[i] + b)) {
            Vec3f one(0);
            one[i] = 1;
            return one;
        }
    }
    if (!(blend > 0))
        return {1, 0, 0};
    for (const int rest : {2, 0, 1}) {  // faces that hardly count leave a blend of the two others
        const int a = rest == 0 ? 1 : 0, b = rest == 2 ? 1 : 2;
        if (n[rest] < (1 - limit) * (n[a] + n[b])) {
            Vec3f two(0);
            two[a] = clamp01((n[a] / (n[a] + n[b]) - 0.5f * (1 - blend)) / blend);
            two[b] = 1 - two[a];
            return two;
        }
    }
    const Vec3f three = (n * (2 - limit) + Vec3f(limit - 1)) / blend;
    return {clamp01(three.x), clamp01(three.y), clamp01(three.z)};  // a tiny blend amplifies rounding
}

}  // namespace

Vec2f sphere_projection(Vec3f p) {
    const float size = length(p - Vec3f(0.5f));
    const Vec3f d = p - Vec3f(0.5f);
    if (!(size > 0))
        return {0, 0};
    const float u = d.x == 0 && d.y == 0 ? 0 : 0.5f - std::atan2(d.x, d.y) / (2 * kPi);
    return {u, 1 - std::acos(std::clamp(d.z / size, -1.0f, 1.0f)) / kPi};
}

Vec2f tube_projection(Vec3f p) {
    const Vec3f d = p - Vec3f(0.5f);
    if (!(d.x * d.x + d.y * d.y > 0))
        return {0, 0};
    return {0.5f - std::atan2(d.x, d.y) / (2 * kPi), p.z};
}

Vec3f box_projection(Vec3f p, Vec3f normal, int axis, float blend) {
    const float weight = box_weights(normal, blend > 0 ? std::min(blend, 1.0f) : 0)[axis];
    const auto flipped = [](bool flip, float x) { return flip ? 1 - x : x; };
    if (axis == 0)
        return {flipped(normal.x < 0, p.y), p.z, weight};
    if (axis == 1)
        return {flipped(normal.y > 0, p.x), p.z, weight};
    return {flipped(normal.z > 0, p.y), p.x, weight};
}

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
