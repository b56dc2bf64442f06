// SPDX-License-Identifier: GPL-3.0-or-later
// Which ways of guiding by the field a render uses. None pays everywhere: what lowers the noise of one scene
// only costs time in the next. So the render tries them side by side on its own paths, each path by one set
// of techniques drawn at random, and goes on with the set whose relative error times work is least. Every set
// is unbiased, and which is drawn or chosen never depends on the path itself.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "settings_table.h"

namespace nephele {

/// What the field is used for along one path.
struct Techniques {
    bool directions = false;  ///< guides scattering
    bool segments = false;    ///< guides the volume scattering probability of later segments
    bool roulette = false;    ///< guides termination and splitting

    bool any() const { return directions || segments || roulette; }
    bool operator==(const Techniques&) const = default;
};

/// Sums over the paths of one set. Fixed point, so that the order of adding does not matter.
struct TrialSums {
    std::uint64_t paths = 0, error = 0, work = 0;

    /// error: squared relative error of a path's radiance. work: as in SegmentGuiding.
    void add(double path_error, double path_work);
    TrialSums& operator+=(const TrialSums& other);
};

inline constexpr int kMostSets = 8;
using Trial = std::array<TrialSums, kMostSets>;

class TechniqueChoice {
  public:
    TechniqueChoice() = default;
    /// The sets that the settings allow: the first is none of them, the last all.
    explicit TechniqueChoice(const Settings& settings);

    /// The set of a path, for u in [0, 1): the chosen one, or any while they are on trial.
    int draw(float u) const;
    const Techniques& set(int number) const { return sets_[static_cast<std::size_t>(number)]; }
    bool decided() const { return chosen_ >= 0; }

    /// The paths of the set that had the fewest.
    std::uint64_t paths(const Trial& trial) const;
    /// Chooses by what the sets have shown.
    void decide(const Trial& trial);

    /// For checkpoints: the number of the set chosen, -1 while there is none.
    int chosen() const { return chosen_; }
    bool allows(double number) const { return number >= -1 && number < static_cast<double>(sets_.size()); }
    void restore(int chosen);

  private:
    std::vector<Techniques> sets_{Techniques{}};
    int chosen_ = -1;
};

}  // namespace nephele
