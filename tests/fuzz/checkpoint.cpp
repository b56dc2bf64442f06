// SPDX-License-Identifier: GPL-3.0-or-later
// Saved state, of checkpoints and of guiding files, with numbers altered and arrays cut, grown or taken away:
// what no archive's own checks can see. A render either refuses it with std::invalid_argument or goes on from
// it.
#include <cmath>
#include <stdexcept>

#include "bytes.h"
#include "render.h"
#include "scene_fixtures.h"

namespace nephele::fuzz {

namespace {

using State = std::map<std::string, std::vector<double>>;
constexpr int kWidth = 4, kHeight = 3;

/// Kinds of renders, by what they save.
Settings settings_of(std::size_t kind) {
    Settings settings;
    settings.threads = 1;
    settings.samples = 8;
    settings.max_bounces = 4;
    settings.train_field = kind == 0   ? Settings::TrainField::never
                           : kind == 1 ? Settings::TrainField::always
                                       : Settings::TrainField::auto_;
    settings.adaptive_sampling = kind == 3;
    settings.target_error = kind == 3 ? 1e-6f : 0;
    return settings;
}
constexpr std::size_t kKinds = 4;

FilmSource frame() {
    FilmSource film;
    film.width = film.x1 = kWidth;
    film.height = film.y1 = kHeight;
    film.passes = {PassId::combined, PassId::variance};
    return film;
}

void finish(Render& render) {
    render.start();
    while (!render.wait(0.1)) {
    }
}

/// The states that renders of each kind leave after a few samples.
struct Originals {
    std::shared_ptr<const Scene> scene = std::make_shared<const Scene>(test::lit_fog());
    State checkpoints[kKinds], knowledge[kKinds];

    Originals() {
        for (std::size_t kind = 0; kind < kKinds; ++kind) {
            Settings settings = settings_of(kind);
            settings.samples = 4;
            Render render(scene, settings, frame());
            finish(render);
            checkpoints[kind] = render.save();
            knowledge[kind] = render.knowledge();
        }
    }
};

double number(Bytes& in, double old) {
    switch (in.below(6)) {
        case 0:
            return double{in.real()};
        case 1:
            return in.take<std::uint32_t>();
        case 2:
            return std::bit_cast<std::uint32_t>(in.real());  // rows are kept as the bits of floats
        case 3:
            return old + in.take<std::int8_t>();
        case 4: {
            const bool word = old >= 0 && old <= std::numeric_limits<std::uint32_t>::max();
            return (word ? static_cast<std::uint32_t>(old) : 0) ^ 1u << in.below(32);
        }
        default:
            return in.take<double>();
    }
}

void alter(State& state, Bytes& in) {
    auto entry = state.begin();
    std::advance(entry, in.below(state.size()));
    std::vector<double>& values = entry->second;
    const std::size_t action = in.below(16);
    if (action == 0) {
        state.erase(entry);
    } else if (action == 1 || values.empty()) {
        values.resize(in.below(2 * values.size() + 8), number(in, 0));
    } else if (action == 2) {
        std::fill(values.begin(), values.end(), number(in, values.front()));
    } else {
        double& value = values[in.below(values.size())];
        value = number(in, value);
    }
}

}  // namespace

void checkpoint(Data data) {
    static const Originals originals;
    Bytes in(data);
    const std::size_t from = in.below(kKinds), to = in.below(4) == 0 ? in.below(kKinds) : from;
    const bool resume = in.below(2) == 0;
    State state = resume ? originals.checkpoints[from] : originals.knowledge[from];
    for (int n = 0; n < 32 && !in.empty() && !state.empty(); ++n)
        alter(state, in);
    Render render(originals.scene, settings_of(to), frame());
    try {
        if (resume)
            render.restore(state);
        else
            render.inherit(state);
    } catch (const std::invalid_argument&) {
        return;
    }
    finish(render);
    render.save();
}

}  // namespace nephele::fuzz
