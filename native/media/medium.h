// SPDX-License-Identifier: GPL-3.0-or-later
// A medium: coefficients, constant or scaled by the density of one grid or computed by a program, that fill
// one region of space. Regions may overlap each other in any number; at a point the coefficients of all media
// there add up.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grids/brick_grid.h"
#include "math/transform.h"
#include "media/medium_bounds.h"
#include "phase/phase_function.h"

namespace nephele {

/// One of three: constant; scaled by the density of a grid; computed by a program.
/// sigma_s, sigma_t: 1/m at density 1; emission: W/(m^3 sr); unused with a program.
struct Medium {
    std::string name;
    std::uint32_t region = 0;  ///< index of the region it fills, see Region
    Rgb sigma_s, sigma_t, emission;
    PhaseFunction phase;
    std::shared_ptr<const BrickGrid> grid;         ///< its density; none: 1 everywhere
    std::shared_ptr<const ProgramMedium> program;  ///< computes all coefficients
    std::shared_ptr<const MediumBounds> bounds;    ///< of what varies; none where nothing does
    Filter filter = Filter::trilinear;
    bool density_scales_emission = false;  ///< the grid scales emission alone, not sigma_s and sigma_t

    float sigma_t_max() const { return max_component(sigma_t); }
    bool interacts() const { return program ? program->interacts() : sigma_t_max() > 0; }
    bool emits() const { return program ? program->emits() : !is_zero(emission); }
};

/// Where media are. A region holds the media media_begin <= i < media_end of the scene.
struct Region {
    enum class Kind {
        world,  ///< everywhere
        box,    ///< the box of a grid, in that grid's index space
        mesh    ///< inside a closed mesh: bounded by crossings of its surface
    };

    std::string name;
    Kind kind = Kind::world;
    std::uint32_t media_begin = 0, media_end = 0;
    std::uint32_t visibility = ~0u;                  ///< kinds of rays it exists for
    std::uint8_t receiver_set = 0, blocker_set = 0;  ///< of its object, see Linking
    const Instance* mover = nullptr;  ///< what carries the region and all that varies in it; null: it stands
    Transform index_from_world;       ///< box only, as at the frame
    Vec3f box_min, box_max;           ///< box only, index space

    Region(std::string region_name, Kind region_kind, std::uint32_t visible_to)
        : name(std::move(region_name)), kind(region_kind), visibility(visible_to) {}

    /// Makes it the box between these points of index space.
    void set_box(const IndexBox& box, const Transform& index_from_world_) {
        index_from_world = index_from_world_;
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            box_min[a] = static_cast<float>(box.min[i]);
            box_max[a] = static_cast<float>(box.max[i]);
        }
    }
    /// The ray's parameters inside the box, or nothing. ray: see RestRay where the region moves.
    std::optional<Vec2f> intersect_box(const Ray& ray) const {
        const Vec3f o = index_from_world.point(ray.o), d = index_from_world.vector(ray.d);
        float t0 = ray.t_min, t1 = ray.t_max;
        for (int i = 0; i < 3; ++i) {
            if (d[i] == 0) {
                if (o[i] < box_min[i] || o[i] > box_max[i])
                    return std::nullopt;
                continue;
            }
            const float a = (box_min[i] - o[i]) / d[i], b = (box_max[i] - o[i]) / d[i];
            t0 = std::max(t0, std::min(a, b));
            t1 = std::min(t1, std::max(a, b));
        }
        if (!(t0 < t1))
            return std::nullopt;
        return Vec2f{t0, t1};
    }
};

}  // namespace nephele
