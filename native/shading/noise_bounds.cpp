// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/noise_bounds.h"

#include <array>
#include <optional>
#include <vector>

namespace nephele {
namespace {

using Box = std::array<Interval1, 3>;

/// A lattice cell or more is too much for gradients to say anything: the octave's whole range is smaller.
constexpr double kLargestResolved = 1;
/// Edge of the pieces that a box is cut into, and the largest box that is, in units of the first octave.
constexpr double kPiece = 0.25, kLargestCut = 4;
/// Coordinates that perlin does not fold into its period.
constexpr double kPeriod = 100000;

/// One octave's place in the sum.
struct Octave {
    float frequency;
    double weight;  ///< factor of its Perlin noise in the result, >= 0
};

/// A fractal with known settings: the result is `constant` plus the weighted octaves.
struct Fractal {
    std::vector<Octave> octaves;
    double constant = 0, scale = 0;  ///< scale: of the largest number that appears on the way
};

/// The weights that fractal_sum gives its octaves; nothing where they overflow.
std::optional<Fractal> fractal_of(double detail_setting, double roughness_setting, double lacunarity,
                                  bool normalize) {
    const double detail = std::clamp(detail_setting, 0.0, 15.0), roughness = std::max(roughness_setting, 0.0);
    const double rest = detail - std::floor(detail);
    const int coarse = static_cast<int>(detail) + 1, all = coarse + (rest > 0 ? 1 : 0);
    double amplitude = 1, coarse_total = 0, total = 0;
    for (int i = 0; i < all; ++i) {
        total += amplitude;
        coarse_total += i < coarse ? amplitude : 0;
        amplitude *= roughness;
    }
    // The result blends, by `rest`, the sum without the finest octave and the sum with it.
    const double without = (1 - rest) * (normalize ? 0.5 / coarse_total : 1),
                 with = rest * (normalize ? 0.5 / total : 1);
    Fractal fractal{{}, normalize ? 0.5 : 0, normalize ? 1 : total};
    amplitude = 1;
    float frequency = 1;
    for (int i = 0; i < all; ++i) {
        fractal.octaves.push_back({frequency, amplitude * (i < coarse ? without + with : with)});
        if (!std::isfinite(frequency) || !(total < 1e12))
            return std::nullopt;
        amplitude *= roughness;
        frequency *= static_cast<float>(lacunarity);
    }
    return fractal;
}

double fade(double t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}
/// Range of fade's derivative, which is highest in the middle.
Interval1 fade_slope(Interval1 t) {
    const auto slope = [](double x) { return 30 * x * x * (1 - x) * (1 - x); };
    const double p = slope(t.lo), q = slope(t.hi);
    return {std::min(p, q), t.contains(0.5) ? slope(0.5) : std::max(p, q)};
}

/// a and b blended by a weight in [0, 1].
Interval1 between(Interval1 a, Interval1 b, Interval1 w) {
    return {a.lo + (b.lo - a.lo) * (b.lo < a.lo ? w.hi : w.lo),
            a.hi + (b.hi - a.hi) * (b.hi < a.hi ? w.lo : w.hi)};
}

/// Range of the gradient of Perlin's noise over a part of one lattice cell. f: the part, in [0, 1]^3; of the
/// noise sum_c w_c(f) g_c . (f - c) over corners c it is sum_c w_c g_c plus the weights' slopes times the
/// differences of g_c . (f - c) across the cell.
class CellGradient {
  public:
    CellGradient(const std::array<int, 3>& cell, const Box& f, int dimensions) : f_(f), n_(dimensions) {
        for (int c = 0; c < 1 << n_; ++c) {
            g_[c] = lattice_gradient({cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)}, n_);
        }
        for (int i = 0; i < n_; ++i)
            weight_[i] = {fade(f[i].lo), fade(f[i].hi)};
    }

    Interval1 along(int axis) const {
        std::array<Interval1, 8> own, across;
        for (int c = 0; c < 1 << n_; ++c) {
            own[c] = Interval1(g_[c][axis]);
            if (c >> axis & 1)
                across[c] = across[c ^ 1 << axis] = difference(c ^ 1 << axis, c);
        }
        const Interval1 slope = fade_slope(f_[axis]), far = blended(across, axis), mean = blended(own, -1);
        const double p = far.lo * (far.lo < 0 ? slope.hi : slope.lo),
                     q = far.hi * (far.hi < 0 ? slope.lo : slope.hi);
        return {mean.lo + p, mean.hi + q};
    }

