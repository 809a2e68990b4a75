// Box law with located events, the twin of aft/breakpoints.rs and aft/located.rs: one thread per state and direction.
//
// A slider is a play: it stays unless one of its bounds, s - mu N and s + mu N, pushes it. Between two breakpoints
// (roots of the gap function, turning points of a bound) a bound can push at the end only. Within an interval between
// samples a signal is its Taylor polynomial, which is exact to rounding.

alias Polynomial = array<real, TERMS>;

const CROSSING: u32 = 1u;
const DIP: u32 = 2u;
// Shifted by the side.
const TURN: u32 = 4u;
const TURN_PAIR: u32 = 16u;

const MAX_STEPS: u32 = 30u;
const MAX_FOUND: u32 = 8u;

// Breakpoints found in the interval at hand.
var<private> found: array<real, MAX_FOUND>;
var<private> crosses: array<bool, MAX_FOUND>;
var<private> n_found: u32;
// Taylor polynomials of the direction's signal and of the gap function there.
var<private> stick: Polynomial;
var<private> gap: Polynomial;
var<private> n_points: u32;
var<private> n_runs: u32;
var<private> overflow: bool;

fn sampled_rate(c: u32, i: u32, state: u32) -> real {
    return sample_of(3u + c, i, state);
}

// Factor on the gap function in a bound: side 0 is the lower one.
fn friction(mu: real, side: u32) -> real {
    return select(-mu, mu, side == 1u);
}

// Taylor polynomial of a signal after sample i, by the share of the interval.
fn taylor(c: u32, i: u32, state: u32) -> Polynomial {
    var p = Polynomial();
    if c == GAP {
        p[0] = states[batch.n_states + state];
    }
    for (var h = 0u; h < HARMONICS; h++) {
        let k = orders[h];
        let phase = (k * i) % N_TIME;
        let cosine = circle[phase];
        let sine = circle[N_TIME + phase];
        let a = coefficient(c, h, 0u, state);
        let b = coefficient(c, h, 1u, state);
        let even = a * cosine + b * sine;
        let odd = b * cosine - a * sine;
        let reach = real(k) * STEP;
        var power = real(1.0);
        for (var t = 0u; t < TERMS; t++) {
            let term = power * select(even, odd, t % 2u == 1u);
            p[t] += select(term, -term, t % 4u >= 2u);
            power *= reach / real(t + 1u);
        }
    }
    return p;
}

fn bound(mu: real, side: u32) -> Polynomial {
    let factor = friction(mu, side);
    var p = stick;
    for (var t = 0u; t < TERMS; t++) {
        p[t] += factor * gap[t];
    }
    return p;
}

fn differentiated(q: Polynomial) -> Polynomial {
    var p = q;
    for (var t = 1u; t < TERMS; t++) {
        p[t - 1u] = real(t) * p[t];
    }
    p[TERMS - 1u] = real(0.0);
    return p;
}

fn value(q: Polynomial, x: real) -> real {
    var p = q;
    var sum = p[TERMS - 1u];
    for (var t = TERMS - 1u; t > 0u; t--) {
        sum = sum * x + p[t - 1u];
    }
    return sum;
}

// Where q passes `level` between two shares: Newton's method, bisection where it leaves the bracket.
fn root(q: Polynomial, level: real, from_share: real, to_share: real, rising: bool, guess: real) -> real {
    let slope = differentiated(q);
    var low = from_share;
    var high = to_share;
    var x = clamp(guess, low, high);
    for (var step = 0u; step < MAX_STEPS; step++) {
        let error = value(q, x) - level;
        if (error > real(0.0)) == rising {
            high = x;
        } else {
            low = x;
        }
        var next = x - error / value(slope, x);
        if !(next > low && next < high) {
            next = real(0.5) * (low + high);
        }
        let moved = abs(next - x);
        x = next;
        if moved <= RESOLUTION {
            break;
        }
    }
    return x;
}

fn linear_share(before: real, after: real) -> real {
    return before / (before - after);
}

// Marks of the interval after sample i: what may happen inside it.
fn marks(i: u32, d: u32, mu: real, state: u32) -> u32 {
    let next = select(i + 1u, 0u, i + 1u == N_TIME);
    let g = array<real, 2>(sample_of(GAP, i, state), sample_of(GAP, next, state));
    let g_rate = array<real, 2>(sampled_rate(GAP, i, state), sampled_rate(GAP, next, state));
    let s = array<real, 2>(sample_of(d, i, state), sample_of(d, next, state));
    let s_rate = array<real, 2>(sampled_rate(d, i, state), sampled_rate(d, next, state));
    var mark = 0u;
    let zero = real(0.0);
    if (g[0] > zero) != (g[1] > zero) {
        mark |= CROSSING;
    } else if g[0] * g_rate[0] < zero && g[1] * g_rate[1] > zero {
        mark |= DIP;
    }
    if g[0] <= zero && g[1] <= zero && mark == 0u {
        return 0u;
    }
    for (var side = 0u; side < 2u; side++) {
        let factor = friction(mu, side);
        let rise = s[1] - s[0] + factor * (g[1] - g[0]);
        let first = s_rate[0] + factor * g_rate[0];
        let last = s_rate[1] + factor * g_rate[1];
        if (first > zero) != (last > zero) {
            mark |= TURN << side;
        } else {
            // the rate of the cubic through values and rates has two roots
            let excess = real(2.0) * (first + last) - real(6.0) * rise;
            let product = first * last;
            if product > zero && excess * first > zero && excess * excess > real(4.0) * product {
                mark |= TURN_PAIR << side;
            }
        }
    }
    return mark;
}

