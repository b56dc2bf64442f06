// SPDX-License-Identifier: GPL-3.0-or-later
// The path tracer: null-collision free flights, next-event estimation at every vertex in volumes and on
// surfaces, multiple importance sampling (power heuristic) between light sampling and scattering, Russian
// roulette.
//
// A path is a walk of segments. Each runs from the last vertex to the next surface, lamp or the world; on it
// the path either scatters in a volume or arrives at the end. Lamps are transparent to rays: they add their
// light and the ray goes on.
#include "integrators/direct_light.h"
#include "integrators/lamps_on_the_way.h"
#include "integrators/phase_mixture.h"
#include "integrators/primary.h"
#include "integrators/primary_guiding.h"

namespace nephele {

namespace {

template <bool kMedia>
class Path {
  public:
    Path(const Scene& scene, const Settings& settings, const SampleRequest& request, const Ray& ray,
         PathSampler& sampler, Workspace& ws)
        : scene_(scene),
          settings_(settings),
          request_(request),
          sampler_(sampler),
          ws_(ws),
          guiding_(settings, request.guide),
          ray_(ray) {}

    PixelSample trace() {
        while (extend()) {
        }
        out_.vsp_achieved = first_ == First::volume;
        if (guiding_.active())
            guiding_.finish(out_.volume - undecided_, out_.surface, gathered_, ws_.counters, out_);
        return out_;
    }

  private:
    /// One segment; false where the path ends.
    bool extend() {
        ++ws_.counters.rays;
        const Hit hit = scene_.intersect(ray_, kind_);
        const float end = std::min(hit.t, ray_.t_max);
        const LampHit lamp = nearest_lamp(end);
        if (kind_ == kCameraRay && !primary_done_) {
            primary_done_ = true;
            record_transmittance(scene_, settings_, request_, ray_.part(ray_.t_min, end), sampler_, ws_,
                                 out_);
            guiding_.start(ws_.counters);
        }
        if constexpr (kMedia) {
            scene_.find_media(ray_.part(ray_.t_min, std::min(end, lamp.distance)), kind_, ws_.segment);
            if (request_.features && first_ == First::none && hit.valid())
                record_surface(scene_, shading(hit), out_, recorded_);
            if (!ws_.segment.empty()) {
                const Flight flight = fly(end);
                add_volume_emission(flight.emitted);
                if (flight.event == Flight::Event::absorbed)
                    return false;
                if (flight.event == Flight::Event::scattered)
                    return scatter_in_volume(flight);
            }
        }
        if (lamp.distance < end)
            return pass_lamp(lamp);
        if (!hit.valid())
            return escape();
        return meet_surface(shading(hit));
    }

    /// The flight through the segment's media, whose ray ends after `distance`.
    Flight fly(float distance) {
        if (kind_ != kCameraRay || !guiding_.active())
            return sample_flight(ws_.segment, ws_.tracking, settings_, beta_, sampler_.rng(), ws_.counters);
        if (!guiding_.resamples())
            return guiding_.normalized_flight(beta_, distance, sampler_, ws_);
        const Stream stream = guiding_.walk(scene_, beta_, sampler_, ws_);
        const float p = guiding_.probability(stream);
        gathered_ = Rgb(0);
        const bool gathers = guiding_.gathers(p);
        if (gathers)
            gather(stream);
        const Flight flight = guiding_.decide(stream, p, beta_, distance, sampler_.rng());
        lit_ = gathers && flight.event == Flight::Event::scattered;
        return flight;
    }

    /// Takes direct light at a stream's candidate, wherever the path goes.
    void gather(const Stream& stream) {
        const Rgb beta = beta_, before = out_.volume;
        beta_ = stream.volume;
        first_ = First::volume;
        light_volume(ray_.at(stream.t), PhaseMixture(ws_.tracking.shares, beta_));
        first_ = First::none;
        beta_ = beta;
        gathered_ = out_.volume - before;
        undecided_ += gathered_;
    }

    /// The first lamp that this ray sees before `end`, beyond the one it passed last. The camera sees none.
    LampHit nearest_lamp(float end) const {
        if (kind_ == kCameraRay || !scene_.features().lamps)
            return {};
        return way_.nearest(scene_.lights(), ray_, kind_, bounces_, end);
    }

