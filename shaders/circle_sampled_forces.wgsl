// Force coefficients less those of the stuck contact: one thread per state, component and coefficient.

@compute @workgroup_size(GROUP)
fn circle_sampled_forces(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = batch.n_states;
    let state = id.x;
    let c = id.y / M;
    let a = id.y % M;
    if state >= n {
        return;
    }
    var sum = real(0.0);
    for (var i = 0u; i < N_TIME; i++) {
        var deviation = -min(sample_of(GAP, i, state), real(0.0));
        if c != GAP {
            deviation = sample_of(TRACTION + c, i, state) - sample_of(c, i, state);
        }
        sum += basis(a, i) * deviation;
    }
    deviations[(c * M + a) * n + state] = weight(a) * sum;
}
