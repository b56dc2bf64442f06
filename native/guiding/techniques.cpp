// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/techniques.h"

#include <algorithm>
#include <stdexcept>

namespace nephele {

namespace {

constexpr double kUnit = 1 << 16;   // of the fixed-point sums
constexpr double kMostError = 1e4;  // of one path: fireflies do not decide alone
constexpr double kMostWork = 1e7;
constexpr double kClearly = 0.75;  // of what the other set costs
constexpr double kWorthIts = 0.9;  // of what none costs: lessons and learning are not in a path's work

std::uint64_t fixed(double x, double most) {
    return x > 0 ? static_cast<std::uint64_t>(std::min(x, most) * kUnit) : 0;
}

}  // namespace

void TrialSums::add(double path_error, double path_work) {
    paths += 1;
    error += fixed(path_error, kMostError);
    work += fixed(path_work, kMostWork);
}

TrialSums& TrialSums::operator+=(const TrialSums& other) {
    paths += other.paths;
    error += other.error;
    work += other.work;
    return *this;
}

std::optional<float> PathPair::variance(int set, float radiance) {
    float& before = last[static_cast<std::size_t>(set)];
    if (before < 0) {
        before = radiance;
        return std::nullopt;
    }
    const float off = radiance - before;
    before = -1;
    return 0.5f * off * off;
}

TechniqueChoice::TechniqueChoice(const Settings& settings) {
    const bool later =
        settings.vsp_secondary && settings.distance_sampling == Settings::DistanceSampling::vspg;
    const Techniques allowed{settings.guide_directions, later, settings.guided_roulette};
    if (allowed.any())
        sets_.push_back(allowed);
    if (settings.train_field == Settings::TrainField::always)
        chosen_ = static_cast<int>(sets_.size()) - 1;
}

int TechniqueChoice::draw(float u) const {
    if (decided())
        return chosen_;
    return u < 0.5f ? 0 : static_cast<int>(sets_.size()) - 1;
}

void TechniqueChoice::decide(const Trial& trial, bool end) {
    const auto cost = [](const TrialSums& sums) {
        const auto n = static_cast<double>(sums.paths);
        return static_cast<double>(sums.error) / n * (static_cast<double>(sums.work) / n);
    };
    if (trial[0].paths == 0 || trial[1].paths == 0)
        return;
    const double none = cost(trial[0]), all = cost(trial[1]);
    if (end || all < kClearly * none || none < kClearly * all)
        chosen_ = all < kWorthIts * none ? 1 : 0;
}

void TechniqueChoice::restore(double number) {
    if (!allows(number))
        throw std::invalid_argument(
            "the checkpoint is of other ways of guiding; render with the settings it "
            "was made with");
    chosen_ = static_cast<int>(number);
}

}  // namespace nephele
