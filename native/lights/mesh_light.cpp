// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/mesh_light.h"

#include <algorithm>
#include <stdexcept>

#include "lights/spherical_triangle.h"

namespace nephele {

namespace {

/// Twice the triangle's area, as a vector along its normal.
Vec3f area_vector(Vec3f a, Vec3f b, Vec3f c) {
    return cross(b - a, c - a);
}

/// Uniform density in area as density in solid angle; infinite where the triangle is seen edge-on.
float area_density(Vec3f twice_area, Vec3f to_light) {
    const float distance = length(to_light);
    return 2 * distance * (distance * distance) / std::fabs(dot(twice_area, to_light));
}

}  // namespace

MeshLight::MeshLight(const Mesh& mesh, const Instance& instance, std::span<const float> radiance_estimate)
    : MeshLight(mesh, instance,
                std::make_shared<const Choice>(choice_of(mesh, instance, radiance_estimate))) {}

MeshLight::Choice MeshLight::choice_of(const Mesh& mesh, const Instance& instance,
                                       std::span<const float> radiance_estimate) {
    if (radiance_estimate.size() != mesh.triangle_count()) {
        throw std::invalid_argument("object '" + instance.name +
                                    "': its emission is not given once per triangle");
    }
    Choice out;
    std::vector<float> weights;
    double area = 0, flux = 0;
    for (std::uint32_t t = 0; t < radiance_estimate.size(); ++t) {
        const float radiance = radiance_estimate[t];
        if (!(radiance >= 0) || !std::isfinite(radiance)) {
            throw std::invalid_argument("object '" + instance.name +
                                        "': its emission is negative or not finite");
        }
        if (radiance == 0)
            continue;
        const Corners k = corners_of(mesh, instance, t);
        const float size = 0.5f * length(area_vector(k.a, k.b, k.c));
        if (!(size > 0))
            continue;
        out.emissive.push_back(t);
        weights.push_back(size * radiance);
        area += static_cast<double>(size);
        flux += static_cast<double>(size) * static_cast<double>(radiance);
        out.lower = min(out.lower, min(k.a, min(k.b, k.c)));
        out.upper = max(out.upper, max(k.a, max(k.b, k.c)));
    }
    out.triangles = DiscreteDistribution(weights);
    out.area = static_cast<float>(area);
    out.intensity = static_cast<float>(0.5 * flux);  // the mean of |cos| over all directions is 1/2
    if (out.emissive.size() == mesh.triangle_count())
        out.emissive = {};
    return out;
}

MeshLight::Corners MeshLight::corners_of(const Mesh& mesh, const Instance& instance, std::uint32_t triangle) {
    const Transform& m = instance.world_from_object;
    return {m.point(mesh.vertex(triangle, 0)), m.point(mesh.vertex(triangle, 1)),
            m.point(mesh.vertex(triangle, 2))};
}

float MeshLight::probability(std::uint32_t triangle) const {
    if (choice_->emissive.empty())
        return triangle < choice_->triangles.size() ? choice_->triangles.probability(triangle) : 0;
    const auto found = std::lower_bound(choice_->emissive.begin(), choice_->emissive.end(), triangle);
    if (found == choice_->emissive.end() || *found != triangle)
        return 0;
    return choice_->triangles.probability(static_cast<std::size_t>(found - choice_->emissive.begin()));
}

std::optional<MeshLight::Sample> MeshLight::sample(Vec3f p, double u_triangle, Vec2f u) const {
    if (empty())
        return std::nullopt;
    const DiscreteDistribution::Choice chosen = choice_->triangles.sample(u_triangle);
    Sample s;
    s.triangle = choice_->emissive.empty() ? chosen.index : choice_->emissive[chosen.index];
    const Corners k = corners(s.triangle);
    const SphericalTriangle spherical(k.a - p, k.b - p, k.c - p);
    if (spherical.usable()) {
        s.barycentric = spherical.sample(u);
    } else {  // uniform in area (Heitz 2019, "A Low-Distortion Map Between Triangle and Square")
        const bool lower = u.y > u.x;
        const float b0 = lower ? u.x / 2 : u.x - u.y / 2, b1 = lower ? u.y - u.x / 2 : u.y / 2;
        s.barycentric = {b0, b1, 1 - b0 - b1};
    }
    const Vec3f to_light =
        (k.a - p) * s.barycentric.x + (k.b - p) * s.barycentric.y + (k.c - p) * s.barycentric.z;
    const Vec3f n = area_vector(k.a, k.b, k.c);
    s.light.distance = length(to_light);
    if (!(s.light.distance > 0))
        return std::nullopt;
    s.light.wi = to_light / s.light.distance;
    s.p = p + to_light;
    s.ng = normalize(instance_->mirrored() ? -n : n);
    const float density = spherical.usable() ? 1 / spherical.solid_angle() : area_density(n, to_light);
    if (!std::isfinite(density))
        return std::nullopt;
    s.light.pdf = chosen.probability * density;
    return s;
}

float MeshLight::pdf(std::uint32_t triangle, Vec3f p, Vec3f point) const {
    const float chosen = probability(triangle);
    if (chosen == 0)
        return 0;
    const Corners k = corners(triangle);
    const SphericalTriangle spherical(k.a - p, k.b - p, k.c - p);
    const float density = spherical.usable() ? 1 / spherical.solid_angle()
                                             : area_density(area_vector(k.a, k.b, k.c), point - p);
    return std::isfinite(density) ? chosen * density : 0;
}

float MeshLight::importance(Vec3f p) const {
    if (empty())
        return 0;
    // At a great distance intensity / d^2; close by no more than its mean radiance from all around.
    const Vec3f outside = max(max(choice_->lower - p, p - choice_->upper), Vec3f(0));
    return choice_->intensity / (dot(outside, outside) + choice_->area / (8 * kPi));
}

}  // namespace nephele
