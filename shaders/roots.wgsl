// Search of a zero between two samples, the twin of aft/signals/roots.rs.

// A search in progress: the bracket, the present trial and the width of the bracket at the start.
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

// The search after a trial at which the function has the value, slope and curvature `f`.
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

// Where a function with these values and rates at both ends passes zero, as a share of the interval.
fn crossing_share(value: vec2<real>, rate: vec2<real>) -> real {
    let line = linear_share(value.x, value.y);
    let rest = real(1.0) - line;
    let share = line * line * (real(1.0) + rest + rest)
        + (value.y - value.x) * line * rest * (rest / rate.x - line / rate.y);
    return select(line, share, share > real(0.0) && share < real(1.0));
}

// Where the rate of a cubic passes zero, as a share of the interval.
fn turn_share(rise: real, rate: vec2<real>) -> real {
    let two = real(2.0);
    let sign = select(real(-1.0), real(1.0), rate.x > real(0.0));
    let curvature = real(3.0) * (rate.x + rate.y) - real(6.0) * rise;
    let slope = sign * (rate.x + curvature - rate.y);
    return two * sign * rate.x / (slope + sqrt(slope * slope - two * two * curvature * rate.x));
}
