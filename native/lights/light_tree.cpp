// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/light_tree.h"

#include <algorithm>
#include <numeric>

namespace nephele {

LightTree::LightTree(const std::vector<std::uint32_t>& lights, const std::vector<LightBounds>& bounds) {
    if (lights.empty())
        return;
    std::vector<std::uint32_t> order(lights.size());
    std::iota(order.begin(), order.end(), 0u);
    nodes_.emplace_back();
    build(0, 0, static_cast<std::uint32_t>(order.size()), bounds, order);

    leaf_of_.resize(*std::max_element(lights.begin(), lights.end()) + std::size_t{1});
    for (const std::uint32_t i : order)
        lights_.push_back(lights[i]);
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
        for (std::uint32_t i = 0; i < nodes_[n].count; ++i)
            leaf_of_[lights_[nodes_[n].first + i]] = n;
    }
}

void LightTree::build(std::uint32_t node, std::uint32_t begin, std::uint32_t end,
                      const std::vector<LightBounds>& bounds, std::vector<std::uint32_t>& order) {
    Vec3f lower(kInfinity), upper(-kInfinity), centre_lower(kInfinity), centre_upper(-kInfinity);
    const auto centre = [&](std::uint32_t light) {
        return (bounds[light].lower + bounds[light].upper) * 0.5f;
    };
    double intensity = 0;
    for (std::uint32_t i = begin; i < end; ++i) {
        const LightBounds& b = bounds[order[i]];
        lower = min(lower, b.lower);
        upper = max(upper, b.upper);
        centre_lower = min(centre_lower, centre(order[i]));
        centre_upper = max(centre_upper, centre(order[i]));
        intensity += static_cast<double>(b.intensity);
    }
    nodes_[node].lower = lower;
    nodes_[node].upper = upper;
    nodes_[node].intensity = static_cast<float>(intensity);
    if (end - begin <= kLeafSize) {
        nodes_[node].first = begin;
        nodes_[node].count = end - begin;
        return;
    }

    // Halve the lights across the longest side of their centres' box.
    const Vec3f size = centre_upper - centre_lower;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) { return centre(a)[axis] < centre(b)[axis]; });
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[node].first = child;
    nodes_.resize(nodes_.size() + 2);
    nodes_[child].parent = nodes_[child + 1].parent = node;
    build(child, begin, middle, bounds, order);
    build(child + 1, middle, end, bounds, order);
}

float LightTree::weight(const Node& node, Vec3f p) {
    const Vec3f to_centre = (node.lower + node.upper) * 0.5f - p, diagonal = node.upper - node.lower;
    const float d2 = std::max(dot(to_centre, to_centre), 0.0625f * dot(diagonal, diagonal));
    return std::min(node.intensity / std::max(d2, 1e-20f), 1e30f);
}

bool LightTree::enters(const Ray& ray, Vec3f inverse_d, const Node& node) {
    float t0 = ray.t_min, t1 = ray.t_max;
    for (int i = 0; i < 3; ++i) {
        const float a = (node.lower[i] - ray.o[i]) * inverse_d[i],
                    b = (node.upper[i] - ray.o[i]) * inverse_d[i];
        // Written so that the NaN of a ray that lies in the slab's plane leaves the interval alone; widened
        // by the rounding of a, b and the boxes, since lamps like rectangles have boxes without thickness.
        t0 = std::min(a, b) > t0 ? std::min(a, b) * (1 - 1e-5f) : t0;
        t1 = std::max(a, b) < t1 ? std::max(a, b) * (1 + 1e-5f) : t1;
    }
    return t0 <= t1;
}

}  // namespace nephele
