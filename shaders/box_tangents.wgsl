// Derivatives in segment form, the twin of those in aft/box_law/located.rs: one thread per state that moves and row.
// A stick adds one product of the sums over it and the basis where its slider was set; masks add Gram matrices.

@compute @workgroup_size(GROUP)
fn tangents_of_moving(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = batch.n_states;
    let slot = id.x;
    let a = id.y;
    if slot >= atomicLoad(&n_moving) {
        return;
    }
    let state = moving[slot];
    if !moved_and_fitted(state) {
        return;
    }
    let mu = states[state];
    for (var d = 0u; d < 2u; d++) {
        let n_sticks = counts[(2u + d) * n + state];
        for (var b = 0u; b < M; b++) {
            var by_stick = -gram(MASK_MOVED + d, a, b, state);
            var by_gap = mu * gram(MASK_SLIP + d, a, b, state);
            for (var t = 0u; t < n_sticks; t++) {
                let product = sticks[stick_at(d, t, 0u, a, state)] * sticks[stick_at(d, t, 1u, b, state)];
                by_stick -= product;
                by_gap -= product * sticks[stick_at(d, t, 1u, M, state)];
            }
            tangents[tangent_at(slot, d, a, b)] = by_stick;
            tangents[tangent_at(slot, 2u + d, a, b)] = by_gap;
        }
    }
    for (var b = 0u; b < M; b++) {
        tangents[tangent_at(slot, 4u, a, b)] = -gram(MASK_OPEN, a, b, state);
    }
}
