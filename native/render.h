// SPDX-License-Identifier: GPL-3.0-or-later
// A render: takes a scene and settings, fills a film on all threads, can be watched and cancelled meanwhile.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "film/film.h"
#include "integrators/integrator.h"
#include "learning.h"
#include "scene/pixel_filter.h"
#include "scene/scene.h"

namespace nephele {

/// The frame and the part of it that is rendered. Row 0 is the bottom row; x1 and y1 are exclusive.
struct FilmSource {
    int width = 0, height = 0;
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool transparent = false;
    std::vector<PassId> passes;
    Mist mist;
    float opaque_alpha = 0.5f;  ///< see SampleRequest
};

/// How far a render had come at one time.
struct ErrorMark {
    double seconds = 0, cpu_seconds = 0;  ///< since the start; cpu: of all render threads
    int samples = 0;
    double error = 0;  ///< estimate of relMSE, see Film
};

struct RenderStatistics {
    std::uint64_t rays = 0, path_segments = 0, density_lookups = 0, nonfinite_samples = 0,
                  bound_violations = 0;
    double render_seconds = 0;      ///< wall clock
    double render_cpu_seconds = 0;  ///< of all render threads
    double train_seconds = 0;       ///< of render_seconds: learning between passes, wall clock
    double first_tile_seconds = 0;  ///< from start to the first finished tile, wall clock
    std::vector<ErrorMark> errors;  ///< after each pass, where the error is estimated
    bool target_reached = false;    ///< the error is at the target
    std::size_t field_regions = 0, field_bytes = 0;  ///< of the guiding field, after the last update
    std::optional<Techniques> techniques;            ///< what it is used for, once that is decided
    std::size_t learning_bytes = 0;                  ///< of all that is learned, after the last update
};

class Render {
  public:
    enum class State { idle, running, done, cancelled, failed };

    Render(std::shared_ptr<const Scene> scene, const Settings& settings, FilmSource film);
    /// Cancels and waits.
    ~Render();

    /// Begins on threads of its own and returns at once.
    void start();
    /// True once finished, however it ended; rethrows what a render thread threw.
    bool wait(double seconds);
    void cancel();
    /// Holds it before its next pass of samples, or lets it go on: for pictures that nobody sees.
    void pause(bool paused);

    State state() const { return state_; }
    /// What a render thread said when it failed, or nothing.
    std::string failure() const;
    /// Samples that every pixel has.
    int samples_done() const { return samples_done_; }
    /// Share of all samples taken, in [0, 1].
    double fraction() const;
    double seconds() const;
    /// The error as it was estimated last; nothing where it is not to be known, or not yet.
    std::optional<double> error() const;
    const Film& film() const { return film_; }
    const Kernel& kernel() const { return kernel_; }
    const FilmSource& frame() const { return frame_; }
    RenderStatistics statistics() const;
    /// The sums of film and guiding, for checkpoints. Throws std::logic_error while it runs.
    std::map<std::string, std::vector<double>> save() const;
    /// Takes up the sums of an earlier render of the same frame. Throws std::invalid_argument where they do
    /// not fit.
    void restore(const std::map<std::string, std::vector<double>>& saved);
    /// What it learned, for another render. Throws std::logic_error while it runs.
    std::map<std::string, std::vector<double>> knowledge() const;
    /// Starts from what another learned; see Learning.
    std::string inherit(const std::map<std::string, std::vector<double>>& knowledge);

  private:
    void run();
    void render_pass(int target);
    void render_tile(int tile, int target);
    void render_pixel(int x, int y, int target, Workspace& ws);
    std::uint32_t number_of_pixel(int x, int y) const;
    std::uint64_t number_of_path(int x, int y, std::uint32_t index) const;
    /// ws.parts belongs to it, where the film has parts.
    PixelSample take_sample(int x, int y, std::uint32_t index, const SampleRequest& request,
                            Workspace& ws) const;
    void learn();
    void note_learned();
    void check_stands_still() const;
    bool enough();
    FilmNeeds film_needs() const;
    bool must_stop() const;
    void hold_while_paused();
    int lowest_count() const;

    std::shared_ptr<const Scene> scene_;
    Settings settings_;
    FilmSource frame_;
    Film film_;
    PixelFilter filter_;
    SampleRequest request_;
    Learning learning_;
    Kernel kernel_;

    std::thread thread_;
    std::atomic<State> state_{State::idle};
    std::atomic<bool> cancelled_{false};
    bool paused_ = false;
    std::atomic<int> samples_done_{0};
    std::atomic<std::uint64_t> samples_taken_{0};
    std::chrono::steady_clock::time_point start_;
    std::exception_ptr failure_;

    mutable std::mutex mutex_;
    std::condition_variable finished_, resumed_;
    RenderStatistics statistics_;
};

}  // namespace nephele
