// Jumps of the derivatives of the tractions at events, the twin of aft/circle_law/kink.rs, where the formula is explained.

// What a sum over the samples lacks at the share x of an interval, per jump of the first and, negative, of the second derivative; before
// them the derivative of the first.
fn kink_weights(x: real) -> vec3<real> {
    let half = real(0.5);
    let one = real(1.0);
    return vec3<real>(x - half, half * (x * x - x + one / real(6.0)), x * (x - half) * (x - one) / real(6.0));
}

// The first two derivatives of the tractions jump by `jump` and `bend` at `node`, and `instant` is the row of its phase; `jump_rows`
// are the rows of `jump`, `bend_rows` those of `bend`.
fn kink(node: Node, jump: vec2<real>, bend: vec2<real>, jump_rows: array<Row, 2>, bend_rows: array<Row, 2>) {
    if !sums_up {
        return;
    }
    let x = node.share;
    let factors = kink_weights(x);
    let twice = factors.z + factors.z;
    let by_jump = vec2<real>(jump_rows[0].z, jump_rows[1].z);
    let by_bend = vec2<real>(bend_rows[0].z, bend_rows[1].z);
    // What the basis function and its first two derivatives are multiplied with.
    let value = factors.y * by_jump - factors.z * by_bend + instant.z * (factors.x * jump - factors.y * bend);
    let rate = -twice * by_jump - instant.z * (factors.y * jump + factors.z * bend);
    let curvature = -(twice * instant.z) * jump;
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
        let step = real(k) * STEP;
        let straight = value - step * step * curvature;
        let turned_rate = step * rate;
        sums[2u * h + 1u] += here.cosine * straight - here.sine * turned_rate;
        sums[2u * h + 2u] += here.sine * straight + here.cosine * turned_rate;
    }
}
