// SPDX-License-Identifier: GPL-3.0-or-later
// The class `Renderer`: one scene, one render. Python polls, cancels and reads; all work runs without the
// GIL.
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings/convert.h"

namespace nb = nanobind;

namespace nephele::bindings {

namespace {

const char* name_of(Render::State state) {
    switch (state) {
        case Render::State::idle:
            return "idle";
        case Render::State::running:
            return "running";
        case Render::State::done:
            return "done";
        case Render::State::cancelled:
            return "cancelled";
        case Render::State::failed:
            break;
    }
    return "failed";
}

template <class T>
nb::object array(std::vector<T> values, std::initializer_list<std::size_t> shape) {
    auto* held = new std::vector<T>(std::move(values));
    const nb::capsule owner(held, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, T>(held->data(), shape.size(), shape.begin(), owner));
}

using Sums = std::map<std::string, std::vector<double>>;

nb::dict arrays(Sums&& sums) {
    nb::dict out;
    for (auto& [name, values] : sums) {
        const std::size_t size = values.size();
        out[name.c_str()] = array(std::move(values), {size});
    }
    return out;
}

Sums values_of(const nb::dict& saved) {
    Sums values;
    for (auto [key, item] : saved) {
        nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu> view;
        const auto name = nb::cast<std::string>(key);
        if (!nb::try_cast(item, view, false))
            throw std::invalid_argument("entry '" + name + "' is not a float64 array");
        values[name].assign(view.data(), view.data() + view.size());
    }
    return values;
}

nb::dict told(const FieldDecision& decision) {
    nb::dict out;
    out["trains"] = decision.trains;
    out["reason"] = decision.reason;
    return out;
}

nb::list marks(const std::vector<ErrorMark>& errors) {
    nb::list out;
    for (const ErrorMark& mark : errors) {
        nb::dict row;
        row["seconds"] = mark.seconds;
        row["cpu_seconds"] = mark.cpu_seconds;
        row["samples"] = mark.samples;
        row["error"] = mark.error;
        out.append(row);
    }
    return out;
}

nb::list uses(const Techniques& techniques) {
    nb::list out;
    if (techniques.directions)
        out.append("directions");
    if (techniques.segments)
        out.append("segments");
    if (techniques.roulette)
        out.append("roulette");
    return out;
}

class Renderer {
  public:
    Renderer(nb::handle description, PartCache* parts) : settings_(settings_of(description)) {
        SceneSource source = scene_source_of(description);
        FilmSource film = film_source_of(description);
        const nb::gil_scoped_release release;
        const auto begin = std::chrono::steady_clock::now();
        scene_ = std::make_shared<const Scene>(std::move(source), settings_, parts);
        render_ = std::make_unique<Render>(scene_, settings_, std::move(film));
        build_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }

    void start() { render_->start(); }
    void cancel() { render_->cancel(); }
    void pause(bool paused) { render_->pause(paused); }
    bool wait(double seconds) {
        const nb::gil_scoped_release release;
        return render_->wait(seconds);
    }
    std::vector<std::string> warnings() const { return scene_->warnings(); }

    nb::dict progress() const {
        nb::dict out;
        out["state"] = name_of(render_->state());
        out["message"] = render_->failure();
        out["samples_done"] = render_->samples_done();
        out["samples"] = settings_.samples;
        out["fraction"] = render_->fraction();
        out["seconds"] = render_->seconds();
        out["error"] = nb::none();
        if (const auto error = render_->error())
            out["error"] = *error;
        return out;
    }

    nb::object read_pass(const std::string& name) const {
        const PassId pass = pass_of(name);
        const Film& film = render_->film();
        std::vector<float> values;
        {
            const nb::gil_scoped_release release;
            values = film.read(pass);
        }
        return array(std::move(values),
                     {static_cast<std::size_t>(film.height()), static_cast<std::size_t>(film.width()),
                      static_cast<std::size_t>(kPasses[static_cast<std::size_t>(pass)].channels)});
    }

    nb::dict statistics() const {
        const RenderStatistics s = render_->statistics();
        nb::dict out;
        out["kernel_features"] = scene_->features().list(true);
        out["left_out"] = scene_->features().list(false);
        out["kernel"] = render_->kernel().list();
        nb::dict memory;
        memory["film"] = render_->film().bytes();
        memory["learning"] = s.learning_bytes;
        memory["light_tree"] = scene_->lights().tree_bytes();
        out["memory"] = memory;
        out["samples_done"] = render_->samples_done();
        out["rays"] = s.rays;
        out["path_segments"] = s.path_segments;
        out["density_lookups"] = s.density_lookups;
        out["nonfinite_samples"] = s.nonfinite_samples;
        out["bound_violations"] = s.bound_violations;
        out["build_seconds"] = build_seconds_;
        out["render_seconds"] = s.render_seconds;
        out["render_cpu_seconds"] = s.render_cpu_seconds;
        out["train_seconds"] = s.train_seconds;
        out["first_tile_seconds"] = s.first_tile_seconds;
        out["errors"] = marks(s.errors);
        out["target_reached"] = s.target_reached;
        out["embree_bytes"] = scene_->hierarchy_bytes();
        nb::dict field = told(decide_field(*scene_, settings_));
        field["regions"] = s.field_regions;
        field["bytes"] = s.field_bytes;
        field["uses"] = nb::none();
        if (s.techniques)
            field["uses"] = uses(*s.techniques);
        out["guiding_field"] = field;
        nb::list grids;
        for (const GridUse& g : scene_->grids()) {
            nb::dict row;
            row["volume"] = g.volume;
            row["path"] = g.path;
            row["grid"] = g.grid;
            row["active_voxels"] = g.active_voxels;
            row["bytes"] = g.bytes;
            grids.append(row);
        }
        out["grids"] = grids;
        return out;
    }

