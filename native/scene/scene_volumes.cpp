// SPDX-License-Identifier: GPL-3.0-or-later
// The volume objects of a scene: loads the grids that their materials read and places them in the world.
#include <algorithm>
#include <set>

#include "grids/grid_cache.h"
#include "scene/naming.h"
#include "scene/placed_grid.h"
#include "scene/scene.h"

namespace nephele {

namespace {

bool direct(const VolumeClosure& c, const std::string& grid) {
    return !c.program && c.grid() == grid;
}

/// The closure as a program: sigma_s, sigma_a and emission times what their grids say.
VolumeClosure as_program(const VolumeClosure& c) {
    VolumeClosure out;
    Program program;
    program.registers = {c.sigma_s, c.sigma_a, c.emission, Vec3f(1), {}, {}};
    if (!c.grid().empty()) {
        const auto op = [](Op o) { return static_cast<std::int32_t>(o); };
        program.code.push_back({op(Op::position), 4});
        program.code.push_back({op(Op::grid), 5, 4});
        const bool emits = c.density_grid.empty();
        for (const std::int32_t r : emits ? std::vector<std::int32_t>{2} : std::vector<std::int32_t>{0, 1})
            program.code.push_back({op(Op::multiply), r, r, 5});
        out.grids = {c.grid()};
    }
    ClosureRow row;
    row.kind = ClosureKind::medium;
    row.weight = 3;
    row.inputs = {0, 1, 2, 3, 3};
    program.closures = {row};
    out.program = std::move(program);
    out.phase = c.phase;
    out.program_has_phase = false;
    return out;
}

}  // namespace

/// Loads the grids of one volume object and makes its media.
class Scene::VolumeBuilder {
  public:
    VolumeBuilder(Scene& scene, const VolumeSource& volume, const VolumeObject& object, GridCacheScope& cache)
        : scene_(scene),
          volume_(volume),
          object_(object),
          cache_(cache),
          filter_(static_cast<Filter>(scene.settings_.interpolation)),
          closures_(scene.source_.materials.at(volume.material).volume) {}

    void build() {
        load();
        if (first_.empty())
            return;
        scene_.features_.motion |= object_.instance.motion.moves();
        const auto motion = make_motion();
        if (motion) {
            for (VolumeClosure& c : closures_)
                c = c.program ? c : as_program(c);
        }
        bool constants = true;  // they fill the box of the first grid
        for (const auto& [name, grid] : grids_) {
            add_direct(name, grid, constants && !motion);
            constants = false;
        }
        for (const VolumeClosure& c : closures_) {
            if (c.program)
                add_program(c, motion);
        }
    }

  private:
    /// Loads what the closures read, and warns of what is not there. Where they read nothing, the file's
    /// first grid, whose box the constant coefficients fill.
    void load() {
        std::set<std::string> wanted;
        for (const VolumeClosure& c : closures_) {
            if (!c.grid().empty())
                wanted.insert(c.grid());
            wanted.insert(c.grids.begin(), c.grids.end());
        }
        const auto available = cache_.list(volume_.path);
        if (wanted.empty()) {
            for (const GridInfo& info : *available) {
                if (first_.empty() && !is_vector_type(info.type))
                    load(info.name, volume_.options);
            }
        }
        for (const std::string& name : wanted)
            load(name, volume_.options);
    }

    /// Loads a grid into grids_, unless it is there. Null where the file lacks it or it cannot be used.
    const PlacedGrid* load(const std::string& name, GridOptions options) {
        if (const auto found = grids_.find(name); found != grids_.end())
            return &found->second;
        PlacedGrid grid;
        const bool vectors = is_vector(name);
        if (vectors) {
            const auto loaded = cache_.vector_grid(volume_.path, name, options);
            grid.field.components = loaded->components;
            place(*loaded, grid);
        } else {
            const auto loaded = cache_.grid(volume_.path, name, options);
            grid.field.components[0] = loaded->grid;
            place(*loaded, grid);
        }
        if (!grid.field.components[0] || grid.field.components[0]->active_bounds().empty())
            return nullptr;
        const Reach reach = reach_of(filter_);
        grid.box = grid.field.components[0]->active_bounds();
        std::size_t bytes = 0;
        for (std::size_t a = 0; a < 3; ++a) {  // interpolation reaches beyond the last value
            grid.box.min[a] -= reach.above;
            grid.box.max[a] += reach.above;
            if (grid.field.components[a])
                bytes += grid.field.components[a]->bytes();
        }
        grid.field.filter = filter_;
        if (first_.empty())
            first_ = name;
        scene_.grids_.push_back({volume_.name, volume_.path, name,
                                 static_cast<std::size_t>(grid.field.components[0]->active_voxels()), bytes});
        return &grids_.emplace(name, std::move(grid)).first->second;
    }

