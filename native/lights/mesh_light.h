// SPDX-License-Identifier: GPL-3.0-or-later
// The emissive triangles of one mesh instance as a light. A triangle is drawn in proportion to area times an
// estimate of its radiance; the point on it uniformly in solid angle where it is near (Arvo 1995, "Stratified
// Sampling of Spherical Triangles"), else uniformly in area. Both sides emit. What is emitted is for the
// material's program to say: samples carry no Li.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/light.h"
#include "lights/distribution.h"
#include "scene/mesh.h"

namespace nephele {

class MeshLight {
  public:
    /// radiance_estimate: one value >= 0 per triangle of the mesh (0: does not emit), finite; typically the
    /// luminance of its material's emission. Mesh and instance must outlive the light. Throws
    /// std::invalid_argument, naming the object.
    MeshLight(const Mesh& mesh, const Instance& instance, std::span<const float> radiance_estimate);

    /// How triangles are drawn: the same for equal vertices, placement and estimates.
    struct Choice {
        std::vector<std::uint32_t> emissive;  ///< sorted numbers of the triangles in `triangles`; empty: all
        DiscreteDistribution triangles;
        Vec3f lower{kInfinity}, upper{-kInfinity};
        float area = 0, intensity = 0;
    };
    /// Throws as the constructor that makes it.
    static Choice choice_of(const Mesh& mesh, const Instance& instance,
                            std::span<const float> radiance_estimate);
    MeshLight(const Mesh& mesh, const Instance& instance, std::shared_ptr<const Choice> choice)
        : mesh_(&mesh), instance_(&instance), choice_(std::move(choice)) {}

    struct Sample {
        LightSample light;  ///< Li is left 0
        std::uint32_t triangle = 0;
        Vec3f barycentric;  ///< weights of corners 0, 1, 2
        Vec3f p;            ///< the point, world space
        Vec3f ng;  ///< unit geometric normal, world space, by the order of the corners (mirroring undone)
    };
    /// A direction from p. None where the chosen triangle is seen edge-on from p, or degenerate.
    std::optional<Sample> sample(Vec3f p, double u_triangle, Vec2f u) const;
    /// Density of `sample` at a point on a triangle, solid angle at p: for a ray from p that hit `point`.
    float pdf(std::uint32_t triangle, Vec3f p, Vec3f point) const;

    bool empty() const { return choice_->triangles.empty(); }
    const Instance& instance() const { return *instance_; }
    const Mesh& mesh() const { return *mesh_; }
    std::size_t triangle_count() const { return choice_->triangles.size(); }
    float area() const { return choice_->area; }
    Vec3f lower() const { return choice_->lower; }
    Vec3f upper() const { return choice_->upper; }
    /// Radiant intensity as seen from afar, averaged over directions, W/sr (by the estimates).
    float intensity() const { return choice_->intensity; }
    /// Estimate of the fluence rate at p, W/m^2; > 0 everywhere unless `empty`.
    float importance(Vec3f p) const;

  private:
    struct Corners {
        Vec3f a, b, c;
    };
    static Corners corners_of(const Mesh& mesh, const Instance& instance, std::uint32_t triangle);
    Corners corners(std::uint32_t triangle) const { return corners_of(*mesh_, *instance_, triangle); }
    float probability(std::uint32_t triangle) const;

    const Mesh* mesh_;
    const Instance* instance_;
    std::shared_ptr<const Choice> choice_;
};

}  // namespace nephele
