// SPDX-License-Identifier: GPL-3.0-or-later
// A medium whose coefficients a node program computes at each point.
#pragma once

#include <optional>
#include <span>

#include "grids/volume_fields.h"
#include "phase/phase_function.h"
#include "shading/program.h"
#include "shading/program_bounds.h"

namespace nephele {

/// Coefficients at a point, 1/m, and how it scatters.
struct MediumPoint {
    Rgb sigma_s, sigma_t;
    PhaseFunction phase;
};

/// Where a program is run: in the world, seen from direction wo by a ray of this kind.
struct VolumePoint {
    Vec3f p, wo;
    std::uint32_t ray_kind = kCameraRay;
    float time = 0;                              ///< of the shutter, in [0, 1]
    const Transform* rest_from_world = nullptr;  ///< at `time`, see ShadingPoint
};

/// Extinction and emission of a medium over a box, largest and smallest of any channel.
struct MediumRange {
    float sigma_t_min = 0, sigma_t_max = 0, emission_max = 0;
};

class ProgramMedium {
  public:
    /// program: validated, with one closure "medium". phase: null where the program says it. scale:
    /// multiplies sigma and emission. place: instance and mesh that the program asks of, null for the world;
    /// they, the images and their bounds must outlive this. Throws std::invalid_argument where the program
    /// has other closures.
    ProgramMedium(const Program& program, const PhaseFunction* phase, VolumeFields fields, float scale,
                  const ShadingPoint& place, const TextureContext& textures,
                  std::span<const ImageBounds> images);

    MediumPoint coefficients(const VolumePoint& at) const;
    /// W/(m^3 sr)
    Rgb emission(const VolumePoint& at) const;
    /// Bounds over the points of a box of the world, which moves as the instance does. Infinite where the
    /// program may return anything.
    MediumRange range(Vec3f lo, Vec3f hi) const;

    /// Whether it can extinguish, or emit, at all.
    bool interacts() const { return interacts_; }
    bool emits() const { return emits_; }

  private:
    ShadingPoint shading_point(const VolumePoint& at) const;
    template <class Registers>
    PhaseFunction phase_of(const Registers& registers) const;
    Rgb coefficient(const RegisterFile& registers, int input) const;

    Program extinction_, emission_;  // each without what the other alone needs
    ClosureRow row_;
    std::optional<PhaseFunction> phase_;  ///< where it is the same everywhere
    VolumeFields fields_;
    ShadingPoint place_;
    TextureContext textures_;
    std::span<const ImageBounds> images_;
    std::vector<Transform> world_from_rest_;  ///< see BoundsInput; empty where nothing moves
    float scale_;
    bool interacts_ = true, emits_ = true;
};

}  // namespace nephele
