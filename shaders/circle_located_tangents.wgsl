// Derivatives of the circle law with located events, the twin of those in aft/circle_law/located.rs: one thread per state that moves
// and column. A lap with a fixed start tells how the slider's end depends on the column; from that follows the start of the steady cycle, and the next
// lap adds up the forces. Both go along the events and tractions that the march has stored.

fn step_row(row: u32, i: u32, state: u32) -> u32 {
    return ((STEPS + row) * N_TIME + i) * batch.n_states + state;
}

// Derivatives of slip from every sample to the next one, for all columns: one thread per state and sample. Of use where
// both slip and no event comes in between.
@compute @workgroup_size(GROUP)
fn circle_steps(@builtin(global_invocation_id) id: vec3<u32>) {
    let state = id.x;
    let i = id.y;
    if state >= batch.n_states || !moved_and_fitted(state) {
        return;
    }
    mu = states[state];
    let before = traction_of(i, state);
    let size = norm(before);
    if !(size > real(0.0)) {
        return;
    }
    let start = half_angle(before / size);
    let step = step_between(sample_node(i, state), sample_node(i + 1u, state));
    let map = slip_map(step);
    let by = angle_rates(step, start);
    signals[step_row(0u, i, state)] = angle_rate(start, map, after_step(start, map));
    signals[step_row(1u, i, state)] = by.path.x;
    signals[step_row(2u, i, state)] = by.path.y;
    signals[step_row(3u, i, state)] = by.rate.x;
    signals[step_row(4u, i, state)] = by.rate.y;
    signals[step_row(5u, i, state)] = by.limit;
}

fn traction_of(i: u32, state: u32) -> vec2<real> {
    return vec2<real>(sample_of(TRACTION, i % N_TIME, state), sample_of(TRACTION + 1u, i % N_TIME, state));
}

fn direction_of(i: u32, state: u32) -> vec2<real> {
    let traction = traction_of(i, state);
    return traction / norm(traction);
}

// The row of the angle from sample i to the next one, which slip both.
fn pass_step(i: u32, state: u32) {
    let half_limit = real(0.5) * signals[step_row(5u, i, state)];
    let before = wave_of_sample(i);
    let after = wave_of_sample(i + 1u);
    var by_column = real(0.0);
    if column_signal == GAP {
        by_column = mu * half_limit * (before.x + after.x);
    } else {
        let by_path = signals[step_row(1u + column_signal, i, state)];
        let by_rate = signals[step_row(3u + column_signal, i, state)];
        by_column = by_path * (after.x - before.x) + by_rate * after.y;
    }
    angle = signals[step_row(0u, i, state)] * angle + Row(real(0.0), real(0.0), by_column);
}

// A step of slip with an event at an end.
fn pass_event_step(here: Node, next: Node) -> real {
    half = half_angle(half.e);
    let step = step_between(here, next);
    let map = slip_map(step);
    let after = after_step(half, map);
    let turning = slide(here, next, after, step, map);
    half = after;
    return turning;
}

// A contact closed from `from_node` on, as `contact` found it before: from event to event, past the samples in between.
fn contact_again(from_node: Node, k: u32, n_roots: u32, state: u32) {
    var here = from_node;
    var end = Event(N_TIME, real(0.0), ZERO, ZERO);
    if k < n_roots {
        end = roots[event_at(k, state)];
    }
    let n_found = counts[batch.n_states + state];
    var i = here.interval + select(1u, 0u, here.event && here.share == real(0.0));
    while true {
        var stop = end;
        var stops_at_event = false;
        if n_events < n_found {
            let event = events[event_at(n_events, state)];
            stops_at_event = event.interval < end.interval || (event.interval == end.interval && event.share <= end.share);
            if stops_at_event {
                stop = event;
            }
        }
        let until = stop.interval + select(0u, 1u, stops_at_event || stop.share > real(0.0));
        // the step after an event ends at a sample, if one comes before the next stop
        let to_sample = slips && here.event && i < until;
        if i < until && !to_sample {
            for (; i < until; i++) {
                if slips {
                    pass_step(i - 1u, state);
                }
                keep_again(i, state);
            }
            here = sample_node(i - 1u, state);
            half.e = direction_of(i - 1u, state);
        }
        let to_end = !to_sample && !stops_at_event && k >= n_roots;
        var next = sample_node(i, state);
        if !to_sample && !to_end {
            next = event_node(stop.interval, stop.share, state);
            next.limit = select(real(0.0), next.limit, stops_at_event);
        }
        var turning = real(0.0);
        if slips {
            turning = pass_event_step(here, next);
        }
        if to_end {
            return;
        }
        if to_sample {
            keep_again(i, state);
            i++;
        } else if stops_at_event {
            pass_event(next, turning, state);
            n_events++;
        } else {
            pass_end(k, next, turning, state);
            return;
        }
        here = next;
    }
}