fn note(share: real, crossing: bool) {
    found[n_found] = share;
    crosses[n_found] = crossing;
    n_found++;
}

// Roots of p in the interval: one where its sign changes, else two where it turns in between.
fn note_roots(p: Polynomial, pair: bool, crossing: bool) {
    let zero = real(0.0);
    let one = real(1.0);
    var ends = array<real, 3>(zero, one, one);
    var n = 1u;
    if pair {
        let bend = differentiated(p);
        let bends_up = value(bend, one) > zero;
        if (value(bend, zero) > zero) == bends_up {
            return;
        }
        let top = root(bend, zero, zero, one, bends_up, real(0.5));
        if (value(p, top) > zero) == (value(p, zero) > zero) {
            return;
        }
        ends[1] = top;
        n = 2u;
    }
    for (var k = 0u; k < n; k++) {
        let first = value(p, ends[k]);
        let last = value(p, ends[k + 1u]);
        let guess = ends[k] + (ends[k + 1u] - ends[k]) * linear_share(first, last);
        // not by the sign of `last`: at a sample that is zero to rounding it may differ from that of the mark
        note(root(p, zero, ends[k], ends[k + 1u], last > first, guess), crossing);
    }
}

// Crossings of the gap function, then turns of both bounds, which its crossings decide on.
fn note_interval(mark: u32, i: u32, mu: real) {
    let zero = real(0.0);
    for (var what = 0u; what < 3u; what++) {
        let side = what - min(what, 1u);
        let single = select(TURN << side, CROSSING, what == 0u);
        let pair = select(TURN_PAIR << side, DIP, what == 0u);
        if (mark & (single | pair)) == 0u {
            continue;
        }
        var p = gap;
        if what > 0u {
            p = differentiated(bound(mu, side));
            let touches = n_found > 0u || i == 0u;
            if value(gap, zero) <= zero && value(gap, real(1.0)) <= zero && n_found == 0u {
                return;
            }
            let away = (value(p, real(1.0)) > zero) == (side == 1u);
            if (mark & single) != 0u && !away && !touches {
                // the bound turns towards the slider and is not at it: the sample before will do
                note(zero, false);
                continue;
            }
        }
        note_roots(p, (mark & pair) != 0u, what == 0u);
    }
}

fn point_at(k: u32, d: u32, state: u32) -> u32 {
    return (k * 2u + d) * batch.n_states + state;
}

fn add_point(point: Point, d: u32, state: u32) {
    if n_points == MAX_POINTS {
        overflow = true;
        return;
    }
    points[point_at(n_points, d, state)] = point;
    n_points++;
}

// Breakpoints of the interval after sample i, in order; returns whether the contact is open after them.
fn add_interval(i: u32, mark: u32, d: u32, mu: real, was_open: bool, state: u32) -> bool {
    n_found = 0u;
    stick = taylor(d, i, state);
    gap = taylor(GAP, i, state);
    note_interval(mark, i, mu);
    var open = was_open;
    for (var k = 0u; k < n_found; k++) {
        var least = k;
        for (var j = k + 1u; j < n_found; j++) {
            if found[j] < found[least] {
                least = j;
            }
        }
        let share = found[least];
        let crossing = crosses[least];
        found[least] = found[k];
        crosses[least] = crosses[k];
        open = open != crossing;
        let here = select(value(gap, share), real(0.0), crossing);
        add_point(Point(i, select(0u, 1u, open), share, value(stick, share), here), d, state);
    }
    return open;
}

// Breakpoints of the period, ascending from phase 0, which is always one.
fn add_points(d: u32, mu: real, state: u32) {
    n_points = 0u;
    let first_gap = sample_of(GAP, 0u, state);
    var open = first_gap <= real(0.0);
    let first = Point(0u, select(0u, 1u, open), real(0.0), sample_of(d, 0u, state), first_gap);
    add_point(first, d, state);
    for (var i = 0u; i < N_TIME; i++) {
        let mark = marks(i, d, mu, state);
        if mark != 0u {
            open = add_interval(i, mark, d, mu, open, state);
        }
    }
}

struct Slider {
    place: real,
    motion: u32,
}

