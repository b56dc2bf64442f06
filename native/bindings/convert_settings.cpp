// SPDX-License-Identifier: GPL-3.0-or-later
// How to render: film, passes, settings.
#include "bindings/attributes.h"
#include "bindings/convert.h"

namespace nephele::bindings {

PassId pass_of(std::string_view name) {
    for (int p = 0; p < kPassCount; ++p) {
        if (name == kPasses[p].name || name == kPasses[p].identifier)
            return static_cast<PassId>(p);
    }
    throw std::invalid_argument("no pass is called '" + std::string(name) + "'");
}

namespace {

FilmSource film(nb::handle film) {
    using Falloff = Mist::Falloff;
    FilmSource out;
    out.width = value<int>(film, "width");
    out.height = value<int>(film, "height");
    out.x1 = out.width;
    out.y1 = out.height;
    if (const nb::object crop = film.attr("crop"); !crop.is_none()) {
        out.x0 = nb::cast<int>(crop[0]);
        out.y0 = nb::cast<int>(crop[1]);
        out.x1 = nb::cast<int>(crop[2]);
        out.y1 = nb::cast<int>(crop[3]);
    }
    out.transparent = value<bool>(film, "transparent");
    for (nb::handle pass : nb::borrow<nb::object>(film.attr("passes")))
        out.passes.push_back(pass_of(nb::cast<std::string>(pass)));
    const nb::object mist = film.attr("mist");
    out.mist.start = nb::cast<float>(mist[0]);
    out.mist.depth = nb::cast<float>(mist[1]);
    const auto falloff = nb::cast<std::string>(mist[2]);
    out.mist.falloff = falloff == "linear"      ? Falloff::linear
                       : falloff == "quadratic" ? Falloff::quadratic
                                                : Falloff::inverse_quadratic;
    out.opaque_alpha = value<float>(film, "opaque_alpha");
    return out;
}

}  // namespace

FilmSource film_source_of(nb::handle scene) {
    return reading("film", [&] { return film(scene.attr("film")); });
}

Settings settings_of(nb::handle scene) {
    Settings out;
    const auto all = value<nb::dict>(scene, "settings");
    for (const std::pair<nb::handle, nb::handle> entry : all) {
        const nb::handle key = entry.first, item = entry.second;
        const auto name = reading("settings", [&] { return nb::cast<std::string>(key); });
        if (nb::isinstance<nb::str>(item)) {
            set_field(out, name, std::string_view(nb::cast<std::string>(item)));
        } else {
            set_field(out, name,
                      reading(name.c_str(), [&] { return nb::cast<double>(nb::float_(nb::borrow(item))); }));
        }
    }
    return out;
}

}  // namespace nephele::bindings