    bool is_vector(const std::string& name) const {
        const auto available = cache_.list(volume_.path);
        const auto found = std::find_if(available->begin(), available->end(),
                                        [&](const GridInfo& info) { return info.name == name; });
        return found != available->end() && is_vector_type(found->type);
    }

    void place(const GridPlacement& placement, PlacedGrid& grid) {
        for (const std::string& w : placement.warnings)
            warn(w);
        if (!grid.field.components[0])
            return;  // it is nowhere
        double index_from_file[16];
        std::copy(placement.world_from_index.begin(), placement.world_from_index.end(), index_from_file);
        multiply(volume_.world_from_object, index_from_file, grid.world_from_index);
        grid.field.index_from_world = inverse_of(grid.world_from_index);
        grid.id = placement.id;
    }

    void warn(const std::string& text) {
        const std::string warning = "volume '" + volume_.name + "': " + text;
        auto& all = scene_.warnings_;
        if (std::find(all.begin(), all.end(), warning) == all.end())
            all.push_back(warning);
    }

    /// Bounds of a grid's components, which other scenes may have made.
    std::shared_ptr<const CellBounds> cells_of(const PlacedGrid& grid, std::size_t component) const {
        const std::string key = std::to_string(static_cast<int>(filter_)) + ' ' + std::to_string(component);
        return cache_.get_or_make<CellBounds>(
            key, {grid.id}, [&] { return CellBounds::of_grid(*grid.field.components[component], filter_); });
    }
    VolumeField bounded(const PlacedGrid& grid) const {
        VolumeField field = grid.field;
        for (std::size_t c = 0; c < 3; ++c) {
            if (field.components[c])
                field.bounds[c] = cells_of(grid, c);
        }
        return field;
    }

    std::shared_ptr<const VolumeMotion> make_motion() {
        const SceneSource& s = scene_.source_;
        if (volume_.velocity_grids.empty() || s.shutter_open == s.shutter_close ||
            volume_.velocity_scale == 0)
            return nullptr;
        GridOptions options = volume_.options;
        options.keep_negative = true;
        options.clipping = 0;
        auto motion = std::make_shared<VolumeMotion>();
        for (const std::string& name : volume_.velocity_grids) {
            const PlacedGrid* grid = load(name, options);
            if (!grid) {
                warn("its velocity is left out; it stands still");
                return nullptr;
            }
            motion->velocity.push_back(bounded(*grid));
        }
        double scaled[16];
        std::copy(std::begin(volume_.world_from_object), std::end(volume_.world_from_object), scaled);
        for (int i = 0; i < 12; ++i)
            scaled[i] = i % 4 == 3 ? 0 : scaled[i] * double{volume_.velocity_scale};
        motion->world_from_velocity = transform_of(scaled);
        motion->open = s.shutter_open;
        motion->close = s.shutter_close;
        scene_.features_.motion = true;
        return motion;
    }

    Region make_region() const {
        Region region(volume_.name, Region::Kind::box, volume_.visibility);
        region.receiver_set = volume_.receiver_set;
        region.blocker_set = volume_.blocker_set;
        if (object_.instance.motion.moves())
            region.mover = &object_.instance;
        return region;
    }

