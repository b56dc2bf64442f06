// SPDX-License-Identifier: GPL-3.0-or-later
#include "media/medium_bounds.h"

#include <stdexcept>

namespace nephele {

namespace {

/// The box that a box of index space fills in the world, and a little more: points of a ray that rounding
/// puts just outside their cell are inside of it.
void world_box(const BoundsFrame& frame, Vec3f lo, Vec3f hi, Vec3f& world_lo, Vec3f& world_hi) {
    world_lo = Vec3f(kInfinity);
    world_hi = Vec3f(-kInfinity);
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3f p = frame.world_from_index.point(
            {corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 4 ? hi.z : lo.z});
        world_lo = min(world_lo, p);
        world_hi = max(world_hi, p);
    }
    constexpr float kRelative = 4e-6f, kOfSide = 1e-3f;
    const Vec3f slack = (world_hi - world_lo) * kOfSide + max(max(world_hi, -world_lo), Vec3f(0)) * kRelative;
    world_lo = world_lo - slack;
    world_hi = world_hi + slack;
}

/// How many candidates a ray gets along the diagonal of the frame's box where emission is strongest.
constexpr float kEmissionCandidates = 16;

}  // namespace

BoundsFrame frame_of_box(Vec3f lo, Vec3f hi) {
    constexpr int kCells = 32;  // noise takes 50 us a cell
    const Vec3f size = hi - lo;
    const double step = double{max_component(size)} / (8 * kCells);
    const double world_from_index[16] = {step, 0, 0,    double{lo.x}, 0, step, 0, double{lo.y},
                                         0,    0, step, double{lo.z}, 0, 0,    0, 1};
    BoundsFrame frame{inverse_of(world_from_index), transform_of(world_from_index), {}};
    frame.box.include({0, 0, 0});
    frame.box.include({static_cast<int>(std::ceil(double{size.x} / step)),
                       static_cast<int>(std::ceil(double{size.y} / step)),
                       static_cast<int>(std::ceil(double{size.z} / step))});
    return frame;
}

std::shared_ptr<const MediumBounds> bounds_of_program(const ProgramMedium& medium, const BoundsFrame& frame,
                                                      const BoundsOptions& options) {
    const auto corner = [](const std::array<int, 3>& v) {
        return Vec3f(static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]));
    };
    Vec3f lo, hi;
    world_box(frame, corner(frame.box.min), corner(frame.box.max), lo, hi);
    const float brightest = medium.range(lo, hi).emission_max;
    const float emission_rate = kEmissionCandidates / length(hi - lo);
    const auto bounds = [&](Vec3f lo_index, Vec3f hi_index) {
        Vec3f cell_lo, cell_hi;
        world_box(frame, lo_index, hi_index, cell_lo, cell_hi);
        const MediumRange range = medium.range(cell_lo, cell_hi);
        float majorant = range.sigma_t_max;
        if (range.emission_max > 0)
            majorant += emission_rate * (brightest < kInfinity ? range.emission_max / brightest : 1);
        return Bounds{majorant, range.sigma_t_min};
    };
    const CellBounds cells = CellBounds::of_function(frame.box, Bounds{0, 0}, bounds);
    if (!(cells.global().max < kInfinity)) {
        throw std::invalid_argument(
            "its volume shader has no upper bound of its density; add a Clamp node, or a Map Range that "
            "clamps");
    }
    const float voxel = std::cbrt(std::fabs(frame.world_from_index.determinant()));
    return std::make_shared<MediumBounds>(MediumBounds{
        Majorants(cells, options.accelerator, voxel, options.minorants), frame.index_from_world});
}

}  // namespace nephele