    nb::dict checkpoint() const { return arrays(render_->save()); }
    void restore(const nb::dict& saved) { render_->restore(values_of(saved)); }
    nb::dict knowledge() const { return arrays(render_->knowledge()); }
    std::string inherit(const nb::dict& knowledge) { return render_->inherit(values_of(knowledge)); }

  private:
    Settings settings_;
    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<Render> render_;
    double build_seconds_ = 0;
};

}  // namespace

void bind_renderer(nb::module_& m) {
    m.def(
        "matte_hash", [](const std::string& name) { return matte_hash(name); }, nb::arg("name"),
        "MurmurHash3_32 of a name, as cryptomatte manifests have it.");
    m.def(
        "scene_features",
        [](nb::handle description) {
            const Settings settings = settings_of(description);
            const Scene scene(scene_source_of(description), settings);
            nb::dict out;
            out["kernel_features"] = scene.features().list(true);
            out["left_out"] = scene.features().list(false);
            const bool parts = asks_for_parts(film_source_of(description).passes);
            out["kernel"] = choose_kernel(settings, scene.features(), learns(scene, settings), parts).list();
            out["warnings"] = scene.warnings();
            out["guiding_field"] = told(decide_field(scene, settings));
            return out;
        },
        nb::arg("scene"),
        "dict: what the scene needs of the renderer, what it leaves out, warnings. Raises as Renderer does.");
    nb::class_<PartCache>(
        m, "SceneParts",
        "Built parts of the last scene that was made with it. Parts of the next whose arrays are the same "
        "objects, and whose numbers are equal, are taken from here. Arrays must not change.")
        .def(nb::init<>())
        .def_prop_ro("size", &PartCache::size, "Number of parts.")
        .def("clear", &PartCache::clear, "Lets go of all parts.")
        .def(
            "counts",
            [](const PartCache& parts) {
                const PartCache::Statistics s = parts.statistics();
                return std::pair(s.hits, s.misses);
            },
            "(parts found, parts made) so far.");
    nb::class_<Renderer>(
        m, "Renderer",
        "A scene being rendered. Built from a description.Scene, whose arrays it keeps and shares.")
        .def(
            nb::init<nb::handle, PartCache*>(), nb::arg("scene"), nb::arg("parts").none() = nb::none(),
            "Builds the scene. parts: SceneParts of earlier scenes. Raises ValueError or RuntimeError naming "
            "the object or file at fault.")
        .def("start", &Renderer::start, "Starts rendering on native threads and returns at once.")
        .def("wait", &Renderer::wait, nb::arg("seconds"),
             "Waits up to `seconds`; True once finished. Raises what a render thread threw.")
        .def("cancel", &Renderer::cancel, "Asks the render to stop; `wait` then returns soon.")
        .def("pause", &Renderer::pause, nb::arg("paused"),
             "Holds the render before its next pass of samples, or lets it go on.")
        .def(
            "progress", &Renderer::progress,
            "dict: state, message (why it failed), samples_done, samples, fraction in [0, 1], seconds, error "
            "(estimated relMSE, None where none is estimated).")
        .def("read_pass", &Renderer::read_pass, nb::arg("name"),
             "The pass so far: (height, width, channels) float32, first row at the bottom. Raises ValueError "
             "where it was not asked for.")
        .def("statistics", &Renderer::statistics, "dict of counts, times (s) and sizes (bytes).")
        .def("checkpoint", &Renderer::checkpoint,
             "dict name -> float64 sums, for `restore`. Not while it runs.")
        .def("restore", &Renderer::restore, nb::arg("saved"),
             "Takes up a checkpoint before `start`. Raises ValueError where it does not fit.")
        .def("knowledge", &Renderer::knowledge,
             "dict name -> float64 array: what it learned, for `inherit` of another render. Not while it "
             "runs.")
        .def(
            "inherit", &Renderer::inherit, nb::arg("knowledge"),
            "Starts from what another render learned, before `start`. Returns what was taken over, in words. "
            "Raises ValueError where it does not fit.")
        .def_prop_ro("warnings", &Renderer::warnings,
                     "What was left out or mended while building, one sentence each.");
}

}  // namespace nephele::bindings
