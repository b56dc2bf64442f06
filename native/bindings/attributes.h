// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes of the description's Python objects as C++ values.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "math/vec.h"

namespace nephele::bindings {

namespace nb = nanobind;

/// Runs `convert`, which reads `what` of the description. Where Python or nanobind finds it missing or of
/// another type, throws std::invalid_argument that names it; other errors pass.
template <class F>
auto reading(const char* what, F&& convert) {
    try {
        return convert();
    } catch (const nb::python_error&) {  // no such attribute, no sequence, too few items
    } catch (const std::bad_cast&) {
    }
    throw std::invalid_argument(
        std::string("'") + what +
        "' is missing or not of the description's type; the scene description is damaged");
}

template <class T>
T value(nb::handle object, const char* attribute) {
    return reading(attribute, [&] { return nb::cast<T>(object.attr(attribute)); });
}

inline std::string text(nb::handle object, const char* attribute) {
    return value<std::string>(object, attribute);
}

inline Rgb rgb(nb::handle object, const char* attribute) {
    return reading(attribute, [&] {
        const nb::object v = object.attr(attribute);
        return Rgb(nb::cast<float>(v[0]), nb::cast<float>(v[1]), nb::cast<float>(v[2]));
    });
}

[[noreturn]] inline void bad_array(const char* what, const char* wanted) {
    throw std::invalid_argument(std::string(what) + " must be a C-contiguous numpy array of " + wanted);
}

/// A numpy array as a buffer that keeps it alive. Its memory is not copied; releasing it takes the GIL.
template <class T>
Buffer<T> buffer(nb::handle array, const char* what, const char* wanted) {
    if (array.is_none())
        return {};
    nb::ndarray<const T, nb::c_contig, nb::device::cpu> view;
    if (!nb::try_cast(array, view, false))
        bad_array(what, wanted);
    auto* held = new nb::object(nb::borrow(array));
    const std::shared_ptr<const void> owner(held, [](nb::object* o) {
        const nb::gil_scoped_acquire gil;
        delete o;
    });
    return Buffer<T>(view.data(), view.size(), owner);
}
inline Buffer<float> floats(nb::handle object, const char* attribute) {
    return buffer<float>(object.attr(attribute), attribute, "float32");
}
inline Buffer<std::int32_t> integers(nb::handle object, const char* attribute) {
    return buffer<std::int32_t>(object.attr(attribute), attribute, "int32");
}

inline void matrix(nb::handle object, const char* attribute, double (&out)[16]) {
    nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu> view;  // small: a copy will do
    if (!nb::try_cast(object.attr(attribute), view, true))
        bad_array(attribute, "4 x 4 float64");
    std::copy(view.data(), view.data() + 16, out);
}
/// A matrix world_from_...: `origin` becomes the origin of the world.
inline void placement(nb::handle object, const char* attribute, const std::array<double, 3>& origin,
                      double (&out)[16]) {
    matrix(object, attribute, out);
    for (std::size_t a = 0; a < 3; ++a)
        out[4 * a + 3] -= origin[a];
}

/// The same at S times of the shutter, (S, 4, 4); none where the attribute is None.
inline std::vector<std::array<double, 16>> motion_matrices(nb::handle object,
                                                           const std::array<double, 3>& origin,
                                                           const char* attribute = "motion") {
    std::vector<std::array<double, 16>> out;
    const nb::object motion = object.attr(attribute);
    if (motion.is_none())
        return out;
    nb::ndarray<const double, nb::shape<-1, 4, 4>, nb::c_contig, nb::device::cpu> view;
    if (!nb::try_cast(motion, view, true))
        bad_array(attribute, "S x 4 x 4 float64");
    out.resize(view.shape(0));
    for (std::size_t i = 0; i < out.size(); ++i)
        std::copy(view.data() + 16 * i, view.data() + 16 * (i + 1), out[i].begin());
    for (auto& m : out) {
        for (std::size_t a = 0; a < 3; ++a)
            m[4 * a + 3] -= origin[a];
    }
    return out;
}

template <class Enum>
Enum choice(nb::handle object, const char* attribute,
            std::initializer_list<std::pair<std::string_view, Enum>> items) {
    const std::string given = text(object, attribute);
    for (const auto& [name, item] : items) {
        if (name == given)
            return item;
    }
    throw std::invalid_argument(std::string(attribute) + ": '" + given + "' is not known");
}

/// Applies `convert` to each element, naming the one at fault.
template <class T, class F>
std::vector<T> list(nb::handle object, const char* attribute, F&& convert) {
    return reading(attribute, [&] {
        std::vector<T> out;
        for (nb::handle item : nb::borrow<nb::object>(object.attr(attribute))) {
            try {
                out.push_back(reading("an item", [&] { return convert(item); }));
            } catch (const std::invalid_argument& e) {
                std::string name;
                if (nb::hasattr(item, "name") && nb::isinstance<nb::str>(item.attr("name")))
                    name = " '" + text(item, "name") + "'";
                throw std::invalid_argument(std::string(attribute) + name + ": " + e.what());
            }
        }
        return out;
    });
}

}  // namespace nephele::bindings
