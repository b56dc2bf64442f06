// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/techniques.h"

#include <algorithm>
#include <stdexcept>

namespace nephele {

namespace {

constexpr double kUnit = 1 << 16;   // of the fixed-point sums
constexpr double kMostError = 1e4;  // of one path: fireflies do not decide alone
constexpr double kMostWork = 1e7;
constexpr double kWorthIts = 0.93;  // of what none costs: lessons and learning are not in a path's work

}  // namespace

void TrialSums::add(double path_error, double path_work) {
    paths += 1;
    error += static_cast<std::uint64_t>(std::clamp(path_error, 0.0, kMostError) * kUnit);
    work += static_cast<std::uint64_t>(std::clamp(path_work, 0.0, kMostWork) * kUnit);
}

TrialSums& TrialSums::operator+=(const TrialSums& other) {
    paths += other.paths;
    error += other.error;
    work += other.work;
    return *this;
}

TechniqueChoice::TechniqueChoice(const Settings& settings) {
    const bool later =
        settings.vsp_secondary && settings.distance_sampling == Settings::DistanceSampling::vspg;
    for (const Techniques set : {Techniques{true, false, false}, Techniques{true, false, true},
                                 Techniques{true, true, false}, Techniques{true, true, true}}) {
        const Techniques allowed{set.directions && settings.guide_directions, set.segments && later,
                                 set.roulette && settings.guided_roulette};
        if (std::find(sets_.begin(), sets_.end(), allowed) == sets_.end())
            sets_.push_back(allowed);
    }
    if (settings.train_field == Settings::TrainField::always)
        chosen_ = static_cast<int>(sets_.size()) - 1;
}

int TechniqueChoice::draw(float u) const {
    if (decided())
        return chosen_;
    const auto n = static_cast<int>(sets_.size());
    return std::min(static_cast<int>(u * static_cast<float>(n)), n - 1);
}

std::uint64_t TechniqueChoice::paths(const Trial& trial) const {
    std::uint64_t fewest = trial[0].paths;
    for (std::size_t i = 1; i < sets_.size(); ++i)
        fewest = std::min(fewest, trial[i].paths);
    return fewest;
}

void TechniqueChoice::decide(const Trial& trial) {
    if (paths(trial) == 0)
        return;
    double least = 0;
    int best = -1;
    for (std::size_t i = 0; i < sets_.size(); ++i) {
        const TrialSums& sums = trial[i];
        const auto n = static_cast<double>(sums.paths);
        const double cost = (static_cast<double>(sums.error) / n) * (static_cast<double>(sums.work) / n) *
                            (sets_[i].any() ? 1 : kWorthIts);
        if (i == 0 || cost < least) {
            least = cost;
            best = static_cast<int>(i);
        }
    }
    chosen_ = best;
}

void TechniqueChoice::restore(int chosen) {
    if (chosen < -1 || chosen >= static_cast<int>(sets_.size()))
        throw std::invalid_argument(
            "the checkpoint is of other ways of guiding; render with the settings it "
            "was made with");
    chosen_ = chosen;
}

}  // namespace nephele
