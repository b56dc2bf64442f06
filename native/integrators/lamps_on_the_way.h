// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps do not block rays: a path adds their light and goes on. Here is which of them it has met since its
// last vertex, wherever transparent surfaces let the ray start anew, so that each is met once.
#pragma once

#include "lights/light_set.h"

namespace nephele {

/// Place of a lamp on the way from the last vertex: its distance, and its number among those at the same
/// distance.
using LampPlace = std::pair<float, std::uint32_t>;

struct LampHit {
    LampPlace place{kInfinity, 0};
    float distance = kInfinity;  ///< on the ray
    std::uint32_t number = 0;
    Rgb Le;
    float pdf = 0;
};

/// Whether a ray of this kind, the path's segment number `bounces`, sees the lamp where it meets it.
inline bool sees(const Lamp& lamp, std::uint32_t kind, int bounces) {
    return (lamp.visibility & kind) != 0 && bounces - 1 <= lamp.max_bounces;
}

class LampsOnTheWay {
  public:
    LampsOnTheWay() = default;
    /// From a vertex on, which has not been moved off its surface.
    explicit LampsOnTheWay(Vec3f vertex) : vertex_(vertex) {}
    /// From the camera's lens on, which sees nothing nearer than that.
    LampsOnTheWay(Vec3f lens, float nearest) : vertex_(lens), passed_{nearest, 0} {}

    Vec3f vertex() const { return vertex_; }
    /// From the vertex to where the ray starts.
    float travelled() const { return travelled_; }
    /// The ray starts anew, so much farther on.
    void advance(float step) { travelled_ += step; }
    /// Takes note of a lamp's place as it was found: a rounded one could be met for ever.
    void pass(const LampHit& lamp) { passed_ = lamp.place; }

    /// The first lamp of finite distance that the ray sees before `end`, beyond the one passed last.
    LampHit nearest(const LightSet& lights, const Ray& ray, std::uint32_t kind, int bounces,
                    float end) const {
        LampHit nearest;
        const Ray reach{vertex_, ray.d, passed_.first, travelled_ + end, ray.time};
        lights.for_each_lamp_hit(reach, [&](std::uint32_t number, const LightHit& hit) {
            if (hit.distance == kInfinity || !sees(lights.lamp(number), kind, bounces))
                return;
            // Lamps at the same distance come in the order of their numbers, each once.
            const LampPlace place(hit.distance, number);
            if (place > passed_ && place < nearest.place)
                nearest = {place, hit.distance - travelled_, number, hit.Le, hit.pdf};
        });
        return nearest;
    }

  private:
    Vec3f vertex_;
    float travelled_ = 0;  // from there to where the ray starts
    LampPlace passed_{-1.0f, 0};
};

}  // namespace nephele
