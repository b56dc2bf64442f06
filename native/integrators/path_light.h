// SPDX-License-Identifier: GPL-3.0-or-later
// Where a path's light comes from: lamps, suns and the world that its rays meet, emission of surfaces and
// volumes, and light sampling at its vertices, weighed against each other by multiple importance sampling.
// Where directions are guided, the weights are those of guided scattering.
#pragma once

#include <type_traits>

#include "integrators/direct_light.h"
#include "integrators/direction_guide.h"
#include "integrators/path_record.h"
#include "integrators/phase_mixture.h"

namespace nephele {

template <KernelTraits k>
class PathLight {
  public:
    PathLight(const Scene& scene, const Settings& settings, const SampleRequest& request, const Ray& ray,
              PathSampler& sampler, Workspace& ws)
        : scene_(scene),
          settings_(settings),
          request_(request),
          sampler_(sampler),
          ws_(ws),
          record_(request, ws) {
        walk_.ray = ray;
        walk_.history.length = -ray.t_min;
        walk_.way = LampsOnTheWay(ray.o, ray.t_min);
    }

  protected:
    using First = Walk::First;
    using Guide = std::conditional_t<k.learning, DirectionGuide, NoDirectionGuide>;
    /// Bounds of the weight that guided directions in a row may come to: light that leaves a volume may have
    /// scattered tens of times there, on surfaces a few times.
    static constexpr float kMostVolumeWeight = 2, kMostSurfaceWeight = 4;

    /// Whether there are lamps that this ray may see.
    bool may_see_lamps() const {
        return scene_.features().lamps && (walk_.kind != kCameraRay || scene_.features().camera_lamps);
    }

    /// The first lamp that this ray sees before `end`, beyond the one it passed last.
    LampHit nearest_lamp(float end) const {
        if (!may_see_lamps())
            return {};
        return walk_.way.nearest(scene_.lights(), walk_.ray, walk_.kind, walk_.bounces, end);
    }

    bool pass_lamp(const LampHit& lamp) {
        const float weight = mis_weight(lamp.number, [&] { return lamp.pdf; });
        if (weight > 0)
            add(walk_.beta * lamp.Le * tint(lamp.number, lamp.place.first) * weight, From::met);
        walk_.way.pass(lamp);
        walk_.ray.t_min = std::max(lamp.distance, walk_.ray.t_min);
        return true;
    }

    /// A share of the camera's light for which the film is to stay open. Divided, not multiplied by a third,
    /// so that all of it leaves an alpha of 0.
    void let_through(Rgb share) { out_.alpha -= (share.x + share.y + share.z) / 3; }

    bool escape() {
        if (walk_.kind == kCameraRay && request_.transparent_film) {
            add_suns();
            let_through(walk_.beta);
            return false;
        }
        add_suns();
        const Rgb Le = scene_.background(walk_.ray.d, walk_.kind, walk_.history);
        if (is_zero(Le))
            return false;
        const std::uint32_t number = scene_.lights().world_number();
        const auto pdf = [&] { return scene_.lights().world()->pdf(walk_.ray.d); };
        add(walk_.beta * Le * mis_weight(number, pdf), From::background);
        if constexpr (k.parts)
            see_light(Le);
        return false;
    }

    /// Lamps at infinity that this direction meets.
    void add_suns() {
        if (!may_see_lamps())
            return;
        const auto meet = [&](std::uint32_t number, const LightHit& hit) {
            if (hit.distance < kInfinity || !sees(scene_.lights().lamp(number), walk_.kind, walk_.bounces))
                return;
            add(walk_.beta * hit.Le * tint(number, kInfinity) * mis_weight(number, [&] { return hit.pdf; }),
                From::met);
        };
        scene_.lights().for_each_lamp_hit({walk_.ray.o, walk_.ray.d, 0, kInfinity, walk_.ray.time}, meet);
    }

    /// What the lamp's nodes make of its light; distance: from the last vertex.
    Rgb tint(std::uint32_t lamp, float distance) const {
        if (!scene_.features().lamp_shaders)
            return Rgb(1);
        const Ray ray{walk_.way.vertex(), walk_.ray.d, 0, kInfinity, walk_.ray.time};
        return scene_.lamp_tint(lamp, ray, distance, walk_.kind, walk_.history);
    }

