// Forces of the circle law with located events. A sum over the samples misses what `kink` in circle_located_kink.wgsl says;
// the normal force is exact. The twin of `add_force` in aft/circle_law/kink.rs.

fn missed(c: u32, a: u32, event: Event) -> real {
    let factors = kink_weights(event.share);
    let value = factors.y * event.jump[c] - factors.z * event.bend[c];
    if a == 0u {
        return value;
    }
    let here = turn_at(order_of(a), event.interval, part_of_step(event.share));
    let rate = -(factors.z + factors.z) * event.jump[c] * real(order_of(a)) * STEP;
    let sine = a % 2u == 0u;
    return value * select(here.cosine, here.sine, sine) + rate * select(-here.sine, here.cosine, sine);
}

fn deviation(c: u32, a: u32, state: u32) -> real {
    if c == GAP {
        return -open_gap(a, state);
    }
    var sum = real(0.0);
    for (var i = 0u; i < N_TIME; i++) {
        sum += basis(a, i) * (sample_of(TRACTION + c, i, state) - sample_of(c, i, state));
    }
    for (var k = 0u; k < counts[state]; k++) {
        sum += missed(c, a, roots[event_at(k, state)]);
    }
    for (var k = 0u; k < counts[batch.n_states + state]; k++) {
        sum += missed(c, a, events[event_at(k, state)]);
    }
    return weight(a) * sum;
}
