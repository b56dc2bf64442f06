// SPDX-License-Identifier: GPL-3.0-or-later
// Colour arithmetic of Blender's nodes: HSV, HSL, blend modes, blackbody. Colours are scene-linear Rec. 709.
#pragma once

#include "math/vec.h"
#include "opcodes_table.h"

namespace nephele {

/// Hue, saturation and value or lightness; hue in [0, 1).
Vec3f hsv_from_rgb(Rgb c);
Rgb rgb_from_hsv(Vec3f hsv);
Vec3f hsl_from_rgb(Rgb c);
Rgb rgb_from_hsl(Vec3f hsl);

/// b blended over a by t, as Blender's Mix Color has it (no clamping of t or of the result).
Rgb blend(BlendMode mode, Rgb a, Rgb b, float t);

/// a with its hue turned by hue - 0.5 and saturation and value scaled, mixed with a by t.
Rgb adjust_hue_saturation(Rgb a, float hue, float saturation, float value, float t);

/// Colour of a blackbody at `kelvin` with luminance 1; channels outside the gamut are cut to 0. Planck's law
/// over the CIE 1931 observer. Tabulated, and constant below 800 K and above 12000 K as in Blender.
Rgb blackbody_color(float kelvin);

}  // namespace nephele
