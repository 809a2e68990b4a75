// Force coefficients less those of the stuck contact: one thread per state, component and coefficient. A sum over the
// samples misses what `kink` in circle_located_lap.wgsl says; the normal force is exact.

fn kinks(c: u32, a: u32, event: Event) -> real {
    let x = event.share;
    let factor = real(0.5) * (x * x - x + real(1.0) / real(6.0)) * event.jump[c];
    if a == 0u {
        return factor;
    }
    let order = order_of(a);
    let part = part_of_step(x);
    var power = Turn(real(1.0), real(0.0));
    for (var k = 0u; k < order; k++) {
        power = times(power, part);
    }
    let here = turned(order, event.interval, power);
    return factor * select(here.cosine, here.sine, a % 2u == 0u);
}

@compute @workgroup_size(GROUP)
fn circle_located_forces(@builtin(global_invocation_id) id: vec3<u32>) {
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
            sum = -states[(2u + c) * n + state];
        }
    } else if c == GAP {
        sum = -open_gap(a, state);
    } else {
        for (var i = 0u; i < N_TIME; i++) {
            sum += basis(a, i) * (sample_of(TRACTION + c, i, state) - sample_of(c, i, state));
        }
        for (var k = 0u; k < counts[state]; k++) {
            sum += kinks(c, a, roots[event_at(k, state)]);
        }
        for (var k = 0u; k < counts[n + state]; k++) {
            sum += kinks(c, a, events[event_at(k, state)]);
        }
        sum *= weight(a);
    }
    deviations[(c * M + a) * n + state] = sum;
}
