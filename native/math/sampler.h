// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers. `Rng` is an unlimited stream of independent numbers (PCG32, O'Neill 2014); `PathSampler`
// gives a path's first dimensions from Owen-scrambled Sobol points, padded in pairs with shuffled indices
// (Burley, JCGT 9(4), 2020, "Practical Hash-based Owen Scrambling"), and independent numbers beyond them.
#pragma once

#include <cstdint>

#include "math/vec.h"

namespace nephele {

/// A good 64-bit mixer (splitmix64's finaliser, Steele et al. 2014).
constexpr std::uint64_t mix_bits(std::uint64_t v) {
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
    return v ^ (v >> 31);
}
constexpr std::uint64_t hash_combine(std::uint64_t a, std::uint64_t b) {
    return mix_bits(a + 0x9e3779b97f4a7c15ull * (b + 1));
}

/// 24 bits of x as a float in [0, 1).
constexpr float unit_float(std::uint32_t x) {
    return static_cast<float>(x >> 8) * 0x1p-24f;
}

/// Two random words, as numbers in [0, 1).
struct RandomPair {
    std::uint32_t x, y;

    Vec2f coarse() const { return {unit_float(x), unit_float(y)}; }
    /// All 32 bits: to choose one of many, whose probability may be no multiple of 2^-24.
    Vec2d fine() const { return {x * 0x1p-32, y * 0x1p-32}; }
};

/// PCG32: 64-bit state, 32-bit output.
class Rng {
  public:
    explicit Rng(std::uint64_t seed = 0) : state_(mix_bits(seed)), increment_(mix_bits(seed + 1) | 1) {}

    std::uint32_t next_uint() {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005ull + increment_;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        const auto rotation = static_cast<std::uint32_t>(old >> 59);
        return (shifted >> rotation) | (shifted << ((-rotation) & 31));
    }
    /// Uniform in [0, 1).
    float next() { return unit_float(next_uint()); }
    Vec2f next2() {
        const float a = next();
        return {a, next()};
    }
    /// True with probability p to 56 bits: where p is small, what happens with it weighs 1 / p, and next() <
    /// p would be true far too often below 2^-24.
    bool chance(float p) {
        const double scaled = double{p} * 0x1p32, whole = std::floor(scaled);
        const double drawn = next_uint();
        return drawn == whole ? double{next()} < scaled - whole : drawn < whole;
    }
    /// Three numbers of 21 bits each from two draws, for decisions that need no more.
    Vec3f next3() {
        const std::uint64_t bits = std::uint64_t{next_uint()} << 32 | next_uint();
        const auto unit = [](std::uint64_t b) {
            return (static_cast<float>(b & 0x1fffff) + 0.5f) * 0x1p-21f;
        };
        return {unit(bits), unit(bits >> 21), unit(bits >> 42)};
    }
    /// Exponential of rate 1: finite and > 0, with 32 bits so that the tail is not cut at 17 mean free paths.
    float next_exponential() {
        const double u = (static_cast<double>(next_uint()) + 0.5) * 0x1p-32;
        return static_cast<float>(-std::log(u));
    }

  private:
    std::uint64_t state_, increment_;
};

namespace sobol {

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}
/// Hash whose output bit i depends on input bits 0..i only: on reversed bits it is a nested uniform (Owen)
/// scramble (Laine and Karras 2011, constants of Vegdahl 2021).
constexpr std::uint32_t laine_karras(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}
constexpr std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) {
    return reverse_bits(laine_karras(reverse_bits(x), seed));
}
/// Second Sobol dimension of an index whose bits come reversed: its generator matrix is Pascal's triangle
/// mod 2, applied by doubling.
constexpr std::uint32_t second_dimension(std::uint32_t reversed_index) {
    std::uint32_t x = reversed_index;
    x ^= x << 16;
    x ^= (x & 0x00ff00ffu) << 8;
    x ^= (x & 0x0f0f0f0fu) << 4;
    x ^= (x & 0x33333333u) << 2;
    return x ^ (x & 0x55555555u) << 1;
}

}  // namespace sobol

/// The random numbers of one path. Dimensions are handed out in call order.
class PathSampler {
  public:
    static constexpr int kStructuredPairs =
        24;  // pairs of dimensions taken from Sobol points before independence

    /// `structured`: Sobol points first; else independent numbers from the start.
    PathSampler(bool structured, std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample)
        : pixel_seed_(hash_combine(seed, pixel)),
          sample_(sample),
          reversed_sample_(sobol::reverse_bits(sample)),
          rng_(hash_combine(pixel_seed_, sample)),
          pairs_(structured ? kStructuredPairs : 0) {}

    RandomPair next_pair() {
        if (pair_ >= pairs_) {
            const std::uint32_t x = rng_.next_uint();
            return {x, rng_.next_uint()};
        }
        const std::uint64_t h = hash_combine(pixel_seed_, static_cast<std::uint64_t>(pair_++) + 0x5eed);
        const std::uint32_t reversed_index =
            sobol::laine_karras(reversed_sample_, static_cast<std::uint32_t>(h));
        const auto hx = static_cast<std::uint32_t>(mix_bits(h)),
                   hy = static_cast<std::uint32_t>(mix_bits(h + 1));
        const std::uint32_t x =
            sobol::reverse_bits(sobol::laine_karras(sobol::reverse_bits(reversed_index), hx));
        const std::uint32_t y = sobol::owen_scramble(sobol::second_dimension(reversed_index), hy);
        return {x, y};
    }
    Vec2f next2() { return next_pair().coarse(); }
    float next() { return next2().x; }
    Rng& rng() { return rng_; }
    /// From here on this sample shares no structure with samples of other epochs. What a path learns from
    /// earlier samples of its pixel must not depend on its own numbers: one point of a Sobol sequence tells
    /// where the others are not. An epoch of 2^k samples from a multiple of 2^k on is a net by itself.
    void enter_epoch(std::uint32_t epoch) { pixel_seed_ = hash_combine(pixel_seed_, 0xe90c4ull + epoch); }
    /// Numbers of their own for something beside the path, which must not shift the path's.
    Rng aside() const {
        return Rng(hash_combine(pixel_seed_, std::uint64_t{sample_} | std::uint64_t{1} << 32));
    }

  private:
    std::uint64_t pixel_seed_;
    std::uint32_t sample_, reversed_sample_;
    Rng rng_;
    int pair_ = 0, pairs_;
};

}  // namespace nephele
