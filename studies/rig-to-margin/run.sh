#!/bin/sh
# From virtual tests of a contact to three margins. Usage: run.sh [MICROSLIP]; results are written to results.
set -eu
microslip=$(command -v "${1:-microslip}")
microslip=$(realpath "$microslip")
cd "$(dirname "$0")"
for loading in air punch; do
    "$microslip" rig "$loading.toml" --output "results/tests-$loading"
    # the gains of the cells keep 1 % in 95 % of the tests
    "$microslip" identify "results/tests-$loading"/test-*.csv --output "results/identified-$loading" --force-error-percent 0.5
done
for study in box measured punched; do
    "$microslip" run "$study.toml"
done
"$microslip" calibrate box.toml --measured results/tests-air/response-0001.csv --output results/calibrated
# resonances of two blades: what they say of four inputs, and what presses the strip
for rig in two-blades two-blades-air two-blades-punch; do
    "$microslip" rig "$rig.toml" --output "results/$rig"
done
"$microslip" calibrate four-inputs.toml --measured results/two-blades/response-0001.csv --output results/calibrated-four
