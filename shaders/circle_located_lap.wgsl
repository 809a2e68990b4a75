// Lap of the circle law with located events, the twin of course.rs and lap.rs of aft/circle_law, where the formulas are explained:
// with the derivatives by the start tractions and by one coefficient of one signal. Time counts in intervals between
// samples.

// Row of `signals` with the tractions.
const TRACTION: u32 = 6u;
// First row with the derivatives of the steps of slip.
const STEPS: u32 = 8u;
const SIGNAL_ROWS: u32 = 14u;
const MASKS: u32 = 1u;

// A root of the gap function or an event of the slider, and the jump of the slope of the tractions there.
struct Event {
    interval: u32,
    share: real,
    jump: vec2<real>,
}

// Ascending from phase 0. Shape: [MAX_ROOTS][state], [MAX_EVENTS][state]
@group(0) @binding(7) var<storage, read_write> roots: array<Event>;
@group(0) @binding(8) var<storage, read_write> events: array<Event>;
// Roots, events. Shape: [2][state]
@group(0) @binding(10) var<storage, read_write> counts: array<u32>;

const ROOTS_PER_STATE: u32 = MAX_ROOTS;
const EVENTS_PER_STATE: u32 = MAX_EVENTS;
const COUNTS_PER_STATE: u32 = 2u;

// The signals at one phase; second derivatives at events only.
struct Node {
    interval: u32,
    share: real,
    event: bool,
    path: vec2<real>,
    rate: vec2<real>,
    bend: vec2<real>,
    limit: real,
    limit_rate: real,
    limit_bend: real,
    // Basis function of the column, and its rate.
    wave: vec2<real>,
}

// Derivatives of one number: by the two start tractions, by the column's coefficient.
alias Row = vec3<real>;

// Factors of the signals at one phase in a number.
struct Mix {
    path: vec2<real>,
    rate: vec2<real>,
    limit: real,
    limit_rate: real,
}

const ZERO: vec2<real> = vec2<real>(real(0.0), real(0.0));
const NO_ROW: Row = Row(real(0.0), real(0.0), real(0.0));

// Signal and coefficient of the column; the march has none.
const NO_SIGNAL: u32 = 3u;
var<private> column_signal: u32 = NO_SIGNAL;
var<private> column: u32;

// Whether events and tractions are stored, whether derivatives of forces are summed up.
var<private> stores: bool;
var<private> sums_up: bool;
var<private> sums: array<vec2<real>, M>;

// The interval whose polynomials are at hand.
var<private> polynomials: array<Polynomial, 3>;
var<private> entered: u32 = N_TIME;

// Motion at hand: whether the contact is open; the slider in stick, the direction in slip, their rows.
var<private> open: bool;
var<private> slips: bool;
var<private> slider: vec2<real>;
var<private> half: HalfAngle;
var<private> slider_rows: array<Row, 2>;
var<private> angle: Row;
var<private> instant: Row;

var<private> moves: bool;
var<private> overflows: bool;
// Where the present slip began, and the longest way of the slider in one slip.
var<private> slip_from: vec2<real>;
var<private> way: real;
var<private> n_events: u32;
// Loop iterations so far: a widespread software adapter ends loops silently after 65 535.
var<private> spent: u32;

fn spend(iterations: u32) {
    spent += iterations;
    overflows = overflows || spent > MAX_ITERATIONS;
}

fn event_at(k: u32, state: u32) -> u32 {
    return k * batch.n_states + state;
}

fn mixed(node: Node, mix: Mix) -> Row {
    var factors = vec2<real>(real(0.0), real(0.0));
    if column_signal < GAP {
        factors = vec2<real>(mix.path[column_signal], mix.rate[column_signal]);
    } else if column_signal == GAP {
        factors = mu * vec2<real>(mix.limit, mix.limit_rate);
    }
    return Row(real(0.0), real(0.0), inner(factors, node.wave));
}

fn of_path(d: u32) -> Mix {
    return Mix(axis(d), ZERO, real(0.0), real(0.0));
}

fn of_rate(d: u32) -> Mix {
    return Mix(ZERO, axis(d), real(0.0), real(0.0));
}

