// SPDX-License-Identifier: GPL-3.0-or-later
// Fits a mixture of von Mises-Fisher lobes to weighted directions, batch after batch: weighted stepwise
// expectation maximisation with priors (Vorba et al. 2014, "On-line Learning of Parametric Mixture Models for
// Light Transport Simulation"; Herholz et al. 2019; Ruppert et al. 2020). Lobes that say the same are merged,
// and lobes whose directions spread more one way than the other are split.
//
// No random numbers: the same samples in the same order give the same mixture.
#pragma once

#include <span>

#include "guiding/vmf_mixture.h"

namespace nephele {

/// A direction in which light came. weight: radiance over the density of drawing it, >= 0.
struct MixtureSample {
    Vec3f wi;
    float weight = 0;
    float inverse_distance = 0;  ///< to where it came from, 1/m
};

class MixtureFit {
  public:
    /// Refits the mixture to what earlier batches left and this one. Batches without light change nothing.
    void update(VmfMixture& mixture, std::span<MixtureSample> samples);

    /// Samples that the statistics stand for.
    float samples() const { return samples_; }
    /// The statistics as if of half as many samples: for two regions that were one.
    void halve();
    /// Turns the statistics to where the mixture's lobes point now: it is seen from another place.
    void follow(const VmfMixture& mixture);

  private:
    /// Sums over samples, weighted by lobe.
    struct Sums {
        LobeValues weight{}, x{}, y{}, z{}, inverse_distance{};
    };
    void expect(const VmfMixture& mixture, std::span<const MixtureSample> samples, Sums& sums) const;
    void maximise(VmfMixture& mixture, const Sums& batch) const;
    bool merge(VmfMixture& mixture);
    bool split(VmfMixture& mixture, std::span<const MixtureSample> samples);
    void keep(const Sums& batch, float count);

    Sums sums_;
    float samples_ = 0;
};

}  // namespace nephele
