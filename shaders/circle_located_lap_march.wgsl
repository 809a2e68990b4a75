// One lap from sample to sample and from event to event, the twin of aft/circle_law/lap_march.rs.

// Counts an event of the slider at `node`, and stores it.
fn add_event(node: Node, state: u32) {
    if n_events == MAX_EVENTS {
        overflows = true;
        return;
    }
    if stores {
        events[event_at(n_events, state)] = Event(node.interval, node.share, ZERO, ZERO);
    }
    n_events++;
}

// Adds the derivatives of the tractions at sample i, minus those of the stuck contact.
fn add_sample(i: u32, rate: vec2<real>) {
    if sums_up {
        spend(HARMONICS);
        sums[0] += rate;
        for (var h = 0u; h < HARMONICS; h++) {
            let phase = (orders[h] * i) % N_TIME;
            sums[2u * h + 1u] += circle[phase] * rate;
            sums[2u * h + 2u] += circle[N_TIME + phase] * rate;
        }
    }
}

// Derivatives of the tractions of the stuck contact at sample i.
fn stuck_rate(i: u32) -> vec2<real> {
    if column_signal >= GAP {
        return ZERO;
    }
    return basis(column, i) * axis(column_signal);
}

// Traction of sample i, which is in contact.
fn keep(i: u32, node: Node, state: u32) {
    if slips {
        if stores {
            store_traction(i, state, node.limit * half.e);
        }
        if sums_up {
            let by_limit = row_of(node, of_limit(real(1.0), real(0.0))).z;
            add_sample(i, node.limit * angle.z * normal_to(half.e) + by_limit * half.e - stuck_rate(i));
        }
    } else {
        if stores {
            store_traction(i, state, node.path - slider);
        }
        add_sample(i, -vec2<real>(slider_rows[0].z, slider_rows[1].z));
    }
}

// The contact is closed from `from_node` to root k, or to the end of the lap if there is no such root.
fn contact(from_node: Node, k: u32, n_roots: u32, state: u32) {
    var here = from_node;
    var end = Node();
    end.interval = N_TIME + 1u;
    if k < n_roots {
        end = root_node(k, state);
    }
    var i = here.interval + select(1u, 0u, here.event && here.share == real(0.0));
    while !overflows {
        let inside = i < end.interval || (i == end.interval && end.share > real(0.0));
        var next = end;
        if inside {
            next = sample_node(i, state);
            turns = turns || (!here.event && turns_around(here, next));
        }
        var step = step_between(here, next);
        var map = slip_map(step);
        var after = after_step(half, map);
        var found = NOTHING;
        if inside || !slips {
            found = event_between(here, next, after, state);
        }
        if found.here {
            next = event_node(here.interval, found.share, state);
            add_event(next, state);
            step = step_between(here, next);
            map = slip_map(step);
            after = after_step(half, map);
        }
        var turning = real(0.0);
        if slips {
            turning = slide(here, next, after, step, map);
            half = after;
        }
        if found.here {
            pass_event(next, turning, state);
            here = next;
            continue;
        }
        if !inside {
            pass_end(k, next, turning, state);
            return;
        }
        if i == N_TIME {
            return;
        }
        keep(i, next, state);
        here = next;
        i++;
    }
}

// Slip begins or ends at `node`; `turning` is the rate of the angle if it ends.
fn pass_event(node: Node, turning: real, state: u32) {
    if slips {
        end_slip(node, turning, state);
    } else {
        start_slip(node, state);
    }
}

// The contact opens at root k. Where it sticks there is no kink, but for rounding.
fn pass_end(k: u32, node: Node, turning: real, state: u32) {
    if slips {
        open_contact(k, node, turning, state);
    } else if stores {
        set_root_jumps(k, ZERO, ZERO, state);
    }
}

// First sample at or after root k; the end of the lap if there is no such root.
fn sample_from(k: u32, n_roots: u32, state: u32) -> u32 {
    if k >= n_roots {
        return N_TIME;
    }
    let root = roots[event_at(k, state)];
    return root.interval + select(1u, 0u, root.share == real(0.0));
}

// Begins a lap from `slider` and its rows.
fn begin_lap(state: u32) -> Node {
    n_events = 0u;
    moves = false;
    slips = false;
    longest_slip = real(0.0);
    spend(2u * N_TIME);
    let here = sample_node(0u, state);
    open = sample_of(GAP, 0u, state) <= real(0.0);
    if !open {
        resume(here);
        keep(0u, here, state);
    }
    return here;
}

// The contact is open up to root k, where it closes, or to the end of the lap.
fn pass_open(k: u32, n_roots: u32, state: u32) -> Node {
    moves = true;
    var i = 0u;
    if k > 0u {
        i = sample_from(k - 1u, n_roots, state);
    }
    let end = sample_from(k, n_roots, state);
    for (; i < end; i++) {
        if stores {
            store_traction(i, state, ZERO);
        }
        add_sample(i, -stuck_rate(i));
    }
    if k < n_roots {
        return close(k, state);
    }
    return Node();
}

// One lap from `slider` and its rows.
fn march_lap(state: u32) {
    let n_roots = counts[state];
    var here = begin_lap(state);
    for (var k = 0u; k <= n_roots && !overflows; k++) {
        if open {
            here = pass_open(k, n_roots, state);
        } else {
            contact(here, k, n_roots, state);
        }
        open = !open;
    }
    end_lap(state);
    if stores {
        counts[batch.n_states + state] = n_events;
    }
}

// One lap from the slider `start`, without derivatives of forces.
fn lap_from(start: vec2<real>, first: bool, state: u32) -> Lap {
    stores = true;
    start_lap(start);
    march_lap(state);
    let monodromy = vec4<real>(slider_rows[0].xy, slider_rows[1].xy);
    // roots may be missing where their array is full; without friction the slider is where the surface is, always
    let leaves = overflows || counts[state] == MAX_ROOTS || mu == real(0.0);
    return Lap(slider, monodromy, moves, longest_slip * ROOT_OF_RESOLUTION <= tolerance, leaves, turns);
}
