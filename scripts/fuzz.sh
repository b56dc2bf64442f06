#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Runs the fuzz targets built by `build.sh fuzz` one after the other: `fuzz.sh SECONDS [TARGET...]`, all of them if
# none is named. An input that makes one fail is kept in build/fuzz/found; once its cause is mended, it belongs into
# tests/fuzz/corpus, which the ordinary tests replay.

source "$(dirname "$0")/common.sh"

native_targets=(vdb program checkpoint)
python_targets=(description archive)

seconds=${1:?"fuzz.sh: say for how many seconds each target is to run"}
shift
targets=("$@")
if ((${#targets[@]} == 0)); then
    targets=("${native_targets[@]}" "${python_targets[@]}")
fi

found=build/fuzz/found
mkdir -p "$found"
export UBSAN_OPTIONS=print_stacktrace=1

# libFuzzer's options for a target: hangs and memory beyond bounds count as failures, too.
options_of() {
    local longest=1024
    if [[ $1 == vdb ]]; then
        longest=65536
    fi
    printf '%s\n' "-max_total_time=$seconds" "-max_len=$longest" -timeout=60 -rss_limit_mb=3072 -print_final_stats=1 \
        "-artifact_prefix=$found/$1-"
}

# The inputs to start from, those found before among them; new ones are kept in the first folder.
corpora_of() {
    mkdir -p "build/fuzz/corpus/$1"
    printf '%s\n' "build/fuzz/corpus/$1"
    if [[ -d tests/fuzz/corpus/$1 ]]; then
        printf '%s\n' "tests/fuzz/corpus/$1"
    fi
}

run_native() {
    ASAN_OPTIONS=detect_leaks=1 "build/fuzz/tests/fuzz/fuzz_$1" "${options[@]}" "${corpora[@]}"
}

# Python is not built with the sanitizers, so their runtime, which atheris brings with libFuzzer in it, is preloaded;
# the C++ runtime too, or exceptions thrown before it is loaded for the module would not be known to the sanitizer.
# Python itself leaks at its end.
run_python() {
    local site
    site=$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
    ASAN_OPTIONS=detect_leaks=0 PYTHONPATH=build/fuzz/native \
        LD_PRELOAD="$site/asan_with_fuzzer.so:$(g++ -print-file-name=libstdc++.so)" \
        .venv/bin/python tests/fuzz/run.py "fuzz_$1" "${options[@]}" "${corpora[@]}"
}

if [[ " ${targets[*]} " == *" vdb "* ]]; then
    mkdir -p build/fuzz/corpus/vdb
    .venv/bin/python tests/fuzz/seeds.py build/fuzz/corpus/vdb
fi
failed=()
for target in "${targets[@]}"; do
    mapfile -t options < <(options_of "$target")
    mapfile -t corpora < <(corpora_of "$target")
    step "Fuzzing $target for $seconds s (build/fuzz/$target.log)"
    case " ${native_targets[*]} / ${python_targets[*]} " in
        *" $target "*/*) runner=run_native ;;
        */*" $target "*) runner=run_python ;;
        *) fail "fuzz.sh: there is no target '$target'; there are ${native_targets[*]} ${python_targets[*]}" ;;
    esac
    if "$runner" "$target" >"build/fuzz/$target.log" 2>&1; then
        grep --only-matching 'cov: [0-9]* ft: [0-9]*' "build/fuzz/$target.log" | tail -n 1 | sed 's/^/    /'
        sed -n 's/^stat::number_of_executed_units: */    executions: /p' "build/fuzz/$target.log"
    else
        failed+=("$target")
        grep --max-count=3 --after-context=12 'ERROR\|runtime error\|fuzz target\|Uncaught Python exception' \
            "build/fuzz/$target.log" || tail -n 15 "build/fuzz/$target.log"
    fi
done
if ((${#failed[@]} > 0)); then
    fail "${failed[*]} failed: mend what build/fuzz/TARGET.log shows, and move the input from $found to tests/fuzz/corpus"
fi
