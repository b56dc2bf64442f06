// SPDX-License-Identifier: GPL-3.0-or-later
// From the scene description (addon/description.py) to the renderer's own structs: attribute by attribute, by
// the same names, arrays without copies. Conversion only; what the values mean is checked where they are
// used.
#pragma once

#include <nanobind/nanobind.h>

#include "render.h"
#include "scene/scene.h"

namespace nephele::bindings {

/// None: nothing.
std::optional<Program> program_of(nanobind::handle program);
/// The closures of attribute `volume`; one whose sigma and emission are scaled differently becomes two.
std::vector<VolumeClosure> volume_closures_of(nanobind::handle object);
SceneSource scene_source_of(nanobind::handle scene);
FilmSource film_source_of(nanobind::handle scene);
/// The scene's settings: dict name -> value, as parameters.checked() returns it.
Settings settings_of(nanobind::handle scene);
PassId pass_of(std::string_view name);

}  // namespace nephele::bindings
