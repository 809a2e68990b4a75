// Conjugate residuals of correction and tangent together, the twin of linalg/recycled.rs: 16 lanes and 4 strands per group.

const STRANDS: u32 = 4u;
const LANES_OF_GROUP: u32 = 16u;
// Share of a product below which its remainder is round-off.
const ROUND_OFF: f32 = 1e-6;

var<workgroup> parts_of_sum: array<f32, 64>;

// Sum over the strands of a lane.
fn total(value: f32, index: u32) -> f32 {
    parts_of_sum[index] = value;
    workgroupBarrier();
    let lane = index % LANES_OF_GROUP;
    var sum = 0.0;
    for (var strand = 0u; strand < STRANDS; strand++) {
        sum += parts_of_sum[strand * LANES_OF_GROUP + lane];
    }
    workgroupBarrier();
    return sum;
}

// Squared length of column `column` of the residual of the linear systems.
fn squared_left(column: u32, index: u32) -> f32 {
    var sum = 0.0;
    for (var i = index / LANES_OF_GROUP; i < N; i += STRANDS) {
        let x = numbers[at(LINEAR, i, column, 2u * job.lanes)];
        sum += x * x;
    }
    return total(sum, index);
}

// The systems begin: the correction is zero, the tangent that of the last point; the residuals are the first directions.
@compute @workgroup_size(GROUP)
fn begun(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let lane = group.x * LANES_OF_GROUP + index % LANES_OF_GROUP;
    let strand = index / LANES_OF_GROUP;
    var largest = 0.0;
    for (var i = strand; i < N; i += STRANDS) {
        largest = max(largest, abs(numbers[at(LINEAR, i, lane, 2u * job.lanes)]));
        numbers[at(SOLUTION, i, lane, 2u * job.lanes)] = 0.0;
        for (var half = 0u; half < 2u; half++) {
            let column = lane + half * job.lanes;
            numbers[at(DIRECTIONS, i, column, 2u * job.lanes)] = numbers[at(LINEAR, i, column, 2u * job.lanes)];
        }
    }
    parts_of_sum[index] = largest;
    workgroupBarrier();
    for (var s = 0u; s < STRANDS; s++) {
        largest = max(largest, parts_of_sum[s * LANES_OF_GROUP + index % LANES_OF_GROUP]);
    }
    workgroupBarrier();
    let right = array<f32, 2>(squared_left(lane, index), squared_left(lane + job.lanes, index));
    if strand == 0u {
        told[SIZE * job.lanes + lane] = largest;
        for (var half = 0u; half < 2u; half++) {
            told[(RIGHT + half) * job.lanes + lane] = sqrt(right[half]);
        }
    }
}

// Place of entry i of direction d: two directions, columns of a lane, lie beside each other.
fn direction(place: u32, d: u32, i: u32, lane: u32) -> u32 {
    return at(place + (d / 2u) * 2u * N, i, lane + (d % 2u) * job.lanes, 2u * job.lanes);
}

// Takes direction d off both systems.
fn taken(d: u32, lane: u32, strand: u32, index: u32) {
    for (var half = 0u; half < 2u; half++) {
        let column = lane + half * job.lanes;
        var sum = 0.0;
        for (var i = strand; i < N; i += STRANDS) {
            sum += numbers[direction(IMAGES, d, i, lane)] * numbers[at(LINEAR, i, column, 2u * job.lanes)];
        }
        let share = total(sum, index);
        for (var i = strand; i < N; i += STRANDS) {
            numbers[at(LINEAR, i, column, 2u * job.lanes)] -= share * numbers[direction(IMAGES, d, i, lane)];
            numbers[at(SOLUTION, i, column, 2u * job.lanes)] += share * numbers[direction(DIRECTIONS, d, i, lane)];
        }
    }
}

// Makes direction d orthogonal to those before it, and its image of length 1.
fn orthogonal(d: u32, lane: u32, strand: u32, index: u32) {
    var sum = 0.0;
    for (var i = strand; i < N; i += STRANDS) {
        let q = numbers[direction(IMAGES, d, i, lane)];
        sum += q * q;
    }
    let whole = total(sum, index);
    // twice is enough
    for (var k = 0u; k < 2u * d; k++) {
        let before = k % d;
        sum = 0.0;
        for (var i = strand; i < N; i += STRANDS) {
            sum += numbers[direction(IMAGES, before, i, lane)] * numbers[direction(IMAGES, d, i, lane)];
        }
        let share = total(sum, index);
        for (var i = strand; i < N; i += STRANDS) {
            numbers[direction(IMAGES, d, i, lane)] -= share * numbers[direction(IMAGES, before, i, lane)];
            numbers[direction(DIRECTIONS, d, i, lane)] -= share * numbers[direction(DIRECTIONS, before, i, lane)];
        }
    }
    sum = 0.0;
    for (var i = strand; i < N; i += STRANDS) {
        let q = numbers[direction(IMAGES, d, i, lane)];
        sum += q * q;
    }
    let left = total(sum, index);
    let is_new = left > ROUND_OFF * ROUND_OFF * whole && left > 0.0;
    let factor = select(0.0, inverseSqrt(left), is_new);
    for (var i = strand; i < N; i += STRANDS) {
        numbers[direction(IMAGES, d, i, lane)] *= factor;
        numbers[direction(DIRECTIONS, d, i, lane)] *= factor;
    }
}

// Two more directions, whose images P J z are there; what is left gives the next two.
@compute @workgroup_size(GROUP)
fn advanced(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let lane = group.x * LANES_OF_GROUP + index % LANES_OF_GROUP;
    let strand = index / LANES_OF_GROUP;
    for (var half = 0u; half < 2u; half++) {
        orthogonal(2u * job.pair + half, lane, strand, index);
        taken(2u * job.pair + half, lane, strand, index);
    }
    if job.pair + 1u < ROUNDS {
        for (var i = strand; i < N; i += STRANDS) {
            for (var half = 0u; half < 2u; half++) {
                let column = lane + half * job.lanes;
                numbers[direction(DIRECTIONS, 2u * (job.pair + 1u) + half, i, lane)] = numbers[at(LINEAR, i, column, 2u * job.lanes)];
            }
        }
    }
    let left = array<f32, 2>(squared_left(lane, index), squared_left(lane + job.lanes, index));
    if strand == 0u {
        for (var half = 0u; half < 2u; half++) {
            told[(LEFT + half) * job.lanes + lane] = sqrt(left[half]);
        }
    }
}
