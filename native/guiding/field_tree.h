// SPDX-License-Identifier: GPL-3.0-or-later
// A kd-tree over all of space whose leaves are FieldRegions. A leaf that has seen many samples is parted at
// their mean, across the axis along which they spread most; both halves start from what it knew.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "guiding/field_region.h"

namespace nephele {

class FieldTree {
  public:
    /// name: of its parts where it is saved. memory: bytes that it may take, but for its first region.
    FieldTree(std::string name, std::size_t memory);

    /// The region around p, or null where nothing has been learned.
    const FieldRegion* find(Vec3f p) const {
        if (nodes_.empty())
            return nullptr;
        std::uint32_t i = 0;
        while (nodes_[i].axis != kLeaf)
            i = nodes_[i].child + (p[static_cast<int>(nodes_[i].axis)] >= nodes_[i].split ? 1 : 0);
        return &regions_[nodes_[i].child];
    }

    /// Learns from a batch in the order of its keys; its samples are reordered.
    void update(const Settings& settings, std::span<FieldSample> samples);

    std::size_t regions() const { return regions_.size(); }
    std::size_t memory() const;

    /// restore() throws std::invalid_argument where what was saved is no tree.
    void save(std::map<std::string, std::vector<double>>& saved) const;
    void restore(const std::map<std::string, std::vector<double>>& saved);

  private:
    static constexpr std::uint32_t kLeaf = 3;
    struct Node {
        float split = 0;
        std::uint32_t axis : 2, child : 30;  ///< child: the lower of two in a row, or a leaf's region
    };
    struct Part {
        std::uint32_t node;
        std::span<FieldSample> samples;
    };
    void distribute(std::uint32_t node, std::span<FieldSample> samples, std::vector<Part>& parts);
    bool part(std::uint32_t node, std::span<FieldSample> samples);
    void check() const;

    std::string name_;
    std::size_t most_regions_;
    std::vector<Node> nodes_;
    std::vector<FieldRegion> regions_;
};

}  // namespace nephele
