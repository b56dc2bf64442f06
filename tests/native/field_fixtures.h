// SPDX-License-Identifier: GPL-3.0-or-later
// Samples that a guiding field may learn from, of light that is known.
#pragma once

#include "base/field_sample.h"
#include "guiding/vmf_mixture.h"
#include "math/sampler.h"
#include "math/warp.h"

namespace nephele::test {

/// A sample of light from far away, at a vertex whose phase function is isotropic.
inline FieldSample isotropic_sample(Vec3f p, Vec3f wi, float light) {
    FieldSample s;
    s.p = p;
    s.wi = wi;
    s.pdf = s.scatter_pdf = s.scattering = kInv4Pi;
    s.light = light;
    s.cost = 10;
    return s;
}

/// A record of a segment, half of which is the volume's; each branch brings so much per unit of weight.
inline VspRecord record_of(float volume, float surface, Rng& rng) {
    VspRecord r;
    r.known = r.walked = true;
    r.scattered = rng.next() < 0.5f;
    r.probability = 0.5f;
    r.volume_weight = r.surface_weight = 0.5f;
    r.light = r.scattered ? volume : surface;  // times the weight, divided by the probability
    r.cost = 10;
    r.transmittance = 0.5f;
    r.majorant_depth = 1;
    return r;
}

}  // namespace nephele::test
