// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of noise: the range of Perlin's noise proved by subdivision, fractals sampled inside boxes of all
// sizes, and how close the bounds come.
#include <queue>
#include <string>

#include "bounds_fixtures.h"
#include "shading/noise_bounds.h"

namespace nephele {
namespace {

using test::holds;
using test::Random;

/// Largest value that Perlin's noise of some hash takes inside [0,1]^n, by branch and bound down to `gap`:
/// over a box of fractions each corner's gradient is the one that gives most there, and the weights are
/// bounded.
double largest_perlin(int n, double gap) {
    struct Part {
        double lo[3], size, bound;
        bool operator<(const Part& other) const { return bound < other.bound; }
    };
    const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
    const auto most_of_gradients = [&](const double(&d)[3]) {  // |offsets| from the corner
        if (n == 1)
            return 8 * d[0];
        if (n == 2)
            return d[0] + d[1] + std::max(d[0], d[1]);  // (1, 2) or (2, 1)
        return d[0] + d[1] + d[2] - std::min({d[0], d[1], d[2]});
    };
    const double scale = n == 1 ? 0.25 : n == 2 ? 0.6616f : 0.9820f;
    const auto bound = [&](Part& part) {
        double v[8];
        for (int c = 0; c < 1 << n; ++c) {
            double d[3] = {};
            for (int i = 0; i < n; ++i)
                d[i] = c >> i & 1 ? 1 - part.lo[i] : part.lo[i] + part.size;
            v[c] = most_of_gradients(d);
        }
        for (int i = 0; i < n; ++i) {
            const double low = fade(part.lo[i]), high = fade(part.lo[i] + part.size);
            for (int c = 0; c < 1 << n; ++c) {
                if (!(c >> i & 1)) {
                    const double a = v[c], b = v[c | 1 << i];
                    v[c] = a + (b - a) * (b > a ? high : low);
                }
            }
        }
        part.bound = scale * v[0];
    };
    std::priority_queue<Part> parts;
    Part whole{{0, 0, 0}, 0.5, 0};  // the rest is its mirror images
    bound(whole);
    parts.push(whole);
    while (parts.top().size > gap) {
        const Part top = parts.top();
        parts.pop();
        for (int k = 0; k < 1 << n; ++k) {
            Part half = top;
            half.size /= 2;
            for (int i = 0; i < n; ++i)
                half.lo[i] += (k >> i & 1) * half.size;
            bound(half);
            parts.push(half);
        }
    }
    return parts.top().bound;
}

TEST(NoiseBounds, PerlinStaysInItsRange) {
    for (const int n : {1, 2, 3}) {
        const double largest = largest_perlin(n, n == 3 ? 1.0 / 2048 : 1e-5);
        EXPECT_LE(largest, kPerlinRange[n]) << n << " dimensions";
        EXPECT_GT(largest, kPerlinRange[n] - 0.01) << n << " dimensions";
    }
}

TEST(NoiseBounds, GradientOfTheLatticeIsPerlins) {
    for (const int n : {1, 2, 3}) {
        const Vec3f g = lattice_gradient({3, -5, n == 3 ? 7 : 0}, n);
        const float h = 1e-3f;
        const float along_x = n == 1   ? perlin(3 + h)
                              : n == 2 ? perlin(3 + h, -5)
                                       : perlin(Vec3f(3 + h, -5, 7));
        EXPECT_NEAR(along_x / h, g.x, 2e-3) << n;
    }
}

Interval3 box(Vec3f lo, Vec3f hi) {
    return {{lo.x, hi.x}, {lo.y, hi.y}, {lo.z, hi.z}};
}

TEST(NoiseBounds, HoldFractalsOverBoxesOfAllSizes) {
    Random random(5);
    for (int k = 0; k < 6000; ++k) {
        const int n = 1 + random.below(3);
        const float details[] = {0, 2, 3.5f, random.between(0, 15)};
        const NoiseSettings settings{
            details[random.below(4)], random.between(0, 1.2f),
            random.between(1, 4),     random.below(2) == 0 ? 0 : random.between(-2, 2),
            random.below(2) == 0,     n};
        const float size = std::exp(random.between(std::log(1e-3f), std::log(100.0f)));
        const float centers[] = {0, 3, 50, 3000};
        const Vec3f center = random.vector(-1, 1) * centers[random.below(4)];
        const Vec3f lo = center, hi = center + random.vector(0, 1) * size;
        const Interval3 bounds = noise_bounds(
            box(lo, hi), Interval3(Vec3f(settings.detail, settings.roughness, settings.lacunarity)),
            Interval1(settings.distortion), settings.normalize, n, true);
        for (int sample = 0; sample < 40; ++sample) {
            const Vec3f p = min(max(lo + (hi - lo) * random.vector(0, 1), lo), hi);
            const Rgb value = noise_color(p, settings);
            ASSERT_TRUE(holds(bounds, value))
                << "dimensions " << n << ", box of " << size << ", detail " << settings.detail << ": "
                << value.x << " " << value.y << " " << value.z << " outside [" << bounds.lo.x << ", "
                << bounds.hi.x << "] [" << bounds.lo.y << ", " << bounds.hi.y << "] [" << bounds.lo.z << ", "
                << bounds.hi.z << "]";
        }
    }
}

/// Width of the bounds against that of what 2000 samples find, over boxes of one size.
TEST(NoiseBounds, AreCloseWhereTheBoxIsSmall) {
    Random random(6);
    const NoiseSettings settings{2, 0.5f, 2, 0, true, 3};
    for (const auto& [size, most] : {std::pair{0.01f, 1.2}, {0.1f, 1.8}, {0.4f, 2.2}}) {
        double ratio = 0;
        for (int k = 0; k < 40; ++k) {
            const Vec3f lo = random.vector(-10, 10), hi = lo + Vec3f(size);
            const Interval3 bounds =
                noise_bounds(box(lo, hi), Interval3(Vec3f(2, 0.5f, 2)), Interval1(0), true, 3, false);
            float least = 1, greatest = 0;
            for (int sample = 0; sample < 2000; ++sample) {
                const float v = noise_value(lo + Vec3f(size) * random.vector(0, 1), settings);
                least = std::min(least, v);
                greatest = std::max(greatest, v);
            }
            ratio += bounds[0].width() / static_cast<double>(greatest - least) / 40;
        }
        RecordProperty("ratio_" + std::to_string(size), std::to_string(ratio));
        printf("size %g ratio %g\n", static_cast<double>(size), ratio);
        EXPECT_LT(ratio, most) << "boxes of " << size;
    }
}

}  // namespace
}  // namespace nephele
