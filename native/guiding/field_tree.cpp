// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/field_tree.h"

#include <algorithm>

#include "base/parallel.h"
#include "guiding/saved_rows.h"

namespace nephele {

namespace {

constexpr float kManySamples = 4000;       // that a region may stand for before it is parted
constexpr std::size_t kEnoughToPart = 64;  // samples of the batch that tell where

/// Mean and variance of positions.
struct Spread {
    Vec3f mean, variance;

    explicit Spread(std::span<const FieldSample> samples) {
        double sum[3] = {}, squares[3] = {};
        const Vec3f origin = samples.front().p;
        for (const FieldSample& s : samples) {
            for (int i = 0; i < 3; ++i) {
                const double x = double{s.p[i]} - double{origin[i]};
                sum[i] += x;
                squares[i] += x * x;
            }
        }
        const auto n = static_cast<double>(samples.size());
        for (int i = 0; i < 3; ++i) {
            mean[i] = static_cast<float>(double{origin[i]} + sum[i] / n);
            variance[i] = static_cast<float>(std::max(squares[i] / n - sum[i] / n * (sum[i] / n), 0.0));
        }
    }
};

}  // namespace

FieldTree::FieldTree(std::string name, std::size_t memory)
    : name_(std::move(name)), most_regions_(memory / (sizeof(FieldRegion) + 2 * sizeof(Node))) {}

std::size_t FieldTree::memory() const {
    return regions_.size() * sizeof(FieldRegion) + nodes_.size() * sizeof(Node);
}

void FieldTree::update(const Settings& settings, std::span<FieldSample> samples) {
    if (samples.empty())
        return;
    if (nodes_.empty()) {
        nodes_.push_back({0, kLeaf, 0});
        regions_.emplace_back().pivot = Spread(samples).mean;
    }
    std::vector<Part> parts;
    distribute(0, samples, parts);
    parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
        regions_[nodes_[parts[i].node].child].update(settings, parts[i].samples);
    });
}

/// Sorts the samples of a node into its leaves, which are parted where they hold too many.
void FieldTree::distribute(std::uint32_t node, std::span<FieldSample> samples, std::vector<Part>& parts) {
    if (samples.empty())
        return;
    if (nodes_[node].axis == kLeaf && !part(node, samples)) {
        parts.push_back({node, samples});
        return;
    }
    const Node inner = nodes_[node];
    const auto upper = std::stable_partition(samples.begin(), samples.end(), [&](const FieldSample& s) {
        return s.p[static_cast<int>(inner.axis)] < inner.split;
    });
    distribute(inner.child, {samples.begin(), upper}, parts);
    distribute(inner.child + 1, {upper, samples.end()}, parts);
}

/// Parts a leaf in two if it should be; returns whether it was.
bool FieldTree::part(std::uint32_t node, std::span<FieldSample> samples) {
    const std::uint32_t lower = nodes_[node].child;
    const float known = regions_[lower].samples() + static_cast<float>(samples.size());
    if (known <= kManySamples || samples.size() < kEnoughToPart || regions_.size() >= most_regions_)
        return false;
    const Spread spread(samples);
    const Vec3f v = spread.variance;
    const int axis = v.x >= v.y && v.x >= v.z ? 0 : v.y >= v.z ? 1 : 2;
    if (!(v[axis] > 0) || !std::isfinite(v[axis]))
        return false;
    // Of places that are all but one the mean is one of them.
    const auto in_upper = [&](const FieldSample& s) { return s.p[axis] >= spread.mean[axis]; };
    if (std::all_of(samples.begin(), samples.end(), in_upper) ||
        std::none_of(samples.begin(), samples.end(), in_upper))
        return false;
    const auto first = static_cast<std::uint32_t>(nodes_.size());
    const auto upper = static_cast<std::uint32_t>(regions_.size());
    const FieldRegion both = regions_[lower];
    regions_.push_back(both);
    nodes_[node] = {spread.mean[axis], static_cast<std::uint32_t>(axis), first};
    nodes_.push_back({0, kLeaf, lower});
    nodes_.push_back({0, kLeaf, upper});
    // Each half stands where its own samples are.
    std::vector<FieldSample> half;
    for (const bool is_upper : {false, true}) {
        half.clear();
        std::copy_if(samples.begin(), samples.end(), std::back_inserter(half),
                     [&](const FieldSample& s) { return in_upper(s) == is_upper; });
        regions_[is_upper ? upper : lower].become_half(Spread(half).mean);
    }
    return true;
}

void FieldTree::save(std::map<std::string, std::vector<double>>& saved) const {
    saved["field_nodes_" + name_] = flattened(nodes_);
    saved["field_regions_" + name_] = flattened(regions_);
}

void FieldTree::restore(const std::map<std::string, std::vector<double>>& saved) {
    FieldTree tree(*this);
    tree.nodes_ = unflattened<Node>(saved, ("field_nodes_" + name_).c_str());
    tree.regions_ = unflattened<FieldRegion>(saved, ("field_regions_" + name_).c_str());
    tree.check();
    *this = std::move(tree);
}

/// A tree's children come after their parents, every region hangs on one leaf, and what paths read is finite.
void FieldTree::check() const {
    const auto damaged = [&](const char* what) {
        throw std::invalid_argument("the guiding field is damaged (" + name_ + ": " + what +
                                    "); render without it");
    };
    std::vector<bool> seen(nodes_.size()), used(regions_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        const Node& n = nodes_[i];
        if (i > 0 && !seen[i])
            damaged("a node without a parent");
        if (n.axis == kLeaf) {
            if (std::size_t{n.child} >= regions_.size() || used[n.child])
                damaged("a leaf without a region of its own");
            used[n.child] = true;
            continue;
        }
        const std::size_t child = n.child;
        if (!std::isfinite(n.split) || child <= i || child + 1 >= nodes_.size() || seen[child] ||
            seen[child + 1])
            damaged("a node without children of its own");
        seen[child] = seen[child + 1] = true;
    }
    if (!std::all_of(used.begin(), used.end(), [](bool u) { return u; }))
        damaged("a region without a leaf");
    for (const FieldRegion& region : regions_) {
        if (!region.sound())
            damaged("a region that holds no numbers");
    }
}

}  // namespace nephele
