#!/usr/bin/env bash
# Measures a GPU in one run and writes files: tests, benchmarks, profiles, other denoisers.
#
#   benches/gpu.sh prepare FOLDER      builds the programs on any machine with the toolchain
#   benches/gpu.sh run FOLDER OUT      runs them in a checkout on the machine with the GPU
#
# The second step needs no toolchain and no network. Denoisers missing from FOLDER, or without
# their Python packages, become rows that name the reason (benches/peers/README.md).
set -euo pipefail
here=$PWD
cd "$(dirname "$0")/.."

usage() { sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 2; }

# Prints name and path of each program that Cargo builds.
programs() {
    cargo "$@" --no-run --message-format=json | python3 -c '
import json, sys
for line in sys.stdin:
    built = json.loads(line)
    if built.get("executable"):
        print(built["target"]["name"], built["executable"])'
}

prepare() {
    mkdir -p "$1"
    cargo build --release
    cp "${CARGO_TARGET_DIR:-target}/release/wgdenoise" "$1/"
    { programs test --release --test ops --test network; programs bench --bench frame; } |
        while read -r name program; do cp "$program" "$1/$name"; done
    ls -l "$1"
}

run() {
    local bin out
    bin=$1 out=$2
    mkdir -p "$out"
    # A failed step is reported at the end; the others still run.
    local failed=()
    step() {
        local file=$1
        shift
        echo "== $file: $*"
        "$@" >"$out/$file" 2>&1 || failed+=("$file")
        tail -n 3 "$out/$file"
    }
    step devices.txt "$bin/wgdenoise" devices
    step test_ops.txt "$bin/ops"
    step test_network.txt "$bin/network"
    step bench.txt "$bin/frame" --operators --record "$out/bench.json" --runs 20
    # Each set that a GPU may run, forced, in alternating rounds, as clocks change with temperature.
    # Fails where a GPU lacks what a set needs: `half` 16-bit floats, `matrix` matrix units.
    local round set tier
    for round in 1 2 3; do
        for set in tiled wide half matrix; do
            step "bench_${set}_$round.txt" "$bin/frame" --kernels "$set" --operators \
                --record "$out/bench_${set}_$round.json" --runs 10
        done
    done
    for tier in fast balanced high; do
        step "profile_$tier.txt" "$bin/wgdenoise" profile --runs 20 --quality "$tier" \
            --width 3840 --height 2160
    done
    local peers=(--wgdenoise "$bin/wgdenoise" --runs 10 --burst 20)
    [[ -x $bin/burn ]] && peers+=(--burn "$bin/burn")
    [[ -x $bin/oidn-webgpu-native ]] && peers+=(--oidn-webgpu-native "$bin/oidn-webgpu-native")
    [[ -d $bin/peer-weights ]] && peers+=(--weights-cache "$bin/peer-weights")
    local size
    for size in 1024x1024 3840x2160; do
        step "peers_$size.md" python3 benches/peers/run.py --size "$size" --out "$out/peers_$size" \
            "${peers[@]}"
    done
    [[ ${#failed[@]} -eq 0 ]] || { echo "failed: ${failed[*]}"; exit 1; }
}

case ${1:-} in
    prepare) [[ $# -eq 2 ]] || usage; prepare "$(cd "$here" && realpath -m "$2")" ;;
    run) [[ $# -eq 3 ]] || usage; run "$(cd "$here" && realpath -m "$2")" "$(cd "$here" && realpath -m "$3")" ;;
    *) usage ;;
esac
