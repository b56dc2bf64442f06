#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Makes the Blenders that the extension is tested in, where they are missing: `blenders.sh NAME...` with
#     bpy-VERSION      Blender as a Python module in a venv of its own, build/venvs/bpy-VERSION (0.6 to 0.9 GB)
#     trixie, sid      a Debian root with that release's Blender, build/roots/NAME (2 GB, needs root)
# sid moves on; build/roots/NAME/blender-version says what was found there.

source "$(dirname "$0")/common.sh"
source scripts/debian_packages.sh

# What a Blender with windows needs on a bare Debian: software OpenGL, a display, a hand on keyboard and mouse, and
# the Python packages that Blender's own add-ons import but Debian only recommends.
root_packages=(
    blender libgl1-mesa-dri libegl1
    xvfb xauth x11-utils imagemagick xdotool
    python3-numpy python3-requests python3-cattr
)

make_module() {
    local folder=build/venvs/$1 version=${1#bpy-}
    if [[ -f $folder/ready ]]; then
        return
    fi
    step "Making $folder: Blender $version as a Python module"
    rm -rf "$folder"
    quietly "build/$1.log" "check that .venv is there (make setup)" .venv/bin/python -m venv "$folder"
    quietly "build/$1.log" "check the network, then try again" \
        "$folder/bin/python" -m pip --disable-pip-version-check install "bpy==$version" "numpy<2" "OpenEXR==3.5.3"
    quietly "build/$1.log" "the line above names what is missing" "$folder/bin/python" -c 'import bpy'
    touch "$folder/ready"
}

make_root() {
    local folder=build/roots/$1
    if [[ -f $folder/blender-version ]]; then
        return
    fi
    ((EUID == 0)) || fail "making $folder takes root: run this with sudo"
    ensure_packages debootstrap
    step "Making $folder: Debian $1 with its Blender (2 GB)"
    rm -rf --one-file-system "$folder"
    mkdir -p build/roots
    quietly "build/root-$1.log" "check the network, then try again" \
        debootstrap --variant=minbase "$1" "$folder" "$(debian_mirror)"
    quietly "build/root-$1.log" "check the network, then try again" scripts/enter_root.sh "$folder" \
        apt-get install --yes --no-install-recommends "${root_packages[@]}"
    scripts/enter_root.sh "$folder" apt-get clean
    scripts/enter_root.sh "$folder" blender --background --version | head -n 1 >"build/root-$1.version"
    mv "build/root-$1.version" "$folder/blender-version"
}

for name in "$@"; do
    case $name in
        bpy-*) make_module "$name" ;;
        trixie | sid) make_root "$name" ;;
        *) fail "blenders.sh: unknown '$name', expected bpy-VERSION, trixie or sid" ;;
    esac
    step "$name: $(cat "build/roots/$name/blender-version" 2>/dev/null || echo "build/venvs/$name")"
done
