// SPDX-License-Identifier: GPL-3.0-or-later
// Where rays meet things, grids, pixels' sums, and shading.
#include "film/film.h"
#include "grids/kd_tree.h"
#include "media_fixtures.h"
#include "scene/pixel_filter.h"
#include "scene/watertight.h"
#include "shading/color_math.h"
#include "shading/image.h"
#include "shading/noise.h"
#include "stability.h"
#include "tracking/candidates.h"

namespace nephele::stability {
namespace {

Exact exact(float x) {
    return static_cast<Exact>(x);
}

// --- Scene
// ------------------------------------------------------------------------------------------------------------

TEST(StabilityScene, Watertight) {
    Worst distance({"scene", "watertight.h", "distance to a triangle",
                    "edge functions cancel where the ray meets an edge",
                    "exact in double after one shear in float",
                    "triangles of 1e-3 to 1e3 m, 1 to 1e4 sizes away, to 85 degrees off",
                    "the distance, over the cosine", 2e-7});
    Worst place({"scene", "watertight.h", "barycentric coordinates of a hit",
                 "a far triangle is sheared with few digits", "what the shear leaves is exact", "the same",
                 "1, per size of distance and over the cosine", 7e-7});
    Rng rng(1);
    int met = 0;
    for (int i = 0; i < 200000; ++i) {
        const float size = std::pow(10.0f, 6 * rng.next() - 3), far = size * std::pow(10.0f, 4 * rng.next());
        const Vec3f o = random_direction(rng) * far, a = random_direction(rng) * size,
                    b = random_direction(rng) * size, c = random_direction(rng) * size;
        const float wa = 0.1f + rng.next(), wb = 0.1f + rng.next(), wc = 0.1f + rng.next();
        const Vec3f d = normalize((a * wa + b * wb + c * wc) / (wa + wb + wc) - o);
        const Exact3 n = cross(Exact3(b) - Exact3(a), Exact3(c) - Exact3(a));
        const Exact cosine = std::fabs(dot(n, Exact3(d))) / length(n);
        if (!(cosine > 0.087L) || length(n) < 0.1L * exact(size) * exact(size))
            continue;
        const auto hit = WatertightRay(o, d).meet(a, b, c);
        if (!hit)
            continue;  // aimed at an inner point; rounding of d over a great distance may still miss
        ++met;
        const Exact t = dot(n, Exact3(a) - Exact3(o)) / dot(n, Exact3(d));
        const Exact3 p = Exact3(o) + Exact3(d) * t - Exact3(a);
        const Exact3 ab = Exact3(b) - Exact3(a), ac = Exact3(c) - Exact3(a);
        const Exact u = dot(cross(p, ac), n) / dot(n, n), v = dot(cross(ab, p), n) / dot(n, n);
        distance.error((exact(hit->t) / t - 1) * cosine, {size, far});
        const Exact unit = exact(far) / exact(size) / cosine;
        place.error((exact(hit->u) - u) / unit, {size, far});
        place.error((exact(hit->v) - v) / unit, {size, far});
    }
    EXPECT_GT(met, 50000);
}

TEST(StabilityScene, RayBox) {
    Worst worst({"media", "medium.h", "where a ray enters and leaves a box",
                 "0 / 0 of a ray in a face's plane; infinite times",
                 "parallel axes are compared, not divided",
                 "boxes of 1e-3 to 1e3 m up to 1e4 m away, directions of 1e-30 along an axis",
                 "the distance from the origin's last place", 2e-7});
    Rng rng(2);
    for (int i = 0; i < 100000; ++i) {
        Region region("r", Region::Kind::box, ~0u);
        const float size = std::pow(10.0f, 6 * rng.next() - 3);
        region.box_min = Vec3f(-size, -size * rng.next(), -size);
        region.box_max = Vec3f(size, size, size * rng.next());
        Vec3f d = random_direction(rng);
        if (i % 4 == 0)
            d[i / 4 % 3] = i % 8 == 0 ? 0.0f : 1e-30f;
        d = normalize(d);
        const Vec3f o = d * (-1e4f * rng.next()) + random_direction(rng) * size;
        const auto got = region.intersect_box({o, d});
        Exact t0 = 0, t1 = std::numeric_limits<Exact>::infinity();
        for (int a = 0; a < 3; ++a) {
            const Exact l = exact(region.box_min[a]) - exact(o[a]),
                        h = exact(region.box_max[a]) - exact(o[a]);
            if (d[a] == 0) {
                t1 = l <= 0 && h >= 0 ? t1 : -1;
                continue;
            }
            t0 = std::fmax(t0, std::fmin(l / exact(d[a]), h / exact(d[a])));
            t1 = std::fmin(t1, std::fmax(l / exact(d[a]), h / exact(d[a])));
        }
        const Exact slack = 1e-3L * exact(size);  // of corners that are met or not by rounding
        if (got && t1 - t0 > slack) {
            worst.error((exact(got->x) - t0) / std::fmax(t0, exact(size)), {size, length(o)});
            worst.error((exact(got->y) - t1) / std::fmax(t1, exact(size)), {size, length(o)});
        }
        if (!got) {
            EXPECT_LT(static_cast<double>(t1 - t0), static_cast<double>(slack + 1e-5L * std::fmax(t0, 1.0L)));
        }
    }
}

TEST(StabilityScene, PixelFilter) {
    Worst worst({"scene", "pixel_filter.cpp", "offset in a pixel filter, inverted",
                 "the root of a quadratic cancels where the density is even",
                 "the stable root over cells of linear density", "widths 0.01 to 10, u from 0 to 1 - 2^-24",
                 "1, of the fraction", 5e-6});
    for (const float width : {0.01f, 1.5f, 10.0f}) {
        for (const auto kind :
             {PixelFilter::Kind::box, PixelFilter::Kind::gaussian, PixelFilter::Kind::blackman_harris}) {
            const PixelFilter filter(kind, width);
            constexpr int kSteps = 1 << 16;
            std::vector<Exact> cumulative{0};
            const double reach = double{filter.reach()};
            for (int i = 0; i < kSteps; ++i) {
                const double x = reach * (2 * (i + 0.5) / kSteps - 1);
                cumulative.push_back(cumulative.back() + exact(filter.density(static_cast<float>(x))) * 2 *
                                                             static_cast<Exact>(reach) / kSteps);
            }
            for (const float u : towards_both_ends(0x1p-24, 200)) {
                const double place = (double{filter.sample({u, 0}).x} / reach + 1) / 2 * kSteps;
                const auto i =
                    std::min(static_cast<std::size_t>(std::max(place, 0.0)), std::size_t{kSteps - 1});
                const Exact f = static_cast<Exact>(place) - static_cast<Exact>(i);
                worst.error(cumulative[i] + f * (cumulative[i + 1] - cumulative[i]) - exact(u), {width, u});
            }
        }
    }
}

// --- Grids
// ------------------------------------------------------------------------------------------------------------

TEST(StabilityGrids, Interpolation) {
    Worst linear({"grids", "brick_grid.h", "trilinear and cubic interpolation",
                  "values of a range that is no float", "linear interpolations, never outside of the voxels",
                  "values 1e-30 to 1e30", "the largest voxel around", 2e-7});
    Rng rng(3);
    for (const float scale : logarithmic(1e-30, 1e30, 7)) {
        std::vector<float> values(8 * 8 * 8);
        for (float& v : values)
            v = rng.next() * scale;
        const auto grid = brick_grid_of_dense({0, 0, 0}, {8, 8, 8}, values.data());
        const auto voxel = [&](int i, int j, int k) {
            return exact(values[static_cast<std::size_t>((i * 8 + j) * 8 + k)]);
        };
        for (int n = 0; n < 3000; ++n) {
            const Vec3f p(1 + 5 * rng.next(), 1 + 5 * rng.next(), 1 + 5 * rng.next());
            const int at[3] = {static_cast<int>(p.x), static_cast<int>(p.y), static_cast<int>(p.z)};
            Exact weights[3][4], tri = 0, cubic = 0;
            for (int a = 0; a < 3; ++a) {
                const Exact f = exact(p[a]) - at[a], g = 1 - f;
                weights[a][0] = g * g * g / 6;
                weights[a][1] = 2.0L / 3 - f * f * (1 - f / 2);
                weights[a][2] = 2.0L / 3 - g * g * (1 - g / 2);
                weights[a][3] = f * f * f / 6;
            }
            for (int c = 0; c < 64; ++c) {
                const int i = c >> 4, j = c >> 2 & 3, k = c & 3;
                const Exact v = voxel(at[0] + i - 1, at[1] + j - 1, at[2] + k - 1);
                cubic += weights[0][i] * weights[1][j] * weights[2][k] * v;
                if (i == 0 || j == 0 || k == 0 || i == 3 || j == 3 || k == 3)
                    continue;
                Exact w = 1;
                for (const auto& [index, axis] : {std::pair{i, 0}, std::pair{j, 1}, std::pair{k, 2}})
                    w *= index == 2 ? exact(p[axis]) - at[axis] : 1 - (exact(p[axis]) - at[axis]);
                tri += w * v;
            }
            linear.scaled(double{grid->trilinear(p)}, tri, exact(scale), {scale});
            linear.scaled(double{grid->tricubic(p)}, cubic, exact(scale), {scale});
        }
    }
}

TEST(StabilityGrids, KdTreeBounds) {
    Worst worst({"grids", "kd_tree.h", "majorants in 20 bits",
                 "rounding to the nearest would make some too low", "majorants rounded up, minorants down",
                 "values 1e-30 to 1e30", "the value, never on the wrong side", 5e-4});
    for (const float value : logarithmic(1e-30, 1e30, 100)) {
        IndexBox box;
        box.include({0, 0, 0});
        box.include({7, 7, 7});
        const CellBounds bounds = CellBounds::of_function(box, Bounds{0, 0}, [&](Vec3f, Vec3f) {
            return Bounds{value, value};
        });
        const KdTree tree(bounds, 1, true);
        const CellBox cell = tree.box_at({0, 0, 0});
        EXPECT_TRUE(cell.majorant >= value && cell.minorant <= value) << value;
        worst.relative(double{cell.majorant}, exact(value), {value});
        worst.relative(double{cell.minorant}, exact(value), {value});
    }
}

TEST(StabilityGrids, Walk) {
    Worst worst({"grids", "majorant_walk.h", "end of a walk through cells",
                 "steps of no length, for ever; gaps between pieces",
                 "cells never step back; pieces end where the next begin",
                 "origins 1 to 1e6 voxels away, directions of 1e-30 along an axis", "the ray's end", 1e-9});
    const test::Field field = test::field_of(40, [](int i, int j, int k) {
        return Rng(static_cast<std::uint64_t>((i * 64 + j) * 64 + k)).next();
    });
    Rng rng(4);
    for (int i = 0; i < 20000; ++i) {
        Vec3f d = random_direction(rng);
        if (i % 3 == 0)
            d[i / 3 % 3] = i % 6 == 0 ? 0.0f : 1e-30f;
        d = normalize(d);
        const float far = std::pow(10.0f, 6 * rng.next());
        const Vec3f o = Vec3f(40 * rng.next(), 40 * rng.next(), 40 * rng.next()) - d * far;
        const float end = far + 100;
        AnyMajorantWalk walk(field.bounds->majorants, o, d, 0, end);
        MajorantPiece piece;
        float last = 0;
        int pieces = 0;
        while (walk.next(piece) && ++pieces < 1000) {
            EXPECT_GT(piece.t_end, last);
            last = piece.t_end;
        }
        EXPECT_LT(pieces, 1000);
        worst.relative(double{last}, exact(end), {far});
    }
}

// --- Film
// -------------------------------------------------------------------------------------------------------------

constexpr PassId kPassesKept[] = {PassId::combined, PassId::variance, PassId::surface};

TEST(StabilityFilm, Sums) {
    Worst mean({"film", "film.cpp", "mean over many samples",
                "single precision stops to grow at 2^24 samples", "sums in double",
                "2^20 samples of 1e-6 to 1e6 each", "the mean", 7e-8});
    Worst variance({"film", "film.cpp", "variance of the mean, by the sum of squares",
                    "E x^2 - (E x)^2 cancels where there is little noise", "in double; not below 0",
                    "the same, spreads of 1e-3 to 1e3 of the mean", "the variance", 2e-6});
    Worst error({"film", "film.cpp", "estimate of the image's relMSE", "relative errors of black pixels",
                 "squares over the squared mean and 0.01, in double", "the same", "the estimate", 2e-6});
    Rng rng(5);
    for (const float light : {1e-6f, 1.0f, 1e6f}) {
        for (const float spread : {1e-3f, 0.1f, 1e3f}) {
            Film film(1, 1, kPassesKept, {true, false});
            std::vector<float> values;
            for (int i = 0; i < 1 << 20; ++i) {
                const float p = 1 / (1 + spread * spread);
                const float x = spread < 1       ? light * (1 + spread * (2 * rng.next() - 1))
                                : rng.next() < p ? light / p
                                                 : 0;
                values.push_back(x);
                PixelSample s;
                s.surface = Rgb(x);
                film.add(0, 0, s, 1);
            }
            Exact sum = 0, squares = 0;
            const auto n = static_cast<Exact>(values.size());
            for (const float v : values)
                sum += exact(v);
            for (const float v : values)
                squares += (exact(v) - sum / n) * (exact(v) - sum / n);
            mean.relative(double{film.read(PassId::combined)[0]}, sum / n, {light, spread});
            variance.relative(double{film.read(PassId::variance)[0]}, squares / n / (n - 1), {light, spread});
            error.relative(film.relative_error(), squares / n / (n - 1) / (sum / n * (sum / n) + 0.01L),
                           {light, spread});
        }
    }
}

TEST(StabilityFilm, Checkpoint) {
    Worst worst({"film", "film.cpp", "a film saved and restored", "counts and sums as floats",
                 "doubles hold both", "counts to 2^32 - 1, weighted samples", "the values", 1e-12});
    Film film(2, 1, kPassesKept, {true, true});
    Rng rng(6);
    for (int i = 0; i < 1000; ++i) {
        PixelSample s;
        s.surface = Rgb(rng.next() * 1e6f);
        film.add(i % 2, 0, s, 1, i % 7 == 0 ? 4000000u : 1u);
    }
    Film other(2, 1, kPassesKept, {true, true});
    other.restore(film.save());
    EXPECT_EQ(other.count(0, 0), film.count(0, 0));
    EXPECT_EQ(other.relative_error(), film.relative_error());
    for (const PassId pass : kPassesKept) {
        for (std::size_t i = 0; i < film.read(pass).size(); ++i)
            worst.relative(double{other.read(pass)[i]}, exact(film.read(pass)[i]));
    }
}

// --- Shading
// ----------------------------------------------------------------------------------------------------------

TEST(StabilityShading, ColorSpaces) {
    Worst worst({"shading", "color_math.cpp", "to HSV or HSL and back",
                 "hue of grey, saturation of black, lightness of HDR colours: x / 0", "0 there",
                 "channels 0 and 1e-30 to 1e30 (HSV), to 1 (HSL)", "the largest channel", 7e-7});
    Rng rng(7);
    for (const float scale : joined({1.0f}, logarithmic(1e-30, 1e30, 60))) {
        for (int i = 0; i < 300; ++i) {
            const Rgb c = Rgb(rng.next(), rng.next(), i % 5 == 0 ? 0.0f : rng.next()) * scale;
            const Rgb hsv = rgb_from_hsv(hsv_from_rgb(c));
            for (int k = 0; k < 3; ++k)
                worst.scaled(double{hsv[k]}, exact(c[k]), exact(scale), {scale});
            if (scale != 1)
                continue;
            const Rgb hsl = rgb_from_hsl(hsl_from_rgb(c));
            for (int k = 0; k < 3; ++k)
                worst.scaled(double{hsl[k]}, exact(c[k]), 1, {scale});
        }
    }
    for (const Rgb c : {Rgb(1.5f, 0.5f, 1), Rgb(-1, 1, 0), Rgb(2, 0, 1), Rgb(0), Rgb(1)})
        EXPECT_TRUE(is_finite(hsl_from_rgb(c)) && is_finite(rgb_from_hsl(hsl_from_rgb(c))));
}

TEST(StabilityShading, Blackbody) {
    Worst worst({"shading", "color_math.cpp", "luminance of a blackbody's colour",
                 "exp - 1 of Planck's law; the fifth power",
                 "expm1 and wavelengths relative to 560 nm, in double; a table",
                 "2500 to 12000 K, where no channel is cut; 0 to infinity finite", "1", 5e-7});
    for (float kelvin = 2500; kelvin <= 12000; kelvin += 7)
        worst.error(exact(luminance(blackbody_color(kelvin))) - 1, {kelvin});
    for (const float kelvin : {0.0f, -1.0f, 799.0f, 1e30f, kInfinity, NAN})
        EXPECT_TRUE(is_finite(blackbody_color(kelvin)) && min_component(blackbody_color(kelvin)) >= 0);
}

TEST(StabilityShading, NoiseFarOut) {
    Worst worst({"shading", "noise.cpp", "gradient noise far from the origin",
                 "fractions of large coordinates are coarse; integers overflow",
                 "coordinates modulo 100000, Blender's period, exactly",
                 "coordinates up to 1e30, on the lattice of 1/64 where floats hold it", "1", 1e-9});
    Rng rng(8);
    for (int i = 0; i < 20000; ++i) {
        const auto at = [&] { return static_cast<float>(rng.next_uint() % 64000) / 64; };
        const Vec3f p(at(), at(), at());
        const float n = perlin(p);
        EXPECT_LE(std::fabs(n), 1.1f);
        worst.error(exact(perlin(p + Vec3f(100000, 100000, 0))) - exact(n), {p.x, p.y, p.z});
        EXPECT_TRUE(std::fabs(perlin(p * 1e25f)) <= 1.1f);
    }
    EXPECT_TRUE(std::isfinite(perlin(Vec3f(kInfinity, NAN, -kInfinity))));
}

TEST(StabilityShading, ImageFarOut) {
    Worst worst({"shading", "image.cpp", "repeated image far from the origin",
                 "texel numbers beyond integers", "whole tiles are taken away first",
                 "u, v from -8190 to 8190 on the lattice of 1/1024", "the largest texel", 1e-9});
    Image image;
    image.width = image.height = 8;
    std::vector<float> texels;
    Rng rng(9);
    for (int i = 0; i < 8 * 8 * 4; ++i)
        texels.push_back(rng.next());
    image.floats = Buffer<float>(texels);
    for (int i = 0; i < 20000; ++i) {
        const float u = static_cast<float>(rng.next_uint() % 1024) / 1024,
                    v = static_cast<float>(rng.next_uint() % 1024) / 1024;
        const float far = 2 * static_cast<float>(static_cast<int>(rng.next_uint() % 8190) - 4095);
        for (const auto extension : {Image::Extension::repeat, Image::Extension::mirror}) {
            const Rgb near = image.sample({u, v}, Image::Filter::linear, extension).rgb,
                      there = image.sample({u + far, v - far}, Image::Filter::linear, extension).rgb;
            worst.error(length(Exact3(near) - Exact3(there)), {u, v, far});
        }
    }
    EXPECT_TRUE(
        is_finite(image.sample({1e38f, -1e38f}, Image::Filter::linear, Image::Extension::repeat).rgb));
}

}  // namespace
}  // namespace nephele::stability
