// SPDX-License-Identifier: GPL-3.0-or-later
// A medium: one set of coefficients, constant or scaled by the density of one grid, that fills one region of
// space. Regions may overlap each other in any number; at a point the coefficients of all media there add up.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/medium.h"
#include "math/transform.h"
#include "grids/brick_grid.h"
#include "grids/majorant_grid.h"
#include "phase/phase_function.h"

namespace nephele {

/// The scalar field that scales a medium's coefficients.
struct DensityField {
    std::shared_ptr<const BrickGrid> grid;
    std::shared_ptr<const MajorantGrid> majorants;
    Transform index_from_world;
};

/// sigma_s, sigma_t: 1/m at density 1; emission: W/(m^3 sr). The field scales sigma_s and sigma_t, or emission alone.
struct Medium {
    std::string name;
    std::uint32_t region = 0;  ///< index of the region it fills, see Region
    Rgb sigma_s, sigma_t, emission;
    PhaseFunction phase;
    std::optional<DensityField> density;  ///< none: 1 everywhere
    bool density_scales_emission = false;

    float sigma_t_max() const { return max_component(sigma_t); }
    bool interacts() const { return sigma_t_max() > 0; }
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
    std::uint32_t visibility = ~0u;  ///< kinds of rays it exists for
    Transform index_from_world;      ///< box only
    Vec3f box_min, box_max;          ///< box only, index space

    Region(std::string region_name, Kind region_kind, std::uint32_t visible_to)
        : name(std::move(region_name)), kind(region_kind), visibility(visible_to) {}

    /// The ray's parameters inside the box, or nothing.
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
