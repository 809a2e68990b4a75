// Spectra of the stretches of each motion, from antiderivatives at their ends: one thread per state and direction. The twin of
// aft/box_law/located.rs, with box_forces.wgsl and box_tangents.wgsl.

// Per stick with a source: sums of the basis over it; basis at the source and the slider's rate by the gap function.
// Shape: [MAX_STICKS][2][2][M + 1][state]
@group(0) @binding(10) var<storage, read_write> sticks: array<real>;

const STICKS_PER_STATE: u32 = 4u * MAX_STICKS * (M + 1u);

fn stick_at(d: u32, stick: u32, part: u32, row: u32, state: u32) -> u32 {
    return ((((stick * 2u + d) * 2u + part) * (M + 1u)) + row) * batch.n_states + state;
}

// Sums of the basis over a stick, basis at its source, and rate of the slider by the gap function there.
fn store_stick(run: Run, start_interval: u32, start_share: real, d: u32, stick: u32, state: u32) {
    let begin = part_of_step(start_share);
    let end = part_of_step(run.share);
    let source = part_of_step(run.source_share);
    let length = (real(run.interval) - real(start_interval)) + (run.share - start_share);
    sticks[stick_at(d, stick, 0u, 0u, state)] = length / real(N_TIME);
    sticks[stick_at(d, stick, 1u, 0u, state)] = real(1.0);
    var powers = array<Turn, 3>(Turn(real(1.0), real(0.0)), Turn(real(1.0), real(0.0)), Turn(real(1.0), real(0.0)));
    var k = 0u;
    var slider_rate = real(0.0);
    var gap_rate = real(0.0);
    for (var h = 0u; h < HARMONICS; h++) {
        let order = orders[h];
        while k < order {
            powers[0] = times(powers[0], begin);
            powers[1] = times(powers[1], end);
            powers[2] = times(powers[2], source);
            k++;
        }
        let a = turned(order, start_interval, powers[0]);
        let b = turned(order, run.interval, powers[1]);
        let s = turned(order, run.source_interval, powers[2]);
        let factor = real(2.0) / (TAU * real(order));
        sticks[stick_at(d, stick, 0u, 2u * h + 1u, state)] = factor * (b.sine - a.sine);
        sticks[stick_at(d, stick, 0u, 2u * h + 2u, state)] = factor * (a.cosine - b.cosine);
        sticks[stick_at(d, stick, 1u, 2u * h + 1u, state)] = s.cosine;
        sticks[stick_at(d, stick, 1u, 2u * h + 2u, state)] = s.sine;
        slider_rate += real(order) * (coefficient(d, h, 1u, state) * s.cosine - coefficient(d, h, 0u, state) * s.sine);
        gap_rate += real(order) * (coefficient(GAP, h, 1u, state) * s.cosine - coefficient(GAP, h, 0u, state) * s.sine);
    }
    var by_gap = real(0.0);
    if run.source_motion == SLIP_UP {
        by_gap = -states[state];
    } else if run.source_motion == SLIP_DOWN {
        by_gap = states[state];
    } else if gap_rate > real(0.0) {
        by_gap = -(slider_rate / gap_rate);
    }
    sticks[stick_at(d, stick, 1u, M, state)] = by_gap;
}

// Sets the spectra of direction d to zero; that of the open contact, which has no direction, with the first one.
fn clear_spectra(d: u32, state: u32) {
    let zero = real(0.0);
    for (var k = 0u; k < N_ORDERS; k++) {
        for (var trig = 0u; trig < 2u; trig++) {
            spectra[spectrum_at(MASK_MOVED + d, trig, k, state)] = zero;
            spectra[spectrum_at(MASK_SLIP + d, trig, k, state)] = zero;
            spectra[spectrum_at(MASK_SLIDER + d, trig, k, state)] = zero;
            if d == 0u {
                spectra[spectrum_at(MASK_OPEN, trig, k, state)] = zero;
            }
        }
    }
}

@compute @workgroup_size(GROUP)
fn spectra_of_runs(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = batch.n_states;
    let state = id.x;
    let d = id.y;
    if state >= n || !moved_and_fitted(state) {
        return;
    }
    let zero = real(0.0);
    clear_spectra(d, state);
    var start_interval = 0u;
    var start_share = zero;
    var n_sticks = 0u;
    let n_runs = counts[d * n + state];
    for (var r = 0u; r < n_runs; r++) {
        let run = runs[(r * 2u + d) * n + state];
        let begin = part_of_step(start_share);
        let end = part_of_step(run.share);
        var first = Turn(real(1.0), zero);
        var last = first;
        for (var k = 0u; k < N_ORDERS; k++) {
            var cosine = (real(run.interval) - real(start_interval) + (run.share - start_share)) / real(N_TIME);
            var sine = zero;
            if k > 0u {
                first = times(first, begin);
                last = times(last, end);
                let a = turned(k, start_interval, first);
                let b = turned(k, run.interval, last);
                let factor = real(1.0) / (TAU * real(k));
                cosine = factor * (b.sine - a.sine);
                sine = factor * (a.cosine - b.cosine);
            }
            if run.motion == STICK {
                add(MASK_SLIDER + d, k, run.slider, cosine, sine, state);
                continue;
            }
            add(MASK_MOVED + d, k, real(1.0), cosine, sine, state);
            if run.motion != SEPARATED {
                add(MASK_SLIP + d, k, select(real(-1.0), real(1.0), run.motion == SLIP_UP), cosine, sine, state);
            } else if d == 0u {
                add(MASK_OPEN, k, real(1.0), cosine, sine, state);
            }
        }
        if run.motion == STICK && run.source_motion != STICK {
            if n_sticks == MAX_STICKS {
                atomicOr(&flags[state], OVERFLOW);
                break;
            }
            store_stick(run, start_interval, start_share, d, n_sticks, state);
            n_sticks++;
        }
        start_interval = run.interval;
        start_share = run.share;
    }
    counts[(2u + d) * n + state] = n_sticks;
}
