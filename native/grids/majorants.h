// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "grids/majorant_grid.h"
namespace nephele {
enum class Accelerator { grid, kdtree };
class Majorants {
  public:
    Majorants(const CellBounds& b, Accelerator, float s, bool m) : grid_(b, s, m) {}
    float global_majorant() const { return grid_.global_majorant(); }
    float global_minorant() const { return grid_.global_minorant(); }
    const MajorantGrid& grid() const { return grid_; }
    MajorantGrid grid_;
};
struct AnyMajorantWalk : MajorantWalk {
    AnyMajorantWalk(const Majorants& m, Vec3f o, Vec3f d, float a, float b) : MajorantWalk(m.grid(), o, d, a, b) {}
};
}
