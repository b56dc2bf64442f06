// SPDX-License-Identifier: GPL-3.0-or-later
// Panoramic lenses: the direction that a point of the picture shows, in the camera's space (x right, y up, it
// looks along -z). The picture is the unit square, (0, 0) its lower left corner; lengths on the sensor in mm,
// angles in radians. Cycles' lenses by their public formulas.
#pragma once

#include <array>
#include <optional>

#include "math/vec.h"

namespace nephele {

struct Panorama {
    enum class Lens {
        equirectangular,      ///< values: longitudes of the left and right side, latitudes of bottom and top
        fisheye_equidistant,  ///< field of view of the inscribed ellipse
        fisheye_equisolid,    ///< field of view, focal length, width and height of the sensor
        fisheye_polynomial,   ///< field of view, width and height of the sensor, k0 to k4
        mirror_ball,          ///< none
        equiangular_cubemap,  ///< none: one face
        central_cylindrical   ///< angles of the left and right side, heights of bottom and top, radius
    };

    Lens lens = Lens::equirectangular;
    std::array<double, 8> values{};

    bool finite() const;
    /// Unit direction at a point of the picture; none outside of what the lens shows.
    std::optional<Vec3f> direction(double x, double y) const;
};

}  // namespace nephele
