// Derivatives of the circle law with located events: one thread per state that moves and column. A lap with a fixed
// start tells how the slider's end depends on the column; from that follows the start of the steady cycle, and the next
// lap adds up the forces.

@compute @workgroup_size(GROUP)
fn circle_located_tangents(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    let c = id.y / M;
    let b = id.y % M;
    if slot >= atomicLoad(&n_moving) {
        return;
    }
    let state = moving[slot];
    if atomicLoad(&flags[state]) != MOVED {
        return;
    }
    set_state(state);
    column_signal = c;
    column = b;
    stores = false;
    let cycle = cycles[state];
    let anchored = cycle.laps > 0u;
    let laps = select(2u, cycle.laps, anchored);
    // laps from the anchor have events of their own
    searches = anchored;
    slider = select(cycle.start, anchor_of(state), anchored);
    slider_rows[0] = Row(real(1.0), real(0.0), real(0.0));
    slider_rows[1] = Row(real(0.0), real(1.0), real(0.0));
    for (var lap = 1u; lap <= laps; lap++) {
        sums_up = lap == laps;
        if lap == 2u && !anchored {
            let monodromy = vec4<real>(slider_rows[0].xy, slider_rows[1].xy);
            let by = solve_identity_minus(monodromy, vec2<real>(slider_rows[0].z, slider_rows[1].z));
            slider = cycle.start;
            slider_rows[0] = Row(real(0.0), real(0.0), by.x);
            slider_rows[1] = Row(real(0.0), real(0.0), by.y);
        }
        walk(state);
    }
    if overflows {
        atomicOr(&flags[state], OVERFLOW);
        return;
    }
    for (var a = 0u; a < M; a++) {
        let w = weight(a);
        tangents[tangent_at(slot, block_of(0u, c), a, b)] = w * sums[a].x;
        tangents[tangent_at(slot, block_of(1u, c), a, b)] = w * sums[a].y;
        if c == GAP {
            tangents[tangent_at(slot, 6u, a, b)] = -gram(MASK_OPEN, a, b, state);
        }
    }
}
