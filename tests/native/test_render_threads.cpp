// SPDX-License-Identifier: GPL-3.0-or-later
// Renders on several threads while others look on, as Blender's preview and the command line do: passes are
// read, progress is asked for, the render is cancelled, saved and taken up again. The sanitizers run this;
// the images are the same, bit for bit, as one thread's.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "render.h"
#include "scene_fixtures.h"

namespace nephele {
namespace {

constexpr int kWidth = 36, kHeight = 34;  // four tiles, three of them in part

Settings settings_of(int threads, bool adaptive = false) {
    Settings settings;
    settings.threads = threads;
    settings.samples = 40;  // beyond the trial of the techniques
    settings.train_field = adaptive ? Settings::TrainField::auto_ : Settings::TrainField::always;
    settings.adaptive_sampling = adaptive;
    settings.target_error = adaptive ? 1e-9f : 0;
    settings.estimate_error = true;
    settings.max_bounces = 4;
    return settings;
}

FilmSource frame() {
    FilmSource film;
    film.width = film.x1 = kWidth;
    film.height = film.y1 = kHeight;
    film.passes = {PassId::combined, PassId::variance, PassId::depth, PassId::vsp_target};
    return film;
}

std::shared_ptr<const Scene> scene() {
    static const auto shared = std::make_shared<const Scene>(test::lit_fog());
    return shared;
}

void finish(Render& render) {
    render.start();
    while (!render.wait(0.05)) {
    }
}

/// Asks a render for all that may be asked for at any time.
void look(const Render& render) {
    for (const PassId pass :
         {PassId::combined, PassId::variance, PassId::depth, PassId::vsp_target, PassId::sample_count}) {
        for (const float v : render.film().read(pass))
            ASSERT_TRUE(std::isfinite(v));
    }
    EXPECT_LE(render.fraction(), 1);
    EXPECT_GE(render.seconds(), 0);
    EXPECT_LE(render.samples_done(), 40);
    EXPECT_TRUE(render.failure().empty());
    render.error();
    const RenderStatistics statistics = render.statistics();
    EXPECT_EQ(statistics.nonfinite_samples, 0u);
}

class RenderThreads : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Adaptive, RenderThreads, testing::Bool());

TEST(RenderPause, HoldsBetweenPassesAndChangesNothing) {
    Settings settings = settings_of(2);
    settings.samples = 1 << 20;
    Render render(scene(), settings, frame());
    render.pause(true);
    render.start();
    EXPECT_FALSE(render.wait(0.2));
    EXPECT_EQ(render.samples_done(), 0);
    render.pause(false);
    while (render.samples_done() < 4)
        EXPECT_FALSE(render.wait(0.01));
    render.pause(true);
    render.wait(0.5);  // the pass that was going on
    const int done = render.samples_done();
    render.wait(0.2);
    EXPECT_LE(render.samples_done(), done + 16);
    render.cancel();  // gets through a pause
    EXPECT_TRUE(render.wait(60));
    EXPECT_EQ(render.state(), Render::State::cancelled);
}

TEST_P(RenderThreads, OthersMayLookOn) {
    Render one(scene(), settings_of(1, GetParam()), frame());
    finish(one);
    Render render(scene(), settings_of(4, GetParam()), frame());
    std::atomic<bool> over{false};
    std::thread viewer([&] {
        while (!over)
            look(render);
    });
    finish(render);
    over = true;
    viewer.join();
    EXPECT_EQ(render.state(), Render::State::done);
    EXPECT_GT(render.statistics().field_regions, 0u);
    EXPECT_EQ(render.film().read(PassId::combined), one.film().read(PassId::combined));
    EXPECT_EQ(render.knowledge(), one.knowledge());
}

TEST_P(RenderThreads, CancelledAndTakenUpAgain) {
    Render whole(scene(), settings_of(1, GetParam()), frame());
    finish(whole);
    Render first(scene(), settings_of(4, GetParam()), frame());
    first.start();
    EXPECT_THROW(first.save(), std::logic_error);
    EXPECT_THROW(first.knowledge(), std::logic_error);
    while (first.samples_done() < 2)
        std::this_thread::yield();
    first.cancel();
    while (!first.wait(0.05)) {
    }
    ASSERT_EQ(first.state(), Render::State::cancelled) << "too fast to be cancelled";
    Render rest(scene(), settings_of(4, GetParam()), frame());
    rest.restore(first.save());
    finish(rest);
    EXPECT_EQ(rest.film().read(PassId::combined), whole.film().read(PassId::combined));
}

TEST(RenderThreadsTogether, TwoRendersOfOneScene) {
    Render a(scene(), settings_of(2), frame()), b(scene(), settings_of(2), frame());
    a.start();
    b.start();
    while (!a.wait(0.05) || !b.wait(0.05))
        look(b);
    EXPECT_EQ(a.film().read(PassId::combined), b.film().read(PassId::combined));
}

TEST(RenderThreadsTogether, ARunningRenderMayBeDestroyed) {
    Render render(scene(), settings_of(4), frame());
    render.start();
}

}  // namespace
}  // namespace nephele
