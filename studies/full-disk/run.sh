#!/usr/bin/env bash
# The study for each engine order, and all orders on one page: run.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")"
program=${1:-microslip}
mkdir -p results
for order in 3 4 5 6 7 8 9 10 11 12; do
    study=results/order-$order.toml
    sed "s/^engine_orders = .*/engine_orders = [$order]/" study.toml > "$study"
    "$program" run "$study" --output "results/order-$order" --quiet
done
"$program" disk results/order-{3,4,5,6,7,8,9,10,11,12} --output results/disk
