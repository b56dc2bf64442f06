#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Makes a clone ready to build: Debian packages, .venv with pinned Python packages, and the package `nephele`
# (the folder addon/) installed there in editable form. Each step leaves a stamp holding what it was made from,
# so that a second run only compares. `setup.sh lint` also installs the tools of `make lint`, `setup.sh bench`
# the other renderers that bench/ measures against, `setup.sh count` what counts instructions, `setup.sh fuzz`
# the fuzzers, `setup.sh extension` what packs wheels.
#
# PYTHON=PATH chooses the Python 3.11 that .venv is made from.

source "$(dirname "$0")/common.sh"
source scripts/debian_packages.sh

stamps=.venv/stamps

# True if the named stamp says exactly this.
stamp_is() {
    [[ -f $stamps/$1 && $(<"$stamps/$1") == "$2" ]]
}

write_stamp() {
    mkdir -p "$stamps"
    printf '%s\n' "$2" >"$stamps/$1"
}

is_python_3_11() {
    [[ $("$1" -c 'import sys; print(*sys.version_info[:2])' 2>/dev/null) == "3 11" ]]
}

# Prints the interpreter .venv is to be made from; prints nothing if there is none. A .venv that is there keeps
# its interpreter, whatever PATH says today.
find_python() {
    local candidate
    if [[ -z ${PYTHON:-} && -f $stamps/venv && $(<"$stamps/venv") == "$root "* ]] && is_python_3_11 .venv/bin/python; then
        candidate=$(<"$stamps/venv")
        printf '%s\n' "${candidate#"$root "}"
        return
    fi
    for candidate in ${PYTHON:-python3.11 python3 /usr/bin/python3.11}; do
        candidate=$(command -v "$candidate") || continue
        if is_python_3_11 "$candidate"; then
            # Behind a shim (pyenv's) stands the real one; a shim in .venv would change with the folder.
            "$candidate" -c 'import sys; print(sys.executable)'
            return
        fi
    done
}

# Debian splits what Python needs to make a .venv and to compile a module into packages of their own.
python_packages() {
    if [[ $1 == /usr/bin/python3* ]]; then
        printf '%s\n' python3.11-venv python3.11-dev
    fi
}

make_venv() {
    local python=$1 made_from="$root $1"
    if stamp_is venv "$made_from" && is_python_3_11 .venv/bin/python; then
        return
    fi
    step "Making .venv from $python"
    rm -rf .venv
    quietly build/venv.log "check that '$python -m venv' works, or choose another with PYTHON=PATH" \
        "$python" -m venv .venv
    write_stamp venv "$made_from"
}

install_requirements() {
    local made_from
    made_from=$(sha256sum requirements.txt)
    if stamp_is requirements "$made_from"; then
        return
    fi
    step "Installing the Python packages of requirements.txt (Blender's module among them: about 0.5 GB)"
    quietly build/pip.log "check the network, then try again" \
        .venv/bin/python -m pip --disable-pip-version-check install --requirement requirements.txt
    step "Loading Blender's module once"
    quietly build/bpy.log "the line above names what is missing; if a library, its Debian package" \
        .venv/bin/python -c 'import bpy; print(bpy.app.version_string)'
    write_stamp requirements "$made_from"
}

# install_extra NAME FILE: what only some targets need.
install_extra() {
    local made_from
    made_from=$(sha256sum "$2")
    if stamp_is "$1" "$made_from"; then
        return
    fi
    step "Installing the Python packages of $2"
    quietly "build/$1.log" "check the network, then try again" \
        .venv/bin/python -m pip --disable-pip-version-check install --no-deps --requirement "$2"
    write_stamp "$1" "$made_from"
}

install_nephele() {
    local made_from
    made_from=$(sha256sum pyproject.toml)
    if stamp_is nephele "$made_from"; then
        return
    fi
    step "Installing the package nephele (the folder addon/, editable)"
    quietly build/nephele.log "see the lines above" \
        .venv/bin/python -m pip --disable-pip-version-check install \
        --no-index --no-deps --no-build-isolation --editable .
    write_stamp nephele "$made_from"
}

lock_clone

python=$(find_python)
[[ -n $python ]] ||
    fail "Python 3.11 not found: 'apt-get install python3' on Debian 12, or pass PYTHON=/path/to/python3.11"
[[ $(uname -m) == x86_64 ]] ||
    fail "Blender's Python module for Linux exists for x86_64 only, this machine is $(uname -m): use an x86_64 one"

mapfile -t packages < <(python_packages "$python")
packages+=("${build_packages[@]}" "${bpy_packages[@]}")
if [[ ${1:-} == lint ]]; then
    packages+=("${lint_packages[@]}")
elif [[ ${1:-} == fuzz ]]; then
    packages+=("${fuzz_packages[@]}")
elif [[ ${1:-} == count ]]; then
    packages+=("${count_packages[@]}")
fi
ensure_packages "${packages[@]}"
make_venv "$python"
install_requirements
case ${1:-} in
    bench) install_extra bench bench/requirements.txt ;;
    extension) install_extra extension tools/extension/requirements.txt ;;
    fuzz) install_extra fuzz tests/fuzz/requirements.txt ;;
esac
install_nephele
