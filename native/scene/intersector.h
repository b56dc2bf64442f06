// SPDX-License-Identifier: GPL-3.0-or-later
// Ray queries against instanced triangle meshes: a thin layer over Embree (3 or 4) that knows nothing of
// materials. Two intersectors serve a scene: one for surfaces, one for the meshes that bound media.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "base/part_cache.h"
#include "math/vec.h"
#include "scene/mesh.h"

namespace nephele {

/// Where a ray meets a triangle.
struct Hit {
    float t = kInfinity;
    std::uint32_t instance = ~0u;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;     ///< barycentric coordinates of corners 1 and 2
    float outside_ior = 1;  ///< index of refraction around the surface, see scene/nesting.h

    bool valid() const { return instance != ~0u; }
};

/// Called for each triangle that a query meets, in no particular order. Returning true accepts the hit.
class HitFilter {
  public:
    virtual ~HitFilter() = default;
    virtual bool accept(const Hit& hit, bool front) = 0;
};

class Intersector {
  public:
    static constexpr float kFarthest = 1e18f;  ///< m; no ray meets anything beyond

    /// How a query decides which faces it meets.
    enum class Faces {
        fast,  ///< Embree's own test: a ray that grazes an edge or vertex may miss one of the faces there
        watertight  ///< watertight.h: a closed mesh is entered as often as left. Not for occluded()
    };

    /// What is built.
    enum class Layout {
        whole,    ///< one hierarchy over all that stands still and is there once: rays are faster
        by_mesh,  ///< one of each mesh, and one over their instances: built faster where something changes
    };

    /// Builds the hierarchy over the instances listed. parts: where to look for those of meshes first. Throws
    /// std::runtime_error naming the cause.
    Intersector(std::span<const Mesh> meshes, std::span<const Instance> instances,
                std::span<const std::uint32_t> used, Faces faces = Faces::fast, Layout layout = Layout::whole,
                PartScope* parts = nullptr);
    /// The one of these instances that is among the parts, or a new one. role: the scene's only one of that
    /// name.
    static std::shared_ptr<const Intersector> shared(PartScope& parts, std::string_view role,
                                                     std::span<const Mesh> meshes,
                                                     std::span<const Instance> instances,
                                                     std::span<const std::uint32_t> used, Faces faces,
                                                     Layout layout);
    ~Intersector();
    Intersector(const Intersector&) = delete;
    Intersector& operator=(const Intersector&) = delete;

    bool empty() const { return empty_; }
    /// Nearest hit in [t_min, t_max] that the filter (if any) accepts.
    Hit intersect(const Ray& ray, HitFilter* filter = nullptr) const;
    /// Whether something in [t_min, t_max] is hit that the filter (if any) accepts. The filter sees every hit
    /// until then, once.
    bool occluded(const Ray& ray, HitFilter* filter = nullptr) const;
    /// Largest coordinate of all that is there, m; 0 where faces are not watertight.
    float reach() const { return reach_; }
    /// Memory that Embree holds, bytes.
    std::size_t bytes() const;

    /// Checks that the library bound at run time is the one compiled against: in a host process that carries
    /// another Embree the wrong one may answer, with no hits and no error. Throws std::runtime_error.
    static void self_test();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
    bool empty_ = true;
    float reach_ = 0;
};

}  // namespace nephele
