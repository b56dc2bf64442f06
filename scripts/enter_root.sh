#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Runs a command inside a Debian root: `enter_root.sh ROOT COMMAND...`, as root. The clone is there at its own path
# and is the working folder. Mounts and processes are the command's own: nothing of them stays when it ends.

source "$(dirname "$0")/common.sh"

((EUID == 0)) || fail "entering a Debian root takes root: run this with sudo"
root_folder=$(realpath "$1")
shift
mkdir -p "$root_folder$root"

# shellcheck disable=SC2016  # the inner shell expands
exec unshare --mount --pid --fork --kill-child bash -c '
    set -e
    inside=$1 clone=$2
    shift 2
    mount -t proc proc "$inside/proc"
    mount --rbind /sys "$inside/sys"
    mount --rbind /dev "$inside/dev"
    mount --bind "$clone" "$inside$clone"
    # Not exec: the X server does not tell a parent of process number 1 that it is ready.
    chroot "$inside" /usr/bin/env --ignore-environment --chdir="$clone" \
        HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "$@" || exit
' enter "$root_folder" "$root" "$@"
