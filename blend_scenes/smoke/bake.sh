#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Bake the fire-and-smoke simulation again: smoke_0001.vdb and smoke_0002.vdb beside this file, and the
# raw cache ../fluid/cache.
#
#   bake.sh [BLENDER]        BLENDER: an executable; default: `blender` on the PATH
#
# The fluid solver of the bpy modules (4.2 to 5.0) is broken, so a real Blender has to do it: 3.4, or 5.2
# and newer (4.3 as packaged by Debian aborts). Repacking needs a Python with the bpy module: set PYTHON,
# default ../../.venv/bin/python. Takes about two minutes on two cores.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
blender=${1:-blender}
python=${PYTHON:-$here/../../.venv/bin/python}

if ! command -v "$blender" >/dev/null 2>&1; then
    echo "bake.sh: no Blender executable '$blender': pass its path (bake.sh /path/to/blender) or put it on the PATH" >&2
    exit 2
fi
if ! command -v "$python" >/dev/null 2>&1; then
    echo "bake.sh: no Python '$python' to repack the cache: set PYTHON to one that has the bpy module" >&2
    exit 2
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

bake() { # cells along the longest side, last frame, cache directory
    "$blender" -b --factory-startup --python-exit-code 1 --python "$here/bake.py" -- "$1" "$2" "$3"
}

bake 96 39 "$work/fine"
"$python" "$here/pack.py" "$work/fine" 38 39

# The fluid scene keeps two frames just as Blender wrote them.
bake 32 24 "$work/coarse"
cache=$here/../fluid/cache
mkdir -p "$cache/data" "$cache/config"
cp "$work/coarse/domain.json" "$cache/"
for frame in 0023 0024; do
    cp "$work/coarse/data/fluid_data_$frame.vdb" "$cache/data/"
    cp "$work/coarse/config/config_$frame.uni" "$cache/config/"
done
