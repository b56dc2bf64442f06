// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/pool.h"

#include <algorithm>

#include "base/parallel.h"

namespace nephele {

namespace {

constexpr int kLevels = 6;           // the widest reaches 63 pixels
constexpr float kEnoughSamples = 8;  // at this effective number half of the trust is given
constexpr float kKernel[2] = {1.0f, 0.5f};

struct Image {
    int width, height;
    std::span<const float> feature;

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
    float similarity(std::size_t a, std::size_t b) const {
        if (feature.empty())
            return 1;
        const float difference = (feature[a] - feature[b]) * 10, d2 = difference * difference;
        return 1 / (1 + d2 * d2);
    }
};

BranchSums widened(const Image& image, const std::vector<BranchSums>& sums, int x, int y, int step) {
    BranchSums out;
    const std::size_t centre = image.index(x, y);
    for (int j = -1; j <= 1; ++j) {
        const int v = y + j * step;
        if (v < 0 || v >= image.height)
            continue;
        for (int i = -1; i <= 1; ++i) {
            const int u = x + i * step;
            if (u < 0 || u >= image.width)
                continue;
            const std::size_t other = image.index(u, v);
            const float w = kKernel[std::abs(i)] * kKernel[std::abs(j)] * image.similarity(centre, other);
            const BranchSums& s = sums[other];
            out.weight += w * s.weight;
            out.light += w * s.light;
            out.light2 += w * w * s.light2;
            out.cost += w * s.cost;
            out.taken += w * s.taken;
        }
    }
    return out;
}

/// How many samples of equal size would say as much.
float effective_samples(const BranchSums& s) {
    const double light = double{s.light};  // whose square need not be a float
    return s.light2 > 0 ? std::min(static_cast<float>(light * light / double{s.light2}), s.taken) : s.taken;
}

/// Adds a level's estimates to the pixel's; `rest`: trust not yet given.
void blend(const BranchSums& s, bool last, Pooled& out, float& rest) {
    const float n = effective_samples(s);
    const float earned = rest * n / (n + kEnoughSamples), trust = last ? rest : earned;
    if (last)
        out.known = 1 - rest + earned;
    if (s.weight > 0)
        out.light += trust * s.light / s.weight;
    if (s.taken > 0)
        out.cost += trust * s.cost / s.taken;
    if (s.weight > 0 && s.taken > 0)
        rest -= trust;
}

}  // namespace

void add_light(BranchSums& sums, float light, float square) {
    // What the sun's disc leaves must not overflow in sums of squares, of which a NaN would spread.
    constexpr float kLargest = 1e15f;
    light = std::min(light, kLargest);
    square = std::min(square, kLargest);
    sums.light += light;
    sums.light2 += light * light;
    sums.square += square;
    sums.square2 += square * square;
}

Pooled pooled_alone(const BranchSums& sums) {
    Pooled out;
    const float n = effective_samples(sums);
    out.known = n / (n + kEnoughSamples);
    if (sums.taken > 0)
        out.cost = sums.cost / sums.taken;
    if (!(sums.weight > 0))
        return out;
    out.light = sums.light / sums.weight;
    const double mean2 = double{out.light} * double{out.light};
    const double square = double{sums.square} / double{sums.weight};
    if (mean2 > 0)
        out.noise = static_cast<float>(std::clamp(square / mean2 - 1, 0.0, 1e30));
    return out;
}

BranchSums thinned(BranchSums sums, float share) {
    for (float* value :
         {&sums.weight, &sums.light, &sums.light2, &sums.square, &sums.square2, &sums.cost, &sums.taken})
        *value *= share;
    return sums;
}

std::vector<Pooled> pool(int width, int height, std::vector<BranchSums> sums,
                         std::span<const float> feature) {
    const Image image{width, height, feature};
    std::vector<Pooled> out(sums.size());
    std::vector<float> rest(sums.size(), 1.0f);
    std::vector<BranchSums> wider(sums.size());
    for (int level = 0; level <= kLevels; ++level) {
        parallel_for(0, height, [&](int y) {
            for (int x = 0; x < width; ++x) {
                const std::size_t i = image.index(x, y);
                blend(sums[i], level == kLevels, out[i], rest[i]);
                if (level < kLevels)
                    wider[i] = widened(image, sums, x, y, 1 << level);
            }
        });
        sums.swap(wider);
    }
    // Where nothing was known at the widest level some trust is left over: it goes to what was known.
    for (std::size_t i = 0; i < out.size(); ++i) {
        const float given = 1 - rest[i];
        if (given > 0) {
            out[i].light /= given;
            out[i].cost /= given;
        }
    }
    return out;
}

std::vector<Pooled> pool_with_noise(int width, int height, std::vector<BranchSums> sums,
                                    std::span<const float> feature) {
    std::vector<Pooled> out = pool(width, height, sums, feature);
    for (std::size_t i = 0; i < sums.size(); ++i) {
        // In doubles: the fourth power of a dim radiance is no float.
        const double mean2 = double{out[i].light} * double{out[i].light};
        const auto relative = [&](float sum, double unit) {
            return unit > 0 ? static_cast<float>(std::min(double{sum} / unit, 1e30)) : 0;
        };
        sums[i].light = relative(sums[i].square, mean2);
        sums[i].light2 = relative(sums[i].square2, mean2 * mean2);
    }
    const std::vector<Pooled> noise = pool(width, height, std::move(sums), feature);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i].noise = std::max(noise[i].light - 1, 0.0f);
    return out;
}

}  // namespace nephele
