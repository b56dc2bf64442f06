// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/camera.h"

#include <algorithm>
#include <stdexcept>

#include "math/warp.h"

namespace nephele {

namespace {

/// Rotation and translation of a camera's matrix: as in Blender, a scale or mirroring of its object changes
/// nothing but the axes' directions.
Transform without_scale(const CameraDescription& camera) {
    Transform m = transform_of(camera.world_from_camera);
    for (int c = 0; c < 3; ++c) {
        const float scale = length(m.column(c));
        if (!(scale > 0) || !std::isfinite(scale)) {
            throw std::invalid_argument("camera '" + camera.name +
                                        "': its transform is singular; give it a scale of 1");
        }
        for (std::size_t r = 0; r < 3; ++r)
            m.row[r][c] /= scale;
    }
    return m;
}
Motion motion_without_scale(const CameraDescription& camera) {
    if (camera.motion.empty())
        return {};
    std::vector<std::array<double, 16>> matrices = camera.motion;
    for (auto& m : matrices) {
        for (std::size_t c = 0; c < 3; ++c) {
            const double scale = std::hypot(m[c], m[4 + c], m[8 + c]);
            for (std::size_t r = 0; r < 3; ++r)
                m[4 * r + c] /= scale;
        }
    }
    try {
        return Motion(matrices);
    } catch (const std::invalid_argument& e) {
        throw std::invalid_argument("camera '" + camera.name + "': " + e.what());
    }
}

void check(const CameraDescription& camera) {
    const auto reject = [&](const char* fault) {
        throw std::invalid_argument("camera '" + camera.name + "': " + fault);
    };
    for (const double m : camera.world_from_camera) {
        if (!std::isfinite(m))
            reject("its transform is not finite; check its location and rotation");
    }
    const double frame[] = {camera.left, camera.right, camera.bottom, camera.top};
    if (!std::all_of(std::begin(frame), std::end(frame), [](double x) { return std::isfinite(x); }))
        reject("its frame is not finite; check its lens and shift");
    if (!std::isfinite(camera.aperture_radius) || !std::isfinite(camera.blades_rotation))
        reject("its aperture is not finite; check its depth of field");
    if (!(camera.right > camera.left && camera.top > camera.bottom))
        reject("its frame has no area");
    if (!(camera.clip_start >= 0 && camera.clip_end > camera.clip_start))
        reject("its clipping range is empty");
    if (!(camera.aperture_radius >= 0))
        reject("its aperture radius must be 0 m or more");
    if (!(camera.aperture_ratio > 0))
        reject("its aperture ratio must be above 0");
    if (camera.blades != 0 && camera.blades < 3)
        reject("its aperture must have 0 blades, or 3 or more");
    if (camera.kind == CameraDescription::Kind::panoramic && !camera.panorama.finite())
        reject("its lens is not finite; check its panorama's values");
    if (camera.aperture_radius > 0 && !(camera.focus_distance > 0))
        reject("its focus distance must be above 0 m");
}

}  // namespace

Camera::Camera(const CameraDescription& d)
    : kind_(d.kind),
      world_from_camera_(without_scale(d)),
      motion_(motion_without_scale(d)),
      neighbours_(d.neighbours),
      panorama_(d.panorama),
      left_(d.left),
      right_(d.right),
      bottom_(d.bottom),
      top_(d.top),
      clip_start_(d.clip_start),
      clip_end_(d.clip_end),
      aperture_radius_(d.aperture_radius),
      blades_rotation_(d.blades_rotation),
      inverse_aperture_ratio_(1 / d.aperture_ratio),
      focus_distance_(d.focus_distance),
      blades_(d.blades) {
    check(d);
}

/// Point on the lens, m. A polygon's corners lie on the circle; unturned, the middle of a side faces +x.
Vec2f Camera::sample_lens(Vec2f u) const {
    Vec2f q;
    if (blades_ == 0) {
        q = sample_disc(u);
    } else {
        // One of the triangles between the centre and a side, then a point in it uniformly.
        const float scaled = u.x * static_cast<float>(blades_);
        const float blade = std::min(std::floor(scaled), static_cast<float>(blades_ - 1));
        const float outwards = std::sqrt(std::min(scaled - blade, 1.0f)), along = 2 * u.y - 1;
        const float half = kPi / static_cast<float>(blades_);
        const float x = outwards * std::cos(half), y = outwards * along * std::sin(half);
        const float turn = blades_rotation_ + 2 * half * blade, c = std::cos(turn), s = std::sin(turn);
        q = {c * x - s * y, s * x + c * y};
    }
    return {aperture_radius_ * inverse_aperture_ratio_ * q.x, aperture_radius_ * q.y};
}

Ray Camera::generate(Vec2f film_position, Vec2f lens_u, Vec2f film_size, float time) const {
    const double film_x = left_ + (right_ - left_) * (double{film_position.x} / double{film_size.x});
    const double film_y = bottom_ + (top_ - bottom_) * (double{film_position.y} / double{film_size.y});
    if (kind_ == CameraDescription::Kind::panoramic)
        return placed(panoramic_ray(film_x, film_y, lens_u), time);
    const auto x = static_cast<float>(film_x), y = static_cast<float>(film_y);
    Vec3f o = perspective() ? Vec3f(0) : Vec3f(x, y, 0);
    Vec3f d = perspective() ? Vec3f(x, y, -1) : Vec3f(0, 0, -1);
    if (aperture_radius_ > 0) {
        // Every point of the lens sends the pixel's rays to the same point in the plane of focus.
        const Vec2f lens = sample_lens(lens_u);
        const Vec3f on_lens(lens.x, lens.y, 0);
        d = d * focus_distance_ - on_lens;
        o += on_lens;
    }
    d = normalize(d);
    const float per_depth = -1 / d.z;
    return placed({o, d, clip_start_ * per_depth, clip_end_ * per_depth}, time);
}

/// A ray of the camera's space, in the world at a time.
Ray Camera::placed(const Ray& ray, float time) const {
    Ray out = ray;
    out.time = time;
    const auto place = [&](const Transform& world_from_camera) {
        out.o = world_from_camera.point(ray.o);
        out.d = normalize(world_from_camera.vector(ray.d));
    };
    if (motion_.moves())
        place(motion_.at(time));
    else
        place(world_from_camera_);
    return out;
}

/// In the camera's space. The lens faces each direction.
Ray Camera::panoramic_ray(double x, double y, Vec2f lens_u) const {
    const auto seen = panorama_.direction(x, y);
    if (!seen)
        return {Vec3f(0), Vec3f(0, 0, -1), 1, 0};
    Vec3f o(0), d = *seen;
    if (aperture_radius_ > 0) {
        const Vec2f lens = sample_lens(lens_u);
        const Vec3f right =
            safe_normalize(std::fabs(d.y) < 0.999f ? cross(d, Vec3f(0, 1, 0)) : Vec3f(1, 0, 0));
        o = right * lens.x + cross(right, d) * lens.y;
        d = normalize(d * focus_distance_ - o);
    }
    return {o, d, clip_start_, clip_end_};
}

float Camera::depth(Vec3f world_point) const {
    const Vec3f v = to_camera(world_point);
    return kind_ == CameraDescription::Kind::panoramic ? length(v) : v.z;
}

Vec3f Camera::to_camera(Vec3f world_point) const {
    const Vec3f v = world_from_camera_.transposed_vector(world_point - world_from_camera_.translation);
    return {v.x, v.y, -v.z};
}

Vec3f Camera::to_camera_vector(Vec3f world_vector) const {
    const Vec3f v = world_from_camera_.transposed_vector(world_vector);
    return {v.x, v.y, -v.z};
}

Vec2f Camera::project(Vec3f world_point, Vec2f film_size, const Transform& world_from_camera) const {
    const Vec3f v = world_from_camera.transposed_vector(world_point - world_from_camera.translation);
    const float scale = perspective() ? -1 / v.z : 1;
    return {static_cast<float>((double{v.x * scale} - left_) / (right_ - left_) * double{film_size.x}),
            static_cast<float>((double{v.y * scale} - bottom_) / (top_ - bottom_) * double{film_size.y})};
}

}  // namespace nephele
