#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Configures and builds the native side: `build.sh module|all|tables|asan|tsan|fuzz`. Ninja decides what is out of
# date.
#     module   build/release: the module alone, installed into .venv as nephele_native
#     all      the same, and the native tests
#     tables   only the generated headers (clang-tidy needs them)
#     asan     build/asan: native tests and module under AddressSanitizer and UndefinedBehaviorSanitizer
#     tsan     build/tsan: native tests under ThreadSanitizer
#     fuzz     build/fuzz: fuzz targets and module for libFuzzer, by Clang, under the sanitizers of asan

source "$(dirname "$0")/common.sh"

what=${1:-module}
folder=build/release
options=(-DCMAKE_BUILD_TYPE=Release)
case $what in
    asan)
        options=(-DCMAKE_BUILD_TYPE=RelWithDebInfo -DNEPHELE_SANITIZE=address -DNEPHELE_TESTS=ON)
        ;;
    tsan)
        options=(-DCMAKE_BUILD_TYPE=RelWithDebInfo -DNEPHELE_SANITIZE=thread -DNEPHELE_MODULE=OFF -DNEPHELE_TESTS=ON)
        ;;
    fuzz)
        options=(-DCMAKE_BUILD_TYPE=RelWithDebInfo -DNEPHELE_SANITIZE=fuzzer -DNEPHELE_TESTS=OFF
            -DCMAKE_CXX_COMPILER=clang++-14)
        ;;
esac
if [[ $what == asan || $what == tsan || $what == fuzz ]]; then
    folder=build/$what
fi

# A build folder copied along with the clone still points to the old place, and CMake refuses it.
forget_foreign_folder() {
    local cache=$folder/CMakeCache.txt
    if [[ -f $cache ]] && ! grep --quiet --line-regexp --fixed-strings "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$cache"; then
        step "Removing $folder, which was made elsewhere"
        rm -rf "$folder"
    fi
}

configure() {
    if [[ -f $folder/build.ninja ]]; then
        return  # Ninja itself calls CMake again when a CMake file changes
    fi
    step "Configuring $folder"
    cmake -S . -B "$folder" -G Ninja -DPython_EXECUTABLE="$root/.venv/bin/python" "${options[@]}" >build/cmake.log ||
        fail "CMake could not configure $folder: see the message above (whole output in build/cmake.log)"
    sed -n 's/^-- Nephele/    Nephele/p' build/cmake.log
}

build() {
    step "Building $folder ($1)"
    cmake --build "$folder" --parallel "$(nproc)" --target "$1" ||
        fail "the build of $1 failed: see the compiler's message above"
}

lock_clone
forget_foreign_folder
configure
case $what in
    module) build nephele_native ;;
    all | asan | tsan | fuzz) build all ;;
    tables) build nephele_tables_files ;;
    *) fail "build.sh: unknown '$what', expected module, all, tables, asan, tsan or fuzz" ;;
esac
if [[ $what == module || $what == all ]]; then
    cmake --install "$folder" >build/install.log || fail "could not install nephele_native into .venv: see build/install.log"
fi
