// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/crossings.h"

#include <tuple>

namespace nephele {

namespace {

struct Collector final : HitFilter {
    std::span<const Instance> instances;
    std::uint32_t ray_kind;
    std::vector<Crossing>& out;

    Collector(std::span<const Instance> i, std::uint32_t kind, std::vector<Crossing>& crossings)
        : instances(i), ray_kind(kind), out(crossings) {}

    bool accept(const Hit& hit, bool front) override {
        if ((instances[hit.instance].visibility & ray_kind) != 0)
            out.push_back({hit.t, hit.instance, front ? 1 : -1, hit.triangle, hit.u, hit.v});
        return false;
    }
};

}  // namespace

void find_crossings(const Intersector& hierarchy, std::span<const Instance> instances, const Ray& ray,
                    std::uint32_t ray_kind, std::vector<Crossing>& out) {
    out.clear();
    Collector collector(instances, ray_kind, out);
    // A ray from afar starts anew nearby, where rounding is what the hierarchy's boxes allow for.
    const float skipped = -dot(ray.o, ray.d) - 4 * hierarchy.reach();
    const bool afar = skipped > 0;
    hierarchy.intersect({afar ? ray.at(skipped) : ray.o, ray.d,
                         afar ? std::max(ray.t_min - skipped, 0.0f) : ray.t_min, kInfinity, ray.time},
                        &collector);
    if (afar) {
        for (Crossing& c : out)
            c.t += skipped;
    }
    std::sort(out.begin(), out.end(), [](const Crossing& a, const Crossing& b) {
        return std::tuple(a.instance, a.t, -a.sign) < std::tuple(b.instance, b.t, -b.sign);
    });
}

}  // namespace nephele