fn of_limit(limit: real, limit_rate: real) -> Mix {
    return Mix(ZERO, ZERO, limit, limit_rate);
}

fn axis(d: u32) -> vec2<real> {
    return select(vec2<real>(real(0.0), real(1.0)), vec2<real>(real(1.0), real(0.0)), d == 0u);
}

// Basis function of the column a part of a step after sample i, and its rate.
fn wave_at(i: u32, part: Turn) -> vec2<real> {
    if column == 0u {
        return vec2<real>(real(1.0), real(0.0));
    }
    let order = order_of(column);
    let here = turn_at(order, i, part);
    let rate = real(order) * STEP;
    if column % 2u == 0u {
        return vec2<real>(here.sine, rate * here.cosine);
    }
    return vec2<real>(here.cosine, -rate * here.sine);
}

fn sample_node(i: u32, state: u32) -> Node {
    let at = i % N_TIME;
    var node = Node();
    node.interval = i;
    node.path = stick_signal(at, state);
    node.rate = vec2<real>(sampled_rate(0u, at, state), sampled_rate(1u, at, state));
    node.limit = mu * max(sample_of(GAP, at, state), real(0.0));
    node.limit_rate = mu * sampled_rate(GAP, at, state);
    if column_signal != NO_SIGNAL {
        node.wave = wave_of_sample(i);
    }
    return node;
}

fn wave_of_sample(i: u32) -> vec2<real> {
    if column == 0u {
        return vec2<real>(real(1.0), real(0.0));
    }
    // the derivative of a cosine is minus the sine, that of a sine the cosine
    let sine = column % 2u == 0u;
    let other = basis(select(column + 1u, column - 1u, sine), i);
    return vec2<real>(basis(column, i), real(order_of(column)) * STEP * select(-other, other, sine));
}

fn enter(interval: u32, state: u32) {
    if entered != interval {
        entered = interval;
        spend(3u * HARMONICS * TERMS);
        for (var c = 0u; c < 3u; c++) {
            polynomials[c] = taylor(c, interval, state);
        }
    }
}

// Value, slope and curvature of a signal in the interval at hand.
fn signal_jet(c: u32, x: real) -> vec3<real> {
    var jet = vec3<real>(polynomials[c][TERMS - 1u], real(0.0), real(0.0));
    for (var t = TERMS - 1u; t > 0u; t--) {
        jet.z = jet.z * x + jet.y;
        jet.y = jet.y * x + jet.x;
        jet.x = jet.x * x + polynomials[c][t - 1u];
    }
    jet.z += jet.z;
    return jet;
}

// The signals in the interval at hand; without the column.
fn trial_node(share: real) -> Node {
    let first = signal_jet(0u, share);
    let second = signal_jet(1u, share);
    let limit = mu * signal_jet(GAP, share);
    spend(3u * TERMS);
    var node = Node();
    node.interval = entered;
    node.share = share;
    node.event = true;
    node.path = vec2<real>(first.x, second.x);
    node.rate = vec2<real>(first.y, second.y);
    node.bend = vec2<real>(first.z, second.z);
    node.limit = limit.x;
    node.limit_rate = limit.y;
    node.limit_bend = limit.z;
    return node;
}

fn event_node(interval: u32, share: real, state: u32) -> Node {
    enter(interval, state);
    var node = trial_node(share);
    if column_signal != NO_SIGNAL {
        node.wave = wave_at(interval, part_of_step(share));
    }
    return node;
}

fn root_node(k: u32, state: u32) -> Node {
    let root = roots[event_at(k, state)];
    var node = event_node(root.interval, root.share, state);
    node.limit = real(0.0);
    return node;
}

// Share of the interval of `here` at which `next` is.
fn share_of(next: Node, here: Node) -> real {
    return select(next.share, real(1.0), next.interval != here.interval);
}

// Rate at which the slider moves along e, and its change where e turns.
fn sliding(node: Node, e: vec2<real>) -> real {
    return inner(e, node.rate) - node.limit_rate;
}

