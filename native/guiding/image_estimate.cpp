// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/image_estimate.h"

#include <algorithm>
#include <cmath>

#include "guiding/saved_rows.h"

namespace nephele {

namespace {

constexpr int kReach = 2;  // pixels
constexpr const char* kSums = "image_sums";
constexpr const char* kWorth = "image_worth";
constexpr const char* kScale = "image_scale";
constexpr const char* kRate = "image_rate";

}  // namespace

ImageEstimate::ImageEstimate(int width, int height)
    : width_(width),
      height_(height),
      sums_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      worth_(sums_.size()),
      scale_(sums_.size()),
      rate_(sums_.size(), 1.0f) {}

void ImageEstimate::add(int x, int y, float radiance, float work) {
    BranchSums& sums = sums_[index(x, y)];
    sums.weight += 1;
    sums.taken += 1;
    sums.cost += work;
    add_light(sums, radiance, radiance * radiance);
}

void ImageEstimate::update() {
    const std::vector<Pooled> pooled = pool_with_noise(width_, height_, sums_, {});
    constexpr float kNoisiest = 1e3f;  // one pixel does not decide for all
    constexpr double kDark = 0.1;      // of the squared mean; about where relMSE draws the line too
    double light = 0, work = 0, known = 0;
    for (const Pooled& p : pooled) {
        if (!(p.light > 0))
            continue;
        light += double{p.light};
        work += double{p.cost};
        known += 1;
    }
    const double mean = known > 0 ? light / known : 0;
    double noise = 0, rates = 0;
    for (std::size_t i = 0; i < scale_.size(); ++i) {
        const double l = double{pooled[i].light}, square = l * l + kDark * mean * mean;
        scale_[i] = static_cast<float>(std::sqrt(square));
        const double error = l > 0 ? double{std::min(pooled[i].noise, kNoisiest)} * (l * l / square) : 0;
        noise += error;
        rate_[i] = pooled[i].cost > 0 ? static_cast<float>(std::sqrt(error / double{pooled[i].cost})) : 0;
        rates += double{rate_[i]};
    }
    for (float& rate : rate_)
        rate = rates > 0 ? static_cast<float>(double{rate} * static_cast<double>(rate_.size()) / rates) : 1;
    spread_rates();
    const double per_work = noise > 0 && work > 0 ? std::sqrt(noise / work) : 0;
    for (std::size_t i = 0; i < worth_.size(); ++i)
        worth_[i] = pooled[i].light > 0 ? static_cast<float>(double{scale_[i]} * per_work) : 0;
}

/// Gives every pixel the highest rate around it: what the pixel filter or a smooth edge brings in now and
/// then was seen there before.
void ImageEstimate::spread_rates() {
    const std::vector<float> own = rate_;
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            float& highest = rate_[index(x, y)];
            for (int v = std::max(y - kReach, 0); v <= std::min(y + kReach, height_ - 1); ++v) {
                for (int u = std::max(x - kReach, 0); u <= std::min(x + kReach, width_ - 1); ++u)
                    highest = std::max(highest, own[index(u, v)]);
            }
        }
    }
}

void ImageEstimate::save(std::map<std::string, std::vector<double>>& saved) const {
    saved[kSums] = flattened(sums_);
    saved[kWorth] = flattened(worth_);
    saved[kScale] = flattened(scale_);
    saved[kRate] = flattened(rate_);
}

void ImageEstimate::restore(const std::map<std::string, std::vector<double>>& saved) {
    ImageEstimate read(*this);  // what is refused changes nothing
    unflatten(saved, kSums, read.sums_);
    check_rows(kSums, read.sums_, [](const BranchSums& s) { return sound(s); });
    const auto unflatten_numbers = [&](const char* name, std::vector<float>& numbers) {
        unflatten(saved, name, numbers);
        check_rows(name, numbers, [](float x) { return x >= 0 && std::isfinite(x); });
    };
    unflatten_numbers(kWorth, read.worth_);
    unflatten_numbers(kScale, read.scale_);
    unflatten_numbers(kRate, read.rate_);
    *this = std::move(read);
}

bool ImageEstimate::inherit(const std::map<std::string, std::vector<double>>& saved, float samples) {
    if (!holds(saved, kSums, sums_))
        return false;
    restore(saved);
    for (BranchSums& sums : sums_)
        sums = thinned(sums, std::min(samples / std::max(sums.taken, 1.0f), 1.0f));
    return true;
}

}  // namespace nephele
