// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/panorama.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/camera.h"

using namespace nephele;

namespace {

using Lens = Panorama::Lens;
constexpr double kTurn = 2 * double{kPi};

Panorama panorama(Lens lens, std::initializer_list<double> values = {}) {
    Panorama out;
    out.lens = lens;
    std::copy(values.begin(), values.end(), out.values.begin());
    return out;
}

void expect_direction(const Panorama& p, double x, double y, Vec3f expected) {
    const auto d = p.direction(x, y);
    ASSERT_TRUE(d);
    EXPECT_NEAR(length(*d - normalize(expected)), 0, 1e-6) << x << ' ' << y;
}

TEST(Panorama, ShowsWhatIsAheadInTheMiddleAndRightOnTheRight) {
    const Panorama lenses[] = {
        panorama(Lens::equirectangular, {-kTurn / 2, kTurn / 2, -kTurn / 4, kTurn / 4}),
        panorama(Lens::fisheye_equidistant, {kTurn / 2}),
        panorama(Lens::fisheye_equisolid, {kTurn / 2, 15, 36, 36}),
        panorama(Lens::fisheye_polynomial, {kTurn / 2, 36, 36, 0, -0.05}),
        panorama(Lens::mirror_ball),
        panorama(Lens::equiangular_cubemap),
        panorama(Lens::central_cylindrical, {-1, 1, -1, 1, 1}),
    };
    for (const Panorama& p : lenses) {
        expect_direction(p, 0.5, 0.5, {0, 0, -1});
        EXPECT_GT(p.direction(0.6, 0.5)->x, 0.1f);
        EXPECT_NEAR(p.direction(0.6, 0.5)->y, 0, 1e-6);
        EXPECT_GT(p.direction(0.5, 0.6)->y, 0.05f);
    }
}

TEST(Panorama, EquirectangularFollowsItsRanges) {
    const Panorama p = panorama(Lens::equirectangular, {-1, 2, -0.5, 1});
    expect_direction(p, 0, 0.5,
                     {-std::sin(1.0f) * std::cos(0.25f), std::sin(0.25f), -std::cos(1.0f) * std::cos(0.25f)});
    expect_direction(p, 1, 1,
                     {std::sin(2.0f) * std::cos(1.0f), std::sin(1.0f), -std::cos(2.0f) * std::cos(1.0f)});
}

TEST(Panorama, EquidistantAnglesGrowWithTheDistance) {
    const double fov = 3.5;
    const Panorama p = panorama(Lens::fisheye_equidistant, {fov});
    for (const double share : {0.1, 0.5, 0.9}) {
        const auto d = p.direction(0.5 + 0.5 * share * 0.6, 0.5 + 0.5 * share * 0.8);
        EXPECT_NEAR(std::acos(double{-d->z}), 0.5 * fov * share, 1e-5);
        EXPECT_NEAR(d->y / d->x, 0.8 / 0.6, 1e-5);
    }
    EXPECT_FALSE(p.direction(0.999, 0.999));
}

TEST(Panorama, EquisolidKeepsAreas) {
    const double f = 12;
    const Panorama p = panorama(Lens::fisheye_equisolid, {3, f, 36, 24});
    // The solid angle within the angle of a point at the distance r from the middle is pi (r / f)^2.
    for (const double r : {1.0, 5.0, 11.0}) {
        const double solid_angle = 0.5 * kTurn * r * r / (f * f);
        EXPECT_NEAR(kTurn * (1 + double{p.direction(0.5 + r / 36, 0.5)->z}), solid_angle,
                    1e-5 * solid_angle + 1e-5);
        EXPECT_NEAR(kTurn * (1 + double{p.direction(0.5, 0.5 + r / 24)->z}), solid_angle,
                    1e-5 * solid_angle + 1e-5);
    }
    EXPECT_FALSE(p.direction(1, 1));
}

TEST(Panorama, CubeMapFaceReachesItsEdgesAt45Degrees) {
    const Panorama p = panorama(Lens::equiangular_cubemap);
    expect_direction(p, 1, 0.5, {1, 0, -1});
    expect_direction(p, 0, 1, {-1, 1, -1});
}

TEST(Panorama, MirrorBallShowsAllRoundOnItsEdge) {
    const Panorama p = panorama(Lens::mirror_ball);
    expect_direction(p, 0.999999, 0.5, {0.004f, 0, 1});
    EXPECT_FALSE(p.direction(0.9, 0.9));
}

TEST(Camera, PanoramicRaysClipByDistanceAndFocusOnASphere) {
    CameraDescription d;
    d.kind = CameraDescription::Kind::panoramic;
    d.left = d.bottom = 0;
    d.panorama = panorama(Lens::fisheye_equidistant, {3});
    d.clip_start = 0.5f;
    d.clip_end = 20;
    d.aperture_radius = 0.2f;
    d.focus_distance = 4;
    const Camera camera(d);
    const Vec2f film{64, 64}, where{50, 40};
    const Vec3f middle = camera.generate(where, {0, 0}, film).at(4);
    for (const Vec2f lens : {Vec2f{0.1f, 0.9f}, Vec2f{0.7f, 0.3f}}) {
        const Ray ray = camera.generate(where, lens, film);
        EXPECT_EQ(ray.t_min, 0.5f);
        EXPECT_EQ(ray.t_max, 20);
        EXPECT_LE(length(ray.o), 0.2001f);
        const Vec3f focus = *d.panorama.direction(50.0 / 64, 40.0 / 64) * 4.0f;
        EXPECT_NEAR(length(cross(focus - ray.o, ray.d)), 0, 1e-5) << "all pass through one point";
        EXPECT_NEAR(length(middle), 4, 0.05);
    }
    EXPECT_NEAR(camera.depth({3, 0, 4}), 5, 1e-6);
    const Ray none = camera.generate({1, 1}, {0.5f, 0.5f}, film);
    EXPECT_LT(none.t_max, none.t_min);
}

TEST(Camera, RefusesAPanoramaOfNoNumbers) {
    CameraDescription d;
    d.name = "Eye";
    d.kind = CameraDescription::Kind::panoramic;
    d.panorama = panorama(Lens::fisheye_equidistant, {std::nan("")});
    EXPECT_THROW(Camera{d}, std::invalid_argument);
}

}  // namespace
