// SPDX-License-Identifier: GPL-3.0-or-later
// What shading programs read from the shading point: coordinates, normals, attributes, the object.
#pragma once

#include "base/surface.h"
#include "shading/program.h"

namespace nephele {

/// Value of an operation that reads the point alone (opcodes.py, "inputs of the shading point"). mode: the
/// operation's.
Vec3f shading_input(Op op, std::int32_t mode, const ShadingPoint& point, const TextureContext& context);

/// Reflectance or facing weight of the Fresnel and Layer Weight nodes for the view against normal n.
float fresnel_node(float ior, Vec3f n, const ShadingPoint& point);
float layer_weight_fresnel(float blend, Vec3f n, const ShadingPoint& point);
float layer_weight_facing(float blend, Vec3f n, const ShadingPoint& point);

/// World normal of a tangent-space normal map. color: its texel; uv_map: the map that gives the tangent,
/// constant over a triangle. Where the mesh lacks it, the shading normal.
Vec3f tangent_normal(Rgb color, float strength, std::int32_t uv_map, const ShadingPoint& point);

}  // namespace nephele
