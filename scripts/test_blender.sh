#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Tests the extension's zips in Blenders, which it makes where they are missing: `test_blender.sh [NAME...]`, names as
# in blenders.sh, and `venv` for the module in .venv; all without a name. Screenshots go to build/screenshots.

source "$(dirname "$0")/common.sh"
source scripts/debian_packages.sh

names=("$@")
if ((${#names[@]} == 0)); then
    names=(bpy-4.2.23 bpy-4.5.15 venv trixie sid)
fi

made=(bpy-4.5.15)  # also saves the scenes anew for older ones
wanted=
for name in "${names[@]}"; do
    [[ $name == venv ]] || made+=("$name")
    wanted+="${wanted:+ or }$name"
done
scripts/blenders.sh "${made[@]}"
.venv/bin/python -m pytest tests/blender -m blender --durations=0 -k "$wanted"
