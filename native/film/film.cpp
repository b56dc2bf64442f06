// SPDX-License-Identifier: GPL-3.0-or-later
#include "film/film.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "compiled/adaptive_sampling.h"
#include "compiled/passes.h"

namespace nephele {

namespace {

constexpr std::size_t at(PassId pass) {
    return static_cast<std::size_t>(pass);
}

/// Passes that describe the first sample alone: an average over a silhouette would be a depth where nothing
/// is.
constexpr bool first_sample_only(PassId pass) {
    return pass == PassId::depth || pass == PassId::mist;
}

/// The pass whose variance `pass` is; `pass` itself where it is no variance.
constexpr PassId variance_of(PassId pass) {
    switch (pass) {
        case PassId::variance:
            return PassId::combined;
        case PassId::volume_variance:
            return PassId::volume;
        case PassId::surface_variance:
            return PassId::surface;
        default:
            return pass;
    }
}

constexpr bool is_variance(PassId pass) {
    return variance_of(pass) != pass;
}

// One thread at a time changes a pixel while others may read it: a number is old or new, never torn.
template <class T>
T seen(const T& number) {
    return std::atomic_ref<T>(const_cast<T&>(number)).load(std::memory_order_relaxed);
}
template <class T>
void increase(T& number, T by) {
    std::atomic_ref<T>(number).store(number + by, std::memory_order_relaxed);
}

/// Counts of samples as a checkpoint has them.
std::vector<std::uint32_t> whole_numbers(const std::map<std::string, std::vector<double>>& saved,
                                         const char* name) {
    constexpr double kMost = std::numeric_limits<int>::max();
    std::vector<std::uint32_t> counts;
    for (const double n : saved.at(name)) {
        if (!(n >= 0 && n <= kMost && n == std::floor(n)))
            throw std::invalid_argument(std::string("the checkpoint is damaged ('") + name +
                                        "'); render without it");
        counts.push_back(static_cast<std::uint32_t>(n));
    }
    return counts;
}

}  // namespace

Film::Film(int width, int height, std::span<const PassId> passes, FilmNeeds needs)
    : width_(width), height_(height) {
    if (width <= 0 || height <= 0) {
        throw std::invalid_argument("the render is " + std::to_string(width) + " x " +
                                    std::to_string(height) + " pixels; set a resolution of at least 1 x 1");
    }
    counts_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
    asked_[at(PassId::sample_count)] = true;
    for (const PassId pass : passes) {
        asked_[at(pass)] = true;
        keep(pass);
    }
    if (needs.error)
        keep(PassId::variance);
    if (needs.weights) {
        taken_.assign(counts_.size(), 0);
        squared_weights_.assign(counts_.size(), 0);
    }
}

/// Allocates what a pass is made of.
void Film::keep(PassId pass) {
    if (pass == PassId::sample_count || (!compiled::passes && pass != PassId::combined))
        return;
    others_ |= pass != PassId::combined;
    allocate(pass, is_variance(pass) ? 3 : kPasses[at(pass)].channels);
    if (const PassId mean = variance_of(pass); sums_of(mean).empty())
        allocate(mean, kPasses[at(mean)].channels);
}

void Film::allocate(PassId pass, int channels) {
    sums_[at(pass)].resize(counts_.size() * static_cast<std::size_t>(channels));
}

void Film::add_to(PassId pass, std::size_t pixel, const float* values, int channels, double weight) {
    ZeroedVector<double>& sums = sums_[at(pass)];
    if (sums.empty())
        return;
    double* out = sums.data() + pixel * static_cast<std::size_t>(channels);
    for (int c = 0; c < channels; ++c)
        increase(out[c], weight * static_cast<double>(values[c]));
}

void Film::add(int x, int y, const PixelSample& sample, float exposure, std::uint32_t weight) {
    const std::size_t pixel = index(x, y);
    const double w = weight;
    const Rgb light = sample.volume * exposure + sample.surface * exposure;
    const float combined[4] = {light.x, light.y, light.z, sample.alpha};
    add_to(PassId::combined, pixel, combined, 4, w);
    if (compiled::passes && others_)
        add_others(pixel, sample, exposure, w);
    increase(counts_[pixel], weight);
    if (compiled::adaptive_sampling && !taken_.empty()) {
        increase(taken_[pixel], 1u);
        increase(squared_weights_[pixel], w * w);
    }
}

/// Adds to all passes but Combined.
void Film::add_others(std::size_t pixel, const PixelSample& sample, float exposure, double w) {
    const Rgb volume = sample.volume * exposure, surface = sample.surface * exposure,
              emission = sample.emission * exposure;
    const Rgb light = volume + surface;
    add_to(PassId::volume, pixel, &volume.x, 3, w);
    add_to(PassId::surface, pixel, &surface.x, 3, w);
    add_to(PassId::emission, pixel, &emission.x, 3, w);
    add_to(PassId::transmittance, pixel, &sample.transmittance.x, 3, w);
    add_to(PassId::albedo, pixel, &sample.albedo.x, 3, w);
    add_to(PassId::volume_albedo, pixel, &sample.volume_albedo.x, 3, w);
    add_to(PassId::normal, pixel, &sample.normal.x, 3, w);
    add_to(PassId::vsp_target, pixel, &sample.vsp_target, 1, w);
    add_to(PassId::vsp_achieved, pixel, &sample.vsp_achieved, 1, w);
    add_to(PassId::majorant_optical_depth, pixel, &sample.majorant_depth, 1, w);
    add_to(PassId::cost, pixel, &sample.cost, 1, w);
    if (counts_[pixel] == 0) {
        add_to(PassId::depth, pixel, &sample.depth, 1, 1);
        add_to(PassId::mist, pixel, &sample.mist, 1, 1);
    }
    add_squares(PassId::variance, pixel, light, w);
    add_squares(PassId::volume_variance, pixel, volume, w);
    add_squares(PassId::surface_variance, pixel, surface, w);
}

void Film::add_squares(PassId pass, std::size_t pixel, Rgb light, double weight) {
    if (sums_of(pass).empty())
        return;
    double* squares = sums_[at(pass)].data() + 3 * pixel;
    for (int c = 0; c < 3; ++c)
        increase(squares[c], weight * (static_cast<double>(light[c]) * static_cast<double>(light[c])));
}

double Film::variance(PassId pass, std::size_t pixel, std::size_t channel) const {
    const PassId mean_pass = variance_of(pass);
    const auto stride = static_cast<std::size_t>(kPasses[at(mean_pass)].channels);
    const double n = seen(counts_[pixel]);
    const double mean = seen(sums_of(mean_pass)[stride * pixel + channel]) / n;
    const double spread = std::max(0.0, seen(sums_of(pass)[3 * pixel + channel]) / n - mean * mean);
    if (taken_.empty())
        return n > 1 ? spread / (n - 1) : 0;
    // Sum of the squared shares: 1 / n of equal weights. Of the spread about the mean, that much is missing.
    const double shares = seen(squared_weights_[pixel]) / (n * n);
    // Where a sample is just being added, its parts may not fit each other yet.
    return seen(taken_[pixel]) > 1 && shares < 1 ? spread * shares / (1 - shares) : 0;
}

std::vector<float> Film::variance(PassId pass) const {
    std::vector<float> out(counts_.size());
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        if (seen(counts_[i]) > 0)
            out[i] =
                static_cast<float>((variance(pass, i, 0) + variance(pass, i, 1) + variance(pass, i, 2)) / 3);
    }
    return out;
}