    bool pass_lamp(const LampHit& lamp) {
        add(beta_ * lamp.Le * mis_weight(lamp.number, [&] { return lamp.pdf; }));
        way_.pass(lamp);
        ray_.t_min = std::max(lamp.distance, ray_.t_min);
        return true;
    }

    bool escape() {
        if (kind_ == kCameraRay && request_.transparent_film) {
            out_.alpha = 1 - mean(beta_);
            return false;
        }
        add_suns();
        const Rgb Le = scene_.background(ray_.d, kind_);
        if (is_zero(Le))
            return false;
        const std::uint32_t number = scene_.lights().world_number();
        add(beta_ * Le * mis_weight(number, [&] { return scene_.lights().world()->pdf(ray_.d); }));
        return false;
    }

    /// Lamps at infinity that this direction meets.
    void add_suns() {
        if (kind_ == kCameraRay || !scene_.features().lamps)
            return;
        scene_.lights().for_each_lamp_hit({ray_.o, ray_.d}, [&](std::uint32_t number, const LightHit& hit) {
            if (hit.distance < kInfinity || !sees(scene_.lights().lamp(number), kind_, bounces_))
                return;
            add(beta_ * hit.Le * mis_weight(number, [&] { return hit.pdf; }));
        });
    }

    /// Weight of light that scattering found, against light sampling at the last vertex.
    template <class Pdf>
    float mis_weight(std::uint32_t light, Pdf&& pdf) const {
        if (previous_specular_ || (light_visibility(scene_, light) & sampling_kind(kind_)) == 0)
            return 1;
        return power_heuristic(previous_pdf_, scene_.lights().selection_pdf(way_.vertex(), light) * pdf());
    }

    ShadingPoint shading(const Hit& hit) const { return scene_.shading_point(hit, ray_, kind_); }

    bool scatter_in_volume(const Flight& flight) {
        const Vec3f p = ray_.at(flight.t), wo = -ray_.d;
        if (first_ == First::none) {
            first_ = First::volume;
            out_.volume_albedo = flight.albedo;
        }
        if (bounces_ > settings_.max_bounces || volume_bounces_ > settings_.volume_bounces)
            return false;
        const PhaseMixture phase(ws_.tracking.shares, beta_);
        if (!lit_)
            light_volume(p, phase);
        lit_ = false;
        const Vec2f u = sampler_.next2();
        const Vec3f wi = phase.sample(wo, ws_.tracking.shares.size() > 1 ? sampler_.rng().next() : 0, u);
        float pdf = 0;
        const Rgb f = phase.eval(wo, wi, pdf);
        beta_ *= f / pdf;
        ++volume_bounces_;
        return continue_from(p, wi, p, pdf, false, kVolumeRay);
    }

    void light_volume(Vec3f p, const PhaseMixture& phase) {
        const auto direct = sample_direct(scene_, p, kVolumeRay, bounces_, sampler_);
        if (!direct)
            return;
        float pdf = 0;
        const Rgb f = phase.eval(-ray_.d, direct->light.wi, pdf);
        add_direct(*direct, p, f, pdf);
    }

    bool meet_surface(const ShadingPoint& point) {
        const Bsdf bsdf = make_bsdf(scene_.program_of(point), point, scene_.textures());
        if (!kMedia && request_.features && first_ == First::none)
            record_surface(scene_, point, out_, recorded_);
        if (!is_zero(bsdf.emission))
            add_surface_emission(point, bsdf.emission);
        const bool exhausted =
            bounces_ > settings_.max_bounces || surface_bounces_ > settings_.surface_bounces;
        if (!exhausted && bsdf.has_smooth())
            light_surface(point, bsdf);
        const Vec2f lobe_u = sampler_.next2(), u = sampler_.next2();
        const auto sample = bsdf.sample(point.wo, lobe_u.x, u);
        if (!sample || is_zero(sample->weight))
            return false;
        beta_ *= sample->weight;
        if (sample->kind == 0) {  // straight through: no event
            const Vec3f o = offset_point(point.p, -point.ng);
            const float step = length(o - ray_.o);
            way_.advance(step);
            ray_ = {o, ray_.d, 0, ray_.t_max - step, ray_.time};
            return true;
        }
        if (exhausted)
            return false;
        if (first_ == First::none)
            first_ = First::surface;
        ++surface_bounces_;
        const auto from = scene_.departure(point, sample->wi, sample->crosses);
        return continue_from(from.o, sample->wi, from.vertex, sample->pdf, sample->specular, sample->kind);
    }

