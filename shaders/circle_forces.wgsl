// Force coefficients less those of the stuck contact: one thread per state, component and coefficient.

fn basis(a: u32, i: u32) -> real {
    if a == 0u {
        return real(1.0);
    }
    let phase = (orders[(a - 1u) / 2u] * i) % N_TIME;
    return circle[select(phase, N_TIME + phase, a % 2u == 0u)];
}

fn weight(a: u32) -> real {
    return select(real(2.0), real(1.0), a == 0u) / real(N_TIME);
}

@compute @workgroup_size(GROUP)
fn circle_forces(@builtin(global_invocation_id) id: vec3<u32>) {
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
            deviation = sample_of(3u + c, i, state) - sample_of(c, i, state);
        }
        sum += basis(a, i) * deviation;
    }
    deviations[(c * M + a) * n + state] = weight(a) * sum;
}
