// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/field_region.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "guiding/bounded.h"

namespace nephele {

namespace {

constexpr float kTrial = 0.25f;          // share of segments that are resampled until it is known to pay
constexpr float kLongestMemory = 16384;  // earlier samples that count, at most

/// What a vertex brings along wi per unit of throughput.
float contribution(const FieldSample& s) {
    return s.scattering * s.light / s.pdf;
}

/// Contributions squared, none of which stands for more than a fiftieth of them all.
std::vector<float> bounded_squares(std::span<const FieldSample> samples) {
    std::vector<float> squares;
    squares.reserve(samples.size());
    for (const FieldSample& s : samples) {
        const float c = std::min(contribution(s), 1e9f);
        squares.push_back(c * c);
    }
    bound_shares(squares);
    return squares;
}

/// A lobe's estimate of one branch; what its samples do not stand for is the region's.
Pooled estimate(const BranchSums& lobe, const BranchSums& region) {
    const Pooled near = pooled_alone(lobe), wide = pooled_alone(region);
    const auto mix = [&](float a, float b) { return near.known * a + (1 - near.known) * b; };
    return {mix(near.light, wide.light), mix(near.cost, wide.cost), mix(1, wide.known),
            mix(near.noise, wide.noise)};
}

void add_to(BranchSums& sum, const BranchSums& one, float share) {
    const BranchSums part = thinned(one, share);
    sum.weight += part.weight;
    sum.light += part.light;
    sum.light2 += part.light2;
    sum.square += part.square;
    sum.square2 += part.square2;
    sum.cost += part.cost;
    sum.taken += part.taken;
}

}  // namespace

VspGuide FieldRegion::vsp(Vec3f wi) const {
    if (!(fit_.samples() > 0))
        return {};  // there are no lobes yet
    const LobeValues gamma = mixture.responsibilities(wi);
    VspGuide out{0, 0, 0, 0, 0, 0, 0};
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        out.volume_radiance += gamma[k] * guides_[k].volume_radiance;
        out.surface_radiance += gamma[k] * guides_[k].surface_radiance;
        out.target += gamma[k] * guides_[k].target;
        out.transmittance += gamma[k] * guides_[k].transmittance;
        out.majorant_depth += gamma[k] * guides_[k].majorant_depth;
        out.surface_noise += gamma[k] * guides_[k].surface_noise;
        out.walk_share += gamma[k] * guides_[k].walk_share;
    }
    return out;
}

void FieldRegion::update(const Settings& settings, std::span<const FieldSample> samples) {
    if (samples.empty())
        return;
    if (count_ > kLongestMemory)
        keep(kLongestMemory / count_);
    learn_share(samples);  // by the mixture that drew them
    learn_worth(samples);
    // What has not been seen yet may come from where the lobes are not: half of the directions look for it.
    if (few_bring_all())
        guided_share = std::min(guided_share, 0.5f);
    std::vector<MixtureSample> directions;
    directions.reserve(samples.size());
    constexpr float kNearest = 1e-12f;  // m
    for (const FieldSample& s : samples) {
        // As seen from the pivot: light that comes from far away comes the same way there.
        const bool near = s.distance < kInfinity;
        const Vec3f seen = near ? s.p + s.wi * s.distance - pivot : s.wi;
        const float length_seen = near ? length(seen) : 1;
        if (!(length_seen > 0))
            continue;
        directions.push_back(
            {seen / length_seen, s.light / s.pdf, near ? 1 / std::max(length_seen, kNearest) : 0});
    }
    fit_.update(mixture, directions);
    if (!(fit_.samples() > 0))
        guided_share = 0;  // all was black: there are no lobes to draw from
    learn_segments(settings, samples);
}

/// Lets what it knows count as `share` of the samples.
void FieldRegion::keep(float share) {
    for (Segments& s : segments_) {
        s.rays = thinned(s.rays, share);
        s.volume = thinned(s.volume, share);
        s.surface = thinned(s.surface, share);
    }
    for (float& m : moments_)
        m *= share;
    light_ *= share;
    all_light_ *= share;
    all_square_ *= share;
    square_ *= share;
    cost_ *= share;
    count_ *= share;
}

