# SPDX-License-Identifier: GPL-3.0-or-later
#
# Shared by the other scripts: where the clone is, and how to speak. Source it; it moves to the top folder.

set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
mkdir -p build

# One line for the step that begins now.
step() {
    printf '==> %s\n' "$*"
}

# One line that says what is wrong and what to do about it; ends the script.
fail() {
    printf 'error: %s\n' "$*" >&2
    exit 1
}

# Runs a talkative command quietly: `quietly LOG REMEDY COMMAND...`. Its output goes to LOG, whose end is shown
# when the command fails.
quietly() {
    local log=$1 remedy=$2
    shift 2
    if ! "$@" >"$log" 2>&1; then
        tail -n 25 "$log" >&2
        fail "'$1 ${2:-}' failed: $remedy (whole output in $log)"
    fi
}

# Lets one set-up or build at a time work in this clone; the lock goes when the script ends.
lock_clone() {
    exec 9>build/.lock
    if ! flock --nonblock 9; then
        step "Waiting for another build in this clone"
        flock 9
    fi
}
