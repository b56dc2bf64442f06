// SPDX-License-Identifier: GPL-3.0-or-later
// The story of a render on one page: passes of ever more samples over all tiles, until enough, out of time or
// cancelled.
#include "render.h"

#include <bit>
#include <ctime>

#include "base/parallel.h"

namespace nephele {

namespace {

constexpr int kTileSize = 32;
constexpr int kLargestPass = 16;  // samples per pixel between two looks at the clock's bigger picture

/// Samples per pixel after the pass that starts at `done`. The guiding learns at powers of two, so a pass
/// ends there: what a render learns does not depend on where it was interrupted.
int next_target(int done, int samples) {
    int power = 1;
    while (power <= done && power <= samples)
        power *= 2;
    return std::min({done + std::clamp(done, 1, kLargestPass), power, samples});
}

/// Number of the sample that stands for `stride` samples from `index` on. Those of one epoch are numbered one
/// after the other: of a net, points at even distances lie side by side.
std::uint32_t strided(std::uint32_t index, std::uint32_t stride) {
    if (stride <= 1)
        return index;
    const std::uint32_t begin = std::bit_floor(index);
    return begin + (index - begin + stride - 1) / stride;
}

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point t) {
    return std::chrono::duration<double>(Clock::now() - t).count();
}

double thread_cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

PixelFilter::Kind filter_kind(Settings::PixelFilter kind) {
    switch (kind) {
        case Settings::PixelFilter::box:
            return PixelFilter::Kind::box;
        case Settings::PixelFilter::gaussian:
            return PixelFilter::Kind::gaussian;
        case Settings::PixelFilter::blackman_harris:
            break;
    }
    return PixelFilter::Kind::blackman_harris;
}

void check_plain(const Settings& settings, const Scene& scene, const Film& film) {
    if (settings.integrator != Settings::Integrator::plain)
        return;
    if (film.has_parts()) {
        throw std::invalid_argument(
            "the plain integrator tells light apart as Volume and Surface alone; leave its other light "
            "passes, "
            "cryptomattes and denoising passes out, or use integrator = path");
    }
    if (scene.features().shadow_linking) {
        throw std::invalid_argument(
            "the plain integrator finds light by running into it, so that no surface can let it through; "
            "clear the lights' blocker collections, or use integrator = path");
    }
    for (const Lamp& lamp : scene.lights().lamps()) {
        if (lamp.delta()) {
            throw std::invalid_argument("light '" + lamp.name +
                                        "' has no size, so the plain integrator can never find it; " +
                                        "give it a radius or angle, or use integrator = path");
        }
    }
}

FilmSource checked(FilmSource f) {
    const bool good =
        f.x0 >= 0 && f.y0 >= 0 && f.x0 < f.x1 && f.y0 < f.y1 && f.x1 <= f.width && f.y1 <= f.height;
    if (!good) {
        throw std::invalid_argument(
            "the film is " + std::to_string(f.width) + " x " + std::to_string(f.height) +
            " pixels, and the part to render is no part of that; set a resolution of at "
            "least 1 x 1 and a region inside it");
    }
    return f;
}

}  // namespace

Render::Render(std::shared_ptr<const Scene> scene, const Settings& settings, FilmSource frame)
    : scene_(std::move(scene)),
      settings_(settings),
      frame_(checked(std::move(frame))),
      film_(frame_.x1 - frame_.x0, frame_.y1 - frame_.y0, frame_.passes, film_needs()),
      filter_(filter_kind(settings.pixel_filter), settings.filter_width),
      learning_(*scene_, settings, film_.width(), film_.height()),
      kernel_(choose_kernel(settings, scene_->features(), learning_.active(), film_.has_parts())) {
    check_plain(settings_, *scene_, film_);
    const auto any = [&](std::initializer_list<PassId> passes) {
        return std::any_of(passes.begin(), passes.end(), [&](PassId p) { return film_.has(p); });
    };
    request_.transmittance = any({PassId::transmittance});
    request_.majorant_depth = any({PassId::majorant_optical_depth});
    request_.features =
        any({PassId::depth, PassId::mist, PassId::normal, PassId::albedo, PassId::volume_albedo,
             PassId::position, PassId::vector, PassId::uv, PassId::object_index, PassId::material_index});
    request_.vector = film_.has(PassId::vector);
    request_.film_size = {static_cast<float>(frame_.width), static_cast<float>(frame_.height)};
    request_.opaque_alpha = frame_.opaque_alpha;
    if (film_.has(PassId::mist))
        request_.mist = &frame_.mist;
    request_.transparent_film = frame_.transparent;
    note_learned();
}

Render::~Render() {
    cancel();
    if (thread_.joinable())
        thread_.join();
}

void Render::start() {
    if (state_ != State::idle)
        throw std::logic_error("this render has been started before; make a new one");
    state_ = State::running;
    start_ = Clock::now();
    thread_ = std::thread([this] { run(); });
}

