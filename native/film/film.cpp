// SPDX-License-Identifier: GPL-3.0-or-later
#include "film/film.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
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
    return pass == PassId::depth || pass == PassId::position || pass == PassId::vector ||
           pass == PassId::object_index || pass == PassId::material_index;
}

/// Light of a SampleParts that a pass holds; a colour divides it in the end, so that the product is the
/// light.
struct LightPass {
    PassId pass;
    Rgb (SampleParts::*parts)[4];
    SampleParts::Event event;
    PassId color;  // the pass itself: none
};
constexpr LightPass kLightPasses[] = {
    {PassId::diffuse_direct, &SampleParts::direct, SampleParts::diffuse, PassId::diffuse_color},
    {PassId::diffuse_indirect, &SampleParts::indirect, SampleParts::diffuse, PassId::diffuse_color},
    {PassId::glossy_direct, &SampleParts::direct, SampleParts::glossy, PassId::glossy_color},
    {PassId::glossy_indirect, &SampleParts::indirect, SampleParts::glossy, PassId::glossy_color},
    {PassId::transmission_direct, &SampleParts::direct, SampleParts::transmission,
     PassId::transmission_color},
    {PassId::transmission_indirect, &SampleParts::indirect, SampleParts::transmission,
     PassId::transmission_color},
    {PassId::volume_direct, &SampleParts::direct, SampleParts::volume, PassId::volume_direct},
    {PassId::volume_indirect, &SampleParts::indirect, SampleParts::volume, PassId::volume_indirect},
};
constexpr std::pair<PassId, SampleParts::Event> kColorPasses[] = {
    {PassId::diffuse_color, SampleParts::diffuse},
    {PassId::glossy_color, SampleParts::glossy},
    {PassId::transmission_color, SampleParts::transmission},
};

/// The pass that `pass` is divided by; itself where it is not.
constexpr PassId color_of(PassId pass) {
    for (const LightPass& row : kLightPasses) {
        if (row.pass == pass)
            return row.color;
    }
    return pass;
}

/// First passes of the three kinds of names, by kind.
constexpr PassId kMattePasses[] = {PassId::cryptoobject00, PassId::cryptomaterial00, PassId::cryptoasset00};
constexpr int kMatteLevels = 8;
constexpr const char* kMatteNames[] = {"mattes of objects", "mattes of materials", "mattes of assets"};

/// (kind, level) of a cryptomatte pass.
constexpr std::optional<std::pair<std::size_t, int>> matte_of(PassId pass) {
    for (std::size_t kind = 0; kind < 3; ++kind) {
        const int level = static_cast<int>(pass) - static_cast<int>(kMattePasses[kind]);
        if (level >= 0 && level < kMatteLevels)
            return std::pair(kind, level);
    }
    return std::nullopt;
}

constexpr bool is_of_parts(PassId pass) {
    const auto holds = [&](const auto& rows, const auto& pass_of) {
        return std::any_of(std::begin(rows), std::end(rows),
                           [&](const auto& r) { return pass_of(r) == pass; });
    };
    return holds(kLightPasses, [](const LightPass& r) { return r.pass; }) ||
           holds(kColorPasses, [](const auto& r) { return r.first; }) || pass == PassId::environment ||
           pass == PassId::denoising_albedo || pass == PassId::denoising_normal ||
           pass == PassId::denoising_depth || matte_of(pass);
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

bool asks_for_parts(std::span<const PassId> passes) {
    return std::any_of(passes.begin(), passes.end(), is_of_parts);
}

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
    if (pass == PassId::noisy_image)
        return keep(PassId::combined);
    others_ |= pass != PassId::combined;
    parts_ |= is_of_parts(pass);
    if (const auto matte = matte_of(pass)) {
        if (!mattes_[matte->first])
            mattes_[matte->first] = std::make_unique<MatteFilm>(width_, height_);
        return;
    }
    if (!sums_of(pass).empty())
        return;
    allocate(pass, is_variance(pass) ? 3 : kPasses[at(pass)].channels);
    for (const PassId other : {variance_of(pass), color_of(pass)}) {
        if (sums_of(other).empty())
            allocate(other, kPasses[at(other)].channels);
    }
}

