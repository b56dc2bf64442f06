// SPDX-License-Identifier: GPL-3.0-or-later
// Whether guiding by the field pays. What lowers the noise of one scene only costs time in the next. So the
// render tries it on its own paths: each goes with all techniques that the settings allow or with none, drawn
// at random, and the render goes on with those whose relative error times work is less. Both are unbiased,
// and which is drawn or chosen never depends on the path itself.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
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

inline constexpr int kSets = 2;  ///< none of the techniques; all that the settings allow

/// Sums over the paths of one set. Fixed point, so that the order of adding does not matter.
struct TrialSums {
    std::uint64_t paths = 0, error = 0, work = 0;

    /// error: relative variance of a path's radiance. work: as in SegmentGuiding.
    void add(double path_error, double path_work);
    TrialSums& operator+=(const TrialSums& other);
};
using Trial = std::array<TrialSums, kSets>;

/// The last path of each set through a pixel, negative: none. Two of one set tell its variance, and nothing
/// has to be known of the pixel's mean.
struct PathPair {
    std::array<float, kSets> last{-1, -1};

    /// Half the squared difference to the set's last path, which then is used up; nothing where there is
    /// none.
    std::optional<float> variance(int set, float radiance);
};

class TechniqueChoice {
  public:
    TechniqueChoice() = default;
    explicit TechniqueChoice(const Settings& settings);

    /// The set of a path, for u in [0, 1): the chosen one, or either while they are on trial.
    int draw(float u) const;
    const Techniques& set(int number) const { return sets_[static_cast<std::size_t>(number)]; }
    bool decided() const { return chosen_ >= 0; }

    /// Chooses by what the sets have shown, if they differ clearly; in any case where the trial is to `end`
    /// and both have been tried.
    void decide(const Trial& trial, bool end);

    /// For checkpoints: the number of the set chosen, -1 while there is none.
    int chosen() const { return chosen_; }
    bool allows(double number) const {
        return number == -1 || number == 0 || (number == 1 && sets_.size() > 1);
    }
    /// Throws std::invalid_argument where `number` names no set.
    void restore(double number);

  private:
    std::vector<Techniques> sets_{Techniques{}};
    int chosen_ = -1;
};

}  // namespace nephele
