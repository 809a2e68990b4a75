// Transitions of the contact between open, stick and slip, with their derivatives: the twin of aft/circle_law/transition.rs.

// Direction of the traction `t`, and the row of its angle, where a slider that rested begins to move; the phase is fixed.
fn turn_towards(node: Node, t: vec2<real>) {
    let size = norm(t);
    let e = t / size;
    let factors = normal_to(e) / size;
    half = half_angle(e);
    angle = row_of(node, SignalWeights(factors, ZERO, real(0.0), real(0.0))) - factors.x * slider_rows[0] - factors.y * slider_rows[1];
    instant = NO_ROW;
}

// The slider and its rows at `node`, where slip ends.
fn stop_slider(node: Node) {
    let e = half.e;
    let p = normal_to(e);
    for (var d = 0u; d < 2u; d++) {
        let moved = node.rate[d] - e[d] * node.limit_rate;
        let turned = node.limit * p[d];
        slider_rows[d] = moved * instant - turned * angle + row_of(node, SignalWeights(axis(d), ZERO, -e[d], real(0.0)));
    }
    slider = node.path - node.limit * e;
}

// The slider, which slipped, has come to `to_place`.
fn note_way(to_place: vec2<real>) {
    longest_slip = max(longest_slip, norm(to_place - slip_from));
}

// Motion of a contact that is closed at the start of the lap.
fn resume(node: Node) {
    let t = node.path - slider;
    let size = norm(t);
    let margin = tolerance + tolerance;
    let slides = size > real(0.0) && size > node.limit - margin && sliding(node, t / size) > real(0.0);
    if slides || size > node.limit + margin {
        moves = true;
        turn_towards(node, t);
        stop_slider(node);
        slip_from = slider;
        slips = slides;
    }
}

// The slider, which rested, begins to slip at `node`.
fn start_slip(node: Node, state: u32) {
    moves = true;
    slip_from = slider;
    slips = true;
    turn_towards(node, node.path - slider);
    let e = half.e;
    let p = normal_to(e);
    let speed = sliding(node, e);
    var inverse = real(0.0);
    if speed > real(0.0) {
        inverse = real(1.0) / speed;
    }
    instant = inverse * (e.x * slider_rows[0] + e.y * slider_rows[1])
        + row_of(node, SignalWeights(-inverse * e, ZERO, inverse, real(0.0)));
    angle += inner(p, node.rate) / norm(node.path - slider) * instant;
    let bend = bending(node, e);
    let speed_row = sliding_row(node, e) + bend * instant;
    set_event_jumps(-speed * e, -bend * e, state);
    let jump_rows = turning_rows(-speed, -speed_row);
    kink(node, -speed * e, -bend * e, jump_rows, turning_rows(-bend, -bending_row(node, e)));
}

// Stores the jumps at the last event.
fn set_event_jumps(jump: vec2<real>, bend: vec2<real>, state: u32) {
    if stores && !overflows {
        events[event_at(n_events - 1u, state)].jump = jump;
        events[event_at(n_events - 1u, state)].bend = bend;
    }
}

// Stores the jumps at root k of the gap function.
fn set_root_jumps(k: u32, jump: vec2<real>, bend: vec2<real>, state: u32) {
    if stores {
        roots[event_at(k, state)].jump = jump;
        roots[event_at(k, state)].bend = bend;
    }
}

// Rows of a vector of the length `size` along the traction; `row` is that of the length.
fn turning_rows(size: real, row: Row) -> array<Row, 2> {
    let e = half.e;
    let turned = size * normal_to(e);
    return array<Row, 2>(e.x * row + turned.x * angle, e.y * row + turned.y * angle);
}

// Row of the second derivative of the elastic traction along e, less that of the limit.
fn bending_row(node: Node, e: vec2<real>) -> Row {
    let moved = inner(e, node.jerk) - node.limit_jerk;
    return inner(normal_to(e), node.bend) * angle + moved * instant + row_of_bends(node, e, real(-1.0));
}

// Row of the rate at which the slider moves along e, at a fixed phase.
fn sliding_row(node: Node, e: vec2<real>) -> Row {
    return inner(normal_to(e), node.rate) * angle + row_of(node, SignalWeights(ZERO, e, real(0.0), real(-1.0)));
}

