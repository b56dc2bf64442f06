// SPDX-License-Identifier: GPL-3.0-or-later
// Guiding of directions at one vertex: a share of them is drawn from the light that the field knows to come
// there, the rest from the BSDF or phase function (one-sample MIS; Vorba et al. 2014, Mueller 2019). The
// share is learned per region (guiding/field_region.h).
#pragma once

#include "guiding/field.h"
#include "phase/phase_function.h"

namespace nephele {

class DirectionGuide {
  public:
    /// Guides nothing.
    DirectionGuide() = default;
    /// share: of the directions that are the field's, below 1; none at 0 or less.
    DirectionGuide(const FieldRegion& region, Vec3f p, float share) : share_(share) {
        if (share_ > 0)
            mixture_ = region.mixture.seen_from(p - region.pivot);
    }

    bool active() const { return share_ > 0; }
    float share() const { return share_; }

    /// Multiplies the light by a phase function, where a lobe stands for it: for what arrives along
    /// `forward`.
    void fold_in(const PhaseFunction& phase, Vec3f forward) {
        constexpr float kNearlyIsotropic = 0.05f;
        if (!active() || phase.kind != PhaseKind::henyey_greenstein || std::abs(phase.p0) < kNearlyIsotropic)
            return;
        const VmfLobe lobe = vmf_of_henyey_greenstein(phase.p0, forward);
        mixture_ = mixture_.times(lobe).mixture;
    }

    Vec3f sample(float choice, Vec2f u) const { return mixture_.sample(choice, u); }
    /// Density with which the field alone draws wi, or -1 where it guides nothing.
    float pdf(Vec3f wi) const { return active() ? mixture_.pdf(wi) : -1; }
    /// Density of both ways together. scatter_pdf: of the BSDF or phase function.
    float mixed(float scatter_pdf, float guide_pdf) const {
        return active() ? (1 - share_) * scatter_pdf + share_ * guide_pdf : scatter_pdf;
    }
    float mixed(float scatter_pdf, Vec3f wi) const { return mixed(scatter_pdf, pdf(wi)); }

  private:
    float share_ = 0;
    VmfMixture mixture_;
};

/// The same where nothing is ever guided.
class NoDirectionGuide {
  public:
    static constexpr bool active() { return false; }
    static constexpr float share() { return 0; }
    void fold_in(const PhaseFunction&, Vec3f) {}
    static Vec3f sample(float, Vec2f) { return {}; }
    static constexpr float pdf(Vec3f) { return -1; }
    static constexpr float mixed(float scatter_pdf, float) { return scatter_pdf; }
    static constexpr float mixed(float scatter_pdf, Vec3f) { return scatter_pdf; }
};

}  // namespace nephele
