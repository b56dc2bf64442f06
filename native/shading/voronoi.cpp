// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/voronoi.h"

#include "shading/hash.h"

namespace nephele {
namespace {

/// A point of N dimensions.
template <int N>
struct Point {
    std::array<float, N> x{};

    float& operator[](int i) { return x[static_cast<std::size_t>(i)]; }
    float operator[](int i) const { return x[static_cast<std::size_t>(i)]; }
};
template <int N, typename F>
Point<N> each(F f, const Point<N>& a, const Point<N>& b) {
    Point<N> out;
    for (int i = 0; i < N; ++i)
        out[i] = f(a[i], b[i]);
    return out;
}
template <int N>
Point<N> operator+(const Point<N>& a, const Point<N>& b) {
    return each([](float x, float y) { return x + y; }, a, b);
}
template <int N>
Point<N> operator-(const Point<N>& a, const Point<N>& b) {
    return each([](float x, float y) { return x - y; }, a, b);
}
template <int N>
float dot(const Point<N>& a, const Point<N>& b) {
    float sum = 0;
    for (int i = 0; i < N; ++i)
        sum += a[i] * b[i];
    return sum;
}

// --- Cells
// -------------------------------------------------------------------------------------------------------

/// Hash of a cell's whole coordinates in [0, 1], N numbers at once.
template <std::size_t N>
std::array<float, N> hash_cell(const std::array<float, N>& c) {
    std::array<std::uint32_t, N> words;
    for (std::size_t i = 0; i < N; ++i)
        words[i] = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::clamp(c[i], -2e9f, 2e9f)));
    words = hash_pcg(words);
    std::array<float, N> out;
    for (std::size_t i = 0; i < N; ++i)
        out[i] = static_cast<float>(words[i] & 0x7fffffffu) * (1.0f / 2147483647.0f);
    return out;
}

/// Numbers in [0, 1] that belong to a cell: where its feature point lies.
template <int N>
Point<N> jitter(const Point<N>& c) {
    if constexpr (N == 1)
        return {{hash_unit(c[0])}};
    else
        return {hash_cell(c.x)};
}
/// The colour of a cell.
template <int N>
Rgb color_of(const Point<N>& c) {
    if constexpr (N == 1)
        return {hash_unit(c[0]), hash_unit(c[0], 1.0f), hash_unit(c[0], 2.0f)};
    else if constexpr (N == 2)
        return color_of(Point<3>{{c[0], c[1], 0}});
    else {
        const Point<N> j = jitter(c);
        return {j[0], j[1], j[2]};
    }
}

template <int N>
float measure(const Point<N>& d, const VoronoiSettings& settings) {
    float sum = 0, largest = 0;
    switch (N == 1 ? VoronoiMetric::manhattan : settings.metric) {
        case VoronoiMetric::euclidean:
            return std::sqrt(dot(d, d));
        case VoronoiMetric::manhattan:
            for (const float x : d.x)
                sum += std::fabs(x);
            return sum;
        case VoronoiMetric::chebychev:
            for (const float x : d.x)
                largest = std::max(largest, std::fabs(x));
            return largest;
        case VoronoiMetric::minkowski:
            break;
    }
    for (const float x : d.x)
        sum += std::pow(std::fabs(x), settings.exponent);
    return std::pow(sum, 1 / settings.exponent);
}

/// The lattice around a point: offsets are relative to the point's own cell.
template <int N>
struct Neighbourhood {
    Point<N> cell, local;
    float randomness;

    Neighbourhood(const Point<N>& p, float r) : randomness(r) {
        for (int i = 0; i < N; ++i) {
            const float x = std::isfinite(p[i]) ? p[i] : 0;  // octaves may have scaled it beyond all numbers
            cell[i] = std::floor(x);
            local[i] = x - cell[i];
        }
    }
    Point<N> feature(const Point<N>& offset) const {
        Point<N> at = jitter(cell + offset);
        for (int i = 0; i < N; ++i)
            at[i] = offset[i] + at[i] * randomness;
        return at;
    }
    /// Calls f(offset) for the cells up to `reach` away, the first coordinate the fastest.
    template <typename F>
    static void visit(int reach, F f) {
        Point<N> offset;
        offset.x.fill(static_cast<float>(-reach));
        for (int i = 0; i < N;) {
            f(offset);
            for (i = 0; i < N && offset[i] == static_cast<float>(reach); ++i)
                offset[i] = static_cast<float>(-reach);
            if (i < N)
                offset[i] += 1;
        }
    }
};

// --- Features
// ----------------------------------------------------------------------------------------------------

/// What one octave gives.
template <int N>
struct Octave {
    float distance = 0;
    Rgb color;
    Point<N> position;
};