    /// The media that are constant, or scaled by this grid as it is.
    void add_direct(const std::string& name, const PlacedGrid& grid, bool with_constants) {
        std::vector<Medium> media;
        float sigma = 0;
        for (const VolumeClosure& c : closures_) {
            if (!direct(c, name) && !(with_constants && direct(c, "")))
                continue;
            Medium medium = scene_.constant_medium(c, volume_.density_scale);
            if (direct(c, name)) {
                medium.grid = grid.field.components[0];
                medium.filter = filter_;
                medium.density_scales_emission = !c.emission_grid.empty();
                sigma += medium.sigma_t_max();
            }
            media.push_back(std::move(medium));
        }
        const auto bounds = std::any_of(media.begin(), media.end(), [](const Medium& m) { return m.grid; })
                                ? bounds_of(grid, sigma)
                                : nullptr;
        for (Medium& medium : media) {
            if (medium.grid)
                medium.bounds = bounds;
        }
        Region region = make_region();
        region.set_box(grid.box, grid.field.index_from_world);
        scene_.add_region(std::move(region), std::move(media));
    }

    std::shared_ptr<const MediumBounds> bounds_of(const PlacedGrid& grid, float sigma) const {
        // Majorants are merged where that saves steps, which depends on the optical depth of a voxel.
        const float voxel = std::cbrt(std::fabs(transform_of(grid.world_from_index).determinant()));
        const BoundsOptions options = scene_.bounds_options();
        PartKey key;
        key.add(grid.id).add(filter_).add(sigma * voxel).add(grid.field.index_from_world);
        key.add(options.accelerator).add(options.minorants);
        return scene_.parts_->get_or_make<MediumBounds>(key, [&] {
            return MediumBounds{
                Majorants(*cells_of(grid, 0), options.accelerator, sigma * voxel, options.minorants),
                grid.field.index_from_world};
        });
    }

    void add_program(const VolumeClosure& c, const std::shared_ptr<const VolumeMotion>& motion) {
        std::vector<VolumeField> fields;
        std::vector<const PlacedGrid*> used;
        for (const std::string& name : c.grids) {
            const auto found = grids_.find(name);
            fields.push_back(found == grids_.end() ? VolumeField{} : bounded(found->second));
            if (found != grids_.end())
                used.push_back(&found->second);
        }
        if (used.empty())
            used.push_back(&grids_.at(first_));
        const BoundsFrame frame = frame_of(used, motion.get());
        ShadingPoint place;
        place.instance = &object_.instance;
        place.mesh = &object_.mesh;
        Region region = make_region();
        region.set_box(frame.box, frame.index_from_world);
        scene_.add_region(std::move(region),
                          {scene_.program_medium(c, volume_.density_scale,
                                                 VolumeFields(std::move(fields), motion), place, frame)});
    }

    Scene& scene_;
    const VolumeSource& volume_;
    const VolumeObject& object_;
    GridCacheScope& cache_;
    Filter filter_;
    std::vector<VolumeClosure> closures_;
    std::map<std::string, PlacedGrid> grids_;
    std::string first_;  ///< the grid loaded first, or empty
};

namespace {

void check(const VolumeSource& volume) {
    if (!(volume.density_scale >= 0) || !std::isfinite(volume.density_scale))
        throw std::invalid_argument("the scale of its density is negative or not finite; mend its scale");
    if (!std::isfinite(volume.options.clipping))
        throw std::invalid_argument("its clipping is not finite; set it to 0");
}

VolumeObject object_of(const VolumeSource& volume) {
    VolumeObject object;
    object.instance.name = volume.name;
    object.instance.world_from_object = transform_of(volume.world_from_object);
    object.instance.object_from_world = inverse_of(volume.world_from_object);
    object.instance.motion = volume.motion;
    object.instance.random = volume.random;
    object.instance.color = volume.color;
    object.instance.pass_index = volume.pass_index;
    object.mesh.generated_min = volume.generated_min;
    object.mesh.generated_size = volume.generated_size;
    return object;
}

}  // namespace

void Scene::add_volumes() {
    GridCacheScope cache;
    for (const VolumeSource& volume : source_.volumes) {
        naming("volume '" + volume.name + "'", [&] {
            check(volume);
            const VolumeObject& object = volume_objects_.emplace_back(object_of(volume));
            VolumeBuilder(*this, volume, object, cache).build();
        });
    }
    cache.commit();
}

}  // namespace nephele
