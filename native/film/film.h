// SPDX-License-Identifier: GPL-3.0-or-later
// The film: sums of samples per pixel for the passes that were asked for, and nothing else. Knows nothing of
// Blender.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/vsp_record.h"
#include "base/zeroed.h"
#include "film/matte.h"
#include "film/sample_parts.h"
#include "math/vec.h"
#include "passes_table.h"

namespace nephele {

/// What one path has to say about its pixel.
struct PixelSample {
    Rgb volume, surface;  ///< parts of the radiance by first event
    Rgb emission;
    Rgb transmittance{1};
    Rgb albedo, volume_albedo;
    Vec3f normal, position;         ///< world space
    Vec3f uv;                       ///< u, v, 1
    std::array<float, 4> vector{};  ///< Scene::motion_vector
    float object_index = 0, material_index = 0;
    float alpha = 1;
    float depth = 1e10f;
    float mist = 1;
    float cost = 0;
    float vsp_target = 0;      ///< probability of scattering that this sample was given; 0 where none was
    float vsp_achieved = 0;    ///< 1 where the path's first event was in a volume
    float majorant_depth = 0;  ///< integral of the majorants up to the first surface
    float work = 0;            ///< of the path, see SegmentGuiding
    VspRecord vsp;
};

/// Whether any of the passes is made of SampleParts.
bool asks_for_parts(std::span<const PassId> passes);

/// What a film keeps besides its passes.
struct FilmNeeds {
    bool error = false;    ///< squares of the light, for relative_error()
    bool weights = false;  ///< samples may stand for several
};

class Film {
  public:
    /// width, height: of the region rendered.
    Film(int width, int height, std::span<const PassId> passes, FilmNeeds needs = {});

    int width() const { return width_; }
    int height() const { return height_; }
    /// Whether the pass was asked for; the sample count always is.
    bool has(PassId pass) const { return asked_[static_cast<std::size_t>(pass)]; }

    /// Adds a sample to pixel (x, y), scaled by `exposure` where it is light. weight: of how many samples it
    /// takes the place. parts: of the same sample, where has_parts().
    void add(int x, int y, const PixelSample& sample, float exposure, std::uint32_t weight = 1,
             const SampleParts* parts = nullptr);
    /// Whether any pass is made of SampleParts.
    bool has_parts() const { return parts_; }
    /// Samples that those of the pixel stand for.
    std::uint32_t count(int x, int y) const { return counts_[index(x, y)]; }

    /// The pass as (height, width, channels) floats, first row at the bottom. Throws std::invalid_argument
    /// where it was not asked for. May be called while samples are being added: pixels are then a mix of
    /// older and newer.
    std::vector<float> read(PassId pass) const;

    /// Estimate of the image's relMSE by the spread of its samples: mean over pixels and RGB of the mean's
    /// variance / (mean^2 + 0.01), as nephele/metrics.py defines it. Pixels of fewer than two samples are
    /// left out; infinite where all are. Errs on the high side where samples are stratified, and on the low
    /// side where what is rare was not seen yet.
    double relative_error() const;

    /// Bytes of all sums and counts.
    std::size_t bytes() const;

    /// Sums by name, for checkpoints. Throws std::invalid_argument where they do not fit this film.
    std::map<std::string, std::vector<double>> save() const;
    void restore(const std::map<std::string, std::vector<double>>& saved);

  private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    const ZeroedVector<double>& sums_of(PassId pass) const { return sums_[static_cast<std::size_t>(pass)]; }
    void keep(PassId pass);
    void allocate(PassId pass, int channels);
    void add_others(std::size_t pixel, const PixelSample& sample, float exposure, double weight);
    void add_to(PassId pass, std::size_t pixel, const float* values, int channels, double weight);
    void add_parts(int x, int y, std::size_t pixel, const SampleParts& parts, float exposure, double weight);
    /// Coverage by names of this pass's kind; null where it is no cryptomatte pass.
    const MatteFilm* mattes_of(PassId pass) const;
    void add_squares(PassId pass, std::size_t pixel, Rgb light, double weight);
    /// Variance of the pixel's mean, of a channel of the pass whose squares `pass` keeps; 0 below two
    /// samples.
    double variance(PassId pass, std::size_t pixel, std::size_t channel) const;
    std::vector<float> variance(PassId pass) const;

    int width_, height_;
    std::array<bool, kPassCount> asked_{};
    bool others_ = false;  // whether anything but Combined is kept
    bool parts_ = false;
    std::array<std::unique_ptr<MatteFilm>, 3> mattes_;  // by kind of name: objects, materials, assets
    std::vector<std::uint32_t> counts_;
    // Where samples may stand for several: how many there are, and the sum of their squared weights.
    std::vector<std::uint32_t> taken_;
    std::vector<double> squared_weights_;
    ZeroedVector<double> sums_[kPassCount];  ///< channels of kPasses; variances: sums of squares, RGB
};

}  // namespace nephele