    /// Weight of light that scattering found, against light sampling at the last vertex.
    template <class Pdf>
    float mis_weight(std::uint32_t light, Pdf&& pdf) const {
        if (scene_.lights().linked() && walk_.kind != kCameraRay) {
            const Linking& linking = scene_.lights().linking(light);
            if (!linking.lights(walk_.receiver))
                return 0;
            // What may block it is known on shadow rays alone.
            if (linking.blockers != Linking::kAll && !walk_.previous_specular)
                return 0;
        }
        if (walk_.previous_specular || (light_visibility(scene_, light) & sampling_kinds(walk_.kind)) == 0)
            return 1;
        const Receiver at(walk_.way.vertex(), walk_.ray.time, walk_.receiver);
        return power_heuristic(walk_.previous_pdf, scene_.lights().selection_pdf(at, light) * pdf());
    }

    ShadingPoint shading(const Hit& hit) const {
        ShadingPoint point = scene_.shading_point(hit, walk_.ray, walk_.kind);
        point.history = walk_.history;
        point.history.length += walk_.way.travelled() + hit.t;
        return point;
    }

    const FieldRegion* region_at(Vec3f p, FieldPart part) {
        if (!k.learning || !compiled::field || !request_.field || !request_.use.any())
            return nullptr;
        ++ws_.counters.field_queries;
        return request_.field->find(p, part);
    }
    Guide guide_at(const FieldRegion* region, Vec3f p, float most_weight) const {
        if constexpr (k.learning) {
            // Each guided direction may weigh up to 1 / (1 - share), and many in a row the product of that: a
            // path whose weight has grown is guided less, and not at all from most_weight on.
            if (region && request_.use.directions)
                return {*region, p, std::min(region->guided_share, 1 - walk_.guided_weight / most_weight)};
        }
        return {};
    }
    /// The same for the media in ws_.tracking.shares.
    Guide guide_in_volume(const FieldRegion* region, Vec3f p) const {
        Guide guide = guide_at(region, p, kMostVolumeWeight);
        if (guide.active() && ws_.tracking.shares.size() == 1)
            guide.fold_in(ws_.tracking.shares[0].phase, walk_.ray.d);
        return guide;
    }

    /// set: of receivers that the medium's object is in.
    void light_volume(Vec3f p, std::uint8_t set, const PhaseMixture& phase, const Guide& guide) {
        const auto direct =
            sample_direct(scene_, {p, walk_.ray.time, set}, kVolumeRay, walk_.history, sampler_);
        if (!direct)
            return;
        float pdf = 0;
        const Rgb f = phase.eval(-walk_.ray.d, direct->light.wi, pdf);
        add_direct(*direct, p, f, guide.mixed(pdf, direct->light.wi));
    }

    void light_surface(const ShadingPoint& point, const Bsdf& bsdf, const Guide& guide) {
        const auto direct = sample_direct(scene_, {point.p, walk_.ray.time, point.instance->receiver_set},
                                          kDiffuseRay, walk_.history, sampler_);
        if (!direct)
            return;
        float pdf = 0;
        bool crosses = false;
        const Rgb f = bsdf.eval(point.wo, direct->light.wi, pdf, crosses, direct->kinds);
        if (is_zero(f))
            return;
        const First before = walk_.first;
        if (walk_.first == First::none) {
            walk_.first = First::surface;
            if constexpr (k.parts)
                shares_ = bsdf.shares(point.wo, BsdfSample{direct->light.wi, Rgb(0)});
        }
        add_direct(*direct, scene_.departure(point, direct->light.wi, crosses).o, f,
                   guide.mixed(pdf, direct->light.wi));
        walk_.first = before;
    }

    void add_direct(const DirectSample& direct, Vec3f p, Rgb f, float pdf) {
        const Rgb T = shadow_transmittance<without_parts(k)>(scene_, settings_, p, walk_.ray.time, direct,
                                                             sampler_, ws_);
        if (is_zero(T))
            return;
        const float weight = direct.light.delta || direct.alone ? 1 : power_heuristic(direct.light.pdf, pdf);
        add(walk_.beta * f * T * direct.light.Li * (weight / direct.light.pdf), From::sampled);
    }

