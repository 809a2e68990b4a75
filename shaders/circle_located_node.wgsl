// The signals of one contact at one phase, the twin of aft/circle_law/node.rs.

// The elastic traction (path), the friction limit and their derivatives by the phase; second (bend) and third ones (jerk) at events
// only.
struct Node {
    interval: u32,
    share: real,
    event: bool,
    path: vec2<real>,
    rate: vec2<real>,
    bend: vec2<real>,
    jerk: vec2<real>,
    limit: real,
    limit_rate: real,
    limit_bend: real,
    limit_jerk: real,
    // Basis function of the column, and its rate.
    wave: vec2<real>,
}

// Sample i; for i = N_TIME it is sample 0, one period later.
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

// Share of the interval of `here` at which `next` is.
fn share_of(next: Node, here: Node) -> real {
    return select(next.share, real(1.0), next.interval != here.interval);
}

// Rate at which the slider moves along e.
fn sliding(node: Node, e: vec2<real>) -> real {
    return inner(e, node.rate) - node.limit_rate;
}

// Derivative of that rate by the phase where e turns at the rate `turning`; at events only.
fn sliding_rate(node: Node, e: vec2<real>, turning: real) -> real {
    return inner(normal_to(e), node.rate) * turning + bending(node, e);
}

// The part of that which does not come from the turn of e.
fn bending(node: Node, e: vec2<real>) -> real {
    return inner(e, node.bend) - node.limit_bend;
}

// Cosine of the angle by which the velocity may turn in a step: half a radian.
const TURN: real = real(0.8776);
// Way in a step, over the friction limit, that is short: there one step of slip resolves the turn.
const SHORT: real = real(0.5);
// Way across the path in a step, over the friction limit, below which the motion counts as straight.
const ACROSS: real = real(1.0e-3);

// Whether the velocity turns by more than half a radian in the interval from sample `here` to sample `next`, the contact moves far, and
// its path is not straight.
fn turns_around(here: Node, next: Node) -> bool {
    let across = abs(here.rate.x * next.rate.y - here.rate.y * next.rate.x);
    let speeds = vec2<real>(norm(here.rate), norm(next.rate));
    let limit = real(0.5) * (here.limit + next.limit);
    let both = speeds.x + speeds.y;
    return inner(here.rate, next.rate) < TURN * speeds.x * speeds.y && both > real(2.0) * SHORT * limit
        && across > ACROSS * limit * both;
}

// A number depends on the step that ends at `node`, with the derivatives `by`; its derivative by the phase of `node`.
fn turning_of(node: Node, by: SlipStep) -> real {
    return inner(by.path, node.rate) + inner(by.rate, node.bend) + real(0.5) * by.limit * node.limit_rate + by.length;
}

// Square of the traction minus the square of its limit, with its first and second derivative.
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

// What a step of slip from `here` to `next` depends on.
fn step_between(here: Node, next: Node) -> SlipStep {
    let length = share_of(next, here) - here.share;
    return SlipStep(next.path - here.path, next.rate, real(0.5) * (here.limit + next.limit), length);
}
