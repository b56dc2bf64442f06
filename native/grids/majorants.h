// SPDX-License-Identifier: GPL-3.0-or-later
// The majorants of one field by either accelerator, chosen when they are built.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>

#include "grids/cell_bounds.h"
#include "grids/kd_tree.h"
#include "grids/majorant_grid.h"
#include "grids/majorant_walk.h"

namespace nephele {

enum class Accelerator : std::uint8_t { grid, kdtree };

class Majorants {
  public:
    /// Arguments as for MajorantGrid and KdTree.
    Majorants(const CellBounds& bounds, Accelerator accelerator, float sigma_scale,
              bool with_minorants = false)
        : held_(accelerator == Accelerator::grid
                    ? Held(std::in_place_type<MajorantGrid>, bounds, sigma_scale, with_minorants)
                    : Held(std::in_place_type<KdTree>, bounds, sigma_scale, with_minorants)),
          origin_(bounds.origin()),
          cells_(bounds.cells()),
          support_min_(bounds.support_min()),
          support_max_(bounds.support_max()),
          background_(bounds.background()) {}

    Accelerator accelerator() const {
        return std::holds_alternative<MajorantGrid>(held_) ? Accelerator::grid : Accelerator::kdtree;
    }
    float global_majorant() const {
        return std::visit([](const auto& held) { return held.global_majorant(); }, held_);
    }
    float global_minorant() const {
        return std::visit([](const auto& held) { return held.global_minorant(); }, held_);
    }
    std::size_t bytes() const {
        return sizeof(*this) +
               std::visit([](const auto& held) { return held.bytes() - sizeof(held); }, held_);
    }

    /// What a walk asks for, see BoxWalk.
    CellBox box_at(const std::array<int, 3>& cell) const {
        if (const auto* grid = std::get_if<MajorantGrid>(&held_))
            return grid->box_at(cell);
        return std::get_if<KdTree>(&held_)->box_at(cell);
    }
    const Bounds& background() const { return background_; }
    const std::array<int, 3>& origin() const { return origin_; }
    const std::array<int, 3>& cells() const { return cells_; }
    Vec3f support_min() const { return support_min_; }
    Vec3f support_max() const { return support_max_; }

  private:
    using Held = std::variant<MajorantGrid, KdTree>;

    Held held_;
    std::array<int, 3> origin_, cells_;
    Vec3f support_min_, support_max_;
    Bounds background_;
};

/// One test per step more than a walk through a known accelerator, and no more state.
using AnyMajorantWalk = BoxWalk<Majorants>;

}  // namespace nephele
