// SPDX-License-Identifier: GPL-3.0-or-later
// Area lamp: a rectangle or ellipse that emits from one side, Lambertian or narrowed by `spread`.
//
// Spread is a grid of slats in front of the lamp: the radiance at the angle a to the normal is scaled by
// (tan(spread/2) - tan a) / (tan(spread/2) - spread/2), which keeps the flux (Cycles' model). Spread 0 is a
// beam of parallel light, a delta light. Near lamps are sampled by the solid angle of their rectangle (an
// ellipse's bounding rectangle, with rejection), cut down to what the spread lets reach the point; far ones
// by area.
#pragma once

#include "lights/lamp_description.h"
#include "lights/spherical_rectangle.h"
#include "math/warp.h"

namespace nephele {

struct AreaLight {
    Vec3f center, x, y, normal;    ///< unit axes; it shines along `normal`
    float half_x = 0, half_y = 0;  ///< m, scale included
    bool ellipse = false;
    float tan_spread = kInfinity;  ///< of half the spread; infinity: Lambertian; 0: parallel
    float spread_scale = 0;        ///< 1 / (tan(spread/2) - spread/2)
    Rgb emission;                  ///< radiance of the Lambertian lamp; irradiance of the beam where parallel

    static AreaLight prepare(const LampDescription& lamp);

    bool delta() const { return tan_spread == 0; }
    float area() const { return half_x * half_y * (ellipse ? kPi : 4); }
    Rgb power() const { return emission * (area() * (delta() ? 1 : kPi)); }

    std::optional<LightSample> sample(Vec3f p, Vec2f u) const;
    float pdf(Vec3f p, Vec3f wi) const;
    std::optional<LightHit> intersect(const Ray& ray) const;
    /// Scale of the radiance along the normal.
    float peak_falloff() const { return delta() ? 1 : spread_falloff(0); }
    /// Fluence rate at p, W/m^2: the radiance towards p of the lamp's point nearest to p, times the solid
    /// angle that the lamp would fill if all of it were there. 0 only where no light arrives.
    float importance(Vec3f p) const;

  private:
    /// A point in the lamp's own coordinates, in double so that far lamps and near planes keep their digits.
    struct Local {
        double x, y, z;
    };
    /// The part of the lamp's bounding rectangle that can light a point.
    struct Window {
        double x0, x1, y0, y1;
        bool whole;  ///< nothing was cut off
        bool empty() const { return !(x0 < x1 && y0 < y1); }
        double area() const { return (x1 - x0) * (y1 - y0); }
    };