fn sliding_rate(node: Node, e: vec2<real>, turning: real) -> real {
    return inner(normal_to(e), node.rate) * turning + inner(e, node.bend) - node.limit_bend;
}

// Change with the phase of `node` of a number with these derivatives by the step that ends there.
fn turning_of(node: Node, by: SlipStep) -> real {
    return inner(by.path, node.rate) + inner(by.rate, node.bend) + real(0.5) * by.limit * node.limit_rate + by.length;
}

// Square of the traction over its limit, with its rate and curvature.
fn excess(node: Node) -> vec3<real> {
    let t = node.path - slider;
    let two = real(2.0);
    return vec3<real>(
        inner(t, t) - node.limit * node.limit,
        two * (inner(t, node.rate) - node.limit * node.limit_rate),
        two * (inner(node.rate, node.rate) + inner(t, node.bend) - node.limit_rate * node.limit_rate
            - node.limit * node.limit_bend),
    );
}

fn step_between(here: Node, next: Node) -> SlipStep {
    let length = share_of(next, here) - here.share;
    return SlipStep(next.path - here.path, next.rate, real(0.5) * (here.limit + next.limit), length);
}

// Search of a zero, the twin of aft/signals/roots.rs.
struct Search {
    low: real,
    high: real,
    x: real,
    width: real,
    done: bool,
}

fn search_between(low: real, high: real, guess: real) -> Search {
    let inside = guess > low && guess < high;
    return Search(low, high, select(real(0.5) * (low + high), guess, inside), high - low, false);
}

fn searched(from_search: Search, f: vec3<real>, rising: bool, accepted: real) -> Search {
    var next = from_search;
    if f.x == real(0.0) {
        next.done = true;
        return next;
    }
    if (f.x > real(0.0)) == rising {
        next.high = next.x;
    } else {
        next.low = next.x;
    }
    let newton = f.x / f.y;
    let bend = newton * f.z / f.y;
    let halley = next.x - newton / (real(1.0) - real(0.5) * bend);
    let inside = halley > next.low && halley < next.high;
    let x = select(real(0.5) * (next.low + next.high), halley, inside);
    let step = abs(x - next.x);
    let share = step / next.width;
    next.x = x;
    next.done = (inside && step * (bend * bend + share * share) <= accepted) || step <= RESOLUTION;
    return next;
}

// An event of the slider, if there is one.
struct Found {
    share: real,
    here: bool,
}

const NOTHING: Found = Found(real(0.0), false);

// Where the values and rates at both ends let a function pass zero, as a share.
fn crossing_share(value: vec2<real>, rate: vec2<real>) -> real {
    let line = linear_share(value.x, value.y);
    let rest = real(1.0) - line;
    let share = line * line * (real(1.0) + rest + rest)
        + (value.y - value.x) * line * rest * (rest / rate.x - line / rate.y);
    return select(line, share, share > real(0.0) && share < real(1.0));
}

// Where the rate of a cubic passes zero, as a share.
fn turn_share(rise: real, rate: vec2<real>) -> real {
    let two = real(2.0);
    let sign = select(real(-1.0), real(1.0), rate.x > real(0.0));
    let curvature = real(3.0) * (rate.x + rate.y) - real(6.0) * rise;
    let slope = sign * (rate.x + curvature - rate.y);
    return two * sign * rate.x / (slope + sqrt(slope * slope - two * two * curvature * rate.x));
}

// What is searched for: where the traction of a stick is largest over its limit and where it passes that, the end of slip.
const TOP: u32 = 0u;
const START: u32 = 1u;
const END: u32 = 2u;

// The function whose zero that is, with its slope and curvature.
fn searched_function(what: u32, here: Node, share: real) -> vec3<real> {
    let node = trial_node(share);
    if what == END {
        let step = step_between(here, node);
        let e = after_step(half, slip_map(step)).e;
        let turning = turning_of(node, angle_rates(step, half));
        return vec3<real>(sliding(node, e), sliding_rate(node, e, turning), real(0.0));
    }
    let f = excess(node);
    return select(f, vec3<real>(f.y, f.z, real(0.0)), what == TOP);
}