/// The nearest feature point, or the second nearest.
template <int N>
Octave<N> nearest(const Point<N>& p, const VoronoiSettings& settings, bool second) {
    const Neighbourhood<N> around(p, settings.randomness);
    struct Found {
        float distance = std::numeric_limits<float>::max();
        Point<N> offset, at;
    } found[2];
    Neighbourhood<N>::visit(1, [&](const Point<N>& offset) {
        const Point<N> at = around.feature(offset);
        const float distance = measure(at - around.local, settings);
        if (distance < found[0].distance) {
            found[1] = found[0];
            found[0] = {distance, offset, at};
        } else if (distance < found[1].distance) {
            found[1] = {distance, offset, at};
        }
    });
    const Found& f = found[second ? 1 : 0];
    return {f.distance, color_of(around.cell + f.offset), f.at + around.cell};
}

/// The nearest feature point, blended with those that are hardly farther by a polynomial smooth minimum.
template <int N>
Octave<N> smooth_nearest(const Point<N>& p, const VoronoiSettings& settings) {
    const float smoothness = settings.smoothness * 0.5f;
    if (smoothness == 0)
        return nearest(p, settings, false);
    const Neighbourhood<N> around(p, settings.randomness);
    Octave<N> blend;
    bool first = true;
    Neighbourhood<N>::visit(2, [&](const Point<N>& offset) {
        const Point<N> at = around.feature(offset);
        const float distance = measure(at - around.local, settings);
        const float t = first ? 1 : clamp01(0.5f + 0.5f * (blend.distance - distance) / smoothness);
        first = false;
        const float h = t * t * (3 - 2 * t), dip = smoothness * h * (1 - h);
        const float softer_dip = dip / (1 + 3 * smoothness);
        blend.distance = lerp(blend.distance, distance, h) - dip;
        blend.color = lerp(blend.color, color_of(around.cell + offset), h) - Rgb(softer_dip);
        blend.position =
            each([&](float a, float b) { return lerp(a, b, h) - softer_dip; }, blend.position, at);
    });
    blend.position = blend.position + around.cell;
    return blend;
}

/// Offset of the cell whose feature point is the nearest by Euclid's metric.
template <int N>
Point<N> nearest_offset(const Neighbourhood<N>& around) {
    float best = std::numeric_limits<float>::max();
    Point<N> nearest;
    Neighbourhood<N>::visit(1, [&](const Point<N>& offset) {
        const Point<N> d = around.feature(offset) - around.local;
        if (const float square = dot(d, d); square < best) {
            best = square;
            nearest = offset;
        }
    });
    return nearest;
}

/// Distance to the border between the cells of the Voronoi diagram: to the planes halfway to other feature
/// points.
template <int N>
float edge_distance(const Point<N>& p, float randomness) {
    const Neighbourhood<N> around(p, randomness);
    if constexpr (N == 1) {  // in 1D the cell's own feature point stands for the nearest
        const auto middle = [&](float other) {
            return std::fabs((around.feature({{0}})[0] + around.feature({{other}})[0]) / 2 - around.local[0]);
        };
        return std::min(middle(-1), middle(1));
    }
    const Point<N> own = around.feature(nearest_offset(around)) - around.local;
    float best = std::numeric_limits<float>::max();
    Neighbourhood<N>::visit(1, [&](const Point<N>& offset) {
        const Point<N> other = around.feature(offset) - around.local, across = other - own;
        if (const float square = dot(across, across); square > 1e-4f)
            best = std::min(best, std::max(0.5f * dot(own + other, across) / std::sqrt(square), 0.0f));
    });
    return best;
}

/// Radius of the sphere around the nearest feature point that touches its nearest neighbour's.
template <int N>
float sphere_radius(const Point<N>& p, float randomness) {
    const Neighbourhood<N> around(p, randomness);
    const Point<N> own = nearest_offset(around), center = around.feature(own);
    float best = std::numeric_limits<float>::max();
    Neighbourhood<N>::visit(1, [&](const Point<N>& offset) {
        if (dot(offset, offset) == 0)
            return;
        const Point<N> d = around.feature(own + offset) - center;
        best = std::min(best, dot(d, d));
    });
    return std::sqrt(best) / 2;
}

// --- Octaves
// -----------------------------------------------------------------------------------------------------

template <int N>
Octave<N> octave(const Point<N>& p, const VoronoiSettings& settings) {
    if (settings.feature == VoronoiFeature::smooth_f1)
        return smooth_nearest(p, settings);
    return nearest(p, settings, settings.feature == VoronoiFeature::f2);
}
template <int N>
Point<N> scaled(Point<N> p, float by) {
    for (float& x : p.x)
        x *= by;
    return p;
}

