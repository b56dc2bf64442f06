// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of point and spot lamps: a sphere, a disc of the same radius that always faces the receiving
// point
// ("soft falloff"), or a mere point. Spheres are sampled uniformly in the solid angle they fill (Wang 1992),
// from inside over all directions; discs by area.
#pragma once

#include <optional>

#include "math/transform.h"
#include "math/warp.h"

namespace nephele {

struct Ball {
    Vec3f center;
    float radius = 0;    ///< m; 0: a point
    bool sphere = true;  ///< false: the disc that faces the receiving point

    /// Seen under a smaller sine than this the ball is a point: no other technique can hit it in single
    /// precision.
    static constexpr float kPointSine = 1e-7f;

    struct Sample {
        Vec3f wi;
        float distance = 0;
        float pdf = 0;          ///< solid angle; 1 where `point`
        float solid_angle = 0;  ///< the ball's, where `point`
        bool point = false;
    };

    /// A ball that is a point from p: intensity counts, not radiance.
    bool is_point_from(Vec3f p) const { return !(radius > kPointSine * length(center - p)); }
    bool contains(Vec3f p) const { return sphere && dot(center - p, center - p) <= radius * radius; }

    /// Direction from p towards the ball; none where p is the bare point itself.
    std::optional<Sample> sample(Vec3f p, Vec2f u) const {
        const Vec3f to_center = center - p;
        const float d = length(to_center);
        if (is_point_from(p)) {
            if (!(d > 0))
                return std::nullopt;
            return Sample{to_center / d, d, 1, kPi * sqr(radius / d), true};
        }
        if (!sphere)
            return sample_disc_facing(p, d > 0 ? to_center / d : Vec3f(0, 0, 1), d, u);
        Sample s;
        if (contains(p)) {
            s.wi = sample_sphere(u);
            s.pdf = kInv4Pi;
        } else {
            const float one_minus_cos = one_minus_cos_of(d);
            s.wi = normalize(Frame(to_center / d).to_world(sample_cone(u, one_minus_cos)));
            s.pdf = cone_pdf(one_minus_cos);
        }
        s.distance = sphere_distance(to_center, s.wi);
        return s;
    }

    /// Distance at which the ray from p along the unit vector wi meets the ball, and the density of `sample`
    /// for it.
    struct Hit {
        float distance, pdf;
    };
    std::optional<Hit> hit(Vec3f p, Vec3f wi) const {
        if (is_point_from(p))
            return std::nullopt;
        const Vec3f to_center = center - p;
        if (!sphere)
            return hit_disc_facing(to_center, wi);
        if (contains(p))
            return Hit{sphere_distance(to_center, wi), kInv4Pi};
        const float along = dot(to_center, wi);
        const Vec3f across =
            to_center - wi * along;  // stays exact for far balls, where d^2 - along^2 would cancel
        if (along <= 0 || dot(across, across) > radius * radius)
            return std::nullopt;
        return Hit{sphere_distance(to_center, wi), cone_pdf(one_minus_cos_of(length(to_center)))};
    }

    /// Solid angle from p (disc: an upper estimate), never 0 for a radius > 0; for `importance`.
    float solid_angle(Vec3f p) const {
        const Vec3f to_center = center - p;
        const float d2 = dot(to_center, to_center);
        if (sphere)
            return d2 <= radius * radius ? 4 * kPi : 2 * kPi * one_minus_cos_of(std::sqrt(d2));
        return std::min(2 * kPi, kPi * radius * radius / d2);
    }

  private:
    /// 1 - cos of the half angle of the sphere at distance d > radius, without cancellation.
    float one_minus_cos_of(float d) const {
        const float sin2 = std::min(1.0f, sqr(radius / d));
        return sin2 / (1 + std::sqrt(1 - sin2));
    }
    /// Distance to the sphere: its near side from outside, its far side from inside. Misses by rounding count
    /// as grazing.
    float sphere_distance(Vec3f to_center, Vec3f wi) const {
        const float along = dot(to_center, wi);
        const Vec3f across = to_center - wi * along;
        const float half_chord = std::sqrt(std::max(0.0f, radius * radius - dot(across, across)));
        const bool inside = dot(to_center, to_center) <= radius * radius;
        return std::max(0.0f, inside ? along + half_chord : along - half_chord);
    }
    std::optional<Sample> sample_disc_facing(Vec3f p, Vec3f axis, float d, Vec2f u) const {
        const Vec2f q = sample_disc(u);
        const Frame frame(axis);
        const Vec3f on_disc = frame.x * (radius * q.x) + frame.y * (radius * q.y);
        const Vec3f v = (center - p) + on_disc;
        const float distance = length(v);
        if (!(distance > 0) || !(d > 0))
            return std::nullopt;  // p on the disc's plane: it is seen edge-on
        Sample s;
        s.wi = v / distance;
        s.distance = distance;
        s.pdf = disc_pdf(distance, d);
        return s;
    }
    std::optional<Hit> hit_disc_facing(Vec3f to_center, Vec3f wi) const {
        const float d = length(to_center);
        const float cosine = d > 0 ? dot(to_center / d, wi) : 0;
        if (cosine <= 0)
            return std::nullopt;
        const float distance = d / cosine;
        const Vec3f across = wi * distance - to_center;
        if (dot(across, across) > radius * radius)
            return std::nullopt;
        return Hit{distance, disc_pdf(distance, d)};
    }
    /// Area density 1/(pi r^2) turned into solid angle; the disc's cosine is d / distance.
    float disc_pdf(float distance, float d) const {
        return distance * distance * (distance / d) / (kPi * radius * radius);
    }
};

}  // namespace nephele