// Where the slider, which rests from `here` on, begins to slip before `next`, or where its slip ends, whose direction
// would be `after` there.
fn event_between(here: Node, next: Node, after: HalfAngle, state: u32) -> Found {
    let zero = real(0.0);
    let one = real(1.0);
    let width = share_of(next, here) - here.share;
    let start = excess(here);
    let end = excess(next);
    let least = tolerance * (next.limit + next.limit + tolerance);
    let rates = width * vec2<real>(start.y, end.y);
    var what = START;
    var guess = zero;
    if slips {
        what = END;
        let last = sliding(next, after.e);
        if last > zero {
            return NOTHING;
        }
        guess = linear_share(sliding(here, half.e), last);
    } else if end.x > least {
        let held = tolerance * (here.limit + here.limit + tolerance);
        if here.event && start.z < zero {
            // slip ended at `here`, or the contact closed: a double zero, and a cubic beyond it
            let fall = real(-0.5) * start.z * width * width;
            guess = sqrt(fall / (end.x + fall));
        } else if start.x >= -held && start.y < zero {
            // at the limit at the start of the lap: a zero, and a parabola beyond it
            guess = rates.x / (rates.x - end.x);
        } else {
            guess = crossing_share(vec2<real>(start.x, end.x), rates);
        }
    } else if end.y < zero && start.y > zero {
        // inside at both ends, and perhaps not between them
        what = TOP;
        guess = turn_share(end.x - start.x, rates);
        let rest = one - guess;
        let top = rest * rest * (one + guess + guess) * start.x + guess * guess * (one + rest + rest) * end.x
            + guess * rest * (rest * rates.x - guess * rates.y);
        if top <= zero {
            return NOTHING;
        }
    } else {
        return NOTHING;
    }
    enter(here.interval, state);
    var high = here.share + width;
    while true {
        var search = search_between(here.share, high, here.share + width * guess);
        let accepted = select(RESOLUTION / STEP, ROOT_OF_RESOLUTION, what == TOP);
        for (var k = 0u; k < MAX_STEPS && !search.done; k++) {
            search = searched(search, searched_function(what, here, search.x), what == START, accepted);
        }
        if what != TOP {
            return Found(search.x, true);
        }
        let highest = excess(trial_node(search.x)).x;
        if highest <= least {
            return NOTHING;
        }
        what = START;
        high = search.x;
        guess *= linear_share(start.x, highest);
    }
    return NOTHING;
}

// An event of the slider at `node`, found just now.
fn add_event(node: Node, state: u32) {
    if n_events == MAX_EVENTS {
        overflows = true;
        return;
    }
    if stores {
        events[event_at(n_events, state)] = Event(node.interval, node.share, ZERO);
    }
    n_events++;
}

// Derivatives of the tractions at sample i, less those of the stuck contact.
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

// What the stuck contact would add to `rate` at sample i.
fn stuck_rate(i: u32) -> vec2<real> {
    if column_signal >= GAP {
        return ZERO;
    }
    return basis(column, i) * axis(column_signal);
}

// Traction of a sample in contact.
fn keep(i: u32, node: Node, state: u32) {
    if slips {
        if stores {
            store_traction(i, state, node.limit * half.e);
        }
        if sums_up {
            let by_limit = mixed(node, of_limit(real(1.0), real(0.0))).z;
            add_sample(i, node.limit * angle.z * normal_to(half.e) + by_limit * half.e - stuck_rate(i));
        }
    } else {
        if stores {
            store_traction(i, state, node.path - slider);
        }
        add_sample(i, -vec2<real>(slider_rows[0].z, slider_rows[1].z));
    }
}

// Factor of a jump of the slope in what a sum over the samples misses of it.
fn kink_weight(x: real) -> real {
    return real(0.5) * (x * x - x + real(1.0) / real(6.0));
}

