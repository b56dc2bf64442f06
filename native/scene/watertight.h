// SPDX-License-Identifier: GPL-3.0-or-later
// Ray against triangle, such that a ray crosses a closed mesh exactly as often inwards as outwards, whatever
// edges and vertices it meets (after Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection").
//
// Vertices are sheared to two dimensions across the ray and rounded there; from then on all is exact.
// Products of floats are exact in double, so the sign of an edge function is, and where it is 0 the ray
// counts as moved aside by an infinitesimal step, the same for all triangles (simulation of simplicity,
// Edelsbrunner and Muecke 1990): a shared edge belongs to one of its triangles, and a silhouette to both or
// to none.
#pragma once

#include <optional>

#include "math/vec.h"

namespace nephele {

struct FaceHit {
    float t, u, v;  ///< u, v: barycentric coordinates of corners 1 and 2
    bool front;     ///< met where the corners go round counter-clockwise
};

class WatertightRay {
  public:
    WatertightRay(Vec3f origin, Vec3f d) : o_(origin) {
        const float x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
        z_ = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
        x_ = (z_ + 1) % 3;
        y_ = (z_ + 2) % 3;
        shear_ = {d[x_] / d[z_], d[y_] / d[z_], 1 / d[z_]};
        turned_ = d[z_] < 0;
    }

    /// The crossing of the whole line with a triangle.
    std::optional<FaceHit> meet(Vec3f a, Vec3f b, Vec3f c) const {
        const Vec3f p = sheared(a), q = sheared(b), r = sheared(c);
        const bool side = left(q, r);
        if (left(r, p) != side || left(p, q) != side || is_point(p, q) || is_point(q, r) || is_point(r, p))
            return std::nullopt;
        const double u = edge(q, r), v = edge(r, p), w = edge(p, q), area = u + v + w;
        if (area == 0)
            return std::nullopt;  // exactly edge-on; then its neighbours are crossed in its place
        const double t = (u * double{p.z} + v * double{q.z} + w * double{r.z}) / area;
        return FaceHit{static_cast<float>(t), static_cast<float>(v / area), static_cast<float>(w / area),
                       side == turned_};
    }

  private:
    Vec3f sheared(Vec3f p) const {
        const Vec3f q = p - o_;
        return {q[x_] - shear_.x * q[z_], q[y_] - shear_.y * q[z_], shear_.z * q[z_]};
    }
    static double edge(Vec3f p, Vec3f q) { return double{p.x} * double{q.y} - double{p.y} * double{q.x}; }
    /// Whether the ray passes the edge from p to q on its left.
    static bool left(Vec3f p, Vec3f q) {
        const double e = edge(p, q);
        if (e != 0)
            return e > 0;
        return p.y != q.y ? p.y > q.y : q.x > p.x;
    }
    static bool is_point(Vec3f p, Vec3f q) { return p.x == q.x && p.y == q.y; }

    Vec3f o_, shear_;
    int x_, y_, z_;
    bool turned_;
};

}  // namespace nephele
