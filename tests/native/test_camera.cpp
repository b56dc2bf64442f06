// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/camera.h"

#include <gtest/gtest.h>

#include <complex>
#include <stdexcept>
#include <string>

#include "math/sampler.h"

namespace nephele::test {
namespace {

constexpr Vec2f kFilm{64, 48};

CameraDescription wide(CameraDescription::Kind kind = CameraDescription::Kind::perspective) {
    CameraDescription d;
    d.name = "Shot";
    d.kind = kind;
    d.left = -0.6;
    d.right = 0.6;
    d.bottom = -0.45;
    d.top = 0.45;
    // Turned a quarter about x and moved: it looks along +y, z up.
    const double m[16] = {1, 0, 0, 3, 0, 0, -1, -5, 0, 1, 0, 2, 0, 0, 0, 1};
    std::copy(m, m + 16, d.world_from_camera);
    return d;
}

TEST(Camera, FilmCornersAndCentre) {
    const Camera camera(wide());
    const Ray centre = camera.generate({32, 24}, {0.5f, 0.5f}, kFilm);
    EXPECT_LT(length(centre.d - Vec3f(0, 1, 0)), 1e-6f);
    EXPECT_EQ(centre.o, Vec3f(3, -5, 2));
    EXPECT_LT(length(camera.forward() - Vec3f(0, 1, 0)), 1e-6f);
    const Ray bottom_left = camera.generate({0, 0}, {0.5f, 0.5f}, kFilm);
    EXPECT_LT(length(bottom_left.d - normalize(Vec3f(-0.6f, 1, -0.45f))), 1e-6f);
    const Ray top_right = camera.generate({64, 48}, {0.5f, 0.5f}, kFilm);
    EXPECT_LT(length(top_right.d - normalize(Vec3f(0.6f, 1, 0.45f))), 1e-6f);
}

TEST(Camera, OrthographicRaysAreParallel) {
    const Camera camera(wide(CameraDescription::Kind::orthographic));
    const Ray ray = camera.generate({64, 0}, {0.5f, 0.5f}, kFilm);
    EXPECT_LT(length(ray.d - Vec3f(0, 1, 0)), 1e-6f);
    EXPECT_LT(length(ray.o - Vec3f(3.6f, -5, 1.55f)), 1e-6f);
}

TEST(Camera, ClippingIsMeasuredAlongTheViewAxis) {
    for (const auto kind : {CameraDescription::Kind::perspective, CameraDescription::Kind::orthographic}) {
        for (const float aperture : {0.0f, 0.2f}) {
            CameraDescription d = wide(kind);
            d.clip_start = 0.1f;
            d.clip_end = 100;
            d.aperture_radius = aperture;
            d.focus_distance = 4;
            const Camera camera(d);
            for (const Vec2f film : {Vec2f{0, 0}, Vec2f{32, 24}, Vec2f{60, 3}}) {
                const Ray ray = camera.generate(film, {0.9f, 0.2f}, kFilm);
                EXPECT_NEAR(length(ray.d), 1, 1e-6);
                EXPECT_NEAR(camera.to_camera(ray.at(ray.t_min)).z, 0.1, 1e-5);
                EXPECT_NEAR(camera.to_camera(ray.at(ray.t_max)).z, 100, 1e-3);
            }
        }
    }
    EXPECT_EQ(Camera(wide()).generate({0, 0}, {0.5f, 0.5f}, kFilm).t_max, kInfinity);
}

TEST(Camera, EveryLensPointFocusesOnTheSamePlane) {
    for (const auto kind : {CameraDescription::Kind::perspective, CameraDescription::Kind::orthographic}) {
        CameraDescription d = wide(kind);
        d.focus_distance = 7;
        const Vec2f film{50, 10};
        const Ray pinhole = Camera(d).generate(film, {0.5f, 0.5f}, kFilm);
        d.aperture_radius = 0.5f;
        const Camera camera(d);
        const auto at_depth = [&](const Ray& r, float z) { return r.at(z / dot(r.d, camera.forward())); };
        const Vec3f focus = at_depth(pinhole, 7);
        Rng rng(1);
        for (int i = 0; i < 100; ++i) {
            const Ray ray = camera.generate(film, rng.next2(), kFilm);
            EXPECT_LT(length(at_depth(ray, 7) - focus), 2e-5f);
            EXPECT_LE(length(ray.o - pinhole.o), 0.5f + 1e-6f);
        }
    }
}

TEST(Camera, ProjectUndoesGenerate) {
    Rng rng(2);
    for (const auto kind : {CameraDescription::Kind::perspective, CameraDescription::Kind::orthographic}) {
        const Camera camera(wide(kind));
        for (int i = 0; i < 100; ++i) {
            const Vec2f film{64 * rng.next(), 48 * rng.next()};
            const Ray ray = camera.generate(film, {0.5f, 0.5f}, kFilm);
            const Vec2f back = camera.project(ray.at(0.1f + 50 * rng.next()), kFilm);
            EXPECT_NEAR(back.x, film.x, 2e-3);
            EXPECT_NEAR(back.y, film.y, 2e-3);
        }
    }
}

TEST(Camera, ScaleOfTheObjectChangesNothing) {
    CameraDescription d = wide();
    const Ray plain = Camera(d).generate({5, 40}, {0.5f, 0.5f}, kFilm);
    for (int r = 0; r < 3; ++r) {
        d.world_from_camera[4 * r] *= 2;
        d.world_from_camera[4 * r + 1] *= 3;
        d.world_from_camera[4 * r + 2] *= 0.1;
    }
    const Ray scaled = Camera(d).generate({5, 40}, {0.5f, 0.5f}, kFilm);
    EXPECT_LT(length(scaled.d - plain.d), 1e-6f);
    EXPECT_EQ(scaled.o, plain.o);
}

// --- The lens
// --------------------------------------------------------------------------------------------------

struct LensMoments {
    double xx = 0, yy = 0;
    std::complex<double> mean, cubed;
    double reach_x = 0, reach_y = 0;
};
/// Moments of the lens of radius 1 seen along the view axis, x right, y up.
LensMoments moments_of(int blades, double rotation, double ratio) {
    CameraDescription d;
    d.aperture_radius = 1;
    d.blades = blades;
    d.blades_rotation = static_cast<float>(rotation);
    d.aperture_ratio = static_cast<float>(ratio);
    const Camera camera(d);
    LensMoments m;
    constexpr int kGrid = 400;
    for (int i = 0; i < kGrid; ++i) {
        for (int j = 0; j < kGrid; ++j) {
            constexpr float h = 1.0f / kGrid;
            const Vec3f o =
                camera
                    .generate({0, 0},
                              {(static_cast<float>(i) + 0.5f) * h, (static_cast<float>(j) + 0.5f) * h},
                              {1, 1})
                    .o;
            const std::complex<double> z(o.x, o.y);
            m.xx += double{o.x} * o.x / (kGrid * kGrid);
            m.yy += double{o.y} * o.y / (kGrid * kGrid);
            m.mean += z / double{kGrid * kGrid};
            m.cubed += z * z * z / double{kGrid * kGrid};
            m.reach_x = std::max(m.reach_x, std::fabs(double{o.x}));
            m.reach_y = std::max(m.reach_y, std::fabs(double{o.y}));
        }
    }
    return m;
}

// Recorded with bpy 5.0.1: a square emitter 1 m wide, 10 m in front of a perspective camera of focal length
// 36 mm and sensor 36 mm, focused at 1 m, aperture radius 0.3 m, 64 x 64 pixels, 512 samples. At the focal
// plane the emitter's image is the lens scaled by 0.9, smeared by the emitter's own 0.1 m (0.1^2/12 = 0.00083
// of variance in x and y; the third moment is not changed by it). xx, yy and the third moment <(x + iy)^3> in
// m^2 and m^3, image x right, y up.
struct CyclesLens {
    int blades;
    double degrees, ratio, xx, yy, cubed_real, cubed_imaginary;
};
TEST(Camera, LensHasTheShapeOfCycles) {
    for (const CyclesLens& c :
         {CyclesLens{0, 0, 1, 0.0190976, 0.0190148, 0, 0}, CyclesLens{0, 0, 2, 0.0053865, 0.0190992, 0, 0},
          CyclesLens{3, 0, 1, 0.0099952, 0.0099186, -0.0019662, 0},
          CyclesLens{3, 20, 1, 0.0100255, 0.0100154, -0.0009879, -0.0017385},
          CyclesLens{3, 0, 2, 0.0031178, 0.0099448, -0.0007918, 0},
          CyclesLens{5, 5.7296, 1, 0.0148151, 0.0148586, 0, 0}}) {
        const LensMoments m = moments_of(c.blades, c.degrees * 3.14159265358979 / 180, c.ratio);
        const double scale = 0.27, smear = 0.01 / 12;
        // The tolerance covers Cycles' 512 samples a pixel, and the pixels' own width (1/64^2/12 = 0.00002).
        EXPECT_NEAR(m.xx * scale * scale + smear, c.xx, 0.02 * c.xx) << c.blades << ' ' << c.ratio;
        EXPECT_NEAR(m.yy * scale * scale + smear, c.yy, 0.02 * c.yy) << c.blades << ' ' << c.ratio;
        EXPECT_NEAR(m.cubed.real() * std::pow(scale, 3), c.cubed_real, 8e-5) << c.blades << ' ' << c.ratio;
        EXPECT_NEAR(m.cubed.imag() * std::pow(scale, 3), c.cubed_imaginary, 8e-5)
            << c.blades << ' ' << c.ratio;
    }
}

TEST(Camera, LensIsUniformAndWithinItsOutline) {
    EXPECT_NEAR(moments_of(0, 0, 1).xx, 0.25, 1e-3);  // uniform disc of radius 1: r^2/4 along either axis
    EXPECT_LE(moments_of(0, 0, 1).reach_x, 1 + 1e-6);
    for (const int blades : {3, 4, 5, 6, 9, 16}) {
        const LensMoments m = moments_of(blades, 0, 1);
        // Uniform regular polygon of circumradius 1: (2 + cos(2 pi / n)) / 12 along either axis.
        EXPECT_NEAR(m.xx, (2 + std::cos(2 * 3.14159265358979 / blades)) / 12, 2e-3) << blades;
        EXPECT_NEAR(m.yy, m.xx, 2e-3) << blades;
        EXPECT_LT(std::abs(m.mean), 2e-3) << blades;
        EXPECT_LE(m.reach_x, 1 + 1e-6) << blades;
    }
    const LensMoments narrow = moments_of(0, 0, 2);
    EXPECT_NEAR(narrow.reach_x, 0.5, 5e-3);
    EXPECT_NEAR(narrow.reach_y, 1, 5e-3);
}

TEST(Camera, FaultsNameTheCamera) {
    const auto fault_of = [](void (*spoil)(CameraDescription&)) -> std::string {
        CameraDescription d = wide();
        spoil(d);
        try {
            const Camera camera(d);
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return "accepted";
    };
    for (const auto spoil :
         {+[](CameraDescription& d) { d.right = d.left; },
          +[](CameraDescription& d) { d.clip_end = d.clip_start; },
          +[](CameraDescription& d) { d.blades = 2; }, +[](CameraDescription& d) { d.aperture_ratio = 0; },
          +[](CameraDescription& d) { d.aperture_radius = 1, d.focus_distance = 0; },
          +[](CameraDescription& d) { d.world_from_camera[0] = 0; }}) {
        EXPECT_NE(fault_of(spoil).find("'Shot'"), std::string::npos) << fault_of(spoil);
    }
}

}  // namespace
}  // namespace nephele::test
