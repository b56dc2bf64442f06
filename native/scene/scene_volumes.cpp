// SPDX-License-Identifier: GPL-3.0-or-later
// The volumes of a scene: loads the grids that their materials read and places them in the world.
#include <algorithm>
#include <set>

#include "grids/vdb_file.h"
#include "scene/naming.h"
#include "scene/scene.h"

namespace nephele {

namespace {

/// The region of a loaded grid: its box, in its own index space.
Region box_region(const VolumeSource& volume, const LoadedGrid& loaded, Transform& world_from_index) {
    double matrix[16], file_from_index[16];
    std::copy(loaded.world_from_index.begin(), loaded.world_from_index.end(), file_from_index);
    multiply(volume.world_from_object, file_from_index, matrix);
    world_from_index = transform_of(matrix);
    Region region(volume.name, Region::Kind::box, volume.visibility);
    region.index_from_world = inverse_of(matrix);
    const IndexBox& box = loaded.grid->active_bounds();
    for (int a = 0; a < 3; ++a) {  // interpolation reaches one voxel beyond the last value
        region.box_min[a] = static_cast<float>(box.min[static_cast<std::size_t>(a)] - 1);
        region.box_max[a] = static_cast<float>(box.max[static_cast<std::size_t>(a)] + 1);
    }
    return region;
}

}  // namespace

void Scene::add_volumes() {
    for (const VolumeSource& volume : source_.volumes) {
        naming("volume '" + volume.name + "'", [&] { add_volume(volume); });
    }
}

/// Names of the grids that the volume's material reads and its file has; a warning for each that it has not.
/// Where none is read, the file's first grid, whose box the constant coefficients fill.
std::vector<std::string> Scene::grids_to_load(const VolumeSource& volume) {
    std::set<std::string> wanted;
    for (const VolumeClosure& c : source_.materials.at(volume.material).volume) {
        if (!c.grid().empty())
            wanted.insert(c.grid());
    }
    std::vector<std::string> available, found;
    for (const GridInfo& info : list_grids(volume.path))
        available.push_back(info.name);
    if (wanted.empty() && !available.empty())
        return {available.front()};
    for (const std::string& name : wanted) {
        if (std::find(available.begin(), available.end(), name) != available.end()) {
            found.push_back(name);
            continue;
        }
        std::string list;
        for (const auto& a : available)
            list += (list.empty() ? "'" : ", '") + a + "'";
        warnings_.push_back("volume '" + volume.name + "': " + volume.path + " has no grid '" + name +
                            "' (it has " + (list.empty() ? "none" : list) + "); what reads it is left out");
    }
    return found;
}

void Scene::add_volume(const VolumeSource& volume) {
    const std::vector<VolumeClosure>& closures = source_.materials.at(volume.material).volume;
    bool first = true;
    for (const std::string& name : grids_to_load(volume)) {
        const LoadedGrid loaded = load_grid(volume.path, name, volume.options);
        for (const std::string& w : loaded.warnings)
            warnings_.push_back("volume '" + volume.name + "': " + w);
        if (!loaded.grid)
            continue;
        std::vector<VolumeClosure> mine;  // those that read this grid; constants go with the first
        float sigma = 0;
        bool read = false;
        for (const VolumeClosure& c : closures) {
            if (c.grid() != name && !(first && c.grid().empty()))
                continue;
            mine.push_back(c);
            if (!c.density_grid.empty())
                sigma += max_component(c.sigma_s + c.sigma_a) * volume.density_scale;
            read |= !c.grid().empty();
        }
        first = false;
        Transform world_from_index;
        Region region = box_region(volume, loaded, world_from_index);
        if (loaded.grid->active_bounds().empty())
            continue;
        std::optional<DensityField> field;
        if (read) {
            // Majorants are merged where that saves steps, which depends on the optical depth of a voxel.
            const float voxel = std::cbrt(std::fabs(world_from_index.determinant()));
            field = DensityField{loaded.grid, std::make_shared<MajorantGrid>(*loaded.grid, sigma * voxel),
                                 region.index_from_world};
            grids_.push_back({volume.name, volume.path, name,
                              static_cast<std::size_t>(loaded.grid->active_voxels()),
                              loaded.grid->bytes() + field->majorants->bytes()});
        }
        add_region(std::move(region), mine, volume.density_scale, field);
    }
}

}  // namespace nephele