/// The second moment that each share of guided directions would have had.
void FieldRegion::learn_share(std::span<const FieldSample> samples) {
    constexpr float kFirst = 0.5f;  // until samples say more
    constexpr float kLargestMoment = 1e30f;
    constexpr float kWorthIts = 1.04f;  // the least gain that guiding has to bring: it takes time
    if (fit_.samples() > 0) {
        const std::vector<float> squares = bounded_squares(samples);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const FieldSample& s = samples[i];
            if (!(s.scatter_pdf > 0) || squares[i] == 0)
                continue;
            const float guide = s.guide_pdf >= 0 ? s.guide_pdf : mixture.seen_from(s.p - pivot).pdf(s.wi);
            for (std::size_t k = 0; k < moments_.size(); ++k) {
                const float pdf = (1 - kGuidedShares[k]) * s.scatter_pdf + kGuidedShares[k] * guide;
                moments_[k] += std::min(squares[i] * s.pdf / pdf, kLargestMoment);
            }
        }
    }
    guided_share = kFirst;
    if (!(moments_[0] > 0))
        return;
    std::size_t best = 0;
    for (std::size_t k = 1; k < moments_.size(); ++k) {
        if (moments_[k] * kWorthIts < moments_[0] && moments_[k] < moments_[best])
            best = k;
    }
    guided_share = kGuidedShares[best];
}

void FieldRegion::learn_worth(std::span<const FieldSample> samples) {
    for (const float square : bounded_squares(samples)) {
        square_ += square;
        light_ += std::sqrt(square);
    }
    for (const FieldSample& s : samples) {
        const float c = std::min(contribution(s), 1e9f);
        all_light_ += c;
        all_square_ += c * c;
        cost_ += s.cost;
    }
    count_ += static_cast<float>(samples.size());
    // Paths that were ended where much has not been seen yet would leave it to ever fewer.
    const bool known = cost_ > 0 && !few_bring_all();
    worth = known ? std::sqrt(square_ / cost_) : 0;
    split_worth = known ? std::sqrt(std::max(square_ - light_ * light_ / count_, 0.0f) / cost_) : 0;
}

/// Whether a few of the samples hold nearly all of the light: then most of what there is was not seen yet.
bool FieldRegion::few_bring_all() const {
    constexpr float kEnough = 64;
    return !(all_square_ > 0) || all_light_ * (all_light_ / all_square_) < kEnough;
}

void FieldRegion::learn_segments(const Settings& settings, std::span<const FieldSample> samples) {
    for (const FieldSample& s : samples) {
        if (!s.vsp.known)
            continue;
        BranchSums volume, surface;
        add_branch(volume, s.vsp.volume_weight, s.vsp.scattered, s.vsp);
        add_branch(surface, s.vsp.surface_weight, !s.vsp.scattered, s.vsp);
        const LobeValues gamma = mixture.responsibilities(s.wi);
        for (std::size_t k = 0; k < kMostLobes; ++k) {
            if (gamma[k] < 0.01f)
                continue;
            add_means(segments_[k].rays, s.vsp, gamma[k]);
            add_to(segments_[k].volume, volume, gamma[k]);
            add_to(segments_[k].surface, surface, gamma[k]);
        }
    }
    Segments all;
    for (const Segments& s : segments_) {
        add_to(all.volume, s.volume, 1);
        add_to(all.surface, s.surface, 1);
    }
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        const Segments& s = segments_[k];
        guides_[k] = learned_guide(settings, s.rays, estimate(s.volume, all.volume),
                                   estimate(s.surface, all.surface), kTrial);
    }
}

bool FieldRegion::sound() const {
    // All members are floats.
    std::array<float, sizeof(FieldRegion) / sizeof(float)> values;
    static_assert(sizeof(values) == sizeof(FieldRegion) && std::is_trivially_copyable_v<FieldRegion>);
    std::memcpy(values.data(), static_cast<const void*>(this), sizeof(values));
    const bool finite = std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
    const auto between = [](const LobeValues& v, float low, float high) {
        return std::all_of(v.begin(), v.end(), [&](float x) { return x >= low && x <= high; });
    };
    const bool sums = std::all_of(segments_.begin(), segments_.end(), [](const Segments& s) {
        return nephele::sound(s.rays) && nephele::sound(s.volume) && nephele::sound(s.surface);
    });
    const bool guides =
        std::all_of(guides_.begin(), guides_.end(), [](const VspGuide& g) { return nephele::sound(g); });
    float total = 0;
    for (const float w : mixture.weight)
        total += w;
    const bool empty = total == 0 && samples() == 0;
    return finite && sums && guides && (empty || std::abs(total - 1) < 1e-3f) &&
           between(mixture.weight, 0, 1.001f) && between(mixture.kappa, 0, kLargestKappa) &&
           between(mixture.peak, 0, kLargestKappa) && between(mixture.inverse_distance, 0, 1e30f) &&
           guided_share >= 0 && guided_share < 1 && worth >= 0 && split_worth >= 0;
}

void FieldRegion::become_half(Vec3f new_pivot) {
    mixture = mixture.seen_from(new_pivot - pivot);
    pivot = new_pivot;
    fit_.halve();
    fit_.follow(mixture);
    keep(0.5f);
}

}  // namespace nephele
