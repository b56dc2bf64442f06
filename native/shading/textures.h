// SPDX-License-Identifier: GPL-3.0-or-later
// Procedural textures other than noise, tables, and the maps from directions to image coordinates, as Blender
// has them.
#pragma once

#include <span>

#include "math/vec.h"

namespace nephele {

/// Whether p lies in an odd cell of the unit checkerboard.
bool checker_is_odd(Vec3f p);

enum class Gradient { linear, quadratic, easing, diagonal, spherical, quadratic_sphere, radial };
/// Value in [0, 1].
float gradient_value(Gradient kind, Vec3f p);

/// Linear interpolation at t in [0, 1] in a table of `channels` floats an entry.
float table_scalar(std::span<const float> table, float t);
Rgb table_rgb(std::span<const float> table, float t);

/// Image coordinates of a point of the unit cube on a sphere or a tube around its middle.
Vec2f sphere_projection(Vec3f p);
Vec2f tube_projection(Vec3f p);
/// Image coordinates on the face across `axis` of a cube, and its weight, at a point with this normal. blend:
/// 0 to 1, how far faces fade into each other.
Vec3f box_projection(Vec3f p, Vec3f normal, int axis, float blend);

/// Image coordinates of direction d on a mirror ball photographed along +y.
Vec2f mirror_ball_from_direction(Vec3f d);

}  // namespace nephele
