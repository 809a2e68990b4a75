// Force coefficients less those of the stuck contact: one thread per state, component and coefficient. `deviation` is that
// of the law.

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
    if (atomicLoad(&flags[state]) & MOVED) != 0u {
        sum = deviation(c, a, state);
    } else if a == 0u && c != GAP {
        // stuck: the mean traction alone
        sum = -states[(2u + c) * n + state];
    }
    deviations[(c * M + a) * n + state] = sum;
}