// Derivatives of a sample's traction.
fn keep_again(i: u32, state: u32) {
    if !sums_up {
        return;
    }
    if !slips {
        add_sample(i, -vec2<real>(slider_rows[0].z, slider_rows[1].z));
        return;
    }
    let traction = traction_of(i, state);
    var rate = angle.z * normal_to(traction);
    if column_signal == GAP {
        rate += mu * basis(column, i) / norm(traction) * traction;
    }
    add_sample(i, rate - stuck_rate(i));
}

// Passes the lap of the steady cycle again.
fn lap_again(state: u32) {
    let n_roots = counts[state];
    var here = begin_lap(state);
    for (var k = 0u; k <= n_roots; k++) {
        if open {
            here = pass_open(k, n_roots, state);
        } else {
            contact_again(here, k, n_roots, state);
        }
        open = !open;
    }
    end_lap(state);
}

// The state, and the column, of a thread: columns of one state stand side by side, since they go the same way.
fn slot_of(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    let thread = id.y * (groups.x * GROUP) + id.x;
    column_signal = thread % (3u * M) / M;
    column = thread % M;
    return thread / (3u * M);
}

// Whether the state at `slot` has a derivative, of laps from the anchor or not.
fn has_derivative(slot: u32, anchored: bool) -> bool {
    if slot >= atomicLoad(&n_moving) {
        return false;
    }
    let state = moving[slot];
    return moved_and_fitted(state) && (cycles[state].laps > 0u) == anchored;
}

fn store_column(slot: u32, state: u32) {
    if overflows {
        atomicOr(&flags[state], OVERFLOW);
        return;
    }
    for (var a = 0u; a < M; a++) {
        let w = weight(a);
        tangents[tangent_at(slot, block_of(0u, column_signal), a, column)] = w * sums[a].x;
        tangents[tangent_at(slot, block_of(1u, column_signal), a, column)] = w * sums[a].y;
        if column_signal == GAP {
            tangents[tangent_at(slot, 6u, a, column)] = -gram(MASK_OPEN, a, column, state);
        }
    }
}

@compute @workgroup_size(GROUP)
fn circle_located_tangents(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let slot = slot_of(id, groups);
    if !has_derivative(slot, false) {
        return;
    }
    let state = moving[slot];
    let cycle = take_cycle(state);
    var by = ZERO;
    for (var lap = 1u; lap <= 2u; lap++) {
        sums_up = lap == 2u;
        start_lap(cycle.start);
        slider_rows[0].z = by.x;
        slider_rows[1].z = by.y;
        lap_again(state);
        let monodromy = vec4<real>(slider_rows[0].xy, slider_rows[1].xy);
        by = solve_identity_minus(monodromy, vec2<real>(slider_rows[0].z, slider_rows[1].z));
    }
    store_column(slot, state);
}

// The same where the cycle is not unique: plain laps from the anchor, with events of their own, tell how it depends on
// the column.
@compute @workgroup_size(GROUP)
fn circle_anchored_tangents(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let slot = slot_of(id, groups);
    if !has_derivative(slot, true) {
        return;
    }
    let state = moving[slot];
    let cycle = take_cycle(state);
    start_lap(anchor_of(state));
    for (var lap = 1u; lap <= cycle.laps && !overflows; lap++) {
        sums_up = lap == cycle.laps;
        march_lap(state);
    }
    store_column(slot, state);
}
