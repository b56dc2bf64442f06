// SPDX-License-Identifier: GPL-3.0-or-later
// A smooth estimate of the image so far, and of how noisy and how much work its samples are: what guided
// termination measures a path's branches by (Rath et al. 2022), and where more samples lower the image's
// error most.
#pragma once

#include <map>
#include <string>

#include "guiding/pool.h"

namespace nephele {

class ImageEstimate {
  public:
    ImageEstimate(int width, int height);

    /// radiance: of one sample, mean over RGB. work: of its path.
    void add(int x, int y, float radiance, float work);
    /// Learns anew from all samples so far; on all threads of the caller's arena.
    void update();
    /// What errors of the pixel's radiance are relative to: its mean radiance, where that is well below the
    /// image's a part of that, because nobody sees the noise of black.
    float scale(int x, int y) const { return scale_[index(x, y)]; }
    /// The pixel's scale times the root of (the image's relative variance / mean work of a path); 0: unknown.
    float worth(int x, int y) const { return worth_[index(x, y)]; }

    /// Of how many samples one takes the place in the passes up to the next update: a power of two, more
    /// where the image is cleaner for some pixels around. Samples in proportion to the root of (relative
    /// variance / work) lower the image's relative error most for the work.
    std::uint32_t stride(int x, int y) const {
        const float rate = rate_[index(x, y)];
        return rate >= 1 ? 1 : rate >= 0.5f ? 2 : rate >= 0.25f ? 4 : 8;
    }

    std::size_t bytes() const {
        return sums_.size() * sizeof(BranchSums) +
               (worth_.size() + scale_.size() + rate_.size()) * sizeof(float);
    }

    /// The state, for checkpoints. Throws std::invalid_argument where it does not fit.
    void save(std::map<std::string, std::vector<double>>& saved) const;
    void restore(const std::map<std::string, std::vector<double>>& saved);
    /// Starts from what another image of this size saved, as if from `samples` a pixel at most. Returns false
    /// where there is none.
    bool inherit(const std::map<std::string, std::vector<double>>& saved, float samples);

  private:
    void spread_rates();
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }

    int width_, height_;
    std::vector<BranchSums> sums_;
    std::vector<float> worth_, scale_;
    std::vector<float> rate_;  // of samples, relative to the image's mean
};

}  // namespace nephele
