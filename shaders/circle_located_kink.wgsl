// Jumps of the slope of the tractions at events, the twin of aft/circle_law/kink.rs, where the formula is explained.

// Factor of a jump of the slope in the error of a sum over the samples.
fn kink_weight(x: real) -> real {
    return real(0.5) * (x * x - x + real(1.0) / real(6.0));
}

// The slope of the tractions jumps at `node`, and `instant` is the row of its phase; the other rows are those of the jump.
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
