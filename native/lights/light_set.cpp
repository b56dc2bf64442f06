// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/light_set.h"

#include <algorithm>
#include <array>

namespace nephele {

LightSet::LightSet(std::vector<Lamp> lamps, std::vector<MeshLight> meshes,
                   std::shared_ptr<const EnvironmentLight> world)
    : lamps_(std::move(lamps)), meshes_(std::move(meshes)), world_(std::move(world)) {
    std::vector<std::uint32_t> finite;
    std::vector<LightBounds>& bounds = near_;
    for (std::uint32_t i = 0; i < lamps_.size(); ++i) {
        if (is_zero(lamps_[i].power()))
            continue;
        if (lamps_[i].infinite()) {
            direct_.push_back(i);
        } else {
            finite.push_back(i);
            bounds.push_back(bounds_of(lamps_[i]));
        }
    }
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        if (meshes_[i].empty())
            continue;
        finite.push_back(mesh_number(i));
        bounds.push_back({meshes_[i].lower(), meshes_[i].upper(), meshes_[i].intensity()});
    }
    if (world_ && !world_->black())
        direct_.push_back(world_number());

    for (const std::uint32_t i : direct_)
        distant_ += importance(i, Vec3f());
    note_linking();
    if (finite.size() > kListSize) {
        tree_ = LightTree(finite, bounds);
        in_tree_.assign(size(), false);
        for (const std::uint32_t i : finite)
            in_tree_[i] = true;
    } else {
        direct_.insert(direct_.end(), finite.begin(), finite.end());
    }
    for (const std::uint32_t i : direct_) {
        if (kind(i) == Kind::lamp && !lamps_[i].delta())
            hittable_.push_back(i);
    }
}

void LightSet::note_linking() {
    const auto plain = [](const auto& light) { return light.linking.plain(); };
    const auto mesh_plain = [](const MeshLight& light) { return light.instance().linking.plain(); };
    if (std::all_of(lamps_.begin(), lamps_.end(), plain) &&
        std::all_of(meshes_.begin(), meshes_.end(), mesh_plain))
        return;
    linking_.resize(size());
    for (std::uint32_t i = 0; i < lamps_.size(); ++i)
        linking_[i] = lamps_[i].linking;
    for (std::size_t i = 0; i < meshes_.size(); ++i)
        linking_[mesh_number(i)] = meshes_[i].instance().linking;
}

float LightSet::importance(std::uint32_t light, const Receiver& at) const {
    if (linked() && !linking_[light].lights(at.set))
        return 0;
    switch (kind(light)) {
        case Kind::lamp:
            return lamp(light).importance(at);
        case Kind::mesh:
            return mesh(light).importance(at.p);
        case Kind::world:
            return world_->importance();
    }
    return 0;
}

float LightSet::fluence(Vec3f p) const {
    float sum = tree_.importance(p);
    for (const std::uint32_t light : direct_)
        sum += importance(light, p);
    return sum;
}

std::optional<std::uint32_t> LightSet::select(const Receiver& at, double u, float& probability) const {
    const Vec3f p = at.p;
    // Weights of the first lights are kept; more than kStored lights at infinity are weighed twice instead.
    constexpr std::size_t kStored = 2 * kListSize;
    std::array<float, kStored> stored;
    double sum = tree_.importance(p);
    const double tree_weight = sum;
    for (std::size_t i = 0; i < direct_.size(); ++i) {
        const float w = importance(direct_[i], at);
        if (i < kStored)
            stored[i] = w;
        sum += w;
    }
    if (!(sum > 0))
        return std::nullopt;

    double rest = u * sum;
    if (rest < tree_weight) {
        const auto choice =
            tree_.select(p, rest / tree_weight, [&](std::uint32_t l, Vec3f) { return importance(l, at); });
        if (!choice)
            return std::nullopt;
        probability = static_cast<float>(choice->probability * (tree_weight / sum));
        return choice->light;
    }
    rest -= tree_weight;
    std::size_t chosen = direct_.size();
    double chosen_weight = 0;
    for (std::size_t i = 0; i < direct_.size(); ++i) {
        const double w = i < kStored ? stored[i] : importance(direct_[i], at);
        if (w > 0) {  // rounding at the end of the list stays on a light with a chance
            chosen = i;
            chosen_weight = w;
        }
        if (rest < w)
            break;
        rest -= w;
    }
    if (chosen == direct_.size())
        return std::nullopt;
    probability = static_cast<float>(chosen_weight / sum);
    return direct_[chosen];
}

float LightSet::selection_pdf(const Receiver& at, std::uint32_t light) const {
    const Vec3f p = at.p;
    const double tree_weight = tree_.importance(p);
    double sum = tree_weight;
    bool listed = false;
    for (const std::uint32_t i : direct_) {
        sum += importance(i, at);
        listed |= i == light;
    }
    if (!(sum > 0))
        return 0;
    if (listed)
        return static_cast<float>(importance(light, at) / sum);
    if (light >= in_tree_.size() || !in_tree_[light])
        return 0;
    const float within =
        tree_.probability(p, light, [&](std::uint32_t l, Vec3f) { return importance(l, at); });
    return static_cast<float>(within * (tree_weight / sum));
}

}  // namespace nephele