// Row of the angle after a step of slip. Returns the derivative of the angle by the phase of the end, if the end is an event.
fn slide(here: Node, next: Node, after: HalfAngle, step: SlipStep, map: vec4<real>) -> real {
    angle *= angle_rate(half, map, after);
    if column_signal == NO_SIGNAL && !here.event && !next.event {
        return real(0.0);
    }
    let by = angle_rates(step, half);
    let limit = real(0.5) * by.limit;
    angle += row_of(here, SignalWeights(-by.path, ZERO, limit, real(0.0)));
    if here.event {
        angle += (limit * here.limit_rate - inner(by.path, here.rate) - by.length) * instant;
    }
    angle += row_of(next, SignalWeights(by.path, by.rate, limit, real(0.0)));
    return turning_of(next, by);
}

// Slip ends at `node`; `turning` is the rate of its angle.
fn end_slip(node: Node, turning: real, state: u32) {
    let e = half.e;
    let fall = sliding_rate(node, e, turning);
    var factor = real(0.0);
    if fall < real(0.0) {
        factor = real(-1.0) / fall;
    }
    instant = factor * sliding_row(node, e);
    angle += turning * instant;
    slips = false;
    stop_slider(node);
    note_way(slider);
    let bend = bending(node, e);
    set_event_jumps(ZERO, bend * e, state);
    kink(node, ZERO, bend * e, array<Row, 2>(NO_ROW, NO_ROW), turning_rows(bend, bending_row(node, e)));
}

// Row of the phase of a root of the gap function.
fn instant_of_root(node: Node) -> Row {
    if node.limit_rate == real(0.0) {
        return NO_ROW;
    }
    return row_of(node, of_limit(real(-1.0) / node.limit_rate, real(0.0)));
}

// Kink at root k of the gap function in slip: the rate of the limit begins to act there, or with the sign -1 it ceases.
fn limit_kink(k: u32, node: Node, sign: real, state: u32) {
    let jump = sign * node.limit_rate;
    let bend = sign * node.limit_bend;
    set_root_jumps(k, jump * half.e, bend * half.e, state);
    let by_limit = sign * (node.limit_bend * instant + row_of(node, of_limit(real(0.0), real(1.0))));
    let by_bend = sign * (node.limit_jerk * instant + row_of_bends(node, ZERO, real(1.0)));
    kink(node, jump * half.e, bend * half.e, turning_rows(jump, by_limit), turning_rows(bend, by_bend));
}

// The contact closes at root k: until then the slider has followed the surface. It then rests or slips at once.
fn close(k: u32, state: u32) -> Node {
    let node = root_node(k, state);
    instant = instant_of_root(node);
    let speed = norm(node.rate);
    slips = speed > node.limit_rate;
    slider = node.path;
    if slips {
        let e = node.rate / speed;
        let p = normal_to(e);
        half = half_angle(e);
        slip_from = node.path;
        angle = inner(p, node.bend) / speed * instant + row_of(node, SignalWeights(ZERO, p / speed, real(0.0), real(0.0)));
        limit_kink(k, node, real(1.0), state);
        return node;
    }
    var rates = array<Row, 2>();
    var bends = array<Row, 2>();
    for (var d = 0u; d < 2u; d++) {
        slider_rows[d] = node.rate[d] * instant + row_of(node, of_path(d));
        rates[d] = node.bend[d] * instant + row_of(node, of_rate(d));
        bends[d] = node.jerk[d] * instant + row_of_bends(node, axis(d), real(0.0));
    }
    set_root_jumps(k, node.rate, node.bend, state);
    kink(node, node.rate, node.bend, rates, bends);
    return node;
}

// The contact, which slips, opens at root k; `turning` is the rate of its angle.
fn open_contact(k: u32, node: Node, turning: real, state: u32) {
    note_way(node.path);
    instant = instant_of_root(node);
    angle += turning * instant;
    limit_kink(k, node, real(-1.0), state);
}

// The slider and its rows at the start of a lap.
fn start_lap(start: vec2<real>) {
    slider = start;
    slider_rows[0] = Row(real(1.0), real(0.0), real(0.0));
    slider_rows[1] = Row(real(0.0), real(1.0), real(0.0));
}

// The slider and its rows at the end of a lap. `open` has already changed there, so that the contact is open if it is false.
fn end_lap(state: u32) {
    let last = sample_node(N_TIME, state);
    if !open {
        slider = last.path;
        slider_rows[0] = row_of(last, of_path(0u));
        slider_rows[1] = row_of(last, of_path(1u));
    } else if slips {
        instant = NO_ROW;
        stop_slider(last);
        note_way(slider);
    }
}
