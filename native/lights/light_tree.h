// SPDX-License-Identifier: GPL-3.0-or-later
// A binary tree over lights of finite size, to choose among many in O(log n) (after Conty Estevez and Kulla,
// HPG 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", without normals and cones,
// since receiving points may lie in volumes).
//
// A node weighs intensity / max(distance^2 to its centre, (diagonal / 4)^2); a quarter leaves a third of the
// deviation that half the diagonal leaves, among 1000 point lamps in a box with the receiving points. At each
// fork one child is chosen by weight; a leaf of up to kLeafSize lights chooses by their own importance. Every
// light keeps a nonzero probability wherever its own importance is not zero.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "lights/any.h"

namespace nephele {

class LightTree {
  public:
    static constexpr std::uint32_t kLeafSize = 16;

    LightTree() = default;
    /// bounds[i] belongs to the light lights[i]; intensities > 0.
    LightTree(const std::vector<std::uint32_t>& lights, const std::vector<LightBounds>& bounds);

    bool empty() const { return nodes_.empty(); }
    std::size_t bytes() const {
        return nodes_.size() * sizeof(Node) + (lights_.size() + leaf_of_.size()) * sizeof(std::uint32_t);
    }
    /// Weight of the whole tree at p, comparable with a light's importance.
    float importance(Vec3f p) const { return empty() ? 0 : weight(nodes_[0], p); }

    struct Choice {
        std::uint32_t light;
        float probability;
    };
    /// A light for u in [0,1); importance(light, p) is the lights' own. None where the leaf reached has none
    /// to offer.
    template <typename Importance>
    std::optional<Choice> select(Vec3f p, double u, Importance&& importance) const;
    /// Probability of a light of this tree.
    template <typename Importance>
    float probability(Vec3f p, std::uint32_t light, Importance&& importance) const;
    /// Calls near(light) for every light whose box the ray enters.
    template <typename Near>
    void for_each_near(const Ray& ray, Near&& near) const;

  private:
    struct Node {
        Vec3f lower, upper;
        float intensity = 0;
        std::uint32_t parent = 0;
        std::uint32_t first = 0;  // inner: its left child, the right one follows; leaf: first of its lights
        std::uint32_t count = 0;  // lights of a leaf; 0: inner
    };
    static float weight(const Node& node, Vec3f p);
    static bool enters(const Ray& ray, Vec3f inverse_d, const Node& node);
    void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end,
               const std::vector<LightBounds>& bounds, std::vector<std::uint32_t>& order);
    /// Probability of the left child of an inner node.
    double left_probability(const Node& node, Vec3f p) const {
        const double left = weight(nodes_[node.first], p), right = weight(nodes_[node.first + 1], p);
        return left + right > 0 ? left / (left + right) : 0.5;  // both may be too little for a float
    }

    std::vector<Node> nodes_;
    std::vector<std::uint32_t> lights_;   // in leaf order
    std::vector<std::uint32_t> leaf_of_;  // a light's leaf, by light number
};

template <typename Importance>
std::optional<LightTree::Choice> LightTree::select(Vec3f p, double u, Importance&& importance) const {
    double probability = 1;
    std::uint32_t node = 0;
    while (nodes_[node].count == 0) {
        const double left = left_probability(nodes_[node], p);
        const bool go_left = u < left;
        u = go_left ? u / left : (u - left) / (1 - left);
        probability *= go_left ? left : 1 - left;
        node = nodes_[node].first + (go_left ? 0 : 1);
    }

    const Node& leaf = nodes_[node];
    std::array<double, kLeafSize> weights;
    double sum = 0;
    for (std::uint32_t i = 0; i < leaf.count; ++i)
        sum += weights[i] = importance(lights_[leaf.first + i], p);
    if (!(sum > 0))
        return std::nullopt;
    double rest = u * sum;
    std::uint32_t chosen = 0;
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
        if (weights[i] > 0)
            chosen = i;  // rounding at the end of the list stays on a light with a chance
        if (rest < weights[i])
            break;
        rest -= weights[i];
    }
    return Choice{lights_[leaf.first + chosen], static_cast<float>(probability * weights[chosen] / sum)};
}

template <typename Importance>
float LightTree::probability(Vec3f p, std::uint32_t light, Importance&& importance) const {
    std::uint32_t node = leaf_of_[light];
    const Node& leaf = nodes_[node];
    double sum = 0;
    for (std::uint32_t i = 0; i < leaf.count; ++i)
        sum += importance(lights_[leaf.first + i], p);
    if (!(sum > 0))
        return 0;
    double probability = importance(light, p) / sum;
    while (node != 0) {
        const Node& parent = nodes_[nodes_[node].parent];
        const double left = left_probability(parent, p);
        probability *= node == parent.first ? left : 1 - left;
        node = nodes_[node].parent;
    }
    return static_cast<float>(probability);
}

template <typename Near>
void LightTree::for_each_near(const Ray& ray, Near&& near) const {
    if (empty())
        return;
    const Vec3f inverse_d(1 / ray.d.x, 1 / ray.d.y, 1 / ray.d.z);
    std::array<std::uint32_t, 64>
        stack;  // the tree halves its lights at every level, so it is less than 32 deep
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const Node& node = nodes_[stack[--top]];
        if (!enters(ray, inverse_d, node))
            continue;
        if (node.count == 0) {
            stack[top++] = node.first;
            stack[top++] = node.first + 1;
        }
        for (std::uint32_t i = 0; i < node.count; ++i)
            near(lights_[node.first + i]);
    }
}

}  // namespace nephele
