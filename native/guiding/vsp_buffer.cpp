// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/vsp_buffer.h"

#include "base/parallel.h"
#include "guiding/saved_rows.h"
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
    add_means(pixel.rays, record);
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
        log_distance.push_back(p.rays.samples > 0 ? p.log_distance / p.rays.samples : 0);
    }
    const auto of_volume = pool_with_noise(width_, height_, std::move(volume), {});
    const auto of_surface = pool_with_noise(width_, height_, std::move(surface), log_distance);
    parallel_for(0, height_, [&](int y) { learn_row(y, of_volume, of_surface); });
}

void VspBuffer::learn_row(int y, std::span<const Pooled> volume, std::span<const Pooled> surface) {
    for (int x = 0; x < width_; ++x) {
        const std::size_t i = index(x, y);
        guides_[i] = learned_guide(settings_, around(x, y), volume[i], surface[i], 1);
    }
}

/// Sums of the pixel and its neighbours: enough for the weights, which vary less from sample to sample than
/// light does.
RayMeans VspBuffer::around(int x, int y) const {
    RayMeans sum;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u) {
            add_means(sum, pixels_[index(u, v)].rays);
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
    std::vector<VspGuide> guides(guides_.size());
    unflatten(saved, kGuides, guides);
    check_rows(kGuides, guides, [](const VspGuide& g) { return sound(g); });
    ZeroedVector<Pixel> pixels(pixels_.size());
    if (!pixels.empty())
        unflatten(saved, kSums, pixels);
    check_rows(kSums, pixels, [](const Pixel& p) {
        return sound(p.volume) && sound(p.surface) && sound(p.rays) && std::isfinite(p.log_distance);
    });
    guides_ = std::move(guides);
    pixels_ = std::move(pixels);
}

bool VspBuffer::inherit(const std::map<std::string, std::vector<double>>& saved, float samples) {
    if (pixels_.empty() || !holds(saved, kSums, pixels_) || !holds(saved, kGuides, guides_))
        return false;
    restore(saved);
    for (Pixel& p : pixels_) {
        const float share = std::min(samples / std::max(p.rays.samples, 1.0f), 1.0f);
        p.volume = thinned(p.volume, share);
        p.surface = thinned(p.surface, share);
        p.rays = thinned(p.rays, share);
        p.log_distance *= share;
    }
    return true;
}

}  // namespace nephele