// The slider after a monotone stretch that ends at the point, and what it did there.
fn pushed(before: real, to_point: Point, mu: real, open: bool) -> Slider {
    let limit = mu * max(to_point.gap, real(0.0));
    if open {
        return Slider(to_point.stick, SEPARATED);
    }
    if to_point.stick - limit > before {
        return Slider(to_point.stick - limit, SLIP_UP);
    }
    if to_point.stick + limit < before {
        return Slider(to_point.stick + limit, SLIP_DOWN);
    }
    return Slider(before, STICK);
}

// Lengthens the last run, or adds a new one.
fn append(run: Run, d: u32, state: u32) {
    if n_runs > 0u {
        let last = point_at(n_runs - 1u, d, state);
        if runs[last].motion == run.motion {
            runs[last].interval = run.interval;
            runs[last].share = run.share;
            return;
        }
    }
    if n_runs == MAX_RUNS {
        overflow = true;
        return;
    }
    runs[point_at(n_runs, d, state)] = run;
    n_runs++;
}

// Instant at which a bound that is monotone between two breakpoints reaches `level`.
fn reaches(a: Point, b: Point, d: u32, mu: real, side: u32, level: real, state: u32) -> Point {
    let factor = friction(mu, side);
    let zero = real(0.0);
    let before = a.stick + factor * max(a.gap, zero);
    let after = b.stick + factor * max(b.gap, zero);
    let rising = after > before;
    var values = array<real, 2>(before, after);
    var low = a.interval + select(0u, 1u, a.share > zero);
    var high = b.interval + select(0u, 1u, b.share > zero);
    var shares = array<real, 2>(a.share, b.share);
    var ends = array<u32, 2>(a.interval, b.interval);
    while low < high {
        let middle = (low + high) / 2u;
        let here = sample_of(d, middle % N_TIME, state) + factor * sample_of(GAP, middle % N_TIME, state);
        if (here > level) == rising {
            high = middle;
            ends[1] = middle;
            shares[1] = zero;
            values[1] = here;
        } else {
            low = middle + 1u;
            ends[0] = middle;
            shares[0] = zero;
            values[0] = here;
        }
    }
    let i = max(low, a.interval + 1u) - 1u;
    let from_share = select(zero, shares[0], ends[0] == i);
    let to_share = select(real(1.0), shares[1], ends[1] == i);
    stick = taylor(d, i, state);
    gap = taylor(GAP, i, state);
    let guess = from_share + (to_share - from_share) * linear_share(values[0] - level, values[1] - level);
    let share = root(bound(mu, side), level, from_share, to_share, rising, guess);
    return Point(i, 0u, share, zero, zero);
}

// Plays the slider from its anchor; `runs` are then the stretches of the last lap. Returns whether it ever moved.
fn play(d: u32, mu: real, state: u32) -> bool {
    let anchor = states[(2u + d) * batch.n_states + state];
    let first = points[point_at(0u, d, state)];
    var slider = pushed(anchor, first, mu, first.open != 0u);
    var source = Point();
    var source_motion = STICK;
    var moved = false;
    for (var lap = 1u; lap <= LAPS; lap++) {
        n_runs = 0u;
        var a = first;
        for (var k = 0u; k < n_points; k++) {
            if slider.motion != STICK {
                source = a;
                source_motion = slider.motion;
                moved = true;
            }
            var b = first;
            b.interval = N_TIME;
            if k + 1u < n_points {
                b = points[point_at(k + 1u, d, state)];
            }
            let before = slider.place;
            slider = pushed(before, b, mu, a.open != 0u);
            var run = Run(b.interval, STICK, b.share, before, source_motion, source.interval, source.share);
            if lap == LAPS && (slider.motion == SLIP_UP || slider.motion == SLIP_DOWN) {
                let side = select(1u, 0u, slider.motion == SLIP_UP);
                let start = a.stick + friction(mu, side) * max(a.gap, real(0.0));
                if start != before {
                    let reached = reaches(a, b, d, mu, side, before, state);
                    var wait = run;
                    wait.interval = reached.interval;
                    wait.share = reached.share;
                    append(wait, d, state);
                }
            }
            if lap == LAPS || !moved {
                run.motion = slider.motion;
                append(run, d, state);
            }
            a = b;
        }
        if !moved && slider.motion == STICK {
            break;
        }
    }
    return moved || slider.motion != STICK;
}

@compute @workgroup_size(GROUP)
fn box_march(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = batch.n_states;
    let state = id.x;
    let d = id.y;
    if state >= n {
        return;
    }
    let mu = states[state];
    overflow = false;
    add_points(d, mu, state);
    let moved = play(d, mu, state);
    counts[d * n + state] = n_runs;
    if moved || overflow {
        let flag = select(MOVED, MOVED | OVERFLOW, overflow);
        if atomicOr(&flags[state], flag) == 0u {
            let slot = atomicAdd(&n_moving, 1u);
            slots[state] = slot;
            moving[slot] = state;
        }
    }
}
