// SPDX-License-Identifier: GPL-3.0-or-later
// From samples of both branches, volume and surface, to the guide of segments that are alike: those of a
// pixel's camera rays (vsp_buffer.h), or those that leave a region of space in about one direction.
#pragma once

#include "base/vsp_record.h"
#include "guiding/pool.h"
#include "tracking/vsp.h"

namespace nephele {

/// Sums over samples of what segments meet.
struct RayMeans {
    float samples = 0, transmittance = 0, majorant_depth = 0;
    float volume_weight = 0, surface_weight = 0;
    float depths = 0;  ///< samples that know the majorants' depth
    // Of those that were walked to their ends before the decision, by weights as they are; see VspRecord:
    float walks = 0, volume_square = 0, surface_square = 0, both = 0, extra_work = 0;
};

/// Whether means that were read from a file can be some.
bool sound(const RayMeans& means);
/// Adds a sample, or `share` of one.
void add_means(RayMeans& means, const VspRecord& record, float share = 1);
void add_means(RayMeans& means, const RayMeans& others);
/// The means as if of `share` as many samples.
RayMeans thinned(RayMeans means, float share);

/// Adds a sample to one branch's sums. weight: the branch's, taken or not; `taken`: it is the record's.
void add_branch(BranchSums& sums, float weight, bool taken, const VspRecord& record);

/// Share of the segments to walk to their ends before deciding. Walking pays where it lowers the product of
/// variance and work against plain delta tracking, which has the second moment V v^2 + T s^2, v and s being
/// root mean squares of the branches' radiances; deciding by a whole stream has (V v + T s)^2. trial: the
/// share until that is known.
float walk_share(const RayMeans& near, const Pooled& volume, const Pooled& surface, float trial);

/// The guide that both branches' estimates ask for. Without samples: delta tracking's probabilities. trial:
/// share of the segments to walk to their ends until it is known whether that pays.
VspGuide learned_guide(const Settings& settings, const RayMeans& near, const Pooled& volume,
                       const Pooled& surface, float trial);

}  // namespace nephele
