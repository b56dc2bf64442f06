// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/noise.h"

#include "shading/hash.h"

namespace nephele {
namespace {

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
float gradient(std::uint32_t h, float x, float y, float z, float w) {
    h &= 31;
    const float u = h < 24 ? x : y, v = h < 16 ? y : z, s = h < 8 ? z : w;
    return signed_by(h & 1, u) + signed_by(h & 2, v) + signed_by(h & 4, s);
}

/// Perlin's quintic fade.
float fade(float t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

/// A coordinate split into its lattice cell and the place inside.
struct Cell {
    std::uint32_t i;
    float f, faded;

    explicit Cell(float x) {
        x = std::isfinite(x) ? std::fmod(x, 100000.0f) : 0;  // keeps fractions exact; Blender's period
        const float whole = std::floor(x);
        i = static_cast<std::uint32_t>(static_cast<int>(whole));
        f = x - whole;
        faded = fade(f);
    }
};

// --- Octaves
// -----------------------------------------------------------------------------------------------------

NoisePoint operator*(const NoisePoint& a, float s) {
    return {a.p * s, a.w * s};
}
NoisePoint operator+(const NoisePoint& a, const NoisePoint& b) {
    return {a.p + b.p, a.w + b.w};
}

float octave(const NoisePoint& at, int dimensions) {
    switch (dimensions) {
        case 1:
            return perlin(at.p.x);
        case 2:
            return perlin(at.p.x, at.p.y);
        case 3:
            return perlin(at.p);
        default:
            return perlin(at.p, at.w);
    }
}

/// The octaves of a fractal, one after the other: each is finer, and its amplitude is `amplitude`.
struct Octaves {
    const NoisePoint& p;
    const NoiseSettings& settings;
    float frequency = 1, amplitude = 1;
    int whole;   ///< number of the last octave that counts in full
    float rest;  ///< share of the one beyond it

    Octaves(const NoisePoint& at, const NoiseSettings& s) : p(at), settings(s) {
        const float detail = std::max(0.0f, std::min(s.detail, 15.0f));  // NaN counts as 0
        whole = static_cast<int>(detail);
        rest = detail - std::floor(detail);
    }
    float noise() const { return octave(p * frequency, settings.dimensions); }
    void next() {
        amplitude *= std::max(settings.roughness, 0.0f);
        frequency *= settings.lacunarity;
    }
};

/// Sum of octaves, each finer and weaker than the one before.
float fbm(Octaves o) {
    const bool normalize = o.settings.normalize;
    float sum = 0, total = 0;
    const auto finished = [&](float s, float t) { return normalize ? 0.5f * s / t + 0.5f : s; };
    for (int i = 0; i <= o.whole; ++i) {
        sum += o.amplitude * o.noise();
        total += o.amplitude;
        o.next();
    }
    if (o.rest == 0)
        return finished(sum, total);
    const float finer = sum + o.amplitude * o.noise();
    return lerp(finished(sum, total), finished(finer, total + o.amplitude), o.rest);
}

/// Product of octaves about 1.
float multifractal(Octaves o) {
    float value = 1;
    for (int i = 0; i <= o.whole; ++i) {
        value *= o.amplitude * o.noise() + 1;
        o.next();
    }
    return o.rest == 0 ? value : value * (o.rest * o.amplitude * o.noise() + 1);
}

/// Octaves that count in proportion to the height so far.
float hetero_terrain(Octaves o) {
    float value = o.settings.offset + o.noise();
    o.next();
    for (int i = 1; i <= o.whole; ++i) {
        value += (o.noise() + o.settings.offset) * o.amplitude * value;
        o.next();
    }
    return o.rest == 0 ? value : value + o.rest * (o.noise() + o.settings.offset) * o.amplitude * value;
}

/// Octaves weighted by what the coarser ones gave.
float hybrid_multifractal(Octaves o) {
    constexpr float kNegligible = 0.001f;
    float value = 0, weight = 1;
    for (int i = 0; weight > kNegligible && i <= o.whole; ++i) {
        const float signal = (o.noise() + o.settings.offset) * o.amplitude;
        weight = std::min(weight, 1.0f);
        value += weight * signal;
        weight *= o.settings.gain * signal;
        o.next();
    }
    if (o.rest == 0 || weight <= kNegligible)
        return value;
    return value + o.rest * std::min(weight, 1.0f) * (o.noise() + o.settings.offset) * o.amplitude;
}

/// Sharp ridges where the noise crosses 0.
float ridged_multifractal(Octaves o) {
    float value = 0, weight = 1;
    for (int i = 0; i <= o.whole; ++i) {
        const float signal = sqr(o.settings.offset - std::fabs(o.noise())) * weight;
        value += signal * o.amplitude;
        weight = clamp01(signal * o.settings.gain);
        o.next();
    }
    return value;
}

float fractal(const NoisePoint& p, const NoiseSettings& settings) {
    const Octaves octaves(p, settings);
    switch (settings.type) {
        case NoiseType::multifractal:
            return multifractal(octaves);
        case NoiseType::hybrid_multifractal:
            return hybrid_multifractal(octaves);
        case NoiseType::ridged_multifractal:
            return ridged_multifractal(octaves);
        case NoiseType::hetero_terrain:
            return hetero_terrain(octaves);
        default:
            return fbm(octaves);
    }
}

/// A point moved by as many noises as there are dimensions.
NoisePoint distorted(const NoisePoint& p, const NoiseSettings& settings) {
    if (settings.distortion == 0)
        return p;
    const int n = settings.dimensions;
    NoisePoint moved = p;
    for (int i = 0; i < n; ++i) {
        float& coordinate = i < 3 ? moved.p[i] : moved.w;
        coordinate += settings.distortion * octave(p + noise_offset(i, n), n);
    }
    return moved;
}

}  // namespace

NoisePoint noise_offset(int seed, int dimensions) {
    const auto s = static_cast<float>(seed);
    const auto scaled = [](float h) { return 100 + 100 * h; };
    if (dimensions == 1)
        return Vec3f(scaled(hash_unit(s)), 0, 0);
    const auto coordinate = [&](float i) { return scaled(hash_unit(s, i)); };
    return {{coordinate(0), coordinate(1), coordinate(2)}, coordinate(3)};
}

float perlin(float x) {
    const Cell cx(x);
    const float n = lerp(gradient(hash(cx.i), cx.f), gradient(hash(cx.i + 1), cx.f - 1), cx.faded);
    return 0.25f * n;
}

float perlin(float x, float y) {
    const Cell cx(x), cy(y);
    const auto row = [&](std::uint32_t j, float fy) {
        return lerp(gradient(hash(cx.i, j), cx.f, fy), gradient(hash(cx.i + 1, j), cx.f - 1, fy), cx.faded);
    };
    return 0.6616f * lerp(row(cy.i, cy.f), row(cy.i + 1, cy.f - 1), cy.faded);
}

float perlin(Vec3f p) {
    const Cell cx(p.x), cy(p.y), cz(p.z);
    const auto row = [&](std::uint32_t j, std::uint32_t k, float fy, float fz) {
        return lerp(gradient(hash(cx.i, j, k), cx.f, fy, fz),
                    gradient(hash(cx.i + 1, j, k), cx.f - 1, fy, fz), cx.faded);
    };
    const auto slab = [&](std::uint32_t k, float fz) {
        return lerp(row(cy.i, k, cy.f, fz), row(cy.i + 1, k, cy.f - 1, fz), cy.faded);
    };
    return 0.9820f * lerp(slab(cz.i, cz.f), slab(cz.i + 1, cz.f - 1), cz.faded);
}

float perlin(Vec3f p, float w) {
    const Cell cx(p.x), cy(p.y), cz(p.z), cw(w);
    const auto row = [&](std::uint32_t j, std::uint32_t k, std::uint32_t l, float fy, float fz, float fw) {
        return lerp(gradient(hash(cx.i, j, k, l), cx.f, fy, fz, fw),
                    gradient(hash(cx.i + 1, j, k, l), cx.f - 1, fy, fz, fw), cx.faded);
    };
    const auto slab = [&](std::uint32_t k, std::uint32_t l, float fz, float fw) {
        return lerp(row(cy.i, k, l, cy.f, fz, fw), row(cy.i + 1, k, l, cy.f - 1, fz, fw), cy.faded);
    };
    const auto block = [&](std::uint32_t l, float fw) {
        return lerp(slab(cz.i, l, cz.f, fw), slab(cz.i + 1, l, cz.f - 1, fw), cz.faded);
    };
    return 0.8344f * lerp(block(cw.i, cw.f), block(cw.i + 1, cw.f - 1), cw.faded);
}

float noise_value(NoisePoint p, const NoiseSettings& settings) {
    return fractal(distorted(p, settings), settings);
}

Rgb noise_color(NoisePoint p, const NoiseSettings& settings) {
    const int n = settings.dimensions;
    const NoisePoint q = distorted(p, settings);
    return {fractal(q, settings), fractal(q + noise_offset(n, n), settings),
            fractal(q + noise_offset(n + 1, n), settings)};
}

float white_noise(NoisePoint at, int dimensions) {
    const auto& [x, y, z] = at.p;
    switch (dimensions) {
        case 1:
            return hash_unit(x);
        case 2:
            return hash_unit(x, y);
        case 3:
            return hash_unit(x, y, z);
        default:
            return hash_unit(x, y, z, at.w);
    }
}

Rgb white_noise_color(NoisePoint at, int dimensions) {
    const auto& [x, y, z] = at.p;
    switch (dimensions) {
        case 1:
            return {hash_unit(x), hash_unit(x, 1.0f), hash_unit(x, 2.0f)};
        case 2:
            return {hash_unit(x, y), hash_unit(x, y, 1.0f), hash_unit(x, y, 2.0f)};
        case 3:
            return {hash_unit(x, y, z), hash_unit(x, y, z, 1.0f), hash_unit(x, y, z, 2.0f)};
        default:
            return {hash_unit(x, y, z, at.w), hash_unit(z, x, at.w, y), hash_unit(at.w, z, y, x)};
    }
}

}  // namespace nephele