  private:
    /// Range of g_b . (f - b) - g_a . (f - a).
    Interval1 difference(int a, int b) const {
        Interval1 sum(0);
        for (int i = 0; i < n_; ++i) {
            const double slope = static_cast<double>(g_[b][i]) - g_[a][i];
            const double start = (a >> i & 1 ? g_[a][i] : 0.0) - (b >> i & 1 ? g_[b][i] : 0.0);
            sum.lo += start + slope * (slope < 0 ? f_[i].hi : f_[i].lo);
            sum.hi += start + slope * (slope < 0 ? f_[i].lo : f_[i].hi);
        }
        return sum;
    }
    /// Values at corners blended by the weights of all axes but `without`.
    Interval1 blended(std::array<Interval1, 8> v, int without) const {
        for (int i = 0; i < n_; ++i) {
            if (i == without)
                continue;
            for (int c = 0; c < 1 << n_; ++c) {
                if (!(c >> i & 1))
                    v[c] = between(v[c], v[c | 1 << i], weight_[i]);
            }
        }
        return v[0];
    }

    std::array<Vec3f, 8> g_;
    Box f_, weight_;
    int n_;
};

/// Range of the gradient over a box that reaches into at most two cells along each axis.
Box gradient_range(const Box& box, int n) {
    std::array<int, 3> first{}, cells{1, 1, 1};
    for (int i = 0; i < n; ++i) {
        first[i] = static_cast<int>(std::floor(box[i].lo));
        cells[i] = static_cast<int>(std::floor(box[i].hi)) - first[i] + 1;
    }
    std::optional<Box> range;
    for (int z = 0; z < cells[2]; ++z) {
        for (int y = 0; y < cells[1]; ++y) {
            for (int x = 0; x < cells[0]; ++x) {
                const std::array<int, 3> cell{first[0] + x, first[1] + y, first[2] + z};
                Box f;
                for (int i = 0; i < n; ++i)
                    f[i] = {std::max(0.0, box[i].lo - cell[i]), std::min(1.0, box[i].hi - cell[i])};
                const CellGradient gradient(cell, f, n);
                Box part;
                for (int i = 0; i < n; ++i)
                    part[i] = range ? join((*range)[i], gradient.along(i)) : gradient.along(i);
                range = part;
            }
        }
    }
    return *range;
}

/// Whether the mean value theorem holds over the box, and helps.
bool resolved(const Box& box, int n) {
    for (int i = 0; i < n; ++i) {
        if (!(box[i].width() <= kLargestResolved && box[i].magnitude() < kPeriod))
            return false;
    }
    return true;
}

float perlin_at(const std::array<float, 3>& p, int n) {
    return n == 1 ? perlin(p[0]) : n == 2 ? perlin(p[0], p[1]) : perlin(Vec3f(p[0], p[1], p[2]));
}

/// Bounds of the weighted octaves over a box that is not cut further.
Interval1 piece_bounds(const Box& p, const Fractal& fractal, int n) {
    Interval1 sum(fractal.constant);
    Box slopes;  // of the resolved octaves together, per unit of p
    double slack = 0;
    for (const Octave& octave : fractal.octaves) {
        const double most = octave.weight * kPerlinRange[n];
        Box box;
        for (int i = 0; i < n; ++i)
            box[i] = p[i] * octave.frequency;
        bool whole = !resolved(box, n);
        if (!whole) {
            const Box gradient = gradient_range(box, n);
            std::array<float, 3> center{};
            double reach = 0, error = 0;
            for (int i = 0; i < n; ++i) {
                center[i] = static_cast<float>(0.5 * (box[i].lo + box[i].hi));
                reach += 0.5 * box[i].width() * gradient[i].magnitude();
                error += gradient[i].magnitude() * 4 * kIntervalRounding * box[i].magnitude();
            }
            const double value = perlin_at(center, n);
            whole = reach + error > kPerlinRange[n];
            if (!whole) {
                sum = {sum.lo + octave.weight * value, sum.hi + octave.weight * value};
                slack += octave.weight * error;
                for (int i = 0; i < n; ++i) {
                    const double w = octave.weight * octave.frequency;
                    const Interval1 g = w < 0 ? -gradient[i] : gradient[i];
                    slopes[i] = {slopes[i].lo + std::fabs(w) * g.lo, slopes[i].hi + std::fabs(w) * g.hi};
                }
            }
        }
        if (whole)
            sum = {sum.lo - most, sum.hi + most};
    }
    for (int i = 0; i < n; ++i)
        slack += 0.5 * p[i].width() * slopes[i].magnitude();
    return rounded({sum.lo - slack, sum.hi + slack}, 4 * fractal.scale);
}

/// Bounds of the weighted octaves over a box.
Interval1 fractal_bounds(const Box& p, const Fractal& fractal, int n) {
    std::array<int, 3> pieces{1, 1, 1};
    double edge = 0;
    for (int i = 0; i < n; ++i)
        edge = std::max(edge, p[i].width());
    if (edge <= kLargestCut) {
        for (int i = 0; i < n; ++i)
            pieces[i] = std::max(1, static_cast<int>(std::ceil(p[i].width() / kPiece)));
    }
    std::optional<Interval1> value;
    for (int z = 0; z < pieces[2]; ++z) {
        for (int y = 0; y < pieces[1]; ++y) {
            for (int x = 0; x < pieces[0]; ++x) {
                const int place[] = {x, y, z};
                Box piece;
                for (int i = 0; i < n; ++i) {
                    const auto cut = [&](int k) {
                        return k == pieces[i] ? p[i].hi : p[i].lo + p[i].width() * k / pieces[i];
                    };
                    piece[i] = {cut(place[i]), cut(place[i] + 1)};
                }
                const Interval1 bounds = piece_bounds(piece, fractal, n);
                value = value ? join(*value, bounds) : bounds;
            }
        }
    }
    return *value;
}

Box moved(const Box& p, Vec3f by) {
    return {p[0] + by.x, p[1] + by.y, p[2] + by.z};
}

Box distorted(const Box& p, Interval1 distortion, int n) {
    if (distortion.is(0))
        return p;
    const Fractal one{{{1, 1}}, 0, 1};
    Box q = p;
    for (int i = 0; i < n; ++i)
        q[i] = p[i] + distortion * fractal_bounds(moved(p, noise_offset(i, n)), one, n);
    return q;
}

/// Bounds where the settings vary too, or the point is not bounded: the octaves' weights are positive.
Interval1 whole_range(const Interval3& fractal, bool normalize, int n) {
    const double most = kPerlinRange[n] + 1e-5;
    if (normalize)
        return {0.5 - 0.5 * most, 0.5 + 0.5 * most};
    double total = 0, amplitude = 1;
    for (int i = 0; i < 17 && i <= std::clamp(fractal[0].hi, 0.0, 15.0) + 1; ++i) {
        total += amplitude;
        amplitude *= std::max(fractal[1].hi, 0.0);
    }
    return rounded({-total * most, total * most});
}

}  // namespace

Interval3 noise_bounds(const Interval3& p, const Interval3& settings, Interval1 distortion, bool normalize,
                       int n, bool color) {
    // Octaves of at most (10^2)^16 keep sums finite.
    if (!tame(settings[0], settings[2]) || settings[1].nan || settings[1].hi > 100)
        return Interval3(everything());
    const Interval1 range = whole_range(settings, normalize, n);
    const bool constant = settings[0].width() == 0 && settings[1].width() == 0 && settings[2].width() == 0;
    if (!constant || !tame(distortion) || !tame(p[0], p[1], p[2]))
        return Interval3(range);
    const auto fractal = fractal_of(settings[0].lo, settings[1].lo, settings[2].lo, normalize);
    if (!fractal)
        return Interval3(range);
    const Box q = distorted({p[0], p[1], p[2]}, distortion, n);
    const auto channel = [&](const Box& box) {
        return narrowed(fractal_bounds(box, *fractal, n), range.lo, range.hi);
    };
    const Interval1 value = channel(q);
    return color ? Interval3(value, channel(moved(q, noise_offset(n, n))),
                             channel(moved(q, noise_offset(n + 1, n))))
                 : Interval3(value);
}

}  // namespace nephele