    void add_surface_emission(const ShadingPoint& point, Rgb Le) {
        const std::uint32_t number = scene_.light_of_instance(scene_.number_of(*point.instance));
        float weight = 1;
        if (number != Scene::kNoLight) {
            weight = mis_weight(number, [&] {
                return scene_.lights().mesh(number).pdf(point.triangle, walk_.way.vertex(), point.p);
            });
        }
        add(walk_.beta * Le * weight, From::met);
    }

    void add_volume_emission(Rgb emitted) {
        if (is_zero(emitted))
            return;
        (walk_.first == First::surface ? out_.surface : out_.volume) += emitted;
        if constexpr (k.parts) {
            tell_apart(emitted, From::met);
            if (!walk_.featured)
                ws_.parts.feature_albedo += min(emitted, Rgb(1));
        }
        if (OpenSegment* segment = record_.current())
            segment->undecided += emitted;
        if (walk_.bounces == 0)
            out_.emission += emitted;
    }

    /// How light was found: by sampling a light, or by meeting something that shines.
    enum class From { sampled, met, background };
    void add(Rgb light, From from) {
        (walk_.first == First::volume ? out_.volume : out_.surface) += light;
        if (walk_.bounces == 0 && from == From::met)
            out_.emission += light;
        if constexpr (k.parts)
            tell_apart(light, from);
    }

    // --- What passes ask for beside the radiance: SampleParts

    void tell_apart(Rgb light, From from) {
        SampleParts& parts = ws_.parts;
        if (walk_.first == First::none) {
            if (from == From::background)
                parts.environment += light;
            return;
        }
        Rgb(&sums)[4] = walk_.bounces == (from == From::sampled ? 0 : 1) ? parts.direct : parts.indirect;
        if (walk_.first == First::volume) {
            sums[SampleParts::volume] += light;
            return;
        }
        sums[SampleParts::diffuse] += light * shares_.diffuse;
        sums[SampleParts::glossy] += light * shares_.glossy;
        sums[SampleParts::transmission] += light * shares_.transmission;
    }

    /// Colours, mattes and features where a path meets a surface.
    void see_surface(const ShadingPoint& point, const Bsdf& bsdf) {
        SampleParts& parts = ws_.parts;
        if (walk_.first == First::none) {
            const LobeShares colors = bsdf.colors(point.wo);
            parts.color[SampleParts::diffuse] += walk_.beta * colors.diffuse;
            parts.color[SampleParts::glossy] += walk_.beta * colors.glossy;
            parts.color[SampleParts::transmission] += walk_.beta * colors.transmission;
            const float covered = mean(walk_.beta * (Rgb(1) - min(bsdf.transparency, Rgb(1))));
            if (covered > 0)
                parts.mattes.push_back(scene_.matte(point, covered));
        }
        constexpr float kMostlyTransparent = 0.75f;
        if (!is_zero(bsdf.emission))
            see_light(bsdf.emission);
        if (walk_.featured || !bsdf.has_smooth() || mean(bsdf.transparency) > kMostlyTransparent)
            return;  // behind glass and mirrors the features are those of what is seen there
        see(bsdf.albedo(point.wo), point.ns, walk_.way.travelled() + length(point.p - walk_.ray.o));
    }
    /// The features of a point in a volume: the path's throughput holds the albedo already. It has no normal.
    void see_volume(float t) {
        if (!walk_.featured)
            see(Rgb(1), Vec3f(0), walk_.way.travelled() + t);
    }
    /// Emitters are told apart by their light.
    void see_light(Rgb Le) {
        if (!walk_.featured)
            ws_.parts.feature_albedo += walk_.beta * min(Le, Rgb(1));
    }
    void see(Rgb albedo, Vec3f n, float distance) {
        const float seen = mean(walk_.beta);
        ws_.parts.feature_albedo += walk_.beta * albedo;
        ws_.parts.feature_normal += seen * scene_.camera().to_camera_vector(n);
        ws_.parts.feature_depth += seen * distance;
        walk_.featured = true;
    }

    Rgb light() const { return out_.volume + out_.surface; }

    const Scene& scene_;
    const Settings& settings_;
    const SampleRequest& request_;
    PathSampler& sampler_;
    Workspace& ws_;
    std::conditional_t<k.learning, PathRecord, NoPathRecord> record_;

    Walk walk_;
    PixelSample out_;
    LobeShares shares_;  // of the light that the path brings, where its first event was on a surface
};

}  // namespace nephele