void Render::run() {
    State end = State::done;
    try {
        const int threads = settings_.threads > 0 ? settings_.threads : tbb::task_arena::automatic;
        tbb::task_arena arena(threads);
        int done = lowest_count();
        samples_done_ = done;
        bool reached = enough();
        while (done < settings_.samples && !must_stop() && !reached) {
            hold_while_paused();
            execute_in(arena, [&] {
                learn();
                render_pass(next_target(done, settings_.samples));
            });
            done = lowest_count();
            samples_done_ = done;
            reached = enough();
        }
        if (cancelled_)
            end = State::cancelled;
    } catch (...) {
        failure_ = std::current_exception();  // rethrown by wait()
        end = State::failed;
    }
    const std::lock_guard lock(mutex_);
    statistics_.render_seconds = seconds_since(start_);
    state_ = end;
    finished_.notify_all();
}

FilmNeeds Render::film_needs() const {
    return {settings_.target_error > 0 || settings_.estimate_error, adapts(settings_)};
}

/// Notes the error so far, where it is to be known; returns whether it is at the target.
bool Render::enough() {
    constexpr int kFirst = 16;  // samples before which the estimate says little
    if (!film_needs().error || samples_done_ < 2)
        return false;
    const double error = film_.relative_error();
    const double target = double{settings_.target_error};
    const bool reached = target > 0 && samples_done_ >= kFirst && error <= target;
    const std::lock_guard lock(mutex_);
    statistics_.errors.push_back(
        {seconds_since(start_), statistics_.render_cpu_seconds, samples_done_, error});
    statistics_.target_reached = reached;
    return reached;
}

void Render::learn() {
    const auto begin = Clock::now();
    if (!learning_.update(samples_done_))
        return;
    const std::lock_guard lock(mutex_);
    statistics_.train_seconds += seconds_since(begin);
    note_learned();
}

/// Notes what others may ask of the learning while it goes on.
void Render::note_learned() {
    if (const GuidingField* field = learning_.field()) {
        statistics_.field_regions = field->regions();
        statistics_.field_bytes = field->memory();
    }
    statistics_.techniques = learning_.chosen();
    statistics_.learning_bytes = learning_.bytes();
}

void Render::check_stands_still() const {
    if (state_ == State::running)
        throw std::logic_error("this render is running; cancel it and wait before its state is read");
}

bool Render::wait(double seconds) {
    std::unique_lock lock(mutex_);
    finished_.wait_for(lock, std::chrono::duration<double>(seconds),
                       [&] { return state_ != State::running; });
    if (state_ == State::failed)
        std::rethrow_exception(failure_);
    return state_ != State::running;
}

void Render::cancel() {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    resumed_.notify_all();
}

void Render::pause(bool paused) {
    const std::lock_guard lock(mutex_);
    paused_ = paused;
    resumed_.notify_all();
}

/// On the render's own thread alone: oneTBB's threads are the host's, too.
void Render::hold_while_paused() {
    std::unique_lock lock(mutex_);
    resumed_.wait(lock, [&] { return !paused_ || cancelled_; });
}

void Render::render_pass(int target) {
    const int columns = (film_.width() + kTileSize - 1) / kTileSize,
              rows = (film_.height() + kTileSize - 1) / kTileSize;
    parallel_for(0, columns * rows, [&](int tile) { render_tile(tile, target); });
}

void Render::render_tile(int tile, int target) {
    const double cpu = thread_cpu_seconds();
    Workspace ws;
    const int columns = (film_.width() + kTileSize - 1) / kTileSize;
    const int x0 = tile % columns * kTileSize, y0 = tile / columns * kTileSize;
    for (int y = y0; y < std::min(y0 + kTileSize, film_.height()); ++y) {
        for (int x = x0; x < std::min(x0 + kTileSize, film_.width()); ++x) {
            if (must_stop())
                break;
            render_pixel(x, y, target, ws);
        }
    }
    const std::lock_guard lock(mutex_);
    statistics_.rays += ws.counters.rays;
    statistics_.path_segments += ws.counters.segments;
    statistics_.density_lookups += ws.counters.density_lookups;
    statistics_.bound_violations += ws.counters.bound_violations;
    statistics_.nonfinite_samples += ws.nonfinite_samples;
    learning_.collect(ws);
    statistics_.render_cpu_seconds += thread_cpu_seconds() - cpu;
    if (statistics_.first_tile_seconds == 0)
        statistics_.first_tile_seconds = seconds_since(start_);
}

void Render::render_pixel(int x, int y, int target, Workspace& ws) {
    const std::uint32_t first = film_.count(x, y), end = static_cast<std::uint32_t>(target);
    SampleRequest request = request_;
    VspGuide guide;
    learning_.guide_pixel(x, y, request, guide);
    const std::uint32_t stride = learning_.stride(x, y);
    for (std::uint32_t n = first; n < end && !cancelled_; n = film_.count(x, y)) {
        const std::uint32_t i = strided(n, stride);
        learning_.ask(number_of_path(x, y, i), request);
        const PixelSample sample = take_sample(x, y, i, request, ws);
        film_.add(x, y, sample, settings_.film_exposure, std::min(stride, end - n), &ws.parts);
        learning_.add(x, y, sample, request.set, ws);
    }
    samples_taken_.fetch_add(film_.count(x, y) - first, std::memory_order_relaxed);
}

