// SPDX-License-Identifier: GPL-3.0-or-later
// The plain twin: brute-force path tracing, written to be obviously right rather than fast. One colour
// channel per path, analog delta tracking against one global majorant, true trilinear lookups, no light
// sampling, no MIS, no roulette, independent random numbers. Light is found by running into it, so lamps
// without size are not for this integrator.
#include <stdexcept>

#include "integrators/integrator.h"
#include "integrators/subsurface.h"
#include "phase/phase_function.h"

namespace nephele {

namespace {

struct Collision {
    enum class What { none, scattered, absorbed } what = What::none;
    float t = 0;
    PhaseFunction phase;
};

/// A medium at a point of the segment, by its true filter.
struct Point {
    MediumPoint coefficients;
    Rgb emission;
};

Point medium_at(const Interval& interval, const Segment& segment, float t, Counters& counters) {
    const Medium& m = *interval.medium;
    if (m.program) {
        ++counters.density_lookups;
        const VolumePoint at = segment.volume_point(interval, t);
        return {m.program->coefficients(at), m.program->emission(at)};
    }
    float density = 1;
    if (m.grid) {
        counters.density_lookups += 8;
        density =
            m.grid->evaluate(m.filter, m.bounds->index_from_world.point(segment.ray_of(interval).at(t)));
    }
    const float emission = m.density_scales_emission ? density : 1;
    return {{m.sigma_s * density, m.sigma_t * density, m.phase}, m.emission * emission};
}

float global_majorant(const Medium& m, int channel) {
    const float scale = m.bounds ? m.bounds->majorants.global_majorant() : 1;
    return m.program ? scale : scale * m.sigma_t[channel];
}

/// Woodcock tracking of one channel through all media of the segment, anew from each point where one begins
/// or ends. Emission is gathered per step.
Collision collide(const Segment& segment, int channel, Rng& rng, Counters& counters, float& emitted) {
    float begin = kInfinity, end = 0;
    for (const Interval& i : segment.intervals) {
        begin = std::min(begin, i.t0);
        end = std::max(end, i.t1);
    }
    for (double t = double{begin}; t < double{end};) {  // floats cannot tell the steps of dense media apart
        const auto before = [&](float border) { return t < double{border}; };
        float majorant = 0, change = end;  // the same media are around up to there
        for (const Interval& i : segment.intervals) {
            const bool here = !before(i.t0) && before(i.t1);
            if (here)
                majorant += global_majorant(*i.medium, channel);
            if (here || before(i.t0))
                change = std::min(change, here ? i.t1 : i.t0);
        }
        const double next =
            majorant > 0 ? t + double{rng.next_exponential()} / double{majorant} : double{kInfinity};
        const bool passes = next >= double{change};
        const auto at = static_cast<float>(next);
        const auto step = static_cast<float>(std::min(next, double{change}) - t);
        float sigma_t = 0, sigma_s = 0;
        PhaseFunction phase;
        for (const Interval& i : segment.intervals) {
            if (before(i.t0) || !before(i.t1))
                continue;
            if (step < kInfinity && i.medium->emits()) {
                const auto on_the_way = static_cast<float>(t + double{step} * double{rng.next()});
                emitted += medium_at(i, segment, on_the_way, counters).emission[channel] * step;
            }
            if (passes)
                continue;
            const MediumPoint m = medium_at(i, segment, at, counters).coefficients;
            sigma_t += m.sigma_t[channel];
            const float s = m.sigma_s[channel];
            sigma_s += s;
            if (s > 0 && rng.next() * sigma_s < s)
                phase = m.phase;
        }
        t = std::min(next, double{change});
        if (passes)
            continue;
        const float u = rng.next() * majorant;
        if (u < sigma_s)
            return {Collision::What::scattered, at, phase};
        if (u < sigma_t)
            return {Collision::What::absorbed, at, {}};
    }
    return {};
}

}  // namespace

PixelSample sample_plain(const Scene& scene, const Settings& settings, const SampleRequest& request,
                         const Ray& camera_ray, PathSampler& sampler, Workspace& ws) {
    Rng& rng = sampler.rng();
    const int channel = std::min(static_cast<int>(rng.next() * 3), 2);
    PixelSample out;
    Ray ray = camera_ray;
    std::uint32_t kind = kCameraRay;
    float beta = 3;  // one channel of three
    int surface_bounces = 0, volume_bounces = 0;
    RayHistory history;
    history.length = -camera_ray.t_min;
    float travelled = 0;  // since the last bounce, where surfaces let the ray through
    bool volume_first = false;
    std::uint8_t receiver = 0;
    const auto lights_it = [&](std::uint32_t light) {
        return kind == kCameraRay || !scene.lights().linked() ||
               scene.lights().linking(light).lights(receiver);
    };
    const auto add = [&](float light) { (volume_first ? out.volume : out.surface)[channel] += beta * light; };
    for (;;) {
        ++ws.counters.rays;
        ++ws.counters.segments;
        const int bounces = surface_bounces + volume_bounces;
        const Hit hit = scene.intersect(ray, kind);
        const float end = std::min(hit.t, ray.t_max);
        {  // lamps on the way; each needs the transmittance up to it, so each gets its own walk
            scene.lights().for_each_lamp_hit(
                ray.part(ray.t_min, end), [&](std::uint32_t number, const LightHit& lamp) {
                    if ((scene.lights().lamp(number).visibility & kind) == 0 || !lights_it(number))
                        return;
                    float ignored = 0;
                    scene.find_media(ray.part(ray.t_min, lamp.distance), kind, ws.shadow);
                    if (collide(ws.shadow, channel, rng, ws.counters, ignored).what == Collision::What::none)
                        add((lamp.Le * scene.lamp_tint(number, ray, lamp.distance, kind, history))[channel]);
                });
        }
        scene.find_media(ray.part(ray.t_min, end), kind, ws.segment);
        float emitted = 0;
        const Collision collision = collide(ws.segment, channel, rng, ws.counters, emitted);
        (bounces == 0 || volume_first ? out.volume : out.surface)[channel] += beta * emitted;
        if (collision.what == Collision::What::absorbed)
            break;
        if (collision.what == Collision::What::scattered) {
            if (bounces == 0)
                volume_first = true;
            if (bounces > settings.max_bounces || volume_bounces > settings.volume_bounces)
                break;
            ++volume_bounces;
            receiver = scene.receiver_set_at(ws.segment, collision.t);
            ray = {ray.at(collision.t), collision.phase.sample(-ray.d, rng.next2()), 0, kInfinity, ray.time};
            kind = kVolumeRay;
            history = history.after(kind, false);
            travelled = 0;
            continue;
        }
        if (!hit.valid()) {
            if (bounces == 0 && request.transparent_film) {
                out.alpha -= beta / 3;
            } else {
                add(scene.background(ray.d, kind, history)[channel]);
            }
            break;
        }
        ShadingPoint point = scene.shading_point(hit, ray, kind);
        if (kind == kCameraRay && point.instance->holdout) {
            out.alpha = 0;
            break;
        }
        point.history = history;
        point.history.length += travelled + hit.t;
        const Bsdf bsdf = make_bsdf(scene.program_of(point), point, scene.textures());
        const std::uint32_t light = scene.light_of_instance(scene.number_of(*point.instance));
        if (light == Scene::kNoLight || lights_it(light))
            add(bsdf.emission[channel]);
        if (bounces == 0 && request.transparent_film)
            out.alpha -= beta / 3 * bsdf.holdout[channel];
        auto sample = bsdf.sample(point.wo, rng.next(), rng.next2());
        if (!sample)
            break;
        beta *= sample->weight[channel];
        if (sample->below) {
            const auto emerged = walk_below(scene, point, *sample->below, sample->wi, rng, ws.counters);
            if (!emerged)
                break;
            beta *= emerged->weight[channel];
            point = emerged->point;
            const Vec3f n = subsurface_normal(scene.program_of(point), point, scene.textures());
            sample = diffuse_bsdf(point, n).sample(point.wo, rng.next(), rng.next2());
            if (!sample)
                break;
        }
        if (beta == 0)
            break;
        if (sample->kind == 0) {
            ++history.transparent;
            travelled += hit.t;
            ray = {point.off(-point.ng), sample->wi, 0, kInfinity, ray.time};
            continue;
        }
        const Vec3f o = scene.departure(point, sample->wi, sample->crosses).o;
        ray = {o, sample->wi, 0, kInfinity, ray.time};
        if (bounces > settings.max_bounces || surface_bounces > settings.surface_bounces)
            break;
        ++surface_bounces;
        receiver = point.instance->receiver_set;
        kind = sample->kind;
        history = history.after(kind, sample->specular);
        travelled = 0;
    }
    return out;
}

}  // namespace nephele
