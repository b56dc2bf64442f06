# SPDX-License-Identifier: GPL-3.0-or-later
#
# nephele_add_module(name sources...): a Python module that exports PyInit_<name> and nothing else.
#
# Why the version script: with hidden visibility alone, the module would still export the weak helpers of
# std::call_once while hiding OpenVDB's type names, and libopenvdb, binding to the former, crashes in
# openvdb::initialize(). It also keeps our symbols away from those of the host's own libraries.
#
# NEPHELE_SITE_PACKAGES: where the module is to be installed, the site-packages of Python_EXECUTABLE.

if(NEPHELE_MODULE)
    execute_process(
        COMMAND "${Python_EXECUTABLE}" -c "import sysconfig; print(sysconfig.get_path('platlib'))"
        OUTPUT_VARIABLE NEPHELE_SITE_PACKAGES OUTPUT_STRIP_TRAILING_WHITESPACE
        COMMAND_ERROR_IS_FATAL ANY)
endif()

function(nephele_add_module name)
    nephele_add_module_target(${name} ${name} ${ARGN})
endfunction()

# What both kinds of module have in common: target makes the module called name.
function(nephele_add_module_target target name)
    # NB_STATIC: nanobind's runtime goes into the module, so nothing else has to be installed beside it.
    # NB_SUPPRESS_WARNINGS: nanobind's headers are system headers. NOMINSIZE: optimise for speed.
    nanobind_add_module(${target} NB_STATIC NB_SUPPRESS_WARNINGS NOMINSIZE ${ARGN})
    nephele_apply_flags(${target})

    set(script "${CMAKE_CURRENT_BINARY_DIR}/${name}.map")
    file(CONFIGURE OUTPUT "${script}" CONTENT "{ global: PyInit_${name}; local: *; };\n" @ONLY)
    target_link_options(${target} PRIVATE "-Wl,--version-script=${script}" -Wl,--no-undefined-version)
    set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS "${script}")
endfunction()

# nephele_add_stable_module(name headers sources...): the same module for every Python from 3.12 on (the stable ABI), as
# stable/<name>.abi3.so below the build folder. headers: include folders of any such Python; nothing of it is run or
# linked. The core is compiled once for both; CMake's own support of the stable ABI would ask for a whole second
# Python, and for CMake 3.26.
function(nephele_add_stable_module name headers)
    # nanobind reads these; here they hold in this function alone.
    set(Python_INCLUDE_DIRS "${headers}")
    set(Python_VERSION 3.12)
    if(NOT TARGET Python::SABIModule)
        add_library(Python::SABIModule INTERFACE IMPORTED)
    endif()
    nephele_add_module_target(${name}_stable ${name} STABLE_ABI ${ARGN})
    set_target_properties(${name}_stable PROPERTIES
        OUTPUT_NAME ${name} LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/stable")
endfunction()