std::uint32_t Render::number_of_pixel(int x, int y) const {
    return static_cast<std::uint32_t>(y + frame_.y0) * static_cast<std::uint32_t>(frame_.width) +
           static_cast<std::uint32_t>(x + frame_.x0);
}

std::uint64_t Render::number_of_path(int x, int y, std::uint32_t index) const {
    return std::uint64_t{number_of_pixel(x, y)} << 24 | index;
}

PixelSample Render::take_sample(int x, int y, std::uint32_t index, const SampleRequest& request,
                                Workspace& ws) const {
    const int fx = x + frame_.x0, fy = y + frame_.y0;
    const std::uint32_t pixel = number_of_pixel(x, y);
    PathSampler sampler(settings_.sampler == Settings::Sampler::sobol,
                        static_cast<std::uint64_t>(settings_.seed), pixel, index);
    const Vec2f offset = filter_.sample(sampler.next2()), lens = sampler.next2();
    const Vec2f position{static_cast<float>(fx) + 0.5f + offset.x, static_cast<float>(fy) + 0.5f + offset.y};
    const float time =
        compiled::motion && scene_->features().motion ? scene_->shutter_time(sampler.next()) : 0;
    const Ray ray = scene_->camera().generate(
        position, lens, {static_cast<float>(frame_.width), static_cast<float>(frame_.height)}, time);
    if (ray.t_max < ray.t_min) {  // the lens shows nothing there
        PixelSample nothing;
        nothing.alpha = 0;
        return nothing;
    }
    if (learning_.active())
        sampler.enter_epoch(epoch_of(index));
    const std::uint64_t lookups = ws.counters.density_lookups;
    PixelSample s = kernel_.sample(*scene_, settings_, request, ray, sampler, ws);
    s.cost = static_cast<float>(ws.counters.density_lookups - lookups);
    if (!is_finite(s.volume + s.surface)) {
        ++ws.nonfinite_samples;
        s.volume = s.surface = s.emission = Rgb(0);
        ws.parts.clear();
        s.vsp = {};
        s.work = 0;
    }
    const float largest = max_component(s.volume + s.surface);
    if (settings_.clamp > 0 && largest > settings_.clamp) {
        s.volume *= settings_.clamp / largest;
        s.surface *= settings_.clamp / largest;
        s.emission *= settings_.clamp / largest;
        ws.parts.scale_light(settings_.clamp / largest);
    }
    return s;
}

bool Render::must_stop() const {
    return cancelled_ || (settings_.time_limit > 0 && samples_done_ > 0 &&
                          seconds() > static_cast<double>(settings_.time_limit));
}

int Render::lowest_count() const {
    std::uint32_t lowest = ~0u;
    for (int y = 0; y < film_.height(); ++y) {
        for (int x = 0; x < film_.width(); ++x)
            lowest = std::min(lowest, film_.count(x, y));
    }
    return static_cast<int>(lowest);
}

std::string Render::failure() const {
    if (state_ != State::failed)
        return {};
    try {
        std::rethrow_exception(failure_);
    } catch (const std::exception& e) {
        return e.what();
    }
}

double Render::fraction() const {
    const double all = static_cast<double>(settings_.samples) * film_.width() * film_.height();
    return std::min(1.0, static_cast<double>(samples_taken_) / all);
}

double Render::seconds() const {
    if (state_ == State::idle)
        return 0;
    return state_ == State::running ? seconds_since(start_) : statistics().render_seconds;
}

std::optional<double> Render::error() const {
    const std::lock_guard lock(mutex_);
    if (statistics_.errors.empty())
        return std::nullopt;
    return statistics_.errors.back().error;
}

RenderStatistics Render::statistics() const {
    const std::lock_guard lock(mutex_);
    return statistics_;
}

std::map<std::string, std::vector<double>> Render::save() const {
    check_stands_still();
    auto saved = film_.save();
    learning_.save(saved);
    return saved;
}

std::map<std::string, std::vector<double>> Render::knowledge() const {
    check_stands_still();
    return learning_.knowledge();
}

std::string Render::inherit(const std::map<std::string, std::vector<double>>& knowledge) {
    if (state_ != State::idle)
        throw std::logic_error("hand knowledge over before the render starts");
    std::string taken = learning_.inherit(knowledge);
    note_learned();
    return taken;
}

void Render::restore(const std::map<std::string, std::vector<double>>& saved) {
    if (state_ != State::idle)
        throw std::logic_error("restore a checkpoint before the render starts");
    film_.restore(saved);
    learning_.restore(saved);
    std::uint64_t taken = 0;
    for (const double n : saved.at("sample_count"))
        taken += static_cast<std::uint64_t>(n);
    samples_taken_ = taken;
    note_learned();
}

}  // namespace nephele