double Film::relative_error() const {
    if (sums_of(PassId::variance).empty())
        throw std::logic_error("this film keeps nothing to tell its error by");
    constexpr double kEpsilon = 0.01;
    const auto stride = static_cast<std::size_t>(kPasses[at(PassId::combined)].channels);
    const ZeroedVector<double>& sums = sums_of(PassId::combined);
    double error = 0, known = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        if ((taken_.empty() ? counts_[i] : taken_[i]) < 2)
            continue;
        for (std::size_t c = 0; c < 3; ++c) {
            const double mean = sums[stride * i + c] / counts_[i];
            error += variance(PassId::variance, i, c) / (mean * mean + kEpsilon);
        }
        known += 3;
    }
    return known > 0 ? error / known : std::numeric_limits<double>::infinity();
}

std::vector<float> Film::read(PassId pass) const {
    const PassInfo& info = kPasses[at(pass)];
    if (pass == PassId::sample_count) {
        const std::vector<std::uint32_t>& samples = taken_.empty() ? counts_ : taken_;
        std::vector<float> out(samples.size());
        std::transform(samples.begin(), samples.end(), out.begin(),
                       [](const std::uint32_t& n) { return static_cast<float>(seen(n)); });
        return out;
    }
    if (!has(pass)) {
        throw std::invalid_argument(std::string("the pass '") + info.name +
                                    "' was not asked for; add it to the film's passes");
    }
    if (is_variance(pass))
        return variance(pass);
    const auto channels = static_cast<std::size_t>(info.channels);
    const ZeroedVector<double>& sums = sums_of(pass);
    std::vector<float> out(sums.size());
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        const std::uint32_t count = seen(counts_[i]);
        const double n = first_sample_only(pass) ? std::min(count, 1u) : count;
        for (std::size_t c = 0; c < channels; ++c) {
            out[channels * i + c] = n > 0 ? static_cast<float>(seen(sums[channels * i + c]) / n) : 0.0f;
        }
    }
    return out;
}

std::size_t Film::bytes() const {
    std::size_t bytes = (counts_.size() + taken_.size()) * sizeof(std::uint32_t);
    for (const auto& sums : sums_)
        bytes += sums.size() * sizeof(double);
    return bytes + squared_weights_.size() * sizeof(double);
}

std::map<std::string, std::vector<double>> Film::save() const {
    std::map<std::string, std::vector<double>> saved;
    saved["sample_count"].assign(counts_.begin(), counts_.end());
    if (!taken_.empty()) {
        saved["samples_taken"].assign(taken_.begin(), taken_.end());
        saved["squared_weights"] = squared_weights_;
    }
    for (int p = 0; p < kPassCount; ++p) {
        if (!sums_[p].empty())
            saved[kPasses[p].identifier].assign(sums_[p].begin(), sums_[p].end());
    }
    return saved;
}

void Film::restore(const std::map<std::string, std::vector<double>>& saved) {
    const auto mine = save();
    for (const auto& [name, values] : mine) {
        const auto found = saved.find(name);
        if (found == saved.end() || found->second.size() != values.size()) {
            throw std::invalid_argument(
                "the checkpoint does not fit this render (pass '" + name +
                "' is missing or of another size); render with the settings it was made with");
        }
    }
    std::vector<std::uint32_t> counts = whole_numbers(saved, "sample_count"), taken;
    if (!taken_.empty()) {
        taken = whole_numbers(saved, "samples_taken");
        squared_weights_ = saved.at("squared_weights");
    }
    counts_ = std::move(counts);
    taken_ = std::move(taken);
    for (int p = 0; p < kPassCount; ++p) {
        if (sums_[p].empty())
            continue;
        const std::vector<double>& values = saved.at(kPasses[p].identifier);
        std::copy(values.begin(), values.end(), sums_[p].begin());
    }
}

}  // namespace nephele
