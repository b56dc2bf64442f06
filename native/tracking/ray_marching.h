// SPDX-License-Identifier: GPL-3.0-or-later
// Unbiased ray marching (Kettunen, d'Eon, Pantaleoni, Novak, SIGGRAPH 2021): transmittance from the power
// series of the exponential, in independent ray-marched estimates X_i of minus the optical depth.
//
// Expanded about one of them, the pivot, exp(-tau) = exp(X_j) sum_k (-tau - X_j)^k / k!. A power's unbiased
// estimate is the mean of the products of k of the others' differences to the pivot: an elementary symmetric
// mean. All estimates take turns as pivot. Russian roulette ends the series: nine times in ten after its
// first term, where the estimate is plain ray marching; the rare longer ones carry the correction.
//
// The marched part is what exceeds the minorants; its points are stratified by the residual majorant, so that
// empty and constant stretches cost nothing, however long they are.
#pragma once

#include "tracking/residual_ratio.h"

namespace nephele {

namespace detail {

/// What is known of an interval without a lookup, and estimates of the rest.
class March {
  public:
    explicit March(const MajorantTrack& track) : start_(track), unit_max_(max_component(track.unit())) {
        for_each_piece([&](const MajorantTrack& piece, float t0, float rate) {
            const double length = double{piece.piece_end()} - double{t0};
            control_ += double{piece.minorant()} * length;
            residual_ += double{rate} * length;
            return true;
        });
    }

    /// Integral of the minorant: times unit() it is a part of the optical depth.
    double control() const { return control_; }
    /// Integral of what the majorant exceeds the minorant by, in the channel where that is most.
    double residual() const { return residual_; }

    /// How many points an estimate takes (their equation 28): with them, few of the higher terms matter.
    int tuple_size() const {
        const double r = residual_;
        return std::max(1, static_cast<int>(std::ceil(std::cbrt((0.015 + r) * (0.65 + r) * (60.3 + r)))));
    }

    /// Minus the residual optical depth, estimated at n evenly spaced points of the residual majorant.
    Rgb estimate(int n, Rng& rng, Counters& counters) const {
        const double step = residual_ / n, offset = double{rng.next()};
        double from = 0;  // the residual majorant's integral up to the piece
        int j = 0;
        Rgb sum;
        for_each_piece([&](const MajorantTrack& piece, float t0, float rate) {
            const double to = from + double{rate} * (double{piece.piece_end()} - double{t0});
            for (double at = step * (offset + j); j < n && at < to; at = step * (offset + ++j)) {
                const float t = t0 + static_cast<float>((at - from) / double{rate});
                const Rgb scale = piece.scale(std::min(t, piece.piece_end()), rng, counters);
                sum += max(scale - Rgb(piece.minorant()), Rgb(0)) * piece.unit() / rate;
            }
            from = to;
            return j < n;
        });
        return sum * static_cast<float>(-step);
    }

  private:
    /// visit(track, t0, rate) for the pieces from start to end, as long as it returns true.
    template <class Visit>
    void for_each_piece(Visit&& visit) const {
        MajorantTrack track = start_;
        for (float t = track.interval().t0; track.advance(); t = track.piece_end()) {
            if (!visit(track, t, unit_max_ * (track.scale_majorant() - track.minorant())))
                return;
        }
    }

    MajorantTrack start_;
    float unit_max_;
    double control_ = 0, residual_ = 0;
};

/// Longest series: the weight of a term beyond it is below any float.
inline constexpr int kMaxTerms = 32;

/// How many terms beyond the first are taken: 0, or 2 and more. go_on(k): probability that term k + 1
/// follows.
inline constexpr float kFirstTermOnly = 0.9f;
inline float go_on(int k) {
    return std::min(1.0f, 2.0f / static_cast<float>(k + 1));
}
inline int series_length(Rng& rng) {
    if (rng.next() < kFirstTermOnly)
        return 0;
    int terms = 2;
    while (terms < kMaxTerms && rng.next() < go_on(terms))
        ++terms;
    return terms;
}

/// Mean over pivots of the truncated series; x: terms + 1 estimates.
inline double power_series(const double* x, int terms) {
    double sum = 0;
    for (int pivot = 0; pivot <= terms; ++pivot) {
        double e[kMaxTerms + 1] = {1};  // elementary symmetric sums of the differences
        int taken = 0;
        for (int i = 0; i <= terms; ++i) {
            if (i == pivot)
                continue;
            ++taken;
            for (int k = taken; k > 0; --k)
                e[k] += e[k - 1] * (x[i] - x[pivot]);
        }
        // weight: 1 over the chance to get to term k; share: 1 / (k! binomial(terms, k)).
        double series = 1, weight = 1 / (1 - double{kFirstTermOnly}), share = 1;
        for (int k = 1; k <= terms; ++k) {
            share /= terms - k + 1;
            if (k > 2)
                weight /= double{go_on(k - 1)};
            series += weight * share * e[k];
        }
        sum += std::exp(x[pivot]) * series;
    }
    return sum / (terms + 1);
}

}  // namespace detail

/// Unbiased estimate of exp(-integral of sigma_t) over the track's interval.
inline Rgb ray_marching_transmittance(const MajorantTrack& track, Rng& rng, Counters& counters) {
    // The cost of marching grows with the optical depth; that of tracking with roulette does not.
    constexpr double kDeepest = 60;
    const detail::March march(track);
    if (march.residual() > kDeepest)
        return residual_ratio_transmittance(track, rng, counters);
    const Rgb control = track.unit() * static_cast<float>(-march.control());
    if (march.residual() == 0)
        return exp(control);
    const int terms = detail::series_length(rng), n = march.tuple_size();
    if (terms == 0)
        return exp(control + march.estimate(n, rng, counters));
    double x[3][detail::kMaxTerms + 1];
    for (int i = 0; i <= terms; ++i) {
        const Rgb estimate = march.estimate(n, rng, counters);
        for (int c = 0; c < 3; ++c)
            x[c][i] = double{estimate[c]};
    }
    Rgb T = exp(control);
    for (int c = 0; c < 3; ++c)
        T[c] *= static_cast<float>(detail::power_series(x[c], terms));
    return T;
}

}  // namespace nephele
