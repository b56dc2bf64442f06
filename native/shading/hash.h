// SPDX-License-Identifier: GPL-3.0-or-later
// Hashes of one to four words: the mixing of Bob Jenkins' lookup3 (2006), and generators that serve as
// hashes. Blender's textures use both, so that pictures agree.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace nephele {
namespace hash_detail {

/// lookup3's final mixing of three words.
inline std::uint32_t final_mix(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
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

}  // namespace hash_detail

inline std::uint32_t hash(std::uint32_t x) {
    using namespace hash_detail;
    return final_mix(start(1) + x, start(1), start(1));
}
inline std::uint32_t hash(std::uint32_t x, std::uint32_t y) {
    using namespace hash_detail;
    return final_mix(start(2) + x, start(2) + y, start(2));
}
inline std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    using namespace hash_detail;
    return final_mix(start(3) + x, start(3) + y, start(3) + z);
}
/// More than three words: lookup3 mixes three of them before the rest.
inline std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t z, std::uint32_t w) {
    using namespace hash_detail;
    std::uint32_t state[] = {start(4) + x, start(4) + y, start(4) + z};
    constexpr int kRotations[] = {4, 6, 8, 16, 19, 4};
    for (int round = 0; round < 6; ++round) {
        std::uint32_t &a = state[round % 3], &b = state[(round + 1) % 3], &c = state[(round + 2) % 3];
        a = (a - c) ^ std::rotl(c, kRotations[round]);
        c += b;
    }
    return final_mix(state[0] + w, state[1], state[2]);
}

/// The permuted congruential generators of Jarzynski and Olano 2020 ("Hash Functions for GPU Rendering"), two
/// to four words at once; their shifts keep the sign, as Blender's do.
template <std::size_t N>
std::array<std::uint32_t, N> hash_pcg(std::array<std::uint32_t, N> v) {
    static_assert(N >= 2 && N <= 4);
    constexpr std::uint32_t kFactor = 1664525;
    const auto stir = [&] {
        if constexpr (N == 2) {
            v[0] += v[1] * kFactor;
            v[1] += v[0] * kFactor;
        } else {
            v[0] += v[1] * v[N - 1];
            v[1] += v[2] * v[0];
            v[2] += v[0] * v[1];
            if constexpr (N == 4)
                v[3] += v[1] * v[2];
        }
    };
    const auto shift = [&] {
        for (std::uint32_t& x : v)
            x ^= static_cast<std::uint32_t>(static_cast<std::int32_t>(x) >> 16);
    };
    for (std::uint32_t& x : v)
        x = x * kFactor + 1013904223u;
    stir();
    shift();
    stir();
    return v;
}

/// A hash as a number in [0, 1].
inline float unit_float(std::uint32_t h) {
    return static_cast<float>(h) * (1.0f / 4294967295.0f);
}
/// Hash in [0, 1] of numbers, by their bits.
template <typename... Float>
float hash_unit(Float... x) {
    return unit_float(hash(std::bit_cast<std::uint32_t>(x)...));
}

}  // namespace nephele
