// SPDX-License-Identifier: GPL-3.0-or-later
// The path tracer: null-collision free flights, next-event estimation at every vertex in volumes and on
// surfaces, multiple importance sampling (power heuristic) between light sampling and scattering, Russian
// roulette and splitting. What was learned so far, by the pixel and by the guiding field, may guide every one
// of these decisions.
//
// A path is a walk of segments. Each runs from the last vertex to the next surface, lamp or the world; on it
// the path either scatters in a volume or arrives at the end. Lamps are transparent to rays: they add their
// light and the ray goes on.
#include "integrators/path_light.h"
#include "integrators/primary.h"
#include "integrators/roulette.h"
#include "integrators/subsurface.h"

namespace nephele {

namespace {

template <KernelTraits k>
class Path : private PathLight<k> {
    using Base = PathLight<k>;

  public:
    using Base::Base;

    PixelSample trace() {
        if constexpr (k.parts)
            ws_.parts.clear();
        if constexpr (k.learning) {
            std::optional<VspGuide> guide;
            if (request_.guide)
                guide = *request_.guide;
            record_.open({SegmentGuiding(settings_, guide, 1)}, light());
        }
        while (extend()) {
        }
        out_.vsp_achieved = walk_.first == First::volume;
        if constexpr (k.learning) {
            record_.close(1, light());
            out_.work = record_.close_camera(light(), out_.vsp, out_.vsp_target);
        }
        return out_;
    }

  private:
    static constexpr KernelTraits kTracking = without_parts(k);
    using Base::add_surface_emission, Base::add_volume_emission, Base::escape, Base::see_surface,
        Base::see_volume, Base::shares_, Base::guide_at, Base::guide_in_volume, Base::kMostSurfaceWeight,
        Base::let_through, Base::light, Base::light_surface, Base::light_volume, Base::nearest_lamp,
        Base::out_, Base::pass_lamp, Base::record_, Base::region_at, Base::request_, Base::sampler_,
        Base::scene_, Base::settings_, Base::shading, Base::walk_, Base::ws_;
    using typename Base::First;
    using typename Base::Guide;

    /// Of a direction, as in FieldSample.
    struct Densities {
        float pdf = 0, scatter_pdf = 0, guide_pdf = -1, scattering = 0;
    };
    /// A vertex and the direction in which the path leaves it.
    struct Departed {
        Vec3f o, vertex;  ///< start of the ray, and the vertex itself
        Vec3f wi;
        Densities densities;
        bool specular;
        std::uint32_t kind;
        FieldPart part;
        std::uint8_t receiver;  ///< set that its object is in, see Linking
    };

