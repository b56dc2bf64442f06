// SPDX-License-Identifier: GPL-3.0-or-later
// Shading programs: straight-line code over registers of three floats, what the exporter makes of a node
// tree. addon/opcodes.py states what every operation and closure means; its enums are generated into
// opcodes_table.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/surface.h"
#include "math/transform.h"
#include "opcodes_table.h"
#include "shading/image.h"

namespace nephele {

inline constexpr std::size_t kMaxRegisters = 256;
/// Most scattering lobes that one program may mix, and those of one Principled BSDF, plastic and subsurface.
inline constexpr int kMaxLobes = 70, kPrincipledLobes = 7, kPlasticLobes = 2, kSubsurfaceLobes = 2;

/// One operation. dst, a to d are registers; `parameter` is an offset into Program::parameters.
struct Instruction {
    std::int32_t op = 0, dst = 0, a = 0, b = 0, c = 0, d = 0, parameter = 0, mode = 0;
};

/// A closure and the registers that hold its weight and its inputs; input -1: not connected (normals only).
struct ClosureRow {
    ClosureKind kind = ClosureKind::diffuse;
    std::int16_t weight = 0;
    std::int16_t mode = 0;  ///< index of Distribution for the microfacet kinds; see opcodes.py
    std::array<std::int16_t, kMaxClosureInputs> inputs{};
};

struct Program {
    std::vector<Vec3f> registers;  ///< initial values, constants among them
    std::vector<Instruction> code;
    std::vector<float> parameters;
    std::vector<ClosureRow> closures;
};

/// What textures need beyond the shading point.
struct TextureContext {
    std::span<const Image> images;
    Transform camera_from_world;  ///< the camera looks along its local -z, y up
    std::array<float, 4> viewplane{0, 1, 0,
                                   1};  ///< left, right, bottom, top (at distance 1 where perspective)
    bool orthographic = false;
    Vec3f
        origin;  ///< what programs call positions is this much further on (bindings/convert.cpp, move_origin)
    float pixel_width = 0.001f;  ///< on the viewplane
};

/// Most lobes that a closure of this kind becomes.
int lobe_count(ClosureKind kind);

/// Throws std::invalid_argument, saying which instruction or closure and why, unless every register,
/// parameter, image, operation and mode of the program exists. Files may be corrupt; a validated program runs
/// without further checks.
void validate(const Program& program, std::size_t image_count);

/// Runs a validated program. registers: room for program.registers.size() values; holds their final values
/// after.
void run(const Program& program, const ShadingPoint& point, const TextureContext& context, Vec3f* registers);

/// Final register values of a program at a point. Copies only the registers in use, and nothing where the
/// program has no code.
class RegisterFile {
  public:
    RegisterFile(const Program& program, const ShadingPoint& point, const TextureContext& context)
        : values_(program.registers.data()) {
        if (program.code.empty())
            return;
        auto* storage = reinterpret_cast<Vec3f*>(storage_);
        run(program, point, context, storage);
        values_ = storage;
    }
    RegisterFile(const RegisterFile&) = delete;
    RegisterFile& operator=(const RegisterFile&) = delete;

    Vec3f operator[](std::int16_t i) const { return values_[i]; }

  private:
    const Vec3f* values_;
    alignas(Vec3f) std::byte storage_[kMaxRegisters * sizeof(Vec3f)];  // filled by run() alone
};

/// What closures make of a register: node trees may compute infinities and NaN; such a channel counts as 0.
inline Vec3f finite(Vec3f v) {
    return {std::isfinite(v.x) ? v.x : 0, std::isfinite(v.y) ? v.y : 0, std::isfinite(v.z) ? v.z : 0};
}
/// As finite(); weights and colours of scattering are not negative either.
inline Vec3f non_negative(Vec3f v) {
    return max(finite(v), Vec3f(0));
}

}  // namespace nephele
