// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/vsp_buffer.h"

#include <cstring>
#include <stdexcept>

#include <tbb/parallel_for.h>

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

void add_to(BranchSums& sums, float weight, bool taken, const VspRecord& record) {
    sums.weight += weight;
    if (!taken)
        return;
    sums.taken += 1;
    sums.cost += record.cost;
    if (weight > 0) {
        // What the sun's disc leaves must not overflow in sums of squares, of which a NaN would spread.
        constexpr float kLargest = 1e15f;
        const float light = std::min(record.light, kLargest);
        const float square = std::min(record.light * record.light * record.probability / weight, kLargest);
        sums.light += light;
        sums.light2 += light * light;
        sums.square += square;
        sums.square2 += square * square;
    }
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
    add_to(pixel.volume, record.volume_weight, record.scattered, record);
    add_to(pixel.surface, record.surface_weight, !record.scattered, record);
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
        guides_[i] = learned(around(x, y), volume[i], surface[i]);
    }
}

/// Sums of the pixel and its neighbours: enough for the weights, which vary less from sample to sample than
/// light does.
VspBuffer::Pixel VspBuffer::around(int x, int y) const {
    Pixel sum;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u) {
            const Pixel& p = pixels_[index(u, v)];
            sum.volume.weight += p.volume.weight;
            sum.surface.weight += p.surface.weight;
            sum.samples += p.samples;
            sum.transmittance += p.transmittance;
            sum.majorant_depth += p.majorant_depth;
        }
    }
    return sum;
}

VspGuide VspBuffer::learned(const Pixel& near, const Pooled& volume, const Pooled& surface) const {
    VspGuide guide;
    if (!(near.samples > 0))
        return guide;
    guide.transmittance = near.transmittance / near.samples;
    guide.majorant_depth = near.majorant_depth / near.samples;
    guide.surface_noise = surface.noise;
    constexpr float kLargest = 1e30f;  // per tiny weights
    float v = std::min(volume.light, kLargest), s = std::min(surface.light, kLargest);
    if (settings_.vsp_criterion == Settings::VspCriterion::variance) {
        v *= std::sqrt(1 + std::min(volume.noise, 1e6f));
        s *= std::sqrt(1 + std::min(surface.noise, 1e6f));
    }
    if (settings_.vsp_cost && volume.cost > 0 && surface.cost > 0) {
        // The least variance times time: sqrt(M / c).
        v /= std::sqrt(volume.cost);
        s /= std::sqrt(surface.cost);
    }
    // What too few samples stand for is taken to be as the other branch: so paths part by transmittance, as
    // in delta tracking, until both are known.
    const float known_v = std::lerp(s, v, volume.known), known_s = std::lerp(v, s, surface.known);
    v = known_v;
    s = known_s;
    if (!(v + s > 0))
        return guide;  // black so far
    // What was not seen yet may be there all the same.
    constexpr float kFloor = 0.02f;
    const float least = kFloor * std::max(v, s);
    guide.volume_radiance = std::max(v, least) / (v + s);
    guide.surface_radiance = std::max(s, least) / (v + s);
    const float towards_volume = guide.volume_radiance * near.volume.weight;
    const float towards_surface = guide.surface_radiance * near.surface.weight;
    if (towards_volume + towards_surface > 0) {
        guide.target =
            std::clamp(towards_volume / (towards_volume + towards_surface), kLowestVsp, kHighestVsp);
    }
    return guide;
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