    /// One segment; false where the branch ends.
    bool extend() {
        ++ws_.counters.rays;
        ++ws_.counters.segments;
        const Hit hit = scene_.intersect(walk_.ray, walk_.kind);
        const float end = std::min(hit.t, walk_.ray.t_max);
        const LampHit lamp = nearest_lamp(end);
        if (walk_.kind == kCameraRay && !primary_done_) {
            primary_done_ = true;
            record_transmittance(scene_, settings_, request_, walk_.ray.part(walk_.ray.t_min, end), sampler_,
                                 ws_, out_);
            record_.start();  // what passes ask for does not count as the path's work
        }
        if constexpr (k.media) {
            scene_.find_media(walk_.ray.part(walk_.ray.t_min, std::min(end, lamp.distance)), walk_.kind,
                              ws_.segment);
            if (request_.features && walk_.first == First::none && hit.valid())
                record_surface(scene_, request_, shading(hit), walk_.clear, out_, recorded_);
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
        OpenSegment* segment = record_.current();
        if (!segment)
            return sample_flight<kTracking>(ws_.segment, ws_.tracking, settings_, walk_.beta, sampler_.rng(),
                                            ws_.counters);
        SegmentGuiding& guiding = segment->guiding;
        if (!guiding.active())
            return guiding.template plain_flight<kTracking>(walk_.beta, distance, sampler_, ws_);
        if (!guiding.resamples())
            return guiding.normalized_flight(walk_.beta, distance, sampler_, ws_);
        if (!guiding.walks(sampler_.rng()))
            return guiding.template plain_flight<kTracking>(walk_.beta, distance, sampler_, ws_);
        const Stream stream =
            guiding.template walk<kTracking>(scene_, walk_.beta, walk_.kind == kCameraRay, sampler_, ws_);
        const float p = guiding.probability(stream);
        segment->gathered = Rgb(0);
        const bool gathers = !exhausted_in_volumes() && guiding.gathers(p);
        if (gathers)
            gather(stream, *segment);
        const Flight flight = guiding.decide(stream, p, walk_.beta, distance, sampler_.rng());
        walk_.lit = gathers && flight.event == Flight::Event::scattered;
        return flight;
    }

    /// Takes direct light at a stream's candidate, wherever the path goes.
    void gather(const Stream& stream, OpenSegment& segment) {
        const Rgb beta = walk_.beta, before = light();
        const First first = walk_.first;
        walk_.beta = stream.volume;
        if (first == First::none)
            walk_.first = First::volume;
        const Vec3f p = walk_.ray.at(stream.t);
        const PhaseMixture phase(ws_.tracking.shares, walk_.beta);
        light_volume(p, receiver_set_at(stream.t), phase,
                     guide_in_volume(region_at(p, FieldPart::volume), p));
        walk_.first = first;
        walk_.beta = beta;
        segment.gathered = light() - before;
        segment.undecided += segment.gathered;
    }

    /// Set of receivers that the object of the medium at t of the segment is in.
    std::uint8_t receiver_set_at(float t) const {
        return scene_.features().light_linking ? scene_.receiver_set_at(ws_.segment, t) : std::uint8_t{0};
    }

    /// Whether the path may not scatter in volumes any more.
    bool exhausted_in_volumes() const {
        return walk_.bounces > settings_.max_bounces || walk_.volume_bounces > settings_.volume_bounces;
    }

    bool scatter_in_volume(const Flight& flight) {
        const Vec3f p = walk_.ray.at(flight.t);
        const std::uint8_t set = receiver_set_at(flight.t);
        record_.arrive(walk_.way.travelled() + flight.t);
        if (walk_.first == First::none) {
            walk_.first = First::volume;
            out_.volume_albedo = flight.albedo;
        }
        if constexpr (k.parts)
            see_volume(flight.t);
        if (exhausted_in_volumes())
            return false;
        const FieldRegion* region = region_at(p, FieldPart::volume);
        const Guide guide = guide_in_volume(region, p);
        const PhaseMixture phase(ws_.tracking.shares, walk_.beta);
        if (!walk_.lit)
            light_volume(p, set, phase, guide);
        walk_.lit = false;
        const int branches = roulette(region);
        if (branches <= 1)
            return branches == 1 && leave_volume(p, set, phase, guide, region);
        const std::vector<ScatterShare> shares = ws_.tracking.shares;  // which the branches overwrite
        const PhaseMixture kept(shares, walk_.beta);
        return branch(branches, [&] { return leave_volume(p, set, kept, guide, region); });
    }

    /// Goes on from a point in a volume.
    bool leave_volume(Vec3f p, std::uint8_t set, const PhaseMixture& phase, const Guide& guide,
                      const FieldRegion* region) {
        const Vec3f wo = -walk_.ray.d;
        const Vec2f u = sampler_.next2();
        Vec3f wi;
        if (guide.active() && sampler_.rng().next() < guide.share()) {
            wi = guide.sample(sampler_.rng().next(), u);
        } else {
            wi = phase.sample(wo, phase.several() ? sampler_.rng().next() : 0, u);
        }
        float scatter_pdf = 0;
        const Rgb f = phase.eval(wo, wi, scatter_pdf);
        const float guide_pdf = guide.pdf(wi), pdf = guide.mixed(scatter_pdf, guide_pdf);
        const float before = mean(walk_.beta);
        walk_.beta *= f / pdf;
        walk_.guided_weight *= scatter_pdf / pdf;
        ++walk_.volume_bounces;
        const Densities densities{pdf, scatter_pdf, guide_pdf, mean(walk_.beta) * pdf / before};
        return continue_from({p, p, wi, densities, false, kVolumeRay, FieldPart::volume, set}, region);
    }

    bool meet_surface(const ShadingPoint& point) {
        if (walk_.kind == kCameraRay && point.instance->holdout) {
            let_through(walk_.beta);
            return false;
        }
        const Bsdf bsdf = make_bsdf(scene_.program_of(point), point, scene_.textures());
        if (!k.media && request_.features && walk_.first == First::none)
            record_surface(scene_, request_, point, walk_.clear, out_, recorded_);
        if constexpr (k.parts)
            see_surface(point, bsdf);
        if (!is_zero(bsdf.emission))
            add_surface_emission(point, bsdf.emission);
        if (!is_zero(bsdf.holdout) && walk_.kind == kCameraRay && request_.transparent_film)
            let_through(walk_.beta * bsdf.holdout);
        return scatter_on_surface(point, bsdf);
    }

    bool scatter_on_surface(const ShadingPoint& point, const Bsdf& bsdf) {
        const bool exhausted =
            walk_.bounces > settings_.max_bounces || walk_.surface_bounces > settings_.surface_bounces;
        const FieldRegion* region =
            bsdf.has_smooth() && !exhausted ? region_at(point.p, part_facing(point.ng)) : nullptr;
        const Guide guide = guide_at(region, point.p, kMostSurfaceWeight);
        if (!exhausted && bsdf.has_smooth())
            light_surface(point, bsdf, guide);
        const int branches = exhausted ? 1 : roulette(region);
        if (branches <= 1)
            return branches == 1 && leave_surface(point, bsdf, guide, region, exhausted);
        return branch(branches, [&] { return leave_surface(point, bsdf, guide, region, exhausted); });
    }

    /// Goes on from a surface, straight through it where it is transparent there.
    bool leave_surface(const ShadingPoint& point, const Bsdf& bsdf, const Guide& guide,
                       const FieldRegion* region, bool exhausted) {
        const auto sample = sample_surface(point, bsdf, guide);
        if (!sample || is_zero(sample->weight))
            return false;
        const float before = mean(walk_.beta);
        walk_.beta *= sample->weight;
        if (sample->kind == 0) {  // straight through: no event
            const Vec3f o = point.off(-point.ng);
            const float step = length(o - walk_.ray.o);
            walk_.way.advance(step);
            ++walk_.history.transparent;
            walk_.clear *= mean(sample->weight);
            walk_.ray = {o, walk_.ray.d, 0, walk_.ray.t_max - step, walk_.ray.time};
            return true;
        }
        if (exhausted)
            return false;
        record_.arrive(walk_.way.travelled() + length(point.p - walk_.ray.o));
        if (walk_.first == First::none) {
            walk_.first = First::surface;
            if constexpr (k.parts)
                shares_ = bsdf.shares(point.wo, *sample);
        }
        if (sample->below)
            return emerge(point, *sample);
        ++walk_.surface_bounces;
        const auto from = scene_.departure(point, sample->wi, sample->crosses);
        Densities densities = drawn_;
        densities.scattering = mean(walk_.beta) * drawn_.pdf / before;
        return continue_from({from.o, from.vertex, sample->wi, densities, sample->specular, sample->kind,
                              part_facing(point.ng), point.instance->receiver_set},
                             region);
    }

    /// Goes on from where light comes out that went below the surface.
    [[gnu::noinline]] bool emerge(const ShadingPoint& point, const BsdfSample& entry) {
        auto out = walk_below(scene_, point, *entry.below, entry.wi, sampler_.rng(), ws_.counters);
        if (!out)
            return false;
        walk_.beta *= out->weight;
        out->point.history = point.history;
        const Vec3f n = subsurface_normal(scene_.program_of(out->point), out->point, scene_.textures());
        return scatter_on_surface(out->point, diffuse_bsdf(out->point, n));
    }

    /// A direction from the BSDF or the guide, whose densities are in drawn_; the sample's is that of both.
    std::optional<BsdfSample> sample_surface(const ShadingPoint& point, const Bsdf& bsdf,
                                             const Guide& guide) {
        const Vec2f lobe_u = sampler_.next2(), u = sampler_.next2();
        if (!guide.active()) {
            const auto sample = bsdf.sample(point.wo, lobe_u.x, u);
            if (sample)
                drawn_ = {sample->pdf, sample->pdf};
            return sample;
        }
        const bool guided = sampler_.rng().next() < guide.share();
        auto sample = guided ? bsdf.at(point.wo, guide.sample(sampler_.rng().next(), u), lobe_u.x)
                             : bsdf.sample(point.wo, lobe_u.x, u);
        if (!sample)
            return sample;
        if (sample->specular) {
            sample->weight /= 1 - guide.share();
            walk_.guided_weight /= 1 - guide.share();
            return sample;
        }
        const float guide_pdf = guide.pdf(sample->wi), pdf = guide.mixed(sample->pdf, guide_pdf);
        drawn_ = {pdf, sample->pdf, guide_pdf};
        sample->weight *= sample->pdf / pdf;
        walk_.guided_weight *= sample->pdf / pdf;
        sample->pdf = pdf;
        return sample;
    }

    /// How many branches leave a vertex: 1 where nothing is known of what they bring, and then plain roulette
    /// may still end the path.
    int roulette(const FieldRegion* region) {
        if (!k.learning)
            return 1;
        const auto expected = expected_branches(request_, region, mean(walk_.beta));
        walk_.weighed = expected.has_value();
        if (!expected)
            return 1;
        walk_.beta /= *expected;
        walk_.clear /= *expected;
        return static_cast<int>(*expected + sampler_.rng().next());
    }

    /// Follows all branches but the last to their ends; the last is where the walk goes on, if it does.
    template <class Leave>
    bool branch(int branches, Leave&& leave) {
        const Walk here = walk_;
        for (int i = 1; i < branches; ++i) {
            const std::size_t opened = record_.size();
            bool goes_on = leave();
            while (goes_on)
                goes_on = extend();
            record_.close(opened, light());
            walk_ = here;
        }
        return leave();
    }

    /// Starts the next segment, unless Russian roulette ends the path.
    bool continue_from(const Departed& from, const FieldRegion* region) {
        if (k.learning && request_.field && (request_.teaches || request_.use.segments))
            open_segment(from, region);
        else
            record_.leave();
        ++walk_.bounces;
        if (!walk_.weighed && walk_.bounces > settings_.roulette_depth) {
            const float survive = std::min(1.0f, max_component(walk_.beta));
            if (!sampler_.rng().chance(survive))
                return false;
            walk_.beta /= survive;
        }
        walk_.ray = {from.o, from.wi, 0, kInfinity, walk_.ray.time};
        walk_.kind = from.kind;
        walk_.history = walk_.history.after(from.kind, from.specular);
        walk_.way = LampsOnTheWay(from.vertex);
        walk_.receiver = from.receiver;
        walk_.previous_pdf = from.densities.pdf;
        walk_.previous_specular = from.specular;
        return true;
    }

    void open_segment(const Departed& from, const FieldRegion* region) {
        std::optional<VspGuide> guide;
        if (k.media && region && request_.use.segments)
            guide = region->vsp(from.wi);
        OpenSegment segment{SegmentGuiding(settings_, guide, mean(walk_.beta))};
        segment.vertex.p = from.vertex;
        segment.vertex.wi = from.wi;
        if (!from.specular) {
            segment.vertex.pdf = from.densities.pdf;
            segment.vertex.scatter_pdf = from.densities.scatter_pdf;
            segment.vertex.guide_pdf = from.densities.guide_pdf;
            segment.vertex.scattering = from.densities.scattering;
        }
        segment.vertex.part = from.part;
        record_.open(segment, light());
    }

    Densities drawn_;  // of the direction that sample_surface drew last
    bool primary_done_ = false, recorded_ = false;
};

template <KernelTraits k>
PixelSample sample_path(const Scene& scene, const Settings& settings, const SampleRequest& request,
                        const Ray& ray, PathSampler& sampler, Workspace& ws) {
    return Path<k>(scene, settings, request, ray, sampler, ws).trace();
}

}  // namespace

PixelSample sample_plain(const Scene&, const Settings&, const SampleRequest&, const Ray&, PathSampler&,
                         Workspace&);

Workspace::Workspace() = default;
Workspace::~Workspace() = default;

namespace {

// The sets of traits that there is a kernel for, each with and without learning. Programs and chromatic media
// cost the others less than 0.3 % (docs/performance.md), and are always in.
constexpr KernelTraits kSurfaces{.media = false,
                                 .overlap = false,
                                 .emission = false,
                                 .programs = false,
                                 .chromatic = false,
                                 .learning = false,
                                 .parts = false};
constexpr KernelTraits media_traits(bool overlap, bool emission) {
    return {.overlap = overlap && compiled::overlap,
            .emission = emission && compiled::volume_emission,
            .learning = false,
            .parts = false};
}
/// Passes that tell light apart cost more than learning that is not asked for: these kernels always can
/// learn.
constexpr KernelTraits with_parts(KernelTraits k) {
    k = with_learning(k);
    k.parts = compiled::passes;
    return k;
}

template <KernelTraits k>
Kernel kernel(bool learning) {
    constexpr KernelTraits kLearning = with_learning(k);
    return learning ? Kernel{sample_path<kLearning>, kLearning} : Kernel{sample_path<k>, k};
}

}  // namespace

Kernel choose_kernel(const Settings& settings, const SceneFeatures& features, bool learning, bool parts) {
    if (settings.integrator == Settings::Integrator::plain)
        return {sample_plain, std::nullopt};
    if (parts) {
        constexpr KernelTraits kWithoutMedia = with_parts(kSurfaces),
                               kAll = with_parts(media_traits(true, true));
        return features.media ? Kernel{sample_path<kAll>, kAll}
                              : Kernel{sample_path<kWithoutMedia>, kWithoutMedia};
    }
    if (!features.media)
        return kernel<kSurfaces>(learning);
    if (features.overlap)
        return features.volume_emission ? kernel<media_traits(true, true)>(learning)
                                        : kernel<media_traits(true, false)>(learning);
    return features.volume_emission ? kernel<media_traits(false, true)>(learning)
                                    : kernel<media_traits(false, false)>(learning);
}

std::vector<std::string> Kernel::list() const {
    if (!traits)
        return {"everything, plainly"};
    std::vector<std::string> names{"surfaces"};
    const auto add = [&](bool present, const char* name) {
        if (present)
            names.emplace_back(name);
    };
    add(traits->media, traits->overlap ? "overlapping media" : "one medium");
    add(traits->media && traits->emission, "volume emission");
    add(traits->learning, "learning");
    add(traits->parts, "parts of light");
    return names;
}

}  // namespace nephele