// The slope of the tractions jumps at an event, whose phase moves as `instant`.
fn kink(node: Node, jump: vec2<real>, by_first: Row, by_second: Row) {
    if !sums_up {
        return;
    }
    let x = node.share;
    let factor = kink_weight(x);
    let slope = x - real(0.5);
    let value = factor * vec2<real>(by_first.z, by_second.z) + slope * instant.z * jump;
    let rate = factor * instant.z * jump;
    let part = part_of_step(x);
    sums[0] += value;
    var power = Turn(real(1.0), real(0.0));
    var k = 0u;
    for (var h = 0u; h < HARMONICS; h++) {
        while k < orders[h] {
            power = times(power, part);
            k++;
        }
        let here = turned(k, node.interval, power);
        let turned_rate = real(k) * STEP * rate;
        sums[2u * h + 1u] += here.cosine * value - here.sine * turned_rate;
        sums[2u * h + 2u] += here.sine * value + here.cosine * turned_rate;
    }
}

// Angle and its row of a slider that rested at a fixed phase, for the traction `t`.
fn turn_towards(node: Node, t: vec2<real>) {
    let size = norm(t);
    let e = t / size;
    let factors = normal_to(e) / size;
    half = half_angle(e);
    angle = mixed(node, Mix(factors, ZERO, real(0.0), real(0.0))) - factors.x * slider_rows[0] - factors.y * slider_rows[1];
    instant = NO_ROW;
}

// The slider at `node`, and its rows, where slip ends.
fn stop_slider(node: Node) {
    let e = half.e;
    let p = normal_to(e);
    for (var d = 0u; d < 2u; d++) {
        let moved = node.rate[d] - e[d] * node.limit_rate;
        let turned = node.limit * p[d];
        slider_rows[d] = moved * instant - turned * angle + mixed(node, Mix(axis(d), ZERO, -e[d], real(0.0)));
    }
    slider = node.path - node.limit * e;
}

fn note_way(to_place: vec2<real>) {
    way = max(way, norm(to_place - slip_from));
}

// Motion of a contact that is closed at the start of the lap.
fn resume(node: Node, state: u32) {
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
    keep(0u, node, state);
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
        + mixed(node, Mix(-inverse * e, ZERO, inverse, real(0.0)));
    angle += inner(p, node.rate) / norm(node.path - slider) * instant;
    let speed_row = sliding_row(node, e) + (inner(e, node.bend) - node.limit_bend) * instant;
    let jump = -speed * e;
    if stores && !overflows {
        events[event_at(n_events - 1u, state)].jump = jump;
    }
    kink(node, jump, -(e.x * speed_row + speed * p.x * angle), -(e.y * speed_row + speed * p.y * angle));
}

// Row of the rate of the slider at a fixed phase.
fn sliding_row(node: Node, e: vec2<real>) -> Row {
    return inner(normal_to(e), node.rate) * angle + mixed(node, Mix(ZERO, e, real(0.0), real(-1.0)));
}

// Row of the angle after a step of slip; returns the change of the angle with the phase of the end, if that is an event.
fn slide(here: Node, next: Node, after: HalfAngle, step: SlipStep, map: vec4<real>) -> real {
    angle *= angle_rate(half, map, after);
    if column_signal == NO_SIGNAL && !here.event && !next.event {
        return real(0.0);
    }
    let by = angle_rates(step, half);
    let limit = real(0.5) * by.limit;
    angle += mixed(here, Mix(-by.path, ZERO, limit, real(0.0)));
    if here.event {
        angle += (limit * here.limit_rate - inner(by.path, here.rate) - by.length) * instant;
    }
    angle += mixed(next, Mix(by.path, by.rate, limit, real(0.0)));
    return turning_of(next, by);
}

// Slip ends at `node`; `turning` is the rate of its angle.
fn end_slip(node: Node, turning: real) {
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
}

// Row of the phase of a root of the gap function.
fn instant_of_root(node: Node) -> Row {
    if node.limit_rate == real(0.0) {
        return NO_ROW;
    }
    return mixed(node, of_limit(real(-1.0) / node.limit_rate, real(0.0)));
}

