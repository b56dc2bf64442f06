// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/vsp_buffer.h"

#include <cstring>
#include <stdexcept>

#include <tbb/parallel_for.h>

#include "guiding/learned_guide.h"
#include "math/sampler.h"

namespace nephele {

namespace {

constexpr const char* kSums = "vsp_sums";
constexpr const char* kGuides = "vsp_guides";

/// The guide that wants the probability `target` whatever was learned.
VspGuide guide_to(float target) {
    VspGuide guide;
    guide.target = target;
    guide.volume_radiance = target;
    guide.surface_radiance = 1 - target;
    return guide;
}

float fixed_target(Settings::VspTarget kind, std::size_t pixel) {
    switch (kind) {
        case Settings::VspTarget::lowest:
            return kLowestVsp;
        case Settings::VspTarget::highest:
            return kHighestVsp;
        case Settings::VspTarget::random:
            return std::clamp(Rng(pixel).next(), kLowestVsp, kHighestVsp);
        case Settings::VspTarget::learned:
            break;
    }
    return 0.5f;
}

/// Rows of floats as the doubles of a checkpoint, and back.
template <class Row>
std::vector<double> flattened(const std::vector<Row>& rows) {
    std::vector<float> values(rows.size() * sizeof(Row) / sizeof(float));
    std::memcpy(values.data(), rows.data(), rows.size() * sizeof(Row));
    return {values.begin(), values.end()};
}
template <class Row>
void unflatten(const std::map<std::string, std::vector<double>>& saved, const char* name,
               std::vector<Row>& rows) {
    const auto found = saved.find(name);
    const std::size_t size = rows.size() * sizeof(Row) / sizeof(float);
    if (found == saved.end() || found->second.size() != size) {
        throw std::invalid_argument(std::string("the checkpoint does not fit this render ('") + name +
                                    "' is missing or of another size); render with the settings it was "
                                    "made with");
    }
    const std::vector<float> values(found->second.begin(), found->second.end());
    std::memcpy(static_cast<void*>(rows.data()), values.data(), size * sizeof(float));
}

}  // namespace

VspBuffer::VspBuffer(int width, int height, const Settings& settings)
    : width_(width), height_(height), settings_(settings) {
    const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    guides_.resize(size);
    if (settings.vsp_target == Settings::VspTarget::learned) {
        pixels_.resize(size);
    } else {
        for (std::size_t i = 0; i < size; ++i)
            guides_[i] = guide_to(fixed_target(settings.vsp_target, i));
    }
}

void VspBuffer::add(int x, int y, const VspRecord& record) {
    if (pixels_.empty() || !record.known)
        return;
    Pixel& pixel = pixels_[index(x, y)];
    add_branch(pixel.volume, record.volume_weight, record.scattered, record);
    add_branch(pixel.surface, record.surface_weight, !record.scattered, record);
    pixel.samples += 1;
    pixel.transmittance += record.transmittance;
    pixel.majorant_depth += std::min(record.majorant_depth, 1e6f);
    pixel.log_distance += std::log(std::clamp(record.distance, 1e-10f, 1e10f));
}

void VspBuffer::update() {
    if (pixels_.empty())
        return;
    std::vector<BranchSums> volume, surface;
    std::vector<float> log_distance;
    for (const Pixel& p : pixels_) {
        volume.push_back(p.volume);
        surface.push_back(p.surface);
        log_distance.push_back(p.samples > 0 ? p.log_distance / p.samples : 0);
    }
    const auto of_volume = estimate(std::move(volume), {});
    const auto of_surface = estimate(std::move(surface), log_distance);
    tbb::parallel_for(0, height_, [&](int y) { learn_row(y, of_volume, of_surface); });
}

/// Radiance of a branch and its noise. Squares are pooled relative to the pixel's mean: as they are, the
/// brightest pixels around would outweigh all others.
std::vector<Pooled> VspBuffer::estimate(std::vector<BranchSums> sums, std::span<const float> feature) const {
    std::vector<Pooled> out = pool(width_, height_, sums, feature);
    for (std::size_t i = 0; i < sums.size(); ++i) {
        // In doubles: the fourth power of a dim radiance is no float.
        const double mean2 = double{out[i].light} * double{out[i].light};
        const auto relative = [&](float sum, double unit) {
            return unit > 0 ? static_cast<float>(std::min(double{sum} / unit, 1e30)) : 0;
        };
        sums[i].light = relative(sums[i].square, mean2);
        sums[i].light2 = relative(sums[i].square2, mean2 * mean2);
    }
    const std::vector<Pooled> noise = pool(width_, height_, std::move(sums), feature);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i].noise = std::max(noise[i].light - 1, 0.0f);
    return out;
}

void VspBuffer::learn_row(int y, std::span<const Pooled> volume, std::span<const Pooled> surface) {
    for (int x = 0; x < width_; ++x) {
        const std::size_t i = index(x, y);
        guides_[i] = learned_guide(settings_, around(x, y), volume[i], surface[i]);
    }
}

/// Sums of the pixel and its neighbours: enough for the weights, which vary less from sample to sample than
/// light does.
RayMeans VspBuffer::around(int x, int y) const {
    RayMeans sum;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u) {
            const Pixel& p = pixels_[index(u, v)];
            sum.volume_weight += p.volume.weight;
            sum.surface_weight += p.surface.weight;
            sum.samples += p.samples;
            sum.transmittance += p.transmittance;
            sum.majorant_depth += p.majorant_depth;
        }
    }
    return sum;
}

VspGuide VspBuffer::guide(int x, int y) const {
    return guides_[index(x, y)];
}

void VspBuffer::save(std::map<std::string, std::vector<double>>& saved) const {
    saved[kGuides] = flattened(guides_);
    if (!pixels_.empty())
        saved[kSums] = flattened(pixels_);
}

void VspBuffer::restore(const std::map<std::string, std::vector<double>>& saved) {
    unflatten(saved, kGuides, guides_);
    if (!pixels_.empty())
        unflatten(saved, kSums, pixels_);
}

}  // namespace nephele
