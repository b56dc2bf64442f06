// SPDX-License-Identifier: GPL-3.0-or-later
// What a path tells beyond its radiance where passes ask for it: its light by the first event and by the
// number of events, the colours of what it saw, mattes, and features for denoisers. Kernels without `parts`
// leave it alone.
#pragma once

#include <cstdint>
#include <vector>

#include "math/vec.h"

namespace nephele {

/// Share of a sample that a surface covers. Ids: see film/matte.h.
struct Matte {
    std::uint32_t object = 0, asset = 0, material = 0;
    float weight = 0;
};

struct SampleParts {
    /// The first event, as Cycles tells light apart: translucency counts as diffuse, what glass reflects as
    /// glossy.
    enum Event { diffuse, glossy, transmission, volume };

    Rgb direct[4], indirect[4];  ///< light after that event alone, and after more; by Event
    Rgb color[3];                ///< albedo of surfaces that the camera sees, by Event
    Rgb environment;             ///< background that the camera sees
    Rgb feature_albedo;
    Vec3f feature_normal;  ///< camera space, z along the view axis
    float feature_depth = 0;
    std::vector<Matte> mattes;

    void clear() {
        std::vector<Matte> kept = std::move(mattes);
        kept.clear();
        *this = {};
        mattes = std::move(kept);
    }
    /// Scales all light.
    void scale_light(float by) {
        for (int i = 0; i < 4; ++i) {
            direct[i] *= by;
            indirect[i] *= by;
        }
        environment *= by;
    }
};

}  // namespace nephele
