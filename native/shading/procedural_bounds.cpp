// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/procedural_bounds.h"

#include "shading/channel_bounds.h"
#include "shading/noise_bounds.h"

namespace nephele {
namespace {

constexpr Interval1 kUnit{0, 1};

Interval1 tame_or_everything(Interval1 x) {
    return tame(x) ? x : everything();
}

// --- Fractals other than fBM: their recurrences over intervals, a fraction of an octave included
// -------------------------------------------------------------------------------------------------------

struct Fractal {
    Interval1 noise, roughness, offset, gain;
    int octaves;  ///< after the first, a started one included
};

Interval1 multifractal(const Fractal& f) {
    Interval1 value(1), amplitude(1), all(1);
    for (int i = 0; i <= f.octaves; ++i) {
        all = join(all, value * (kUnit * amplitude * f.noise + 1));
        value = value * (amplitude * f.noise + 1);
        amplitude = amplitude * f.roughness;
    }
    return all;
}

Interval1 hetero_terrain(const Fractal& f) {
    Interval1 value = f.offset + f.noise, amplitude = f.roughness;
    for (int i = 1; i <= f.octaves; ++i) {
        value = value + kUnit * (f.noise + f.offset) * amplitude * value;
        amplitude = amplitude * f.roughness;
    }
    return value;
}

Interval1 hybrid_multifractal(const Fractal& f) {
    Interval1 value(0), amplitude(1), weight(1);
    for (int i = 0; i <= f.octaves; ++i) {
        const Interval1 signal = (f.noise + f.offset) * amplitude, counts = min(weight, Interval1(1));
        value = value + kUnit * counts * signal;
        weight = counts * f.gain * signal;
        amplitude = amplitude * f.roughness;
    }
    return value;
}

Interval1 ridged_multifractal(const Fractal& f) {
    Interval1 value(0), amplitude(1), weight(1);
    for (int i = 0; i <= f.octaves; ++i) {
        const Interval1 signal = squared(f.offset - absolute(f.noise)) * weight;
        value = value + kUnit * signal * amplitude;
        weight = clamp01(signal * f.gain);
        amplitude = amplitude * f.roughness;
    }
    return value;
}

Interval1 fractal_range(NoiseType type, const Fractal& f) {
    switch (type) {
        case NoiseType::multifractal:
            return multifractal(f);
        case NoiseType::hybrid_multifractal:
            return hybrid_multifractal(f);
        case NoiseType::ridged_multifractal:
            return ridged_multifractal(f);
        default:
            return hetero_terrain(f);
    }
}

int most_octaves(Interval1 detail) {
    return static_cast<int>(std::ceil(std::clamp(detail.hi, 0.0, 15.0)));
}

// --- Voronoi
// -----------------------------------------------------------------------------------------------------

/// Length by the metric of the largest vector whose components are at most `side`.
double corner(const VoronoiMode& mode, Interval1 exponent, double side) {
    const double n = mode.dimensions;
    if (n == 1 || mode.metric == VoronoiMetric::chebychev)
        return side;
    if (mode.metric == VoronoiMetric::manhattan)
        return n * side;
    return side * std::pow(n, mode.metric == VoronoiMetric::euclidean ? 0.5 : 1 / exponent.lo);
}

/// The point of the own cell is at most a cell's diagonal away and a neighbour's two; a smooth minimum of
/// smoothness k leaves [-1.25 k, minimum + k]. Half the distance between two points of neighbours, and an
/// edge, are no farther than one and a half diagonals.
Interval1 octave_distance(const VoronoiMode& mode, Interval1 exponent, Interval1 smoothness) {
    const double k = 0.5 * std::clamp(smoothness.hi, 0.0, 1.0);
    switch (mode.feature) {
        case VoronoiFeature::f1:
            return {0, corner(mode, exponent, 1)};
        case VoronoiFeature::f2:
            return {0, corner(mode, exponent, 2)};
        case VoronoiFeature::smooth_f1:
            return {-1.25 * k, corner(mode, exponent, 1) + k};
        default:
            return {0, 1.5 * std::sqrt(mode.dimensions)};
    }
}

/// Least of voronoi_largest_distance: every metric's length is at least that of the largest component.
double least_scale(const VoronoiMode& mode, Interval1 exponent, Interval1 randomness) {
    const double side = 0.5 + 0.5 * std::clamp(randomness.lo, 0.0, 1.0);
    if (mode.feature == VoronoiFeature::distance_to_edge)
        return side;
    const Interval1 most(exponent.hi);
    return corner(mode, most, side) * (mode.feature == VoronoiFeature::f2 ? 2 : 1);
}

struct VoronoiOctaves {
    double total = 0;                 ///< largest sum of amplitudes
    double finest = 1, coarsest = 1;  ///< frequencies
};
VoronoiOctaves octaves_of(const Interval3& fractal) {
    VoronoiOctaves out;
    double amplitude = 1, high = 1, low = 1;
    for (int i = 0; i <= most_octaves(fractal[0]); ++i) {
        out.total += amplitude;
        out.finest = std::max(out.finest, high);
        out.coarsest = std::min(out.coarsest, low);
        amplitude *= std::clamp(fractal[1].hi, 0.0, 1.0);
        high *= fractal[2].hi;
        low *= fractal[2].lo;
    }
    return out;
}

Interval1 voronoi_distance(const VoronoiMode& mode, Interval1 one, double scale,
                           const VoronoiOctaves& octaves) {
    if (mode.feature == VoronoiFeature::n_sphere_radius)
        return rounded(one, 4);
    if (mode.feature == VoronoiFeature::distance_to_edge) {  // the least of octaves: no more than the first
        const double most = mode.normalize ? octaves.finest / scale : 1;
        return tame_or_everything(rounded({0, 8 * most}, 8 * most));
    }
    const double weight = mode.normalize ? 1 / scale : octaves.total;
    return tame_or_everything(rounded(one * weight, 4 * one.magnitude() * weight));
}

/// Colours blend between cells; a smooth minimum takes up to a twentieth from them at every neighbour.
Interval1 voronoi_color(const VoronoiMode& mode, const VoronoiOctaves& octaves) {
    const double weight = mode.normalize ? 1 : octaves.total;
    const bool smooth = mode.feature == VoronoiFeature::smooth_f1;
    const double taken = smooth ? 0.05 * std::pow(5, mode.dimensions) : 0;
    return rounded({-taken * weight, weight}, (1 + taken) * weight);
}

/// Positions are those of points in neighbouring cells.
Interval3 voronoi_position(const VoronoiMode& mode, const Interval3& p, Interval1 w, Interval1 scale,
                           const VoronoiOctaves& octaves) {
    const bool smooth = mode.feature == VoronoiFeature::smooth_f1;
    const double away = (smooth ? 3 + 0.05 * std::pow(5, mode.dimensions) : 2) / octaves.coarsest;
    const auto near = [&](Interval1 x) {
        if (!tame(x))
            return everything();
        const Interval1 place = rounded({x.lo - away, x.hi + away}, 16 * (x.magnitude() + away));
        return scale.contains(0) ? everything() : divide(place, scale);
    };
    const int n = mode.dimensions;
    const Interval1 none(0);
    if (mode.output == VoronoiOutput::w)
        return Interval3(n == 1 ? near(p[0]) : n == 4 ? near(w) : none);
    return {near(p[0]), n > 1 ? near(p[1]) : none, n > 2 ? near(p[2]) : none};
}

}  // namespace

Interval3 noise_operation_bounds(std::int32_t mode, const Interval3& a, const Interval3& b,
                                 const Interval3& c, const Interval3& d) {
    const NoiseMode m(mode);
    if (m.type == NoiseType::fbm) {
        const Interval3 p{a[0] * b[0], a[1] * b[0], a[2] * b[0]};
        return noise_bounds(p, b[1] * b[0], c, d[0], m.normalize, m.dimensions, m.color);
    }
    if (!tame(c[0], c[1], c[2], b[2], d[1]))
        return Interval3(everything());
    const double most = kPerlinRange[m.dimensions] + 1e-5;
    const Fractal fractal{{-most, most}, max(c[1], Interval1(0)), b[2], d[1], most_octaves(c[0])};
    return Interval3(tame_or_everything(fractal_range(m.type, fractal)));
}

Interval3 voronoi_operation_bounds(std::int32_t mode, const Interval3& a, const Interval3& b,
                                   const Interval3& c, const Interval3& d) {
    const VoronoiMode m(mode);
    const bool minkowski = m.metric == VoronoiMetric::minkowski;
    const bool known = tame(b[0], b[1], c[0], c[1], d[0], d[1]) && c[2].lo >= 0.01 && c[2].hi <= 100 &&
                       (!minkowski || (tame(b[2]) && b[2].lo >= 0.05 && b[2].hi <= 1000));
    if (!known)
        return Interval3(everything());
    const VoronoiOctaves octaves = octaves_of(c);
    const bool pointless =  // features without a colour and a place
        m.feature == VoronoiFeature::distance_to_edge || m.feature == VoronoiFeature::n_sphere_radius;
    switch (m.output) {
        case VoronoiOutput::distance:
            return Interval3(
                voronoi_distance(m, octave_distance(m, b[2], d[0]), least_scale(m, b[2], d[1]), octaves));
        case VoronoiOutput::color:
            return Interval3(pointless ? Interval1(0) : voronoi_color(m, octaves));
        default:
            break;
    }
    if (pointless)
        return Interval3(b[0].contains(0) ? join(divide(Interval1(0), b[0]), Interval1(0)) : Interval1(0));
    const Interval3 p{a[0] * b[0], a[1] * b[0], a[2] * b[0]};
    return voronoi_position(m, p, b[1] * b[0], b[0], octaves);
}

/// Every impulse of the cells around may add its whole envelope.
Interval3 gabor_operation_bounds(std::int32_t mode, const Interval3& b, const Interval3& c) {
    const bool solid = (mode & 4) != 0;
    const double most = solid ? 8 * 27 / 5.0 : 8 * 9 / 6.0;  // over six standard deviations
    const bool nan = !tame(b[0], b[1], b[2]) || !tame(c[0], c[1], c[2]);
    switch (mode & 3) {
        case 0:
            return Interval3(Interval1(0.5 - 0.5 * most, 0.5 + 0.5 * most, nan));
        case 1:
            return Interval3(Interval1(-kIntervalRounding, 1 + kIntervalRounding, nan));
        default:
            return Interval3(Interval1(0, most * std::sqrt(2), nan));
    }
}

Interval3 brick_operation_bounds(const Interval3& a, const Interval3& b, const Interval3& c) {
    const bool nan = !tame(a[0], a[1]) || !tame(b[0], b[1], b[2]) || !tame(c[0], c[1]);
    const Interval1 unit(0, 1 + kIntervalRounding, nan);
    return {unit, unit, Interval1(0)};
}

}  // namespace nephele
