// SPDX-License-Identifier: GPL-3.0-or-later
#include "learning.h"

#include <algorithm>
#include <cstring>

#include "guiding/saved_rows.h"

namespace nephele {

namespace {

constexpr const char* kState = "learning_state";
constexpr const char* kChoice = "learning_choice";
constexpr const char* kTrial = "learning_trial";
constexpr const char* kPairs = "learning_pairs";
constexpr const char* kLessons = "field_lessons";

/// Lessons between two updates: more cost more time and memory than they bring.
constexpr double kMostLessons = 1 << 17;
constexpr double kLessonSamples = 4;  // of each pixel between two updates
constexpr double kUsualVertices = 8;  // of a path, before any was seen
/// Samples per pixel between which the techniques are judged, each time by those since the last update: the
/// field goes on learning, and early on it looks worse than it will be.
constexpr int kTrialBegins = 8, kTrialEnds = 32;

constexpr double kMostSamples = 1 << 24;  // per pixel, by the setting's range

[[noreturn]] void damaged(const char* name) {
    throw std::invalid_argument(std::string("the checkpoint is damaged ('") + name + "'); render without it");
}

/// Whether what a lesson's bytes say is a value of its types: neither a third truth nor a part that is not.
bool is_whole(const FieldSample& s) {
    const auto is_bool = [](const bool& b) {
        unsigned char byte;
        std::memcpy(&byte, &b, 1);
        return byte <= 1;
    };
    std::uint32_t part;
    std::memcpy(&part, &s.part, sizeof(part));
    return part < kFieldParts && is_bool(s.vsp.known) && is_bool(s.vsp.scattered) && is_bool(s.vsp.walked) &&
           is_bool(s.vsp.weighed);
}

bool is_power_of_two(int n) {
    return n > 0 && (n & (n - 1)) == 0;
}

bool guides_camera_rays(const Settings& settings, const SceneFeatures& features) {
    return compiled::vsp && settings.integrator == Settings::Integrator::path && features.media &&
           settings.vsp_primary && settings.distance_sampling != Settings::DistanceSampling::delta;
}

}  // namespace

FieldDecision decide_field(const Scene& scene, const Settings& settings) {
    const SceneFeatures& f = scene.features();
    const bool later_vsp =
        f.media && settings.vsp_secondary && settings.distance_sampling == Settings::DistanceSampling::vspg;
    if (!compiled::field || settings.train_field == Settings::TrainField::never)
        return {false, "switched off"};
    if (settings.integrator != Settings::Integrator::path)
        return {false, "the plain integrator guides nothing"};
    if (!(settings.guide_directions || later_vsp || settings.guided_roulette))
        return {false, "no setting asks for it"};
    if (settings.train_field == Settings::TrainField::always)
        return {true, "switched on"};
    if (settings.max_bounces == 0)
        return {false, "paths do not bounce"};
    if (!f.media && !f.surfaces)
        return {false, "nothing scatters"};
    const std::size_t lights = scene.lights().size();
    if (!f.surfaces && !f.grids && !f.programs && !f.overlap && lights <= 1 && !f.volume_emission)
        return {false, "one medium that does not vary, and one light"};
    return {true, "light arrives by way of several bounces"};
}

bool learns(const Scene& scene, const Settings& settings) {
    return guides_camera_rays(settings, scene.features()) || decide_field(scene, settings).trains ||
           adapts(settings);
}

Learning::Learning(const Scene& scene, const Settings& settings, int width, int height)
    : settings_(settings), width_(width) {
    if (guides_camera_rays(settings, scene.features()))
        guides_.emplace(width, height, settings);
    const bool trains = decide_field(scene, settings).trains;
    if (trains || adapts(settings_))
        image_.emplace(width, height);
    if (!trains)
        return;
    constexpr std::size_t kMebibyte = 1 << 20;
    field_.emplace(settings, static_cast<std::size_t>(settings.guiding_memory) * kMebibyte);
    asked_share_ = std::min(1.0, kMostLessons / (kUsualVertices * width * height));
    choice_ = TechniqueChoice(settings);
    if (!choice_.decided())
        pairs_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

void Learning::guide_pixel(int x, int y, SampleRequest& request, VspGuide& guide) const {
    if (guides_) {
        guide = guides_->guide(x, y);
        request.guide = &guide;
    }
    request.field = field();
    request.worth = image_ ? image_->worth(x, y) : 0;
}

void Learning::ask(std::uint64_t path, SampleRequest& request) const {
    request.key = path;
    if (!field_)
        return;
    request.set = choice_.draw(unit_float(static_cast<std::uint32_t>(
        hash_combine(static_cast<std::uint64_t>(settings_.seed) + 1, path) >> 32)));
    request.use = choice_.set(request.set);
    const double u = unit_float(
        static_cast<std::uint32_t>(hash_combine(static_cast<std::uint64_t>(settings_.seed), path) >> 32));
    request.teaches = u < asked_share_ && !retired();
}

std::uint32_t Learning::stride(int x, int y) const {
    constexpr int kFirst = 16;  // samples before which too little is known of the noise
    return adapts(settings_) && learned_at_ >= kFirst ? image_->stride(x, y) : 1;
}

void Learning::add(int x, int y, const PixelSample& sample, int set, Workspace& ws) {
    if (guides_)
        guides_->add(x, y, sample.vsp);
    if (!image_)
        return;
    const float radiance = mean(sample.volume + sample.surface);
    if (field_ && learned_at_ >= kTrialBegins && !choice_.decided())
        judge(x, y, radiance, sample.work, set, ws);
    image_->add(x, y, radiance, sample.work);
}

/// Notes what a sample says about its set.
void Learning::judge(int x, int y, float radiance, float work, int set, Workspace& ws) {
    PathPair& pair = pairs_[static_cast<std::size_t>(y * width_ + x)];
    const auto variance = pair.variance(set, radiance);
    const float scale = image_->scale(x, y);
    if (variance && scale > 0)
        ws.trial[static_cast<std::size_t>(set)].add(double{*variance} / (double{scale} * double{scale}),
                                                    double{work});
}

void Learning::collect(Workspace& ws) {
    lessons_.insert(lessons_.end(), ws.lessons.begin(), ws.lessons.end());
    for (std::size_t i = 0; i < trial_.size(); ++i)
        trial_[i] += ws.trial[i];
}

bool Learning::update(int samples) {
    if (!active() || !is_power_of_two(samples) || learned_at_ == samples)
        return false;
    if (guides_)
        guides_->update();
    if (image_ && (adapts(settings_) || !retired()))
        image_->update();
    if (field_ && !choice_.decided() && samples > kTrialBegins)
        end_round(samples >= kTrialEnds);
    if (field_ && !retired()) {
        // Of all paths up to the next update: there are as many samples until then as from the start on.
        const double expected =
            static_cast<double>(lessons_.size()) / asked_share_ * samples / (samples - learned_at_);
        field_->update(std::move(lessons_));
        lessons_ = {};
        asked_share_ = std::min({1.0, kMostLessons / std::max(expected, 1.0), kLessonSamples / samples});
    }
    learned_at_ = samples;
    return true;
}

/// Chooses by what the samples since the last update have shown, or goes on trying.
void Learning::end_round(bool last) {
    choice_.decide(trial_, last);
    trial_ = {};
    if (choice_.decided())
        pairs_ = {};
    else
        std::fill(pairs_.begin(), pairs_.end(), PathPair{});
}

/// Whether the field has turned out to be of no use.
bool Learning::retired() const {
    return choice_.decided() && !choice_.set(choice_.chosen()).any();
}

std::optional<Techniques> Learning::chosen() const {
    if (!field_ || !choice_.decided())
        return std::nullopt;
    return choice_.set(choice_.chosen());
}

std::size_t Learning::bytes() const {
    return (guides_ ? guides_->bytes() : 0) + (image_ ? image_->bytes() : 0) +
           (field_ ? field_->memory() : 0) + lessons_.capacity() * sizeof(FieldSample) +
           pairs_.capacity() * sizeof(PathPair);
}

void Learning::save(std::map<std::string, std::vector<double>>& saved) const {
    if (!active())
        return;
    saved[kState] = {static_cast<double>(learned_at_), asked_share_, static_cast<double>(choice_.chosen())};
    saved[kTrial] = flattened(std::vector(trial_.begin(), trial_.end()));
    saved[kPairs] = flattened(pairs_);
    if (guides_)
        guides_->save(saved);
    if (image_)
        image_->save(saved);
    if (field_) {
        field_->save(saved);
        saved[kLessons] = flattened(lessons_);
    }
}

void Learning::restore(const std::map<std::string, std::vector<double>>& saved) {
    if (!active())
        return;
    if (!saved.contains(kState) || saved.at(kState).size() != 3)
        throw std::invalid_argument(
            "the checkpoint holds nothing learned; render with the settings it was "
            "made with");
    const std::vector<double>& state = saved.at(kState);
    if (!(state[0] >= 0 && state[0] <= kMostSamples && state[1] > 0 && state[1] <= 1))
        damaged(kState);
    learned_at_ = static_cast<int>(state[0]);
    asked_share_ = state[1];
    choice_.restore(state[2]);
    const auto trial = unflattened<TrialSums>(saved, kTrial);
    if (trial.size() != trial_.size())
        damaged(kTrial);
    std::copy(trial.begin(), trial.end(), trial_.begin());
    if (choice_.decided())
        pairs_ = {};
    unflatten(saved, kPairs, pairs_);
    if (guides_)
        guides_->restore(saved);
    if (image_)
        image_->restore(saved);
    if (field_) {
        field_->restore(saved);
        lessons_ = unflattened<FieldSample>(saved, kLessons);
        if (!std::all_of(lessons_.begin(), lessons_.end(), is_whole))
            damaged(kLessons);
    }
}

std::map<std::string, std::vector<double>> Learning::knowledge() const {
    std::map<std::string, std::vector<double>> saved;
    if (guides_)
        guides_->save(saved);
    if (image_)
        image_->save(saved);
    if (field_) {
        field_->save(saved);
        saved[kChoice] = {static_cast<double>(choice_.chosen())};
    }
    return saved;
}

std::string Learning::inherit(const std::map<std::string, std::vector<double>>& knowledge) {
    constexpr float kWorthSamples = 8;  // of each pixel, however many there were
    std::vector<std::string> taken;
    if (field_ && knowledge.contains(GuidingField::kSavedAs)) {
        field_->restore(knowledge);
        taken.push_back("the field");
        // What paid there need not be allowed here.
        if (!choice_.decided() && knowledge.contains(kChoice) && knowledge.at(kChoice).size() == 1 &&
            choice_.allows(knowledge.at(kChoice)[0]))
            choice_.restore(knowledge.at(kChoice)[0]);
    }
    if (guides_ && guides_->inherit(knowledge, kWorthSamples))
        taken.push_back("the camera rays' guides");
    if (image_ && image_->inherit(knowledge, kWorthSamples))
        taken.push_back("the image's estimate");
    if (taken.empty())
        throw std::invalid_argument("nothing of it is of use here: the settings guide nothing that it knows");
    std::string out = taken[0];
    for (std::size_t i = 1; i < taken.size(); ++i)
        out += (i + 1 < taken.size() ? ", " : " and ") + taken[i];
    return out;
}

}  // namespace nephele
