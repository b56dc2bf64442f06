// SPDX-License-Identifier: GPL-3.0-or-later
// What a kernel of the path tracer can do. Kernels are templates over it: what a scene does not hold is not
// in the code that renders it. choose_kernel (integrators/path.cpp) says for which sets there is one.
#pragma once

#include "compiled/adaptive_sampling.h"
#include "compiled/chromatic.h"
#include "compiled/field.h"
#include "compiled/media.h"
#include "compiled/overlap.h"
#include "compiled/passes.h"
#include "compiled/volume_emission.h"
#include "compiled/volume_programs.h"
#include "compiled/vsp.h"

namespace nephele {

struct KernelTraits {
    bool media = compiled::media;               ///< any; without them the next four mean nothing
    bool overlap = compiled::overlap;           ///< else one medium: a ray's intervals follow each other
    bool emission = compiled::volume_emission;  ///< of media
    bool programs = compiled::volume_programs;  ///< compute coefficients of media
    bool chromatic = compiled::chromatic;       ///< else extinction is the same in all channels
    bool learning = true;                       ///< paths keep what they teach, and may be guided
    bool parts = compiled::passes;              ///< paths tell their light apart: film/sample_parts.h

    bool operator==(const KernelTraits&) const = default;
};

/// Everything that is compiled in.
inline constexpr KernelTraits kEverything{};

constexpr KernelTraits with_learning(KernelTraits k) {
    k.learning = compiled::vsp || compiled::field || compiled::adaptive_sampling;
    return k;
}

/// For code that knows nothing of parts: there shall be one of it, not two.
constexpr KernelTraits without_parts(KernelTraits k) {
    k.parts = false;
    return k;
}

}  // namespace nephele
