// SPDX-License-Identifier: GPL-3.0-or-later
// What the pixels learn about the volume scattering probability of their camera rays (Xu et al., SIGGRAPH
// Asia 2024, section 4), in image space, while rendering.
//
// Each sample leaves, for the branch its path took, an unbiased sample of that branch's radiance per unit of
// weight or of its square, whatever probability P it was taken with then: a contribution C = F / P has
// C P [taken] / W and C^2 P [taken] / W in expectation E[F] / W and E[F^2] / W. From time to time the sums
// are filtered over the image, and every pixel gets a new VspGuide.
//
// Radiances per unit of weight, not probabilities, are what is filtered: they change slowly across the edges
// of a cloud, whose shape is in the weights that each ray finds for itself.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "base/zeroed.h"
#include "guiding/learned_guide.h"

namespace nephele {

class VspBuffer {
  public:
    /// Nothing is learned, and no memory held, where the settings do not ask for it.
    VspBuffer(int width, int height, const Settings& settings);

    void add(int x, int y, const VspRecord& record);
    /// Learns anew from all samples so far; on all threads of the caller's arena.
    void update();
    VspGuide guide(int x, int y) const;

    std::size_t bytes() const { return pixels_.size() * sizeof(Pixel) + guides_.size() * sizeof(VspGuide); }

    /// The state, for checkpoints. Throws std::invalid_argument where it does not fit.
    void save(std::map<std::string, std::vector<double>>& saved) const;
    void restore(const std::map<std::string, std::vector<double>>& saved);
    /// Starts from what another image of this size saved, as if from `samples` a pixel at most. Returns false
    /// where there is none.
    bool inherit(const std::map<std::string, std::vector<double>>& saved, float samples);

  private:
    struct Pixel {
        BranchSums volume, surface;
        RayMeans rays;
        float log_distance = 0;
    };
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    void learn_row(int y, std::span<const Pooled> volume, std::span<const Pooled> surface);
    RayMeans around(int x, int y) const;

    int width_, height_;
    Settings settings_;
    ZeroedVector<Pixel> pixels_;
    std::vector<VspGuide> guides_;
};

}  // namespace nephele
