#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Builds the extension's zips into dist/: the native module for any processor from x86-64-v3 on, once for Python 3.11
# and once for every later Python, each in a wheel with the libraries it needs (tools/extension/make_wheel.py), each
# wheel in a zip of its own with the add-on (make_zip.py). `extension.sh KIND...` builds those of
# tools/extension/kinds.py; py311 and py312 without one.

source "$(dirname "$0")/common.sh"
source scripts/debian_packages.sh

folder=build/extension
headers=build/python_headers
header_release=trixie header_package=libpython3.13-dev header_version=python3.13
kinds=("$@")
if ((${#kinds[@]} == 0)); then
    kinds=(py311 py312)
fi

# Debian 12 has no Python from 3.12 on. Its headers are all that the stable ABI takes, and a later Debian's package has
# them: apt fetches it with lists of its own, and nothing is installed.
fetch_headers() {
    if [[ -f $headers/usr/include/$header_version/Python.h ]]; then
        return
    fi
    step "Fetching the headers of Python 3.13 (Debian $header_release)"
    local apt=build/apt mirror
    mirror=$(debian_mirror)
    rm -rf "$apt" "$headers"
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial" "$headers"
    : >"$apt/status"
    printf 'deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s %s main\n' \
        "$mirror" "$header_release" >"$apt/sources.list"
    local options=(
        -o "Dir::Etc::sourcelist=$root/$apt/sources.list" -o Dir::Etc::sourceparts=-
        -o "Dir::State::lists=$root/$apt/lists" -o "Dir::State::status=$root/$apt/status"
        -o "Dir::Cache=$root/$apt/cache" -o APT::Sandbox::User=root
    )
    local remedy="check the network and the mirror $mirror"
    quietly build/apt-headers.log "$remedy" apt-get "${options[@]}" update
    (cd "$apt" && quietly ../apt-headers.log "$remedy" apt-get "${options[@]}" download "$header_package")
    dpkg-deb --extract "$apt/$header_package"_*.deb "$headers"
}

build_modules() {
    local include=$root/$headers/usr/include targets=()
    if [[ ! -f $folder/build.ninja ]]; then
        step "Configuring $folder"
        cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DNEPHELE_TESTS=OFF -DNEPHELE_ARCH=x86-64-v3 \
            -DPython_EXECUTABLE="$root/.venv/bin/python" \
            "-DNEPHELE_STABLE_ABI_HEADERS=$include/$header_version;$include" >build/cmake-extension.log ||
            fail "CMake could not configure $folder: see the message above"
    fi
    [[ " ${kinds[*]} " != *" py311 "* ]] || targets+=(nephele_native)
    [[ " ${kinds[*]} " != *" py312 "* && " ${kinds[*]} " != *" system "* ]] || targets+=(nephele_native_stable)
    step "Building $folder (${targets[*]})"
    cmake --build "$folder" --parallel "$(nproc)" --target "${targets[@]}" ||
        fail "the build of ${targets[*]} failed: see the compiler's message above"
}

lock_clone
fetch_headers
build_modules
for kind in "${kinds[@]}"; do
    step "Packing $kind"
    .venv/bin/python tools/extension/make_wheel.py "$kind"
    .venv/bin/python tools/extension/make_zip.py "$kind"
done
