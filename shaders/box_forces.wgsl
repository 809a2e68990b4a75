// Forces of the box law by Gram matrices of the motions, the twin of those in aft/box_law/located.rs.

fn deviation(c: u32, a: u32, state: u32) -> real {
    if c == GAP {
        return -open_gap(a, state);
    }
    let mu = states[state];
    var sum = mu * gram(MASK_SLIP + c, a, 0u, state) * states[batch.n_states + state] - gram(MASK_SLIDER + c, a, 0u, state);
    for (var b = 1u; b < M; b++) {
        let h = (b - 1u) / 2u;
        let trig = (b - 1u) % 2u;
        sum += mu * gram(MASK_SLIP + c, a, b, state) * coefficient(GAP, h, trig, state);
        sum -= gram(MASK_MOVED + c, a, b, state) * coefficient(c, h, trig, state);
    }
    return sum;
}