/// Weights of the octaves of a fractal: f(frequency, amplitude, share) for each; share is below 1 where a
/// fraction of `detail` blends the last one in.
template <typename F>
void visit_octaves(const VoronoiSettings& settings, F f) {
    const float whole = std::floor(settings.detail), rest = settings.detail - whole;
    float amplitude = 1, frequency = 1;
    for (int i = 0; i <= static_cast<int>(whole); ++i) {
        f(frequency, amplitude, 1.0f);
        frequency *= settings.lacunarity;
        amplitude *= settings.roughness;
    }
    if (rest != 0)
        f(frequency, amplitude, rest);
}

/// Sum of distances and colours; the position blends from each octave to the next.
template <int N>
Octave<N> sum_of_octaves(const Point<N>& p, const VoronoiSettings& settings) {
    Octave<N> sum;
    float total = 0;
    if (settings.detail == 0 || settings.roughness == 0) {
        sum = octave(p, settings);
        total = 1;
    } else {
        visit_octaves(settings, [&](float frequency, float amplitude, float share) {
            const Octave<N> o = octave(scaled(p, frequency), settings);
            total += share * amplitude;
            sum.distance += share * amplitude * o.distance;
            sum.color += o.color * (share * amplitude);
            sum.position = each([&](float a, float b) { return lerp(a, b / frequency, share * amplitude); },
                                sum.position, o.position);
        });
    }
    if (settings.normalize) {
        sum.distance /= total * voronoi_largest_distance(settings);
        sum.color = sum.color / total;
    }
    return sum;
}

/// The least of the octaves' distances, each blended in by its amplitude.
template <int N>
float edges_of_octaves(const Point<N>& p, const VoronoiSettings& settings) {
    float largest = voronoi_largest_distance(settings);
    if (settings.detail == 0 || settings.roughness == 0) {
        const float distance = edge_distance(p, settings.randomness);
        return settings.normalize ? distance / largest : distance;
    }
    const float one = largest;
    float distance = 8;  // beyond any
    visit_octaves(settings, [&](float frequency, float amplitude, float share) {
        const float d = edge_distance(scaled(p, frequency), settings.randomness) / frequency;
        const float nearer = lerp(distance, std::min(distance, d), amplitude);
        const float larger = lerp(largest, one / frequency, amplitude);
        distance = lerp(distance, std::min(distance, nearer), share);
        largest = lerp(largest, larger, share);
    });
    return settings.normalize ? distance / largest : distance;
}

template <int N>
Voronoi evaluate(const std::array<float, 4>& at, const VoronoiSettings& settings) {
    Point<N> p;
    for (int i = 0; i < N; ++i)
        p[i] = at[static_cast<std::size_t>(i)];
    Voronoi out;
    if (settings.feature == VoronoiFeature::distance_to_edge) {
        out.distance = edges_of_octaves(p, settings);
    } else if (settings.feature == VoronoiFeature::n_sphere_radius) {
        out.distance = sphere_radius(p, settings.randomness);
    } else {
        const Octave<N> sum = sum_of_octaves(p, settings);
        out.distance = sum.distance;
        out.color = sum.color;
        std::copy(sum.position.x.begin(), sum.position.x.end(), out.position.begin());
    }
    return out;
}

VoronoiSettings in_range(VoronoiSettings s) {
    const auto number = [](float x, float low, float high) { return x > low ? std::min(x, high) : low; };
    s.detail = number(s.detail, 0, 15);
    s.roughness = number(s.roughness, 0, 1);
    s.smoothness = number(s.smoothness, 0, 1);
    s.randomness = number(s.randomness, 0, 1);
    return s;
}

}  // namespace

float voronoi_largest_distance(const VoronoiSettings& settings) {
    const float side = 0.5f + 0.5f * settings.randomness;
    if (settings.feature == VoronoiFeature::distance_to_edge)
        return side;
    const auto corner = [&] {
        switch (settings.dimensions) {
            case 1:
                return side;
            case 2:
                return measure(Point<2>{{side, side}}, settings);
            case 3:
                return measure(Point<3>{{side, side, side}}, settings);
            default:
                return measure(Point<4>{{side, side, side, side}}, settings);
        }
    };
    return corner() * (settings.feature == VoronoiFeature::f2 ? 2 : 1);
}

Voronoi voronoi(const std::array<float, 4>& p, const VoronoiSettings& settings) {
    const VoronoiSettings s = in_range(settings);
    switch (s.dimensions) {
        case 1:
            return evaluate<1>(p, s);
        case 2:
            return evaluate<2>(p, s);
        case 3:
            return evaluate<3>(p, s);
        default:
            return evaluate<4>(p, s);
    }
}

}  // namespace nephele
