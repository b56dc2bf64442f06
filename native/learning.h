// SPDX-License-Identifier: GPL-3.0-or-later
// What a render learns from its own samples, and when: at powers of two of the samples per pixel, without a
// pre-pass. Between two updates everything learned stands still, so that all threads read it without locks,
// and what a sample is guided by does not depend on the sample.
#pragma once

#include <optional>

#include "guiding/image_estimate.h"
#include "guiding/vsp_buffer.h"
#include "integrators/integrator.h"

namespace nephele {

/// Whether pixels take fewer samples where the image is clean.
inline bool adapts(const Settings& settings) {
    return compiled::adaptive_sampling && settings.adaptive_sampling && settings.target_error > 0;
}

class Learning {
  public:
    /// width, height: of the region rendered.
    Learning(const Scene& scene, const Settings& settings, int width, int height);

    /// Whether anything is learned.
    bool active() const { return guides_.has_value() || image_.has_value(); }
    const GuidingField* field() const { return field_ ? &*field_ : nullptr; }
    /// What the field is used for, once that is decided.
    std::optional<Techniques> chosen() const;
    /// Bytes held at present.
    std::size_t bytes() const;

    /// Fills in what samples of a pixel are guided by; `guide` is storage for it.
    void guide_pixel(int x, int y, SampleRequest& request, VspGuide& guide) const;
    /// Fills in whether the path teaches the field. path: its number among all paths of the frame.
    void ask(std::uint64_t path, SampleRequest& request) const;
    /// Of how many samples one of the pixel takes the place up to the next update.
    std::uint32_t stride(int x, int y) const;
    /// Takes note of a sample; each pixel from one thread at a time.
    void add(int x, int y, const PixelSample& sample, int set, Workspace& ws);
    /// Takes over what a thread's paths taught; from one thread at a time.
    void collect(Workspace& ws);

    /// Learns from all samples so far, if `samples` per pixel are a power of two at which it has not yet. On
    /// all threads of the caller's arena. Returns whether it learned.
    bool update(int samples);

    /// The state, for checkpoints. Throws std::invalid_argument where it does not fit.
    void save(std::map<std::string, std::vector<double>>& saved) const;
    void restore(const std::map<std::string, std::vector<double>>& saved);

    /// What another render of this scene or of the next frame may start from.
    std::map<std::string, std::vector<double>> knowledge() const;
    /// Starts from it, before the first sample. What pixels know counts as a few samples, and only where the
    /// image has the same size. Returns what was taken over, in words. Throws std::invalid_argument where
    /// nothing fits.
    std::string inherit(const std::map<std::string, std::vector<double>>& knowledge);

  private:
    bool retired() const;
    void judge(int x, int y, float radiance, float work, int set, Workspace& ws);
    void end_round(bool last);

    Settings settings_;
    int width_;
    std::optional<VspBuffer> guides_;
    std::optional<GuidingField> field_;
    std::optional<ImageEstimate> image_;
    std::vector<FieldSample> lessons_;
    TechniqueChoice choice_;
    Trial trial_{};
    std::vector<PathPair> pairs_;  // of each pixel, while techniques are on trial
    double asked_share_ = 1;       // of the paths that teach the field
    int learned_at_ = 0;           // samples per pixel when it learned last
};

/// Whether the samples of a scene can gain by a field, and in words why not.
struct FieldDecision {
    bool trains = false;
    std::string reason;
};
FieldDecision decide_field(const Scene& scene, const Settings& settings);

/// Whether a render learns anything at all.
bool learns(const Scene& scene, const Settings& settings);

/// Number of the epoch of a pixel's sample: the samples between two updates.
inline std::uint32_t epoch_of(std::uint32_t sample) {
    return static_cast<std::uint32_t>(std::bit_width(sample));
}

}  // namespace nephele
