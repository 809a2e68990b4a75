// Box law with located events, the twin of aft/signals/breakpoints.rs and aft/box_law/play.rs: one thread per state and direction.
//
// A slider is a play: it stays unless one of its bounds, s - mu N and s + mu N, pushes it. Between two breakpoints
// (roots of the gap function, turning points of a bound) a bound can push at the end only. Within an interval between
// samples a signal is its Taylor polynomial, which is exact to rounding.

const SIGNAL_ROWS: u32 = 6u;

const STICK: u32 = 0u;
const SLIP_UP: u32 = 1u;
const SLIP_DOWN: u32 = 2u;
const SEPARATED: u32 = 3u;

// Masks of the spectra, the first three per direction.
const MASK_MOVED: u32 = 0u;
const MASK_SLIP: u32 = 2u;
const MASK_SLIDER: u32 = 4u;
const MASKS: u32 = 7u;

// Instant at which a motion may change: share of the interval after a sample, signals there, whether the contact is
// open afterwards.
struct Point {
    interval: u32,
    open: u32,
    share: real,
    stick: real,
    gap: real,
}

// Stretch of one motion up to an instant. `slider` is k_t w of a stick; `source_...` says where, and by which motion, it was set last.
struct Run {
    interval: u32,
    motion: u32,
    share: real,
    slider: real,
    source_motion: u32,
    source_interval: u32,
    source_share: real,
}

// Shape: [MAX_POINTS][2][state]
@group(0) @binding(6) var<storage, read_write> points: array<Point>;
// Shape: [MAX_RUNS][2][state]
@group(0) @binding(7) var<storage, read_write> runs: array<Run>;
// Runs, and sticks with a source. Shape: [2][2][state]
@group(0) @binding(8) var<storage, read_write> counts: array<u32>;

const POINTS_PER_STATE: u32 = 2u * MAX_POINTS;
const RUNS_PER_STATE: u32 = 2u * MAX_RUNS;
const COUNTS_PER_STATE: u32 = 4u;

// The rate of a bound changes sign, or may do so twice. Shifted by the side.
const TURN: u32 = 4u;
const TURN_PAIR: u32 = 16u;

// Which of the roots found in the interval at hand are those of the gap function.
var<private> crosses: array<bool, MAX_FOUND>;
// Taylor polynomials of the direction's signal and of the gap function there.
var<private> stick: Polynomial;
var<private> gap: Polynomial;
var<private> n_points: u32;
var<private> n_runs: u32;
var<private> overflow: bool;

// Factor on the gap function in a bound: side 0 is the lower one.
fn friction(mu: real, side: u32) -> real {
    return select(-mu, mu, side == 1u);
}

fn bound(mu: real, side: u32) -> Polynomial {
    let factor = friction(mu, side);
    var p = stick;
    for (var t = 0u; t < TERMS; t++) {
        p[t] += factor * gap[t];
    }
    return p;
}

// Marks of the interval after sample i: what may happen inside it.
fn marks(i: u32, d: u32, mu: real, state: u32) -> u32 {
    let next = select(i + 1u, 0u, i + 1u == N_TIME);
    let g = array<real, 2>(sample_of(GAP, i, state), sample_of(GAP, next, state));
    let g_rate = array<real, 2>(sampled_rate(GAP, i, state), sampled_rate(GAP, next, state));
    var mark = gap_mark(g, g_rate);
    let s = array<real, 2>(sample_of(d, i, state), sample_of(d, next, state));
    let s_rate = array<real, 2>(sampled_rate(d, i, state), sampled_rate(d, next, state));
    let zero = real(0.0);
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
                crosses[n_found] = false;
                found[n_found] = zero;
                n_found++;
                continue;
            }
        }
        let before = n_found;
        find_roots(p, (mark & pair) != 0u);
        for (var k = before; k < n_found; k++) {
            crosses[k] = what == 0u;
        }
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
