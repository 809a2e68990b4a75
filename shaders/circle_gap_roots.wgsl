// Roots of the gap function, at which the contact opens and closes, and the spectrum of the open contact: the twin of `gap_roots` in
// aft/signals/breakpoints.rs and of `normal` in aft/box_law/located.rs.

@compute @workgroup_size(GROUP)
fn gap_roots(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = batch.n_states;
    let state = id.x;
    if state >= n {
        return;
    }
    var n_roots = 0u;
    for (var i = 0u; i < N_TIME; i++) {
        let next = (i + 1u) % N_TIME;
        let gap = array<real, 2>(sample_of(GAP, i, state), sample_of(GAP, next, state));
        let rate = array<real, 2>(sampled_rate(GAP, i, state), sampled_rate(GAP, next, state));
        let mark = gap_mark(gap, rate);
        if mark == 0u {
            continue;
        }
        n_found = 0u;
        find_roots(taylor(GAP, i, state), mark == DIP);
        // a pair comes in its order
        for (var k = 0u; k < n_found && n_roots < MAX_ROOTS; k++) {
            roots[event_at(n_roots, state)] = Event(i, found[k], ZERO, ZERO);
            n_roots++;
        }
    }
    counts[state] = n_roots;
    // spectrum of the open contact
    for (var k = 0u; k < N_ORDERS; k++) {
        spectra[spectrum_at(MASK_OPEN, 0u, k, state)] = real(0.0);
        spectra[spectrum_at(MASK_OPEN, 1u, k, state)] = real(0.0);
    }
    let opens_at_start = sample_of(GAP, 0u, state) <= real(0.0);
    var open = opens_at_start;
    for (var r = 0u; r < n_roots; r++) {
        let root = roots[event_at(r, state)];
        add_end(root.interval, root.share, select(real(-1.0), real(1.0), open), state);
        open = !open;
    }
    if opens_at_start {
        add_end(0u, real(0.0), real(-1.0), state);
    }
    if open {
        add_end(N_TIME, real(0.0), real(1.0), state);
    }
}

// Adds the antiderivatives of the basis functions at the end of an open stretch, or with the sign -1 at its start.
fn add_end(interval: u32, share: real, sign: real, state: u32) {
    add(MASK_OPEN, 0u, sign, (real(interval) + share) / real(N_TIME), real(0.0), state);
    let part = part_of_step(share);
    var power = Turn(real(1.0), real(0.0));
    for (var k = 1u; k < N_ORDERS; k++) {
        power = times(power, part);
        let here = turned(k, interval, power);
        add(MASK_OPEN, k, sign / (TAU * real(k)), here.sine, -here.cosine, state);
    }
}
