// Forces of the circle law with located events. A sum over the samples misses what `kink` in circle_located_kink.wgsl says;
// the normal force is exact.

fn missed(c: u32, a: u32, event: Event) -> real {
    let factor = kink_weight(event.share) * event.jump[c];
    if a == 0u {
        return factor;
    }
    let here = turn_at(order_of(a), event.interval, part_of_step(event.share));
    return factor * select(here.cosine, here.sine, a % 2u == 0u);
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
