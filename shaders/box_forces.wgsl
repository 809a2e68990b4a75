// Force coefficients less those of the stuck contact: one thread per state, component and coefficient.

@compute @workgroup_size(GROUP)
fn forces(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = batch.n_states;
    let state = id.x;
    let c = id.y / M;
    let a = id.y % M;
    if state >= n {
        return;
    }
    var sum = real(0.0);
    if (atomicLoad(&flags[state]) & MOVED) == 0u {
        // stuck: the mean traction alone
        if a == 0u && c != GAP {
            sum = -runs[c * n + state].slider;
        }
    } else if c == GAP {
        sum = -open_gap(a, state);
    } else {
        let mu = states[state];
        sum = mu * gram(MASK_SLIP + c, a, 0u, state) * states[n + state] - gram(MASK_SLIDER + c, a, 0u, state);
        for (var b = 1u; b < M; b++) {
            let h = (b - 1u) / 2u;
            let trig = (b - 1u) % 2u;
            sum += mu * gram(MASK_SLIP + c, a, b, state) * coefficient(GAP, h, trig, state);
            sum -= gram(MASK_MOVED + c, a, b, state) * coefficient(c, h, trig, state);
        }
    }
    deviations[(c * M + a) * n + state] = sum;
}
