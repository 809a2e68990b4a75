// Slip of the circle law between two instants, the twin of aft/circle_law/slip.rs, where the formulas are explained. Time counts in
// intervals between samples.

// |path| over the mean limit in the longest step.
const LONGEST: real = 1.0e3;
const LEAST_LIMIT: real = 1.2e-38;

// What a step of slip depends on, besides the direction before it; or the derivatives of a number by all that.
struct SlipStep {
    path: vec2<real>,
    rate: vec2<real>,
    limit: real,
    length: real,
}

struct SlipParts {
    distance: real,
    limit: real,
    flexibility: real,
    y: real,
    growth: real,
    scale: real,
    even: real,
    odd: real,
    ahead: vec2<real>,
    cross_product: real,
    inverse_of_squares: real,
    weight: real,
    polynomial: real,
    turn: real,
}

// Direction of the traction: `psi` turns half as fast.
struct HalfAngle {
    psi: vec2<real>,
    e: vec2<real>,
}

fn slip_parts(step: SlipStep) -> SlipParts {
    let zero = real(0.0);
    let one = real(1.0);
    var parts = SlipParts();
    let square = inner(step.path, step.path);
    parts.distance = sqrt(square);
    parts.limit = max(step.limit, parts.distance / LONGEST);
    if parts.limit > LEAST_LIMIT {
        parts.flexibility = one / parts.limit;
    }
    let y = parts.distance * parts.flexibility;
    parts.y = y;
    let cubic = ((y / real(120.0) + one / real(24.0)) * y + one / real(6.0)) * y;
    parts.growth = (cubic + real(0.5)) * y + one;
    let exponential = parts.growth * y + one;
    parts.scale = one / (exponential + exponential);
    parts.even = real(0.5) + parts.scale;
    parts.odd = parts.growth * parts.scale;
    parts.ahead = step.rate * step.length;
    parts.cross_product = step.path.x * parts.ahead.y - step.path.y * parts.ahead.x;
    let squares = square + inner(parts.ahead, parts.ahead) + real(0.5) * RESOLUTION * parts.limit * parts.limit;
    if squares > zero {
        parts.inverse_of_squares = one / squares;
    }
    parts.polynomial = ((y / real(120.0) + one / real(40.0)) * y + one / real(12.0)) * y + one / real(6.0);
    parts.weight = parts.polynomial * y * y * (parts.scale + parts.scale);
    parts.turn = parts.weight * parts.cross_product * parts.inverse_of_squares;
    return parts;
}

// The matrix that psi is multiplied by, row by row.
fn slip_map(step: SlipStep) -> vec4<real> {
    let parts = slip_parts(step);
    let boost = parts.odd * parts.flexibility * step.path;
    let a = vec2<real>(parts.even + boost.x, boost.y);
    let b = vec2<real>(boost.y, parts.even - boost.x);
    let first = a - parts.turn * b;
    let second = b + parts.turn * a;
    return vec4<real>(first.x, first.y, second.x, second.y);
}

// Derivatives of the parts of a step by y.
struct PartRates {
    even: real,
    odd: real,
    weight: real,
}

fn rates_by_y(parts: SlipParts) -> PartRates {
    let one = real(1.0);
    let two = real(2.0);
    let y = parts.y;
    let scale = parts.scale;
    let growth_by_y = ((y / real(30.0) + real(0.125)) * y + one / real(3.0)) * y + real(0.5);
    let exponential_by_y = parts.growth + growth_by_y * y;
    let even_by_y = -two * exponential_by_y * scale * scale;
    let odd_by_y = growth_by_y * scale + parts.growth * even_by_y;
    let polynomial_by_y = (y / real(40.0) + real(0.05)) * y + one / real(12.0);
    let risen = (polynomial_by_y * y + two * parts.polynomial) * y;
    let weight_by_y = two * scale * (risen - parts.weight * exponential_by_y);
    return PartRates(even_by_y, odd_by_y, weight_by_y);
}

// Derivatives of the angle after a step from the direction `before` by what the step depends on.
fn angle_rates(step: SlipStep, before: HalfAngle) -> SlipStep {
    let one = real(1.0);
    let two = real(2.0);
    let parts = slip_parts(step);
    let part_rates = rates_by_y(parts);
    let a = step.path * parts.flexibility;
    let c = before.psi.x;
    let s = before.psi.y;
    let image = vec2<real>(inner(a, before.psi), a.y * c - a.x * s);
    let boosted = parts.even * before.psi + parts.odd * image;
    // angle by which a change of psi after the boost turns it
    let turned = two / inner(boosted, boosted) * normal_to(boosted);

    let by_turn = two / (one + parts.turn * parts.turn);
    let by_share = by_turn * parts.inverse_of_squares;
    let by_cross = by_share * parts.weight;
    let twice = -two * by_cross * parts.cross_product * parts.inverse_of_squares;
    let by_y = part_rates.even * inner(turned, before.psi) + part_rates.odd * inner(turned, image)
        + by_share * part_rates.weight * parts.cross_product;
    let by_a = parts.odd * vec2<real>(inner(turned, vec2<real>(c, -s)), inner(turned, vec2<real>(s, c)));

    var unit = vec2<real>(real(0.0), real(0.0));
    if parts.distance > real(0.0) {
        unit = step.path / parts.distance;
    }
    let ahead = parts.ahead;
    var by = SlipStep();
    by.path = parts.flexibility * (by_a + by_y * unit) - by_cross * normal_to(ahead) + twice * step.path;
    by.limit = twice * real(0.5) * RESOLUTION * parts.limit - parts.flexibility * (by_y * parts.y + inner(by_a, a));
    if parts.limit > step.limit {
        by.path += by.limit / LONGEST * unit;
        by.limit = real(0.0);
    }
    let by_ahead = twice * ahead + by_cross * normal_to(step.path);
    by.rate = by_ahead * step.length;
    by.length = inner(by_ahead, step.rate);
    return by;
}

fn half_angle(e: vec2<real>) -> HalfAngle {
    let one = real(1.0);
    return HalfAngle(select(vec2<real>(e.y, one - e.x), vec2<real>(one + e.x, e.y), e.x > real(0.0)), e);
}

fn after_step(before: HalfAngle, map: vec4<real>) -> HalfAngle {
    let c = map.x * before.psi.x + map.y * before.psi.y;
    let s = map.z * before.psi.x + map.w * before.psi.y;
    let e = vec2<real>(c * c - s * s, real(2.0) * c * s) / (c * c + s * s);
    return HalfAngle(vec2<real>(c, s), e);
}

// Derivative of the angle after a step by that before it.
fn angle_rate(before: HalfAngle, map: vec4<real>, after: HalfAngle) -> real {
    return (map.x * map.w - map.y * map.z) * inner(before.psi, before.psi) / inner(after.psi, after.psi);
}