    void light_surface(const ShadingPoint& point, const Bsdf& bsdf) {
        const auto direct = sample_direct(scene_, point.p, kDiffuseRay, bounces_, sampler_);
        if (!direct)
            return;
        float pdf = 0;
        bool crosses = false;
        const Rgb f = bsdf.eval(point.wo, direct->light.wi, pdf, crosses);
        if (is_zero(f))
            return;
        const First before = first_;
        if (first_ == First::none)
            first_ = First::surface;
        add_direct(*direct, scene_.departure(point, direct->light.wi, crosses).o, f, pdf);
        first_ = before;
    }

    void add_direct(const DirectSample& direct, Vec3f p, Rgb f, float pdf) {
        const Rgb T = shadow_transmittance(scene_, settings_, p, ray_.time, direct, sampler_, ws_);
        if (is_zero(T))
            return;
        const float weight = direct.light.delta ? 1 : power_heuristic(direct.light.pdf, pdf);
        add(beta_ * f * T * direct.light.Li * (weight / direct.light.pdf));
    }

    void add_surface_emission(const ShadingPoint& point, Rgb Le) {
        const std::uint32_t number = scene_.light_of_instance(scene_.number_of(*point.instance));
        float weight = 1;
        if (number != Scene::kNoLight) {
            weight = mis_weight(number, [&] {
                return scene_.lights().mesh(number).pdf(point.triangle, way_.vertex(), point.p);
            });
        }
        add(beta_ * Le * weight);
        if (bounces_ == 0)
            out_.emission += beta_ * Le;
    }

    void add_volume_emission(Rgb emitted) {
        if (is_zero(emitted))
            return;
        (first_ == First::surface ? out_.surface : out_.volume) += emitted;
        if (first_ == First::none)
            undecided_ += emitted;
        if (bounces_ == 0)
            out_.emission += emitted;
    }

    void add(Rgb light) { (first_ == First::volume ? out_.volume : out_.surface) += light; }

    /// Starts the next segment, unless Russian roulette ends the path.
    bool continue_from(Vec3f o, Vec3f wi, Vec3f vertex, float pdf, bool specular, std::uint32_t kind) {
        ++bounces_;
        if (bounces_ > settings_.roulette_depth) {
            const float survive = std::min(1.0f, max_component(beta_));
            if (sampler_.rng().next() >= survive)
                return false;
            beta_ /= survive;
        }
        ray_ = {o, wi, 0, kInfinity, ray_.time};
        kind_ = kind;
        way_ = LampsOnTheWay(vertex);
        previous_pdf_ = pdf;
        previous_specular_ = specular;
        return true;
    }

    const Scene& scene_;
    const Settings& settings_;
    const SampleRequest& request_;
    PathSampler& sampler_;
    Workspace& ws_;
    PrimaryGuiding guiding_;

    Ray ray_;
    std::uint32_t kind_ = kCameraRay;
    Rgb beta_{1};
    int bounces_ = 0, surface_bounces_ = 0, volume_bounces_ = 0;
    enum class First { none, surface, volume } first_ = First::none;
    LampsOnTheWay way_;  // from the last vertex
    float previous_pdf_ = 0;
    bool previous_specular_ = true;  // the camera: nothing else could have found what it sees
    bool primary_done_ = false, recorded_ = false;
    bool lit_ = false;  // direct light was taken where the path scatters
    Rgb gathered_;      // direct light at the last stream's candidate, taken in any case
    Rgb undecided_;     // light of the volume that no decision had a part in, this included
    PixelSample out_;
};

template <bool kMedia>
PixelSample sample_path(const Scene& scene, const Settings& settings, const SampleRequest& request,
                        const Ray& ray, PathSampler& sampler, Workspace& ws) {
    return Path<kMedia>(scene, settings, request, ray, sampler, ws).trace();
}

}  // namespace

PixelSample sample_plain(const Scene&, const Settings&, const SampleRequest&, const Ray&, PathSampler&,
                         Workspace&);

SampleFunction choose_kernel(const Settings& settings, const SceneFeatures& features) {
    if (settings.integrator == Settings::Integrator::plain)
        return sample_plain;
    return features.media ? sample_path<true> : sample_path<false>;
}

}  // namespace nephele
