// SPDX-License-Identifier: GPL-3.0-or-later
// The guiding field: what is known of light at every place and in every direction, learned from the paths of
// the render itself. Kd-trees over space, one for vertices in volumes and one for surfaces of each facing;
// their leaves are FieldRegions, and are parted where paths go often (Mueller, Gross, Novak 2017, "Practical
// Path Guiding"; Herholz et al. 2019).
//
// Between two updates the field stands still: any number of threads may read it without locks.
#pragma once

#include <map>
#include <string>

#include "guiding/field_tree.h"

namespace nephele {

class GuidingField {
  public:
    /// Name under which save() puts what tells a field from other state.
    static constexpr const char* kSavedAs = "field_regions_volume";

    /// memory: bytes that the trees may take at most; a single region a tree is there in any case.
    GuidingField(const Settings& settings, std::size_t memory);

    /// The region around p, or null where nothing has been learned.
    const FieldRegion* find(Vec3f p, FieldPart part) const {
        return trees_[static_cast<std::size_t>(part)].find(p);
    }

    /// Learns from a batch, on all threads of the caller's arena. What comes of it depends on the samples and
    /// their keys, not on their order or the threads. Samples that are not finite are left out.
    void update(std::vector<FieldSample> samples);

    std::size_t regions() const;
    /// Bytes that the trees take.
    std::size_t memory() const;

    /// The state, for checkpoints and other renders. Throws std::invalid_argument where it is damaged.
    void save(std::map<std::string, std::vector<double>>& saved) const;
    void restore(const std::map<std::string, std::vector<double>>& saved);

  private:
    Settings settings_;
    std::vector<FieldTree> trees_;  // of each FieldPart
};

}  // namespace nephele
