// SPDX-License-Identifier: GPL-3.0-or-later
// The Python module nephele_native.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "scene/intersector.h"

namespace nb = nanobind;

namespace nephele::bindings {
void bind_renderer(nb::module_& m);
}

NB_MODULE(nephele_native, m) {
    m.doc() = "Nephele's renderer: a volumetric path tracer. Use it through the package `nephele`.";
    m.attr("__version__") = NEPHELE_VERSION;
    m.def(
        "build_info",
        [] {
            nb::dict info;
            info["compiler"] = "g++ " __VERSION__;
            info["architecture"] = NEPHELE_ARCH;
            info["embree_major"] = NEPHELE_EMBREE_MAJOR;
            return info;
        },
        "dict: how this module was built.");
    nephele::Intersector::self_test();
    nephele::bindings::bind_renderer(m);
}
