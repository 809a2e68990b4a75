// Signals between two samples as Taylor polynomials by the share of the interval, exact to rounding, and their roots.

alias Polynomial = array<real, TERMS>;

// Marks of an interval: the gap function changes its sign, or dips towards zero and back.
const CROSSING: u32 = 1u;
const DIP: u32 = 2u;

const MAX_STEPS: u32 = 30u;
const MAX_FOUND: u32 = 8u;

// Roots found in the interval at hand.
var<private> found: array<real, MAX_FOUND>;
var<private> n_found: u32;

fn sampled_rate(c: u32, i: u32, state: u32) -> real {
    return sample_of(3u + c, i, state);
}

// By the gap function and its rate at both ends of an interval.
fn gap_mark(value: array<real, 2>, rate: array<real, 2>) -> u32 {
    let zero = real(0.0);
    if (value[0] > zero) != (value[1] > zero) {
        return CROSSING;
    }
    return select(0u, DIP, value[0] * rate[0] < zero && value[1] * rate[1] > zero);
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

// Roots of p in the interval: one where its sign changes, else two where it turns in between.
fn find_roots(p: Polynomial, pair: bool) {
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
        found[n_found] = root(p, zero, ends[k], ends[k + 1u], last > first, guess);
        n_found++;
    }
}
