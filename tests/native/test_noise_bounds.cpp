// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of noise: the range of Perlin's noise proved by subdivision, fractals sampled inside boxes of all
// sizes, and how close the bounds come.
#include <array>
#include <string>

#include "bounds_fixtures.h"
#include "shading/noise_bounds.h"

namespace nephele {
namespace {

using test::holds;
using test::Random;

/// Perlin's noise over a part of a lattice cell, or its derivative along x: the sum over corners c of
/// g_c . a_c(f), a_c the weight of the corner times f - c, derived. `order` counts derivatives.
class PerlinPart {
  public:
    PerlinPart(int dimensions, int order, const std::array<Interval1, 4>& f) : n_(dimensions) {
        for (int c = 0; c < 1 << n_; ++c) {
            Interval1 rest(1);  // weight of the other axes
            for (int i = 1; i < n_; ++i)
                rest = rest * weight(f[i], c >> i & 1, 0);
            const auto x = [&](int k) { return weight(f[0], c & 1, k); };
            std::array<Interval1, 4> a;
            for (int i = 0; i < n_; ++i) {
                a[i] = rest * x(order) * (f[i] - (c >> i & 1));
                if (i == 0 && order > 0)  // the product rule: f.x - c.x has derivative 1
                    a[i] = a[i] + rest * x(order - 1) * order;
            }
            bound += scale() * most(a);
        }
    }

    double bound = 0;  ///< of the value for any gradients

  private:
    /// Weight of a corner along one axis, derived k times.
    static Interval1 weight(Interval1 t, int upper, int k) {
        const auto fade = [](double x) { return x * x * x * (x * (x * 6 - 15) + 10); };
        const Interval1 u = k == 0   ? Interval1(fade(t.lo), fade(t.hi))
                            : k == 1 ? squared(t) * squared(1 - t) * 30
                                     : t * (1 - t) * (1 - t * 2) * 60;
        return upper ? u : k == 0 ? 1 - u : -u;
    }
    /// Largest product of a with a gradient: 1 to 8 along x; (1, 2) or (2, 1); or all components but one of
    /// 1; any signs.
    double most(const std::array<Interval1, 4>& a) const {
        const double x = a[0].magnitude(), y = a[1].magnitude(), z = a[2].magnitude(), w = a[3].magnitude();
        return n_ == 1   ? 8 * x
               : n_ == 2 ? x + y + std::max(x, y)
               : n_ == 3 ? x + y + z - std::min({x, y, z})
                         : x + y + z + w - std::min({x, y, z, w});
    }
    double scale() const { return n_ == 1 ? 0.25 : n_ == 2 ? 0.6616 : n_ == 3 ? 0.9820 : 0.8344; }

    int n_;
};

/// Whether no part of a cell exceeds `most`: parts that may are halved, down to 1/4096. The other halves of
/// the cell are mirror images of this one, and y and z play the same role.
bool stays_below(int n, int order, double most,
                 std::array<Interval1, 4> f = {Interval1(0, 0.5), {0, 0.5}, {0, 0.5}, {0, 0.5}}) {
    if ((n >= 3 && f[1].lo > f[2].hi) || (n == 4 && f[2].lo > f[3].hi))
        return true;
    if (PerlinPart(n, order, f).bound <= most)
        return true;
    if (f[0].width() < 1.0 / 4096)
        return false;
    bool all = true;
    for (int k = 0; k < 1 << n && all; ++k) {
        auto half = f;
        for (int i = 0; i < n; ++i) {
            const double middle = 0.5 * (f[i].lo + f[i].hi);
            (k >> i & 1 ? half[i].lo : half[i].hi) = middle;
        }
        all = stays_below(n, order, most, half);
    }
    return all;
}

TEST(NoiseBounds, PerlinAndItsDerivativesStayInTheirRanges) {
    for (const int n : {1, 2, 3, 4}) {
        EXPECT_TRUE(stays_below(n, 0, kPerlinRange[n])) << n << " dimensions";
        EXPECT_TRUE(stays_below(n, 1, kPerlinSlope[n])) << n << " dimensions";
        EXPECT_TRUE(stays_below(n, 2, kPerlinCurvature[n])) << n << " dimensions";
        if (n == 4)  // as good as is proved in a second: how tight they are takes minutes to say
            continue;
        EXPECT_FALSE(stays_below(n, 0, 0.98 * kPerlinRange[n])) << n << " dimensions";
        EXPECT_FALSE(stays_below(n, 1, 0.9 * kPerlinSlope[n])) << n << " dimensions";
        EXPECT_FALSE(stays_below(n, 2, 0.9 * kPerlinCurvature[n])) << n << " dimensions";
    }
}

Interval3 box(Vec3f lo, Vec3f hi) {
    return {{lo.x, hi.x}, {lo.y, hi.y}, {lo.z, hi.z}};
}

TEST(NoiseBounds, HoldFractalsOverBoxesOfAllSizes) {
    Random random(5);
    for (int k = 0; k < 6000; ++k) {
        const int n = 1 + random.below(4);
        const float w = random.between(-3, 3);
        const float details[] = {0, 2, 3.5f, random.between(0, 15)};
        const NoiseSettings settings{
            details[random.below(4)], random.between(0, 1.2f),
            random.between(1, 4),     random.below(2) == 0 ? 0 : random.between(-2, 2),
            random.below(2) == 0,     n};
        const float size = std::exp(random.between(std::log(1e-3f), std::log(100.0f)));
        const float centers[] = {0, 3, 50, 3000};
        const Vec3f center = random.vector(-1, 1) * centers[random.below(4)];
        const Vec3f lo = center, hi = center + random.vector(0, 1) * size;
        const Interval3 bounds =
            noise_bounds(box(lo, hi), Interval1(w),
                         Interval3(Vec3f(settings.detail, settings.roughness, settings.lacunarity)),
                         Interval1(settings.distortion), settings.normalize, n, true);
        for (int sample = 0; sample < 40; ++sample) {
            const Vec3f p = min(max(lo + (hi - lo) * random.vector(0, 1), lo), hi);
            const Rgb value = noise_color({p, w}, settings);
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
    for (const auto& [size, most] : {std::pair{0.01f, 1.6}, {0.1f, 1.6}, {0.4f, 1.3}}) {
        double ratio = 0;
        for (int k = 0; k < 40; ++k) {
            const Vec3f lo = random.vector(-10, 10), hi = lo + Vec3f(size);
            const Interval3 bounds = noise_bounds(box(lo, hi), Interval1(0), Interval3(Vec3f(2, 0.5f, 2)),
                                                  Interval1(0), true, 3, false);
            float least = 1, greatest = 0;
            for (int sample = 0; sample < 2000; ++sample) {
                const float v = noise_value(lo + Vec3f(size) * random.vector(0, 1), settings);
                least = std::min(least, v);
                greatest = std::max(greatest, v);
            }
            ratio += bounds[0].width() / static_cast<double>(greatest - least) / 40;
        }
        EXPECT_LT(ratio, most) << "boxes of " << size;
    }
}

}  // namespace
}  // namespace nephele
