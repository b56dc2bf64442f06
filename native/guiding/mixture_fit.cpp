// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/mixture_fit.h"

#include "guiding/bounded.h"

namespace nephele {

namespace {

constexpr float kLongestMemory = 16384;  // earlier samples that count, at most
constexpr float kWeightPrior = 1;        // samples that every lobe is sure of
constexpr float kCosinePrior = 1.5f;     // samples of any direction that every lobe has seen besides
constexpr float kLargestMeanCosine = 0.9999f;
constexpr float kAlike = 0.97f;       // cosine of two lobes' densities from which they are one
constexpr float kLopsided = 3;        // ratio of the principal variances from which a lobe is two
constexpr float kEnoughToSplit = 64;  // samples
constexpr int kFirstSteps = 8, kLaterSteps = 2;

/// Lobes at the corners of a cube.
VmfMixture spread() {
    VmfMixture out;
    constexpr float kCorner = 0.577350269f, kKappa = 3;
    for (int k = 0; k < kMostLobes; ++k) {
        const Vec3f corner((k & 1) ? kCorner : -kCorner, (k & 2) ? kCorner : -kCorner,
                           (k & 4) ? kCorner : -kCorner);
        out.set(k, 1.0f / kMostLobes, {corner, kKappa}, 0);
    }
    return out;
}

/// Bounds single weights, and scales them so that their mean is 1. Returns false where there is no light.
bool tame(std::span<MixtureSample> samples) {
    std::vector<float> weights;
    weights.reserve(samples.size());
    for (const MixtureSample& s : samples)
        weights.push_back(is_finite(s.wi) ? s.weight : 0);
    const double sum = bound_shares(weights);
    if (!(sum > 0))
        return false;
    const double mean = sum / static_cast<double>(samples.size());  // may be too little for a float
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i].weight = static_cast<float>(double{weights[i]} / mean);
    return true;
}

/// Integral over the sphere of the product of two lobes.
float overlap(const VmfLobe& a, const VmfLobe& b) {
    const Vec3f v = a.mu * a.kappa + b.mu * b.kappa;
    const float product = length(v);
    const float exponent = 2 * a.kappa * b.kappa * vmf_cosine_less_one(a.mu, b.mu) /
                           std::max(product + a.kappa + b.kappa, 1e-30f);
    return vmf_peak(a.kappa) * vmf_peak(b.kappa) / vmf_peak(product) * std::exp(exponent);
}

}  // namespace

void MixtureFit::update(VmfMixture& mixture, std::span<MixtureSample> samples) {
    if (samples.empty() || !tame(samples))
        return;
    const bool first = samples_ == 0;
    if (first)
        mixture = spread();
    const auto count = static_cast<float>(samples.size());
    Sums batch;
    for (int i = first ? kFirstSteps : kLaterSteps; i > 0; --i) {
        expect(mixture, samples, batch);
        maximise(mixture, batch);
    }
    keep(batch, count);
    while (merge(mixture)) {
    }
    split(mixture, samples);
}

void MixtureFit::expect(const VmfMixture& mixture, std::span<const MixtureSample> samples, Sums& sums) const {
    sums = {};
    for (const MixtureSample& s : samples) {
        if (s.weight == 0)
            continue;
        const LobeValues gamma = mixture.responsibilities(s.wi);
        for (std::size_t k = 0; k < kMostLobes; ++k) {
            const float w = gamma[k] * s.weight;
            sums.weight[k] += w;
            sums.x[k] += w * s.wi.x;
            sums.y[k] += w * s.wi.y;
            sums.z[k] += w * s.wi.z;
            sums.inverse_distance[k] += w * s.inverse_distance;
        }
    }
}

void MixtureFit::maximise(VmfMixture& mixture, const Sums& batch) const {
    const float old = std::min(1.0f, samples_ > 0 ? kLongestMemory / samples_ : 0);
    float total = 0;
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        if (mixture.weight[k] == 0)
            continue;
        const float weight = old * sums_.weight[k] + batch.weight[k];
        const Vec3f sum(old * sums_.x[k] + batch.x[k], old * sums_.y[k] + batch.y[k],
                        old * sums_.z[k] + batch.z[k]);
        const float towards = length(sum);
        const float mean_cosine = std::min(towards / (weight + kCosinePrior), kLargestMeanCosine);
        const Vec3f mu = towards > 0 ? sum / towards : mixture.mu(static_cast<int>(k));
        const float distance = old * sums_.inverse_distance[k] + batch.inverse_distance[k];
        mixture.set(static_cast<int>(k), weight + kWeightPrior, {mu, vmf_kappa(mean_cosine)},
                    weight > 0 ? distance / weight : 0);
        total += weight + kWeightPrior;
    }
    for (float& w : mixture.weight)
        w /= total;
}

void MixtureFit::keep(const Sums& batch, float count) {
    const float old = std::min(1.0f, samples_ > 0 ? kLongestMemory / samples_ : 0);
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        sums_.weight[k] = old * sums_.weight[k] + batch.weight[k];
        sums_.x[k] = old * sums_.x[k] + batch.x[k];
        sums_.y[k] = old * sums_.y[k] + batch.y[k];
        sums_.z[k] = old * sums_.z[k] + batch.z[k];
        sums_.inverse_distance[k] = old * sums_.inverse_distance[k] + batch.inverse_distance[k];
    }
    samples_ = old * samples_ + count;
}

