// SPDX-License-Identifier: GPL-3.0-or-later
// The grids that a volume's program reads, placed in the world: numbers or vectors by number, at rest or
// carried along by a velocity.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "base/part_key.h"
#include "grids/brick_grid.h"
#include "grids/cell_bounds.h"
#include "math/transform.h"

namespace nephele {

/// One grid. A grid of numbers has one component, one of vectors three of the same topology.
struct VolumeField {
    std::array<std::shared_ptr<const BrickGrid>, 3> components;  ///< [1] and [2] null for numbers
    std::array<std::shared_ptr<const CellBounds>, 3> bounds;     ///< of the components, under `filter`
    Filter filter = Filter::trilinear;
    Transform index_from_world;

    bool is_vector() const { return components[1] != nullptr; }
    /// The filter's value at a point of the world; programs may ask for one that is nowhere, or infinitely
    /// far: there is the background.
    Vec3f value(Vec3f p_world) const {
        constexpr float kBeyond = 1e30f;
        Vec3f p = index_from_world.point(p_world);
        if (!is_finite(p))
            p = Vec3f(kBeyond);
        const float x = components[0]->evaluate(filter, p);
        return is_vector() ? Vec3f(x, components[1]->evaluate(filter, p), components[2]->evaluate(filter, p))
                           : Vec3f(x);
    }
    /// Bounds of value() over a box of the world, by component.
    std::array<Bounds, 3> range(Vec3f lo_world, Vec3f hi_world) const;
    void add_to(PartKey& key) const;
};

/// What carries the fields of a volume along (motion blur): at a time, a point shows what would get there
/// from where it was, one step of the velocity back.
struct VolumeMotion {
    std::vector<VolumeField> velocity;  ///< one of vectors, or three of numbers
    Transform world_from_velocity;      ///< vectors only: of a value of 1 each frame, m
    float open = 0, close = 0;          ///< of the shutter, frames

    /// Where to look up for `time` in [0, 1] of the shutter.
    Vec3f origin(Vec3f p_world, float time) const {
        return p_world - world_from_velocity.vector(velocity_at(p_world)) * (open + (close - open) * time);
    }
    /// Grows a box so that it holds origin() of all its points at all times.
    void grow(Vec3f& lo_world, Vec3f& hi_world) const;
    void add_to(PartKey& key) const;

  private:
    Vec3f velocity_at(Vec3f p) const {
        if (velocity.size() == 1)
            return velocity[0].value(p);
        return {velocity[0].value(p).x, velocity[1].value(p).x, velocity[2].value(p).x};
    }
};

class VolumeFields {
  public:
    VolumeFields() = default;
    explicit VolumeFields(std::vector<VolumeField> fields,
                          std::shared_ptr<const VolumeMotion> motion = nullptr)
        : fields_(std::move(fields)), motion_(std::move(motion)) {}

    /// Value of field `number` at a point of the world and a time of the shutter; 0 where the volume lacks
    /// it.
    Vec3f value(std::int32_t number, Vec3f p_world, float time) const {
        const auto i = static_cast<std::size_t>(number);
        if (i >= fields_.size() || !fields_[i].components[0])
            return Vec3f(0);
        return fields_[i].value(motion_ ? motion_->origin(p_world, time) : p_world);
    }
    /// Bounds of value() over a box of the world and all times.
    std::array<Bounds, 3> range(std::int32_t number, Vec3f lo_world, Vec3f hi_world) const;

    void add_to(PartKey& key) const;

  private:
    std::vector<VolumeField> fields_;
    std::shared_ptr<const VolumeMotion> motion_;
};

}  // namespace nephele
