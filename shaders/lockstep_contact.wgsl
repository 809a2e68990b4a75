// From a lane's point to its contact states (`scaled`, the twin of gpu/scaled.rs), and back from forces and tangents.

// The point moves along the last correction and tangent; a lane that rests stays where it is.
@compute @workgroup_size(GROUP)
fn moved(@builtin(global_invocation_id) id: vec3<u32>) {
    let lane = id.x;
    let row = id.y;
    let bits = steps[lane];
    if (bits & 0x7fffffffu) > 0x7f800000u {
        return;
    }
    let step = bitcast<f32>(bits);
    if row == N {
        numbers[DETUNING * job.lanes + lane] += step;
        return;
    }
    let correction = numbers[at(SOLUTION, row, lane, 2u * job.lanes)];
    let tangent = numbers[at(SOLUTION, row, lane + job.lanes, 2u * job.lanes)];
    numbers[at(POINT, row, lane, job.lanes)] += correction + step * tangent;
}

// Force of a spring by coefficient j of component c.
fn spring(c: u32, j: u32, pair: u32, lane: u32) -> f32 {
    return constant(c, pair, lane) * numbers[at(POINT, j * ROWS + c * PAIRS + pair, lane, job.lanes)];
}

// The smallest power of two above x, by which a product is not rounded; 1 for 0.
fn power_of_two(x: f32) -> f32 {
    return select(1.0, 2.0 * bitcast<f32>(bitcast<u32>(x) & 0x7f800000u), x > 0.0);
}

// Gap function without its dynamic part, and anchors without the mean displacement (N).
fn offsets(pair: u32, lane: u32) -> vec3<f32> {
    var out = vec3<f32>(constant(4u, pair, lane) + spring(2u, 0u, pair, lane), 0.0, 0.0);
    for (var d = 0u; d < 2u; d++) {
        out[1u + d] = constant(d, pair, lane) * constant(5u + d, pair, lane) - spring(d, 0u, pair, lane);
    }
    return out;
}

// Force (N) that counts as 1 in the contact passes.
fn scale_of(pair: u32, lane: u32) -> f32 {
    let offset = abs(offsets(pair, lane));
    var largest = max(offset.x, max(offset.y, offset.z));
    for (var c = 0u; c < 3u; c++) {
        for (var j = 1u; j < M; j++) {
            largest = max(largest, abs(spring(c, j, pair, lane)));
        }
    }
    return power_of_two(largest);
}

// States of the contact passes.
@compute @workgroup_size(GROUP)
fn scaled(@builtin(global_invocation_id) id: vec3<u32>) {
    let lane = id.x;
    let pair = id.y;
    let n = PAIRS * job.lanes;
    let state = pair * job.lanes + lane;
    let scale = scale_of(pair, lane);
    numbers[at(SCALES, pair, lane, job.lanes)] = scale;
    for (var c = 0u; c < 3u; c++) {
        for (var j = 1u; j < M; j++) {
            coefficients[(c * (M - 1u) + j - 1u) * n + state] = spring(c, j, pair, lane) / scale;
        }
    }
    let offset = offsets(pair, lane) / scale;
    states[state] = constant(3u, pair, lane);
    for (var i = 0u; i < 3u; i++) {
        states[(1u + i) * n + state] = offset[i];
    }
}

// Forces F in the first column, and what they add to the residual: r less its rest, and the force on the reference springs.
@compute @workgroup_size(GROUP)
fn loaded(@builtin(global_invocation_id) id: vec3<u32>) {
    let lane = id.x;
    let pair = id.y / M;
    let j = id.y % M;
    let scale = numbers[at(SCALES, pair, lane, job.lanes)];
    for (var c = 0u; c < 3u; c++) {
        let row = j * ROWS + c * PAIRS + pair;
        let r = numbers[at(POINT, row, lane, job.lanes)];
        var stuck = constant(c, pair, lane) * r;
        if j == 0u {
            stuck = select(0.0, constant(4u, pair, lane) + stuck, c == 2u);
        }
        let force = stuck + scale * deviations[(c * M + j) * PAIRS * job.lanes + pair * job.lanes + lane];
        numbers[at(FORCE, row, lane, 2u * job.lanes)] = force;
        var left = r;
        if j == 0u {
            let i = c * PAIRS + pair;
            left -= own[(REST + i) * job.lanes + lane];
            numbers[at(REST_FORCE, i, lane, 2u * job.lanes)] = force - shared_numbers[REFERENCE_SPRINGS + i] * r;
        }
        numbers[at(PRODUCT, row, lane, 2u * job.lanes)] = left;
    }
}

// w = (dF/dr) x, what x and w add to J x: x itself, and the force on the reference springs. One thread per column, pair and force
// coefficient.
@compute @workgroup_size(GROUP)
fn rate(@builtin(global_invocation_id) id: vec3<u32>) {
    let column = id.x;
    let lane = column % job.lanes;
    let pair = id.y / M;
    let a = id.y % M;
    let state = pair * job.lanes + lane;
    let slot = slots[state];
    let moves = (flags[state] & MOVED) != 0u;
    var sum = vec3<f32>();
    if moves {
        for (var b = 0u; b < M; b++) {
            for (var block = 0u; block < BLOCKS; block++) {
                let component = block_columns[block];
                let row = b * ROWS + component * PAIRS + pair;
                let x = constant(component, pair, lane) * numbers[at(job.x, row, column, job.columns)];
                let entry = tangents[((((slot / GROUP) * BLOCKS + block) * M + a) * M + b) * GROUP + slot % GROUP];
                sum[block_rows[block]] += entry * x;
            }
        }
    }
    for (var c = 0u; c < 3u; c++) {
        let row = a * ROWS + c * PAIRS + pair;
        let x = numbers[at(job.x, row, column, job.columns)];
        // a tangential spring carries no mean, but the tangent of a stuck pair has all its coefficients
        let force = constant(c, pair, lane) * x + sum[c];
        numbers[at(FORCE, row, column, job.columns)] = force;
        numbers[at(PRODUCT, row, column, job.columns)] = x;
        if a == 0u {
            let i = c * PAIRS + pair;
            numbers[at(REST_FORCE, i, column, job.columns)] = force - shared_numbers[REFERENCE_SPRINGS + i] * x;
        }
    }
}
