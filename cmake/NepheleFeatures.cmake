# SPDX-License-Identifier: GPL-3.0-or-later
#
# nephele_write_features(folder): C++ headers folder/compiled/NAME.h, each with one constant
# `nephele::compiled::NAME` that says whether the feature is compiled in. All of them are, but for
# bench/specialisation.py, which compiles one out at a time and shows that scenes without it render no faster for
# that. Such builds render other scenes wrongly: install none.

set(nephele_features media overlap volume_emission volume_programs chromatic motion vsp field passes adaptive_sampling)
option(NEPHELE_COMPARABLE "No fused multiply-adds in the kernels: builds without a feature then give the same bits" OFF)
set(NEPHELE_WITHOUT "" CACHE STRING "Features to compile out, for measuring alone: ${nephele_features}")

function(nephele_write_features folder)
    foreach(name IN LISTS NEPHELE_WITHOUT)
        if(NOT name IN_LIST nephele_features)
            message(FATAL_ERROR " NEPHELE_WITHOUT: no feature is called '${name}'; there are ${nephele_features}")
        endif()
    endforeach()
    foreach(name IN LISTS nephele_features)
        set(value true)
        if(name IN_LIST NEPHELE_WITHOUT)
            set(value false)
        endif()
        file(CONFIGURE OUTPUT "${folder}/compiled/${name}.h" @ONLY CONTENT "// Written by cmake/NepheleFeatures.cmake.
#pragma once

namespace nephele::compiled {
inline constexpr bool ${name} = ${value};
}  // namespace nephele::compiled
")
    endforeach()
endfunction()