    Local local(Vec3f p) const {
        const Vec3f v = p - center;
        return {dot(v, x), dot(v, y), dot(v, normal)};
    }
    bool inside(double px, double py) const {
        const double a = px / half_x, b = py / half_y;
        return ellipse ? a * a + b * b <= 1 : std::fabs(a) <= 1 && std::fabs(b) <= 1;
    }
    /// Scale of the radiance at an angle to the normal with this tangent.
    float spread_falloff(double tangent) const {
        if (tan_spread == kInfinity)
            return 1;
        return static_cast<float>(std::max(0.0, tan_spread - tangent)) * spread_scale;
    }
    Window window(const Local& p) const;
    bool near(const Local& p, const Window& w) const {
        const double dx = w.x1 - w.x0, dy = w.y1 - w.y0;
        const double cx = p.x - 0.5 * (w.x0 + w.x1), cy = p.y - 0.5 * (w.y0 + w.y1);
        return 100 * (dx * dx + dy * dy) > cx * cx + cy * cy + p.z * p.z;
    }
    std::optional<LightSample> sample_beam(const Local& p) const;
    /// Density of `sample` for a point of the lamp at this squared distance; p.z > 0.
    float density(const Local& p, const Window& w, double distance_squared) const;
};

inline AreaLight AreaLight::prepare(const LampDescription& lamp) {
    AreaLight a;
    a.center = lamp.position();
    a.x = lamp.axis(0);
    // A sheared object's rectangle is straightened; a mirrored one still shines along its -z.
    a.y = safe_normalize(lamp.axis(1) - a.x * dot(a.x, lamp.axis(1)));
    a.normal = cross(a.x, a.y);
    if (dot(a.normal, lamp.axis(2)) > 0)
        a.normal = -a.normal;
    a.half_x = 0.5f * lamp.size_x * lamp.scale(0);
    a.half_y = 0.5f * lamp.size_y * lamp.scale(1);
    a.ellipse = lamp.ellipse;
    a.emission = lamp.power * kInvPi;
    if (lamp.normalize)
        a.emission = a.emission / a.area();
    const double half = 0.5 * std::clamp(double{lamp.spread}, 0.0, double{kPi});
    if (lamp.spread >= kPi)
        return a;
    // Narrower than this, directions in single precision cannot tell the beam from a parallel one.
    if (half < 1e-5) {
        a.tan_spread = 0;
        a.emission *= kPi;
        return a;
    }
    a.tan_spread = static_cast<float>(std::tan(half));
    const double opening =
        half > 0.05 ? std::tan(half) - half : half * half * half * (1.0 / 3 + half * half * 2 / 15);
    a.spread_scale = static_cast<float>(1 / opening);
    return a;
}

inline AreaLight::Window AreaLight::window(const Local& p) const {
    Window w{-half_x, half_x, -half_y, half_y, true};
    if (tan_spread == kInfinity)
        return w;
    const double reach = p.z * tan_spread;
    const Window cut{std::max(w.x0, p.x - reach), std::min(w.x1, p.x + reach), std::max(w.y0, p.y - reach),
                     std::min(w.y1, p.y + reach), false};
    const bool whole = cut.x0 == w.x0 && cut.x1 == w.x1 && cut.y0 == w.y0 && cut.y1 == w.y1;
    return whole ? w : cut;
}

inline std::optional<LightSample> AreaLight::sample_beam(const Local& p) const {
    if (!inside(p.x, p.y))
        return std::nullopt;
    return LightSample{-normal, static_cast<float>(p.z), emission, 1, true};
}

inline float AreaLight::density(const Local& p, const Window& w, double distance_squared) const {
    if (near(p, w)) {
        const SphericalRectangle r(w.x0 - p.x, w.x1 - p.x, w.y0 - p.y, w.y1 - p.y, p.z);
        if (r.solid_angle() > 0)
            return static_cast<float>(1 / r.solid_angle());
    }
    const double sampled = ellipse && w.whole ? area() : w.area();
    return static_cast<float>(distance_squared * std::sqrt(distance_squared) / (p.z * sampled));
}

inline std::optional<LightSample> AreaLight::sample(Vec3f p, Vec2f u) const {
    const Local q = local(p);
    if (!(q.z > 0))
        return std::nullopt;
    if (delta())
        return sample_beam(q);
    const Window w = window(q);
    if (w.empty())
        return std::nullopt;

    Vec2f on;  // the chosen point, relative to p's foot on the lamp's plane
    bool by_solid_angle = false;
    if (near(q, w)) {
        const SphericalRectangle r(w.x0 - q.x, w.x1 - q.x, w.y0 - q.y, w.y1 - q.y, q.z);
        by_solid_angle = r.solid_angle() > 0;
        if (by_solid_angle)
            on = r.sample(u);
    }
    if (!by_solid_angle) {
        const Vec2f d = ellipse && w.whole ? sample_disc(u) : Vec2f{2 * u.x - 1, 2 * u.y - 1};
        on.x = static_cast<float>(0.5 * (w.x0 + w.x1) - q.x + 0.5 * (w.x1 - w.x0) * d.x);
        on.y = static_cast<float>(0.5 * (w.y0 + w.y1) - q.y + 0.5 * (w.y1 - w.y0) * d.y);
    }
    // Only the bounding rectangle of an ellipse can be missed.
    if (ellipse && !(w.whole && !by_solid_angle) && !inside(q.x + on.x, q.y + on.y))
        return std::nullopt;

    const double lateral2 = double{on.x} * on.x + double{on.y} * on.y, d2 = lateral2 + q.z * q.z;
    LightSample s;
    s.distance = static_cast<float>(std::sqrt(d2));
    s.wi = normalize(x * on.x + y * on.y - normal * static_cast<float>(q.z));
    s.Li = emission * spread_falloff(std::sqrt(lateral2) / q.z);
    if (is_zero(s.Li))
        return std::nullopt;
    s.pdf = density(q, w, d2);
    return s;
}

inline std::optional<LightHit> AreaLight::intersect(const Ray& ray) const {
    const float cosine = -dot(ray.d, normal);
    const Local q = local(ray.o);
    if (delta() || !(cosine > 0) || !(q.z > 0))
        return std::nullopt;
    const double t = q.z / cosine;
    const double on_x = t * dot(ray.d, x), on_y = t * dot(ray.d, y);
    if (t < ray.t_min || t > ray.t_max || !inside(q.x + on_x, q.y + on_y))
        return std::nullopt;
    const double lateral2 = on_x * on_x + on_y * on_y;
    const float falloff = spread_falloff(std::sqrt(lateral2) / q.z);
    if (falloff == 0)
        return std::nullopt;
    const Window w = window(q);
    if (w.empty())
        return std::nullopt;
    return LightHit{static_cast<float>(t), emission * falloff, density(q, w, lateral2 + q.z * q.z)};
}

inline float AreaLight::pdf(Vec3f p, Vec3f wi) const {
    const auto h = intersect({p, wi, 0, kInfinity});
    return h ? h->pdf : 0;
}

inline float AreaLight::importance(Vec3f p) const {
    const Local q = local(p);
    if (!(q.z > 0))
        return 0;
    if (delta())
        return inside(q.x, q.y) ? mean(emission) : 0;
    // Nearest point of the bounding rectangle: there the angle to the normal is the smallest.
    const double dx = std::max(0.0, std::fabs(q.x) - half_x), dy = std::max(0.0, std::fabs(q.y) - half_y);
    const double lateral2 = dx * dx + dy * dy, d2 = lateral2 + q.z * q.z;
    const double solid_angle = area() * (q.z / std::sqrt(d2)) / (d2 + area() / (2 * double{kPi}));
    return mean(emission) * spread_falloff(std::sqrt(lateral2) / q.z) * static_cast<float>(solid_angle);
}

}  // namespace nephele
