// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/noise.h"

#include <bit>

namespace nephele {
namespace {

// --- Hash of lattice points
// ------------------------------------------------------------------------------------

/// lookup3's final mixing of three words.
std::uint32_t final_mix(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    c = (c ^ b) - std::rotl(b, 14);
    a = (a ^ c) - std::rotl(c, 11);
    b = (b ^ a) - std::rotl(a, 25);
    c = (c ^ b) - std::rotl(b, 16);
    a = (a ^ c) - std::rotl(c, 4);
    b = (b ^ a) - std::rotl(a, 14);
    return (c ^ b) - std::rotl(b, 24);
}
/// lookup3's initial state for a key of that many words.
constexpr std::uint32_t start(std::uint32_t words) {
    return 0xdeadbeefu + (words << 2) + 13;
}

std::uint32_t hash(int x) {
    return final_mix(start(1) + static_cast<std::uint32_t>(x), start(1), start(1));
}
std::uint32_t hash(int x, int y) {
    return final_mix(start(2) + static_cast<std::uint32_t>(x), start(2) + static_cast<std::uint32_t>(y),
                     start(2));
}
std::uint32_t hash(int x, int y, int z) {
    return final_mix(start(3) + static_cast<std::uint32_t>(x), start(3) + static_cast<std::uint32_t>(y),
                     start(3) + static_cast<std::uint32_t>(z));
}

// --- Gradients: dot products of the hashed gradient with the offset (Perlin 2002)
// --------------------------------

float signed_by(std::uint32_t bit, float v) {
    return bit ? -v : v;
}

float gradient(std::uint32_t h, float x) {
    return signed_by(h & 8, static_cast<float>(1 + (h & 7)) * x);
}
float gradient(std::uint32_t h, float x, float y) {
    const bool along_x = (h & 7) < 4;
    return signed_by(h & 1, along_x ? x : y) + signed_by(h & 2, 2 * (along_x ? y : x));
}
float gradient(std::uint32_t h, float x, float y, float z) {
    h &= 15;
    const float u = h < 8 ? x : y, v = h < 4 ? y : h == 12 || h == 14 ? x : z;
    return signed_by(h & 1, u) + signed_by(h & 2, v);
}

/// Perlin's quintic fade.
float fade(float t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

/// A coordinate split into its lattice cell and the place inside.
struct Cell {
    int i;
    float f, faded;

    explicit Cell(float x) {
        x = std::isfinite(x) ? std::fmod(x, 100000.0f) : 0;  // keeps fractions exact; Blender's period
        const float whole = std::floor(x);
        i = static_cast<int>(whole);
        f = x - whole;
        faded = fade(f);
    }
};

// --- Octaves
// -----------------------------------------------------------------------------------------------------

float octave(Vec3f p, int dimensions) {
    return dimensions == 1 ? perlin(p.x) : dimensions == 2 ? perlin(p.x, p.y) : perlin(p);
}

/// Sum of octaves, each finer and weaker than the one before.
float fractal_sum(Vec3f p, const NoiseSettings& settings) {
    const float detail = std::max(0.0f, std::min(settings.detail, 15.0f)),  // NaN counts as 0
        roughness = std::max(settings.roughness, 0.0f);
    const int octaves = static_cast<int>(detail);
    const float rest = detail - std::floor(detail);
    float sum = 0, amplitude = 1, total = 0, frequency = 1;
    const auto finished = [&](float s, float t) { return settings.normalize ? 0.5f * s / t + 0.5f : s; };
    for (int i = 0; i <= octaves; ++i) {
        sum += amplitude * octave(p * frequency, settings.dimensions);
        total += amplitude;
        amplitude *= roughness;
        frequency *= settings.lacunarity;
    }
    if (rest == 0)
        return finished(sum, total);
    const float finer = sum + amplitude * octave(p * frequency, settings.dimensions);
    return lerp(finished(sum, total), finished(finer, total + amplitude), rest);
}

/// A point moved by as many noises as there are dimensions.
Vec3f distorted(Vec3f p, const NoiseSettings& settings) {
    if (settings.distortion == 0)
        return p;
    const int n = settings.dimensions;
    Vec3f moved = p;
    for (int i = 0; i < n; ++i)
        moved[i] += settings.distortion * octave(p + noise_offset(i, n), n);
    return moved;
}

}  // namespace

Vec3f noise_offset(int seed, int dimensions) {
    const auto bits = [](int i) { return std::bit_cast<int>(static_cast<float>(i)); };
    const auto scaled = [](std::uint32_t h) { return 100 + 100 * (static_cast<float>(h) / 4294967295.0f); };
    if (dimensions == 1)
        return {scaled(hash(bits(seed))), 0, 0};
    return {scaled(hash(bits(seed), bits(0))), scaled(hash(bits(seed), bits(1))),
            scaled(hash(bits(seed), bits(2)))};
}

float perlin(float x) {
    const Cell cx(x);
    const float n = lerp(gradient(hash(cx.i), cx.f), gradient(hash(cx.i + 1), cx.f - 1), cx.faded);
    return 0.25f * n;
}

float perlin(float x, float y) {
    const Cell cx(x), cy(y);
    const auto row = [&](int j, float fy) {
        return lerp(gradient(hash(cx.i, j), cx.f, fy), gradient(hash(cx.i + 1, j), cx.f - 1, fy), cx.faded);
    };
    return 0.6616f * lerp(row(cy.i, cy.f), row(cy.i + 1, cy.f - 1), cy.faded);
}

float perlin(Vec3f p) {
    const Cell cx(p.x), cy(p.y), cz(p.z);
    const auto row = [&](int j, int k, float fy, float fz) {
        return lerp(gradient(hash(cx.i, j, k), cx.f, fy, fz),
                    gradient(hash(cx.i + 1, j, k), cx.f - 1, fy, fz), cx.faded);
    };
    const auto slab = [&](int k, float fz) {
        return lerp(row(cy.i, k, cy.f, fz), row(cy.i + 1, k, cy.f - 1, fz), cy.faded);
    };
    return 0.9820f * lerp(slab(cz.i, cz.f), slab(cz.i + 1, cz.f - 1), cz.faded);
}

float noise_value(Vec3f p, const NoiseSettings& settings) {
    return fractal_sum(distorted(p, settings), settings);
}

Rgb noise_color(Vec3f p, const NoiseSettings& settings) {
    const int n = settings.dimensions;
    const Vec3f q = distorted(p, settings);
    return {fractal_sum(q, settings), fractal_sum(q + noise_offset(n, n), settings),
            fractal_sum(q + noise_offset(n + 1, n), settings)};
}

}  // namespace nephele
