// SPDX-License-Identifier: GPL-3.0-or-later
// All lights of a scene and the choice among them. Lights are numbered: lamps, then mesh lights, then the
// world.
//
// At a receiving point every light has an `importance`, an estimate of its fluence rate there; up to
// kListSize lights of finite size are chosen in proportion to it, more through a LightTree, which competes
// with suns and world as one entry. Normals play no part, since receiving points may lie in volumes. Wherever
// a light can contribute, its probability is above zero.
#pragma once

#include <memory>
#include <vector>

#include "lights/any.h"
#include "lights/environment.h"
#include "lights/light_tree.h"
#include "lights/mesh_light.h"

namespace nephele {

class LightSet {
  public:
    static constexpr std::size_t kListSize = 16;

    LightSet() = default;
    /// Mesh lights that are empty, and a world that is null or black, are never chosen but keep their
    /// numbers.
    LightSet(std::vector<Lamp> lamps, std::vector<MeshLight> meshes,
             std::shared_ptr<const EnvironmentLight> world);

    std::size_t size() const { return lamps_.size() + meshes_.size() + (world_ ? 1 : 0); }
    bool empty() const { return direct_.empty() && tree_.empty(); }
    std::size_t tree_bytes() const { return tree_.bytes(); }

    const std::vector<Lamp>& lamps() const { return lamps_; }
    const std::vector<MeshLight>& meshes() const { return meshes_; }
    const EnvironmentLight* world() const { return world_.get(); }

    enum class Kind { lamp, mesh, world };
    Kind kind(std::uint32_t light) const {
        return light < lamps_.size()                    ? Kind::lamp
               : light < lamps_.size() + meshes_.size() ? Kind::mesh
                                                        : Kind::world;
    }
    const Lamp& lamp(std::uint32_t light) const { return lamps_[light]; }
    const MeshLight& mesh(std::uint32_t light) const { return meshes_[light - lamps_.size()]; }
    std::uint32_t mesh_number(std::size_t i) const { return static_cast<std::uint32_t>(lamps_.size() + i); }
    std::uint32_t world_number() const { return static_cast<std::uint32_t>(lamps_.size() + meshes_.size()); }

    /// A light's number for u in [0,1), with its probability; none where no light can contribute there.
    std::optional<std::uint32_t> select(const Receiver& at, double u, float& probability) const;
    /// Probability with which `select` returns this light there.
    float selection_pdf(const Receiver& at, std::uint32_t light) const;

    /// Whether any light does not shine on everything, or not through everything.
    bool linked() const { return !linking_.empty(); }
    /// Of any light; only where some are linked.
    const Linking& linking(std::uint32_t light) const { return linking_[light]; }

    /// Estimate of the fluence rate at p from all lights, nothing in the way, W/m^2.
    float fluence(Vec3f p) const;
    /// The part of it that suns and the world bring everywhere.
    float distant_fluence() const { return distant_; }
    /// Where the lights of finite size are, in no order.
    const std::vector<LightBounds>& near_lights() const { return near_; }

    /// Calls found(number, LightHit) for every lamp that the ray meets in [t_min, t_max], in no order. Lamps
    /// do not block rays. Mesh lights and the world are found by tracing.
    template <typename Found>
    void for_each_lamp_hit(const Ray& ray, Found&& found) const;

  private:
    float importance(std::uint32_t light, const Receiver& at) const;
    void note_linking();

    std::vector<Lamp> lamps_;
    std::vector<MeshLight> meshes_;
    std::shared_ptr<const EnvironmentLight> world_;
    std::vector<std::uint32_t> direct_;    // lights weighed one by one
    std::vector<std::uint32_t> hittable_;  // the lamps among them that rays can hit
    LightTree tree_;                       // the other ones
    std::vector<LightBounds> near_;        // of the lights of finite size
    float distant_ = 0;
    std::vector<bool> in_tree_;
    std::vector<Linking> linking_;  // by light; empty: all shine on everything
};

template <typename Found>
void LightSet::for_each_lamp_hit(const Ray& ray, Found&& found) const {
    const auto test = [&](std::uint32_t light) {
        if (const auto hit = lamps_[light].intersect(ray))
            found(light, *hit);
    };
    for (const std::uint32_t light : hittable_)
        test(light);
    tree_.for_each_near(ray, [&](std::uint32_t light) {
        if (kind(light) == Kind::lamp && !lamps_[light].delta())
            test(light);
    });
}

}  // namespace nephele
