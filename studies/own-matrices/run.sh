#!/bin/sh
# The tutorial of the book from the matrices to verdicts. Usage: run.sh [MICROSLIP] [FOLDER]; microslip and results if absent.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
microslip=${1:-microslip}
out=${2:-$here/results}
"$microslip" inspect "$here/study.toml"
"$microslip" solve "$here/study.toml" --output "$out"
"$microslip" run "$here/study.toml" --output "$out"
"$microslip" extend "$out" --samples 400
"$microslip" reweight "$out" --prior "$here/prior.toml"
