// SPDX-License-Identifier: GPL-3.0-or-later
// What shading programs read from the shading point: coordinates, normals, attributes, the object.
#pragma once

#include "base/surface.h"
#include "shading/program.h"

namespace nephele {

/// Value of an operation that reads the point alone (opcodes.py, "inputs of the shading point"). mode: the
/// operation's.
Vec3f shading_input(Op op, std::int32_t mode, const ShadingPoint& point, const TextureContext& context);
/// The same where the mode counts from kShift on: read `pixels` beside the point in its tangent plane.
Vec3f shifted_input(Op op, std::int32_t mode, float pixels, const ShadingPoint& point,
                    const TextureContext& context);

/// Normal n bent as a surface of those heights is. heights: here and one step along the tangent plane's axes.
Vec3f bump_normal(Vec3f heights, float strength, float distance, float pixels, Vec3f n,
                  const ShadingPoint& point, const TextureContext& context);
/// Whether the point lies within half of `size` (of pixels, or metres) of an edge of its triangle.
bool on_wire(float size, bool pixels, const ShadingPoint& point, const TextureContext& context);
/// a from one space to another, as the mode of "convert_space" says.
Vec3f convert_space(std::int32_t mode, Vec3f a, const ShadingPoint& point, const TextureContext& context);

/// Reflectance or facing weight of the Fresnel and Layer Weight nodes for the view against normal n.
float fresnel_node(float ior, Vec3f n, const ShadingPoint& point);
float layer_weight_fresnel(float blend, Vec3f n, const ShadingPoint& point);
float layer_weight_facing(float blend, Vec3f n, const ShadingPoint& point);

/// World normal of a tangent-space normal map. color: its texel; uv_map: the map that gives the tangent,
/// constant over a triangle. Where the mesh lacks it, the shading normal.
Vec3f tangent_normal(Rgb color, float strength, std::int32_t uv_map, const ShadingPoint& point);

}  // namespace nephele
