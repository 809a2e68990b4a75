#!/usr/bin/env bash
# What happens to four small studies where one constant of the source has another value:
#
#     benches/constants/constants.sh FILE NAME VALUE [FILE NAME VALUE ...]
#     benches/constants/constants.sh src/solver/hb/newton/solve.rs PATIENCE 6 src/solver/hb/newton/solve.rs PATIENCE 24
#
# Works on a copy of the source under target/, one build per value. Only what the constant touches is compiled again.
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
copy=${CARGO_TARGET_DIR:-$root/target}/constants
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target} CARGO_PROFILE_BENCH_INCREMENTAL=true

mkdir -p "$copy"
for part in Cargo.toml Cargo.lock src shaders benches tests python; do
    cp -a --update "$part" "$copy/"
done
cd "$copy"
outcome() { cargo bench --quiet --bench constants -- "$copy/peaks.json"; }

rm -f peaks.json
echo "== as it is"
outcome
while [ $# -ge 3 ]; do
    file=$1 name=$2 value=$3
    shift 3
    cp "$file" before.rs
    sed -i -E "s|^(pub(\(.*\))? )?const $name: ([^=]+) = .*;|\1const $name: \3 = $value;|" "$file"
    if cmp -s before.rs "$file"; then
        echo "$file has no constant $name on one line with another value" >&2
        exit 2
    fi
    echo "== $file $name = $value"
    outcome || echo "fails"
    cp before.rs "$file"
done
