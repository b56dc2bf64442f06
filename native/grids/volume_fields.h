// SPDX-License-Identifier: GPL-3.0-or-later
// The grids that a volume's program reads, placed in the world: numbers or vectors by number.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "grids/brick_grid.h"
#include "math/transform.h"

namespace nephele {

/// One grid. A grid of numbers has one component, one of vectors three of the same topology.
struct VolumeField {
    std::array<std::shared_ptr<const BrickGrid>, 3> components;  ///< [1] and [2] null for numbers
    Transform index_from_world;

    /// The trilinear filter's value at a point of the world.
    Vec3f value(Vec3f p_world) const {
        const Vec3f p = index_from_world.point(p_world);
        const float x = components[0]->trilinear(p);
        return components[1] ? Vec3f(x, components[1]->trilinear(p), components[2]->trilinear(p)) : Vec3f(x);
    }
};

class VolumeFields {
  public:
    VolumeFields() = default;
    explicit VolumeFields(std::vector<VolumeField> fields) : fields_(std::move(fields)) {}

    const std::vector<VolumeField>& fields() const { return fields_; }
    /// Value of field `number` at a point of the world; 0 where the volume lacks it.
    Vec3f value(std::int32_t number, Vec3f p_world) const {
        const auto i = static_cast<std::size_t>(number);
        return i < fields_.size() && fields_[i].components[0] ? fields_[i].value(p_world) : Vec3f(0);
    }

  private:
    std::vector<VolumeField> fields_;
};

}  // namespace nephele
