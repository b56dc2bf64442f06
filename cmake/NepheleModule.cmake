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
    # NB_STATIC: nanobind's runtime goes into the module, so nothing else has to be installed beside it.
    # NB_SUPPRESS_WARNINGS: nanobind's headers are system headers. NOMINSIZE: optimise for speed.
    nanobind_add_module(${name} NB_STATIC NB_SUPPRESS_WARNINGS NOMINSIZE ${ARGN})
    nephele_apply_flags(${name})

    set(script "${CMAKE_CURRENT_BINARY_DIR}/${name}.map")
    file(CONFIGURE OUTPUT "${script}" CONTENT "{ global: PyInit_${name}; local: *; };\n" @ONLY)
    target_link_options(${name} PRIVATE "-Wl,--version-script=${script}" -Wl,--no-undefined-version)
    set_property(TARGET ${name} APPEND PROPERTY LINK_DEPENDS "${script}")
endfunction()
