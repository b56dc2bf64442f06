// SPDX-License-Identifier: GPL-3.0-or-later
// Noise against values recorded from Cycles; the other textures and image filtering against their
// definitions.
#include <gtest/gtest.h>

#include <vector>

#include "math/sampler.h"
#include "math/warp.h"
#include "shading/color_math.h"
#include "shading/image.h"
#include "shading/noise.h"
#include "shading/textures.h"

namespace nephele {
namespace {

/// Noise Texture of Cycles 5.0 (Blender's bpy 5.0.1), type fBM, Color output: an emissive plane under an
/// orthographic camera, one sample a pixel, the pixels' positions rendered the same way. A constant of 10 was
/// added in the nodes and taken away afterwards, which leaves about 1e-6 of rounding.
struct CyclesNoise {
    int dimensions;
    bool normalize;
    float detail, roughness, lacunarity, distortion, scale;
    Vec3f p;
    Rgb color;
};
const CyclesNoise kCyclesNoise[] = {
#include "cycles_noise.inc"
};

TEST(Noise, AgreesWithCycles) {
    for (const CyclesNoise& row : kCyclesNoise) {
        const NoiseSettings settings{row.detail,     row.roughness, row.lacunarity,
                                     row.distortion, row.normalize, row.dimensions};
        const Rgb color = noise_color(row.p * row.scale, settings);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(color[c], row.color[c], 3e-5f)
                << row.dimensions << "D, detail " << row.detail << ", channel " << c;
        }
        EXPECT_EQ(noise_value(row.p * row.scale, settings), color.x);
    }
}

TEST(Noise, IsZeroAtLatticePointsAndBounded) {
    EXPECT_EQ(perlin(3.0f), 0);
    EXPECT_EQ(perlin(3.0f, -2.0f), 0);
    EXPECT_EQ(perlin(Vec3f(3, -2, 5)), 0);
    Rng rng(1);
    float largest = 0;
    for (int i = 0; i < 100000; ++i) {
        const Vec3f p(50 * rng.next() - 25, 50 * rng.next() - 25, 50 * rng.next() - 25);
        largest =
            std::max({largest, std::fabs(perlin(p)), std::fabs(perlin(p.x, p.y)), std::fabs(perlin(p.x))});
    }
    EXPECT_GT(largest, 0.7f);
    EXPECT_LE(largest, 1.1f);
}

TEST(Noise, SurvivesExtremeInput) {
    const NoiseSettings settings{15, 1, 10, 5, true, 3};
    for (const float x : {0.0f, 1e6f, -1e30f, INFINITY, -INFINITY, NAN}) {
        EXPECT_TRUE(is_finite(noise_color(Vec3f(x, 1, -x), {2, 0.5f, 2, 0, true, 3}))) << x;
        EXPECT_TRUE(std::isfinite(perlin(x)) && std::isfinite(perlin(x, x)) &&
                    std::isfinite(perlin(Vec3f(x))));
    }
    EXPECT_TRUE(is_finite(noise_color(Vec3f(1e6f, 2, 3), settings)));
}

TEST(Textures, CheckerChangesAtEveryCell) {
    EXPECT_FALSE(checker_is_odd({0.5f, 0.5f, 0.5f}));
    EXPECT_TRUE(checker_is_odd({1.5f, 0.5f, 0.5f}));
    EXPECT_TRUE(checker_is_odd({-0.5f, 0.5f, 0.5f}));
    EXPECT_FALSE(checker_is_odd({1.5f, 1.5f, 0.5f}));
    EXPECT_TRUE(checker_is_odd({1.5f, 1.5f, 1.5f}));
    EXPECT_FALSE(checker_is_odd({0.5f, 0.5f, 0}));  // a plane at z = 0 does not flicker
    EXPECT_EQ(checker_is_odd({0.5f, 0.5f, -1e-9f}), checker_is_odd({0.5f, 0.5f, 1e-9f}));
}

TEST(Textures, Gradients) {
    const Vec3f p(0.5f, 0.25f, 0);
    EXPECT_FLOAT_EQ(gradient_value(Gradient::linear, p), 0.5f);
    EXPECT_FLOAT_EQ(gradient_value(Gradient::quadratic, p), 0.25f);
    EXPECT_FLOAT_EQ(gradient_value(Gradient::easing, {0.25f, 0, 0}), 0.15625f);
    EXPECT_FLOAT_EQ(gradient_value(Gradient::diagonal, p), 0.375f);
    EXPECT_NEAR(gradient_value(Gradient::spherical, {0.6f, 0, 0.8f}), 0, 1e-5);
    EXPECT_NEAR(gradient_value(Gradient::spherical, {0, 0.25f, 0}), 0.75f, 1e-5);
    EXPECT_NEAR(gradient_value(Gradient::quadratic_sphere, {0, 0.5f, 0}), 0.25f, 1e-5);
    EXPECT_FLOAT_EQ(gradient_value(Gradient::radial, {1, 0, 0}), 0.5f);
    EXPECT_FLOAT_EQ(gradient_value(Gradient::radial, {0, 1, 0}), 0.75f);
    EXPECT_EQ(gradient_value(Gradient::linear, {-3, 0, 0}), 0);
    EXPECT_EQ(gradient_value(Gradient::linear, {3, 0, 0}), 1);
}

TEST(Textures, TablesInterpolateAndHoldTheirEnds) {
    const std::vector<float> table = {0, 1, 4};
    EXPECT_FLOAT_EQ(table_scalar(table, 0.25f), 0.5f);
    EXPECT_FLOAT_EQ(table_scalar(table, 0.75f), 2.5f);
    EXPECT_EQ(table_scalar(table, 1), 4);
    EXPECT_EQ(table_scalar(table, 9), 4);
    EXPECT_EQ(table_scalar(table, -9), 0);
    EXPECT_EQ(table_scalar(table, NAN), 0);
}

TEST(Textures, MirrorBallSeesForwardAtItsRimAndBackAtItsCentre) {
    const Vec2f back = mirror_ball_from_direction({0, -1, 0});
    EXPECT_NEAR(back.x, 0.5f, 1e-6);
    EXPECT_NEAR(back.y, 0.5f, 1e-6);
    const Vec2f up = mirror_ball_from_direction({0, 0, 1});
    EXPECT_NEAR(up.x, 0.5f, 1e-6);
    EXPECT_NEAR(up.y, 0.5f + 0.5f * 0.70710678f, 1e-6);
}

Image bytes(int width, int height, std::vector<std::uint8_t> values, bool srgb) {
    Image image;
    image.width = width;
    image.height = height;
    image.bytes = Buffer(std::move(values));
    image.srgb = srgb;
    return image;
}

TEST(Images, DecodeBytes) {
    const std::vector<std::uint8_t> values = {0, 128, 255, 51};
    const Image::Texel linear = bytes(1, 1, values, false).texel(0, 0),
                       srgb = bytes(1, 1, values, true).texel(0, 0);
    EXPECT_NEAR(linear.rgb.y, 128.0f / 255, 1e-6);
    EXPECT_NEAR(srgb.rgb.y, 0.2158605f, 1e-6);  // IEC 61966-2-1
    EXPECT_EQ(srgb.rgb.x, 0);
    EXPECT_EQ(srgb.rgb.z, 1);
    EXPECT_NEAR(srgb.alpha, 0.2f, 1e-6);  // alpha is never encoded
}

TEST(Images, FilterBilinearlyWithRowsFromTheBottom) {
    const Image image = bytes(2, 2, {0, 0, 0, 255, 255, 0, 0, 255, 0, 255, 0, 255, 255, 255, 0, 255}, false);
    const auto at = [&](float u, float v) {
        return image.sample({u, v}, Image::Filter::linear, Image::Extension::extend).rgb;
    };
    EXPECT_NEAR(at(0.5f, 0.5f).x, 0.5f, 1e-6);
    EXPECT_NEAR(at(0.25f, 0.25f).y, 0, 1e-6);
    EXPECT_NEAR(at(0.25f, 0.75f).y, 1, 1e-6);
    EXPECT_NEAR(at(0.375f, 0.25f).x, 0.25f, 1e-6);
    EXPECT_NEAR(at(-3, 0.25f).x, 0, 1e-6);
    const auto repeated = [&](float u) {
        return image.sample({u, 0.25f}, Image::Filter::linear, Image::Extension::repeat).rgb.x;
    };
    EXPECT_NEAR(repeated(0), 0.5f, 1e-6);  // halfway between the last texel and the first
    EXPECT_NEAR(repeated(-0.25f), 1, 1e-6);
    EXPECT_NEAR(repeated(1e7f), 0.5f, 1e-6);
}

TEST(Images, SurviveExtremeCoordinates) {
    const Image image = bytes(2, 2, std::vector<std::uint8_t>(16, 255), true);
    for (const float u : {1e30f, -1e30f, INFINITY, NAN, 1.0f, -0.0f, 1.0000001f, 0.99999994f, -1e-10f}) {
        for (int e = 0; e < 4; ++e) {
            for (int f = 0; f < 3; ++f) {
                const Image::Texel t =
                    image.sample({u, u}, static_cast<Image::Filter>(f), static_cast<Image::Extension>(e));
                EXPECT_TRUE(length(t.rgb - Rgb(1)) < 1e-6f || t.rgb == Rgb(0)) << u << " extension " << e;
            }
        }
    }
    EXPECT_EQ(image.sample({0.5f, 1.5f}, Image::Filter::closest, Image::Extension::clip).alpha, 0);
}

TEST(Colors, ConversionsInvertEachOther) {
    Rng rng(2);
    for (int i = 0; i < 1000; ++i) {
        const float r = rng.next(), g = rng.next();
        const Rgb c(r, g, rng.next());
        const Rgb via_hsv = rgb_from_hsv(hsv_from_rgb(c)), via_hsl = rgb_from_hsl(hsl_from_rgb(c));
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(via_hsv[k], c[k], 2e-6f);
            EXPECT_NEAR(via_hsl[k], c[k], 2e-6f);
        }
    }
}

TEST(Environment, MapInvertsItsDirection) {
    Rng rng(3);
    for (int i = 0; i < 1000; ++i) {
        const Vec3f d = sample_sphere(rng.next2());
        EXPECT_LT(length(direction_from_equirectangular(equirectangular_from_direction(d)) - d), 1e-3f);
    }
}

}  // namespace
}  // namespace nephele
