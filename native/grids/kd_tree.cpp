// SPDX-License-Identifier: GPL-3.0-or-later
// Building of kd-trees.
//
// The cost of a tree, in candidates, summed over uniformly random lines: such lines meet a box of volume V
// and surface A in proportion to A / 4, and their lengths within it sum up to V (so that 4 V / A is the mean
// chord). A leaf of majorant M at depth d of the tree costs
//     V * M * sigma_scale * kCandidateCost            (candidates: lookups, random numbers)
//     + A / 4 * (kStepCost + d * kNodeCost)           (steps of the walk, each with a descent from the root)
// With minorants M is the majorant less the minorant. For cubes and kNodeCost = 0 this is the cost by which
// cells of majorant grids merge. Each node takes the split whose children are expected to cost least, as
// leaves or evenly divided, and among equals the one nearest to its middle; once its subtree is complete, the
// node becomes a leaf again if that costs no more. Where not even children as tight as single cells would pay
// for one more node on the way, nothing is tried.
//
// Bounds come from that level of CellBounds of which a node holds no more than kMostUnits units: large
// trees are never looked at cell by cell but at their ends, and uniform or empty space ends a branch.
#include "grids/kd_tree.h"

#include <algorithm>

#include "base/parallel.h"

namespace nephele {

namespace {

// In units of one candidate, as in majorant_grid.cpp; a level of the descent takes about 5 ns.
constexpr float kCandidateCost = 1.0f, kStepCost = 0.5f, kNodeCost = 0.08f;
constexpr int kMostUnits = 1 << 16, kMostSlabs = 128;
constexpr int kSpareDepth = 2;  // room for trees that are not balanced

/// Cells first <= c < end.
struct Box {
    std::array<int, 3> first, end;

    float edge(std::size_t a) const {
        return static_cast<float>(CellBounds::kCellSize) * static_cast<float>(end[a] - first[a]);
    }
    /// Splits on the way to a single cell, at most, where each one halves the box.
    int halvings() const {
        int sum = 0;
        for (std::size_t a = 0; a < 3; ++a)
            sum += std::bit_width(static_cast<unsigned>(end[a] - first[a] - 1));
        return sum;
    }
    float volume() const { return edge(0) * edge(1) * edge(2); }
    float surface() const { return 2 * (edge(0) * edge(1) + edge(1) * edge(2) + edge(2) * edge(0)); }
};

/// What a node knows of its box: bounds of the slabs of each axis, one unit of `level` thick.
struct Profile {
    int level = 0;
    std::array<int, 3> first{}, count{};  // in units
    std::array<std::array<Bounds, kMostSlabs>, 3> slabs;
    std::array<std::array<float, kMostSlabs>, 3> rates{};  // of each slab, summed over its units
    Bounds bounds;
    float rate = 0;  // summed over all units
};

}  // namespace

class KdTreeBuilder {
  public:
    KdTreeBuilder(KdTree& tree, const CellBounds& bounds, float sigma_scale, bool with_minorants)
        : nodes_(tree.nodes_), bounds_(bounds), sigma_scale_(sigma_scale), with_minorants_(with_minorants) {
        const Box table{{0, 0, 0}, bounds.cells()};
        max_depth_ = std::min(KdTree::kMaxDepth, table.halvings() + kSpareDepth);
        nodes_.resize((std::size_t{2} << max_depth_) - 1);
        const Result root = build(0, 0, table);
        nodes_.resize(root.last_node + 1);
        nodes_.shrink_to_fit();
    }

  private:
    struct Result {
        float cost = 0;
        std::size_t last_node = 0;  // the highest number in the subtree
    };
    struct Split {
        std::size_t axis = 3;
        int cell = 0;
        float cost = kInfinity;
    };

    float rate(const Bounds& b) const {
        return std::max(b.max - (with_minorants_ ? b.min : 0.0f), 0.0f) * sigma_scale_ * kCandidateCost;
    }
    float leaf_cost(const Box& box, const Bounds& b, int depth) const {
        return box.volume() * rate(b) +
               box.surface() * 0.25f * (kStepCost + static_cast<float>(depth) * kNodeCost);
    }
    /// What a child is expected to cost: as a leaf, or divided evenly down to the units of a level, as far as
    /// the depth that is left allows.
    float expected_cost(const Box& box, const Bounds& b, float sum_of_rates, int level, int depth) const {
        const float edge = static_cast<float>(CellBounds::kCellSize << level);
        const float units = std::max(box.volume() / (edge * edge * edge), 1.0f);
        const int halvings = box.halvings();
        const float unit_depth = static_cast<float>(depth) + std::log2(units);
        const float divided = std::max(sum_of_rates, 0.0f) * edge * edge * edge +
                              units * 1.5f * edge * edge * (kStepCost + unit_depth * kNodeCost);
        const float leaf = leaf_cost(box, b, depth);
        if (leaf <= divided || depth + halvings <= max_depth_)
            return std::min(leaf, divided);
        return lerp(leaf, divided, static_cast<float>(max_depth_ - depth) / static_cast<float>(halvings));
    }
    Profile profile_of(const Box& box) const;
    Split best_split(const Box& box, const Profile& profile, int depth) const;
    Result build(std::size_t number, int depth, const Box& box);

