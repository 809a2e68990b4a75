// Derivatives along a lap of the circle law with located events, the twin of aft/circle_law/sensitivity.rs: a row holds the derivatives
// of one number by the two start tractions of the slider and by one coefficient of one signal, which is the thread's column.

// Derivatives of one number: by the two start tractions, by the column's coefficient.
alias Row = vec3<real>;

const NO_ROW: Row = Row(real(0.0), real(0.0), real(0.0));

// Factors of the signals at one phase in a number that is a sum of them.
struct SignalWeights {
    path: vec2<real>,
    rate: vec2<real>,
    limit: real,
    limit_rate: real,
}

// Row of the sum of the second derivatives of the signals at an event: of the elastic tractions with the factors `path`, and of the
// limit.
fn row_of_bends(node: Node, path: vec2<real>, limit: real) -> Row {
    var factor = real(0.0);
    if column_signal < GAP {
        factor = path[column_signal];
    } else if column_signal == GAP {
        factor = mu * limit;
    }
    let rate = real(order_of(column)) * STEP;
    return Row(real(0.0), real(0.0), -(rate * rate * factor * node.wave.x));
}

// Signal and coefficient of the column; the search for the steady cycle has none.
const NO_SIGNAL: u32 = 3u;
var<private> column_signal: u32 = NO_SIGNAL;
var<private> column: u32;

// Row of the sum of the signals at `node` with these factors.
fn row_of(node: Node, weights: SignalWeights) -> Row {
    var factors = vec2<real>(real(0.0), real(0.0));
    if column_signal < GAP {
        factors = vec2<real>(weights.path[column_signal], weights.rate[column_signal]);
    } else if column_signal == GAP {
        factors = mu * vec2<real>(weights.limit, weights.limit_rate);
    }
    return Row(real(0.0), real(0.0), inner(factors, node.wave));
}

// The elastic traction of direction d alone, then its rate alone, then the limit and its rate.
fn of_path(d: u32) -> SignalWeights {
    return SignalWeights(axis(d), ZERO, real(0.0), real(0.0));
}

fn of_rate(d: u32) -> SignalWeights {
    return SignalWeights(ZERO, axis(d), real(0.0), real(0.0));
}

fn of_limit(limit: real, limit_rate: real) -> SignalWeights {
    return SignalWeights(ZERO, ZERO, limit, limit_rate);
}

fn axis(d: u32) -> vec2<real> {
    return select(vec2<real>(real(0.0), real(1.0)), vec2<real>(real(1.0), real(0.0)), d == 0u);
}

// Basis function of the column, and its rate, at the part `part` of an interval after sample i.
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

// The same at sample i.
fn wave_of_sample(i: u32) -> vec2<real> {
    if column == 0u {
        return vec2<real>(real(1.0), real(0.0));
    }
    // the derivative of a cosine is minus the sine, that of a sine the cosine
    let sine = column % 2u == 0u;
    let other = basis(select(column + 1u, column - 1u, sine), i);
    return vec2<real>(basis(column, i), real(order_of(column)) * STEP * select(-other, other, sine));
}
