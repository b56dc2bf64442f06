# SPDX-License-Identifier: GPL-3.0-or-later
#
# Which Debian packages the project needs, and how missing ones are installed. Sourced after common.sh.

build_packages=(
    g++ make cmake ninja-build
    libembree-dev libopenvdb-dev libtbb-dev libopenexr-dev libimath-dev
    libboost-dev libboost-iostreams-dev libblosc-dev zlib1g-dev  # OpenVDB's headers and CMake file ask for them
    libgtest-dev
)

# bpy brings its own libraries except those of the window system, which it loads even without a display. Without
# libegl1 `import bpy` works, but Blender aborts as soon as an engine or a compositor asks for a GPU context.
bpy_packages=(
    libx11-6 libxext6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libice6 libgl1 libegl1
)

lint_packages=(clang-format clang-tidy git)
count_packages=(valgrind)

fuzz_packages=(clang-14 libclang-rt-14-dev)  # libFuzzer and the sanitizers' runtime

# Prints those of the named packages that are not installed. Asks dpkg alone: no network, no root.
missing_packages() {
    local installed
    # dpkg-query fails when it knows one of the names not at all; that is an answer, too.
    installed=$(dpkg-query --show --showformat='${Package} ${db:Status-Status}\n' "$@" 2>/dev/null |
        sed -n 's/ installed$//p') || true
    local package
    for package in "$@"; do
        grep --quiet --line-regexp --fixed-strings "$package" <<<"$installed" || printf '%s\n' "$package"
    done
}

# Installs what is missing of the named packages; does nothing, and needs nothing, when all are there.
ensure_packages() {
    command -v dpkg-query >/dev/null ||
        fail "this set-up needs Debian 12's packages: run it on Debian 12, or follow CONTRIBUTING.md by hand"
    local missing
    mapfile -t missing < <(missing_packages "$@")
    if ((${#missing[@]} == 0)); then
        return
    fi

    local as_root=()
    if ((EUID != 0)); then
        sudo true 2>/dev/null ||  # a prompt for a password goes to the terminal all the same
            fail "Debian packages are missing: as root run 'apt-get install ${missing[*]}', then try again"
        as_root=(sudo)
    fi
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300)

    step "Installing Debian packages: ${missing[*]}"
    if ! "${apt[@]}" update >build/apt-update.log 2>&1; then
        step "apt-get update complained (build/apt-update.log); going on with the lists it has"
    fi
    quietly build/apt-install.log "check the network and /etc/apt/sources.list" \
        "${apt[@]}" install --yes --no-install-recommends "${missing[@]}"
}

# Prints the mirror that this machine's own apt takes Debian from.
debian_mirror() {
    local mirror
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' |
        grep --max-count 1 '/debian/$') || fail "apt knows no mirror of Debian: run 'apt-get update' as root"
    printf '%s\n' "$mirror"
}