    std::vector<std::uint64_t>& nodes_;
    const CellBounds& bounds_;
    float sigma_scale_;
    bool with_minorants_;
    int max_depth_ = 0;
};

Profile KdTreeBuilder::profile_of(const Box& box) const {
    Profile out;
    for (;; ++out.level) {
        for (std::size_t a = 0; a < 3; ++a) {
            out.first[a] = box.first[a] >> out.level;
            out.count[a] = ((box.end[a] - 1) >> out.level) - out.first[a] + 1;
        }
        const auto& n = out.count;
        if (std::max({n[0], n[1], n[2]}) <= kMostSlabs && n[0] * n[1] * n[2] <= kMostUnits)
            break;
    }
    for (int x = 0; x < out.count[0]; ++x) {
        Bounds slab;
        float slab_rate = 0;
        for (int y = 0; y < out.count[1]; ++y) {
            Bounds row;
            float row_rate = 0;
            for (int z = 0; z < out.count[2]; ++z) {
                const Bounds& unit =
                    bounds_.at(out.level, out.first[0] + x, out.first[1] + y, out.first[2] + z);
                const float unit_rate = rate(unit);
                row.include(unit);
                row_rate += unit_rate;
                out.slabs[2][static_cast<std::size_t>(z)].include(unit);
                out.rates[2][static_cast<std::size_t>(z)] += unit_rate;
            }
            out.slabs[1][static_cast<std::size_t>(y)].include(row);
            out.rates[1][static_cast<std::size_t>(y)] += row_rate;
            slab.include(row);
            slab_rate += row_rate;
        }
        out.slabs[0][static_cast<std::size_t>(x)] = slab;
        out.rates[0][static_cast<std::size_t>(x)] = slab_rate;
        out.bounds.include(slab);
        out.rate += slab_rate;
    }
    return out;
}

KdTreeBuilder::Split KdTreeBuilder::best_split(const Box& box, const Profile& profile, int depth) const {
    Split best;
    float best_distance = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto n = static_cast<std::size_t>(profile.count[a]);
        std::array<Bounds, kMostSlabs + 1> above{};  // of slab i and those after it
        for (std::size_t i = n; i-- > 0;) {
            above[i] = above[i + 1];
            above[i].include(profile.slabs[a][i]);
        }
        Bounds below;
        float rate_below = 0;
        for (std::size_t i = 1; i < n; ++i) {
            below.include(profile.slabs[a][i - 1]);
            rate_below += profile.rates[a][i - 1];
            const int cell = (profile.first[a] + static_cast<int>(i)) << profile.level;
            Box lower = box, upper = box;
            lower.end[a] = upper.first[a] = cell;
            const float cost =
                expected_cost(lower, below, rate_below, profile.level, depth + 1) +
                expected_cost(upper, above[i], profile.rate - rate_below, profile.level, depth + 1);
            const float distance = std::fabs(lower.edge(a) - upper.edge(a));
            if (cost < best.cost || (cost == best.cost && distance < best_distance)) {
                best = {a, cell, cost};
                best_distance = distance;
            }
        }
    }
    return best;
}

KdTreeBuilder::Result KdTreeBuilder::build(std::size_t number, int depth, const Box& box) {
    const Profile profile = profile_of(box);
    nodes_[number] = KdTree::pack({profile.bounds.max, with_minorants_ ? profile.bounds.min : 0.0f});
    const Result leaf{leaf_cost(box, profile.bounds, depth), number};
    if (depth == max_depth_ || profile.bounds.max == profile.bounds.min)
        return leaf;
    const float cells_alone = profile.rate * 512.0f;  // candidates at least, however it is divided
    if (profile.level == 0 &&
        box.volume() * rate(profile.bounds) - cells_alone <= box.surface() * 0.25f * kNodeCost)
        return leaf;
    const Split split = best_split(box, profile, depth);
    if (split.axis == 3)
        return leaf;
    Box lower = box, upper = box;
    lower.end[split.axis] = upper.first[split.axis] = split.cell;
    Result a, b;
    const auto build_lower = [&] { a = build(2 * number + 1, depth + 1, lower); };
    const auto build_upper = [&] { b = build(2 * number + 2, depth + 1, upper); };
    if (depth < 6) {
        parallel_invoke(build_lower, build_upper);
    } else {
        build_lower();
        build_upper();
    }
    if (a.cost + b.cost >= leaf.cost)
        return leaf;
    nodes_[number] = KdTree::split_node(nodes_[number], split.axis, split.cell);
    return {a.cost + b.cost, std::max(a.last_node, b.last_node)};
}

std::uint64_t KdTree::pack(const Bounds& bounds) {
    const auto most = std::bit_cast<std::uint32_t>(std::max(bounds.max, 0.0f));
    const auto least = std::bit_cast<std::uint32_t>(std::max(bounds.min, 0.0f));
    const std::uint64_t up = (most + ((1u << kDroppedBits) - 1)) >> kDroppedBits;
    return kLeaf | up << 24 | std::uint64_t{least >> kDroppedBits} << 44;
}

KdTree::KdTree(const CellBounds& bounds, float sigma_scale, bool with_minorants)
    : origin_(bounds.origin()),
      cells_(bounds.cells()),
      support_min_(bounds.support_min()),
      support_max_(bounds.support_max()),
      background_(bounds.background()) {
    if (cells_[0] > 0) {
        KdTreeBuilder(*this, bounds, sigma_scale, with_minorants);
    } else {
        nodes_.push_back(pack(background_));
    }
    const std::uint64_t global = pack(bounds.global());
    global_majorant_ = majorant_of(global);
    global_minorant_ = with_minorants ? minorant_of(global) : 0;
}

std::size_t KdTree::leaves() const {
    std::size_t count = 0;
    std::vector<std::size_t> open{0};
    while (!open.empty()) {
        const std::size_t i = open.back();
        open.pop_back();
        if ((nodes_[i] & 3) == kLeaf) {
            ++count;
        } else {
            open.insert(open.end(), {2 * i + 1, 2 * i + 2});
        }
    }
    return count;
}

}  // namespace nephele