/// Makes one of the two lobes that are most alike, if they are; returns whether they were.
bool MixtureFit::merge(VmfMixture& mixture) {
    int a = -1, b = -1;
    float most = kAlike;
    for (int i = 0; i < kMostLobes; ++i) {
        for (int j = i + 1; j < kMostLobes; ++j) {
            const auto at = [&](int k) {
                return VmfLobe{mixture.mu(k), mixture.kappa[static_cast<std::size_t>(k)]};
            };
            if (mixture.weight[static_cast<std::size_t>(i)] == 0 ||
                mixture.weight[static_cast<std::size_t>(j)] == 0)
                continue;
            const float alike =
                overlap(at(i), at(j)) / std::sqrt(overlap(at(i), at(i)) * overlap(at(j), at(j)));
            if (alike > most) {
                most = alike;
                a = i;
                b = j;
            }
        }
    }
    if (a < 0)
        return false;
    const auto k = static_cast<std::size_t>(a), gone = static_cast<std::size_t>(b);
    for (LobeValues* values : {&sums_.weight, &sums_.x, &sums_.y, &sums_.z, &sums_.inverse_distance}) {
        (*values)[k] += (*values)[gone];
        (*values)[gone] = 0;
    }
    mixture.weight[k] += mixture.weight[gone];
    mixture.weight[gone] = 0;
    const Vec3f sum(sums_.x[k], sums_.y[k], sums_.z[k]);
    const float towards = length(sum);
    if (towards > 0) {
        const float mean_cosine = std::min(towards / (sums_.weight[k] + kCosinePrior), kLargestMeanCosine);
        mixture.set(a, mixture.weight[k], {sum / towards, vmf_kappa(mean_cosine)},
                    sums_.inverse_distance[k] / std::max(sums_.weight[k], 1e-30f));
    }
    return true;
}

/// Parts the lobe that is most lopsided for its weight, where a lobe is free; returns whether one was.
bool MixtureFit::split(VmfMixture& mixture, std::span<const MixtureSample> samples) {
    std::size_t free = kMostLobes;
    for (std::size_t k = 0; k < kMostLobes; ++k)
        free = mixture.weight[k] == 0 && free == kMostLobes ? k : free;
    if (free == kMostLobes)
        return false;
    // Second moments of the directions in each lobe's tangent plane.
    LobeValues xx{}, xy{}, yy{}, weight{};
    std::array<Frame, kMostLobes> frames{Frame(mixture.mu(0)), Frame(mixture.mu(1)), Frame(mixture.mu(2)),
                                         Frame(mixture.mu(3)), Frame(mixture.mu(4)), Frame(mixture.mu(5)),
                                         Frame(mixture.mu(6)), Frame(mixture.mu(7))};
    for (const MixtureSample& s : samples) {
        if (s.weight == 0)
            continue;
        const LobeValues gamma = mixture.responsibilities(s.wi);
        for (std::size_t k = 0; k < kMostLobes; ++k) {
            const Vec3f local = frames[k].to_local(s.wi);
            const float w = gamma[k] * s.weight;
            weight[k] += w;
            xx[k] += w * local.x * local.x;
            xy[k] += w * local.x * local.y;
            yy[k] += w * local.y * local.y;
        }
    }
    std::size_t chosen = kMostLobes;
    float worst = 0, axis_angle = 0, spread_out = 0;
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        if (weight[k] < kEnoughToSplit)
            continue;
        const float mean_of_both = (xx[k] + yy[k]) / 2, difference = (xx[k] - yy[k]) / 2;
        const float root = std::sqrt(difference * difference + xy[k] * xy[k]);
        const float large = mean_of_both + root, small = std::max(mean_of_both - root, 1e-6f * mean_of_both);
        if (large > kLopsided * small && large > worst) {
            worst = large;
            chosen = k;
            axis_angle = 0.5f * std::atan2(2 * xy[k], xx[k] - yy[k]);
            spread_out = std::sqrt(large / weight[k]);
        }
    }
    if (chosen == kMostLobes)
        return false;
    const Frame& frame = frames[chosen];
    const Vec3f axis = frame.x * std::cos(axis_angle) + frame.y * std::sin(axis_angle);
    const float step = 0.8f * spread_out;
    for (LobeValues* values : {&sums_.weight, &sums_.x, &sums_.y, &sums_.z, &sums_.inverse_distance}) {
        (*values)[chosen] /= 2;
        (*values)[free] = (*values)[chosen];
    }
    const float half = mixture.weight[chosen] / 2, kappa = std::min(2 * mixture.kappa[chosen], 1e4f);
    const float inverse_distance = mixture.inverse_distance[chosen];
    const Vec3f mu = frame.z;
    mixture.set(static_cast<int>(chosen), half, {normalize(mu + axis * step), kappa}, inverse_distance);
    mixture.set(static_cast<int>(free), half, {normalize(mu - axis * step), kappa}, inverse_distance);
    follow(mixture);  // or the next step would put both where one was
    return true;
}

void MixtureFit::follow(const VmfMixture& mixture) {
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        const float towards = length(Vec3f(sums_.x[k], sums_.y[k], sums_.z[k]));
        const Vec3f mu = mixture.mu(static_cast<int>(k));
        sums_.x[k] = mu.x * towards;
        sums_.y[k] = mu.y * towards;
        sums_.z[k] = mu.z * towards;
    }
}

void MixtureFit::halve() {
    for (LobeValues* values : {&sums_.weight, &sums_.x, &sums_.y, &sums_.z, &sums_.inverse_distance}) {
        for (float& v : *values)
            v /= 2;
    }
    samples_ /= 2;
}

}  // namespace nephele
