// Signals at the samples: one thread per state and sample.

@compute @workgroup_size(GROUP)
fn transform(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = batch.n_states;
    let state = id.x;
    let i = id.y;
    if state >= n {
        return;
    }
    var value = array<real, 3>();
    var rate = array<real, 3>();
    value[GAP] = states[n + state];
    for (var h = 0u; h < HARMONICS; h++) {
        let k = orders[h];
        let phase = (k * i) % N_TIME;
        let cosine = circle[phase];
        let sine = circle[N_TIME + phase];
        for (var c = 0u; c < 3u; c++) {
            let a = coefficient(c, h, 0u, state);
            let b = coefficient(c, h, 1u, state);
            value[c] += a * cosine + b * sine;
            rate[c] += real(k) * (b * cosine - a * sine);
        }
    }
    for (var c = 0u; c < 3u; c++) {
        signals[(c * N_TIME + i) * n + state] = value[c];
        signals[((3u + c) * N_TIME + i) * n + state] = STEP * rate[c];
    }
}