// Kink at a root of the gap function in slip: the rate of the limit comes, or with the sign -1 goes.
fn limit_kink(k: u32, node: Node, sign: real, state: u32) {
    let e = half.e;
    let p = normal_to(e);
    let jump = sign * node.limit_rate * e;
    if stores {
        roots[event_at(k, state)].jump = jump;
    }
    let by_limit = sign * (node.limit_bend * instant + mixed(node, of_limit(real(0.0), real(1.0))));
    let turned = sign * node.limit_rate * angle;
    kink(node, jump, e.x * by_limit + p.x * turned, e.y * by_limit + p.y * turned);
}

// The contact closes at root k: the slider stood where the surface is, at rest or already sliding.
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
        angle = inner(p, node.bend) / speed * instant + mixed(node, Mix(ZERO, p / speed, real(0.0), real(0.0)));
        limit_kink(k, node, real(1.0), state);
        return node;
    }
    var bends = array<Row, 2>();
    for (var d = 0u; d < 2u; d++) {
        slider_rows[d] = node.rate[d] * instant + mixed(node, of_path(d));
        bends[d] = node.bend[d] * instant + mixed(node, of_rate(d));
    }
    if stores {
        roots[event_at(k, state)].jump = node.rate;
    }
    kink(node, node.rate, bends[0], bends[1]);
    return node;
}

// The contact, which slips, opens at root k; `turning` is the rate of its angle.
fn open_contact(k: u32, node: Node, turning: real, state: u32) {
    note_way(node.path);
    instant = instant_of_root(node);
    angle += turning * instant;
    limit_kink(k, node, real(-1.0), state);
}

// A contact closed from `from_node` to root k, or to the end of the lap where there is none.
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

// An event of the slider; `turning` is the rate of the direction that slips until then.
fn pass_event(node: Node, turning: real, state: u32) {
    if slips {
        end_slip(node, turning);
    } else {
        start_slip(node, state);
    }
}

// The contact opens at root k. Without slip, to rounding, there is no kink.
fn pass_end(k: u32, node: Node, turning: real, state: u32) {
    if slips {
        open_contact(k, node, turning, state);
    } else if stores {
        roots[event_at(k, state)].jump = ZERO;
    }
}

// First sample at or after a root, the end of the lap where there is none.
fn sample_from(k: u32, n_roots: u32, state: u32) -> u32 {
    if k >= n_roots {
        return N_TIME;
    }
    let root = roots[event_at(k, state)];
    return root.interval + select(1u, 0u, root.share == real(0.0));
}

fn start_lap(start: vec2<real>) {
    slider = start;
    slider_rows[0] = Row(real(1.0), real(0.0), real(0.0));
    slider_rows[1] = Row(real(0.0), real(1.0), real(0.0));
}

// Begins a lap from `slider` and its rows.
fn begin_lap(state: u32) -> Node {
    n_events = 0u;
    moves = false;
    slips = false;
    way = real(0.0);
    spend(2u * N_TIME);
    let here = sample_node(0u, state);
    open = sample_of(GAP, 0u, state) <= real(0.0);
    if !open {
        resume(here, state);
    }
    return here;
}

// The open contact up to root k, where it closes, or to the end of the lap.
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

// The slider and its rows at the end of a lap; `open` tells of the stretch after it.
fn end_lap(state: u32) {
    let last = sample_node(N_TIME, state);
    if !open {
        slider = last.path;
        slider_rows[0] = mixed(last, of_path(0u));
        slider_rows[1] = mixed(last, of_path(1u));
    } else if slips {
        instant = NO_ROW;
        stop_slider(last);
        note_way(slider);
    }
}

// Walks one lap.
fn walk(state: u32) {
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

fn lap_from(start: vec2<real>, first: bool, state: u32) -> Lap {
    stores = true;
    start_lap(start);
    walk(state);
    let monodromy = vec4<real>(slider_rows[0].xy, slider_rows[1].xy);
    // roots may be missing where their room is full; without friction the slider is where the surface is, always
    let leaves = overflows || counts[state] == MAX_ROOTS || mu == real(0.0);
    return Lap(slider, monodromy, moves, way * ROOT_OF_RESOLUTION <= tolerance, leaves);
}

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
            roots[event_at(n_roots, state)] = Event(i, found[k], ZERO);
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

// Adds antiderivatives at the end of a stretch of the open contact, or with the sign -1 at its start.
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
