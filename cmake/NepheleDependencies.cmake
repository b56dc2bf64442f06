# SPDX-License-Identifier: GPL-3.0-or-later
#
# Finds every library the native side uses, early, and says in one line what to install when one is missing.
# Defines the interface targets
#     nephele::embree    Embree 4 where found, else 3; sets NEPHELE_EMBREE_MAJOR for the few places that differ
#     nephele::openvdb   OpenVDB 10 or newer
#     nephele::tbb       oneTBB
#     nephele::openexr   OpenEXR 3 and Imath
# and, for tests and module, GTest::gtest_main and nanobind's commands.

# Stops with one line that names the missing part and the cure.
function(nephele_missing what remedy)
    # The leading space keeps CMake from wrapping the line.
    message(FATAL_ERROR " ${what} not found: ${remedy}")
endfunction()

# --- Python: runs tools/generate_tables.py, and hosts the module -----------------------------------------------

set(nephele_venv_python "${CMAKE_CURRENT_SOURCE_DIR}/.venv/bin/python")
if(NOT Python_EXECUTABLE AND EXISTS "${nephele_venv_python}")
    set(Python_EXECUTABLE "${nephele_venv_python}")
endif()
set(nephele_python_parts Interpreter)
if(NEPHELE_MODULE)
    list(APPEND nephele_python_parts Development.Module)
endif()
find_package(Python 3.11 COMPONENTS ${nephele_python_parts} QUIET)
if(NOT Python_Interpreter_FOUND)
    nephele_missing("Python 3.11 or newer" "run `make setup`, or pass -DPython_EXECUTABLE=PATH")
endif()
if(NEPHELE_MODULE AND NOT Python_Development.Module_FOUND)
    nephele_missing("The headers of ${Python_EXECUTABLE}" "run `make setup`, or apt-get install python3-dev")
endif()

# --- Libraries -------------------------------------------------------------------------------------------------

# The packages' own chatter (Debian's Imath complains of its absent Python bindings) would bury our messages.
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)

find_package(TBB CONFIG QUIET)
if(NOT TBB_FOUND OR TBB_VERSION VERSION_LESS 2021.5)
    nephele_missing("oneTBB 2021.5 or newer" "apt-get install libtbb-dev")
endif()
add_library(nephele_tbb INTERFACE)
target_link_libraries(nephele_tbb INTERFACE TBB::tbb)
add_library(nephele::tbb ALIAS nephele_tbb)

# Embree's package refuses another major version than the one asked for, hence two questions.
find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
    find_package(embree 3 CONFIG QUIET)
endif()
if(NOT embree_FOUND)
    nephele_missing("Embree 4 or 3" "apt-get install libembree-dev")
endif()
add_library(nephele_embree INTERFACE)
target_link_libraries(nephele_embree INTERFACE embree)
target_compile_definitions(nephele_embree INTERFACE NEPHELE_EMBREE_MAJOR=${EMBREE_VERSION_MAJOR})
add_library(nephele::embree ALIAS nephele_embree)

find_package(OpenEXR 3 CONFIG QUIET)
find_package(Imath 3 CONFIG QUIET)
if(NOT OpenEXR_FOUND OR NOT Imath_FOUND)
    nephele_missing("OpenEXR 3 with Imath" "apt-get install libopenexr-dev libimath-dev")
endif()
# Imath is named although OpenEXR brings it: OpenVDB's headers use imath_half_to_float_table, too.
add_library(nephele_openexr INTERFACE)
target_link_libraries(nephele_openexr INTERFACE OpenEXR::OpenEXR Imath::Imath)
add_library(nephele::openexr ALIAS nephele_openexr)

# OpenVDB ships its find module in a folder of its own that CMake does not search.
find_path(NEPHELE_OPENVDB_MODULE_DIR FindOpenVDB.cmake
    PATH_SUFFIXES lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB lib/cmake/OpenVDB
    DOC "Folder of FindOpenVDB.cmake")
if(NOT NEPHELE_OPENVDB_MODULE_DIR)
    nephele_missing("OpenVDB 10 or newer" "apt-get install libopenvdb-dev")
endif()
list(APPEND CMAKE_MODULE_PATH "${NEPHELE_OPENVDB_MODULE_DIR}")
find_package(OpenVDB 10 QUIET COMPONENTS openvdb)
if(NOT OpenVDB_FOUND)
    nephele_missing("OpenVDB 10 or newer, or the boost it needs,"
        "apt-get install libopenvdb-dev libboost-dev libboost-iostreams-dev libblosc-dev zlib1g-dev")
endif()
add_library(nephele_openvdb INTERFACE)
target_link_libraries(nephele_openvdb INTERFACE OpenVDB::openvdb Imath::Imath)
add_library(nephele::openvdb ALIAS nephele_openvdb)

# --- Module and tests ------------------------------------------------------------------------------------------

if(NEPHELE_MODULE)
    execute_process(COMMAND "${Python_EXECUTABLE}" -m nanobind --cmake_dir
        OUTPUT_VARIABLE nanobind_ROOT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    find_package(nanobind CONFIG QUIET)
    if(NOT nanobind_FOUND)
        nephele_missing("nanobind in ${Python_EXECUTABLE}" "run `make setup`, or pip install nanobind")
    endif()
endif()

if(NEPHELE_TESTS)
    find_package(GTest CONFIG QUIET)
    if(NOT GTest_FOUND)
        nephele_missing("GoogleTest" "apt-get install libgtest-dev, or pass -DNEPHELE_TESTS=OFF")
    endif()
endif()

unset(CMAKE_MESSAGE_LOG_LEVEL)
message(STATUS "Nephele ${PROJECT_VERSION}: Embree ${EMBREE_VERSION}, OpenVDB ${OpenVDB_VERSION}, "
    "oneTBB ${TBB_VERSION}, OpenEXR ${OpenEXR_VERSION}, Python ${Python_VERSION} (${Python_EXECUTABLE})")