const MatteFilm* Film::mattes_of(PassId pass) const {
    const auto matte = matte_of(pass);
    return matte ? mattes_[matte->first].get() : nullptr;
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

void Film::add(int x, int y, const PixelSample& sample, float exposure, std::uint32_t weight,
               const SampleParts* parts) {
    const std::size_t pixel = index(x, y);
    const double w = weight;
    const Rgb light = sample.volume * exposure + sample.surface * exposure;
    const float combined[4] = {light.x, light.y, light.z, sample.alpha};
    add_to(PassId::combined, pixel, combined, 4, w);
    if (compiled::passes && others_)
        add_others(pixel, sample, exposure, w);
    if (compiled::passes && parts_ && parts)
        add_parts(x, y, pixel, *parts, exposure, w);
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
    add_to(PassId::mist, pixel, &sample.mist, 1, w);
    add_to(PassId::uv, pixel, &sample.uv.x, 3, w);
    if (counts_[pixel] == 0) {
        add_to(PassId::depth, pixel, &sample.depth, 1, 1);
        add_to(PassId::position, pixel, &sample.position.x, 3, 1);
        add_to(PassId::vector, pixel, sample.vector.data(), 4, 1);
        add_to(PassId::object_index, pixel, &sample.object_index, 1, 1);
        add_to(PassId::material_index, pixel, &sample.material_index, 1, 1);
    }
    add_squares(PassId::variance, pixel, light, w);
    add_squares(PassId::volume_variance, pixel, volume, w);
    add_squares(PassId::surface_variance, pixel, surface, w);
}

/// Adds to the passes that are made of SampleParts.
void Film::add_parts(int x, int y, std::size_t pixel, const SampleParts& parts, float exposure, double w) {
    for (const LightPass& row : kLightPasses) {
        const Rgb light = (parts.*row.parts)[row.event] * exposure;
        add_to(row.pass, pixel, &light.x, 3, w);
    }
    for (const auto& [pass, event] : kColorPasses)
        add_to(pass, pixel, &parts.color[event].x, 3, w);
    const Rgb environment = parts.environment * exposure;
    add_to(PassId::environment, pixel, &environment.x, 3, w);
    add_to(PassId::denoising_albedo, pixel, &parts.feature_albedo.x, 3, w);
    add_to(PassId::denoising_normal, pixel, &parts.feature_normal.x, 3, w);
    add_to(PassId::denoising_depth, pixel, &parts.feature_depth, 1, w);
    for (const Matte& matte : parts.mattes) {
        const std::uint32_t ids[] = {matte.object, matte.material, matte.asset};
        for (std::size_t kind = 0; kind < 3; ++kind) {
            if (mattes_[kind])
                mattes_[kind]->add(x, y, ids[kind], w * double{matte.weight});
        }
    }
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
    if (pass == PassId::noisy_image)
        pass = PassId::combined;  // which others denoise
    if (const auto matte = matte_of(pass)) {
        std::vector<std::uint32_t> counts(counts_.size());
        std::transform(counts_.begin(), counts_.end(), counts.begin(), seen<std::uint32_t>);
        return mattes_[matte->first]->read(matte->second, counts);
    }
    const auto channels = static_cast<std::size_t>(info.channels);
    const ZeroedVector<double>& sums = sums_of(pass);
    const ZeroedVector<double>* colors = color_of(pass) == pass ? nullptr : &sums_of(color_of(pass));
    std::vector<float> out(sums.size());
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        const std::uint32_t count = seen(counts_[i]);
        for (std::size_t c = 0; c < channels; ++c) {
            const std::size_t at = channels * i + c;
            const double n = colors                    ? seen((*colors)[at])
                             : first_sample_only(pass) ? std::min(count, 1u)
                                                       : count;
            out[at] = n > 0 ? static_cast<float>(seen(sums[at]) / n) : 0.0f;
        }
    }
    return out;
}

std::size_t Film::bytes() const {
    std::size_t bytes = (counts_.size() + taken_.size()) * sizeof(std::uint32_t);
    for (const auto& sums : sums_)
        bytes += sums.size() * sizeof(double);
    for (const auto& mattes : mattes_)
        bytes += mattes ? mattes->bytes() : 0;
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
    for (std::size_t kind = 0; kind < mattes_.size(); ++kind) {
        const std::string name = kMatteNames[kind];
        if (mattes_[kind])
            mattes_[kind]->save(saved[name], saved[name + ", ids"], saved[name + ", weights"]);
    }
    return saved;
}

void Film::restore(const std::map<std::string, std::vector<double>>& saved) {
    const auto mine = save();
    for (const auto& [name, values] : mine) {
        const auto found = saved.find(name);
        const bool of_any_size = name.starts_with("mattes of") && name.find(',') != std::string::npos;
        if (found == saved.end() || (found->second.size() != values.size() && !of_any_size)) {
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
    for (std::size_t kind = 0; kind < mattes_.size(); ++kind) {
        const std::string name = kMatteNames[kind];
        if (mattes_[kind])
            mattes_[kind]->restore(saved.at(name), saved.at(name + ", ids"), saved.at(name + ", weights"));
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
