// SPDX-License-Identifier: GPL-3.0-or-later
// What is known of one region of space, for vertices in volumes or for those on surfaces: the directions that
// light comes from, how segments that leave it should part between volume and surface, and what a path that
// goes on from it brings.
#pragma once

#include "base/field_sample.h"
#include "guiding/learned_guide.h"
#include "guiding/mixture_fit.h"

namespace nephele {

/// Shares of guided directions that a region chooses from (one-sample MIS).
inline constexpr std::array<float, 5> kGuidedShares = {0, 0.25f, 0.5f, 0.75f, 0.9f};

class FieldRegion {
  public:
    // What paths read.
    VmfMixture mixture;      ///< of incident radiance, as seen from the pivot
    Vec3f pivot;             ///< world space
    float guided_share = 0;  ///< of the directions that the mixture is worth drawing
    // Roots of (what a branch that goes on from here brings per unit of throughput / its work): of the second
    // moment, which a branch that is ended leaves to chance, and of the variance, which another branch
    // averages.
    float worth = 0, split_worth = 0;  ///< 0: unknown

    /// How segments that leave in direction wi should be sampled; what is not known of it is as in delta
    /// tracking.
    VspGuide vsp(Vec3f wi) const;

    /// Learns from the samples of one batch, in this order.
    void update(const Settings& settings, std::span<const FieldSample> samples);

    /// Samples that its knowledge stands for.
    float samples() const { return fit_.samples(); }
    /// Whether what it holds can be used: after it was read from a file.
    bool sound() const;
    /// Moves it to the middle of one half of itself, with half the weight for what it knows.
    void become_half(Vec3f new_pivot);

  private:
    /// Sums over the segments that leave towards one lobe.
    struct Segments {
        RayMeans rays;
        BranchSums volume, surface;
    };
    void keep(float share);
    void learn_share(std::span<const FieldSample> samples);
    void learn_worth(std::span<const FieldSample> samples);
    bool few_bring_all() const;
    void learn_segments(const Settings& settings, std::span<const FieldSample> samples);

    MixtureFit fit_;
    std::array<Segments, kMostLobes> segments_{};
    std::array<VspGuide, kMostLobes> guides_{};
    std::array<float, kGuidedShares.size()> moments_{};    // of a vertex's contribution, for each share
    float light_ = 0, square_ = 0, cost_ = 0, count_ = 0;  // of what branches bring, single ones bounded
    float all_light_ = 0, all_square_ = 0;                 // the same, not bounded
};

}  // namespace nephele
