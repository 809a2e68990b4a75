// Conjugate residuals of correction and tangent together, the twin of linalg/recycled.rs: 16 lanes and 16 strands per group. What belongs
// to correction and tangent of a lane lies in two columns, and so do the two directions of a round: one is read with the other.

const STRANDS: u32 = 16u;
const LANES_OF_GROUP: u32 = 16u;
const DIRECTION_GROUP: u32 = 256u;
// Share of a product below which its remainder is round-off.
const ROUND_OFF: f32 = 1e-6;

var<workgroup> parts_of_sum: array<vec4<f32>, 256>;
// Products of the images of a round with the two new ones. Shape: [round][lane]
var<workgroup> shares: array<vec4<f32>, 16u * ROUNDS>;

// A thread's lane, the first entry that is its own, and its number in the group.
struct Place {
    lane: u32,
    strand: u32,
    index: u32,
}

fn place_of(group: vec3<u32>, index: u32) -> Place {
    return Place(group.x * LANES_OF_GROUP + index % LANES_OF_GROUP, index / LANES_OF_GROUP, index);
}

// Sum over the strands of a lane.
fn total(value: vec4<f32>, index: u32) -> vec4<f32> {
    parts_of_sum[index] = value;
    workgroupBarrier();
    var sum = vec4<f32>();
    for (var strand = 0u; strand < STRANDS; strand++) {
        sum += parts_of_sum[strand * LANES_OF_GROUP + index % LANES_OF_GROUP];
    }
    workgroupBarrier();
    return sum;
}

// Entry i of both columns of a lane in the array at `array`, and of the two directions of a round in those of DIRECTIONS or IMAGES.
fn both(array: u32, i: u32, lane: u32) -> vec2<f32> {
    let first = at(array, i, lane, 2u * job.lanes);
    return vec2<f32>(numbers[first], numbers[first + job.lanes]);
}

fn put_both(array: u32, i: u32, lane: u32, value: vec2<f32>) {
    let first = at(array, i, lane, 2u * job.lanes);
    numbers[first] = value.x;
    numbers[first + job.lanes] = value.y;
}

fn of_round(array: u32, round: u32) -> u32 {
    return array + 2u * N * round;
}

// The systems begin: the correction is zero, the tangent that of the last point; the residuals are the first directions.
@compute @workgroup_size(DIRECTION_GROUP)
fn begun(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let p = place_of(group, index);
    var largest = 0.0;
    var squares = vec4<f32>();
    for (var i = p.strand; i < N; i += STRANDS) {
        let left = both(LINEAR, i, p.lane);
        largest = max(largest, abs(left.x));
        squares += vec4<f32>(left * left, 0.0, 0.0);
        numbers[at(SOLUTION, i, p.lane, 2u * job.lanes)] = 0.0;
        put_both(DIRECTIONS, i, p.lane, left);
    }
    parts_of_sum[index] = vec4<f32>(largest);
    workgroupBarrier();
    for (var s = 0u; s < STRANDS; s++) {
        largest = max(largest, parts_of_sum[s * LANES_OF_GROUP + index % LANES_OF_GROUP].x);
    }
    workgroupBarrier();
    let right = total(squares, index);
    if p.strand == 0u {
        told[SIZE * job.lanes + p.lane] = largest;
        told[RIGHT * job.lanes + p.lane] = sqrt(right.x);
        told[(RIGHT + 1u) * job.lanes + p.lane] = sqrt(right.y);
    }
}

// Squared lengths of the new images.
fn lengths(p: Place) -> vec4<f32> {
    var sum = vec4<f32>();
    for (var i = p.strand; i < N; i += STRANDS) {
        let w = both(of_round(IMAGES, job.pair), i, p.lane);
        sum += vec4<f32>(w * w, 0.0, 0.0);
    }
    return total(sum, p.index);
}

// Takes the directions of the rounds before off both new ones; first squared length, mixed product and second squared length of the
// images then.
fn remainders(p: Place) -> vec4<f32> {
    let images = of_round(IMAGES, job.pair);
    let directions = of_round(DIRECTIONS, job.pair);
    for (var k = 0u; k < job.pair; k++) {
        var sum = vec4<f32>();
        for (var i = p.strand; i < N; i += STRANDS) {
            let q = both(of_round(IMAGES, k), i, p.lane);
            let w = both(images, i, p.lane);
            sum += vec4<f32>(q.x * w, q.y * w);
        }
        let share = total(sum, p.index);
        if p.strand == 0u {
            shares[k * LANES_OF_GROUP + p.index] = share;
        }
    }
    workgroupBarrier();
    var sum = vec4<f32>();
    for (var i = p.strand; i < N; i += STRANDS) {
        var w = both(images, i, p.lane);
        var z = both(directions, i, p.lane);
        for (var k = 0u; k < job.pair; k++) {
            let share = shares[k * LANES_OF_GROUP + p.index % LANES_OF_GROUP];
            let q = both(of_round(IMAGES, k), i, p.lane);
            let y = both(of_round(DIRECTIONS, k), i, p.lane);
            w -= q.x * share.xy + q.y * share.zw;
            z -= y.x * share.xy + y.y * share.zw;
        }
        put_both(images, i, p.lane, w);
        put_both(directions, i, p.lane, z);
        sum += vec4<f32>(w.x * w.x, w.x * w.y, w.y * w.y, 0.0);
    }
    return total(sum, p.index);
}

// Takes `share` of the first new direction off the second one, and multiplies both by `factors`; mixed product and second squared
// length of the images then.
fn separated(share: f32, factors: vec2<f32>, p: Place) -> vec4<f32> {
    let arrays = vec2<u32>(of_round(IMAGES, job.pair), of_round(DIRECTIONS, job.pair));
    var sum = vec4<f32>();
    for (var i = p.strand; i < N; i += STRANDS) {
        let w = both(arrays.x, i, p.lane);
        let z = both(arrays.y, i, p.lane);
        let image = factors * vec2<f32>(w.x, w.y - share * w.x);
        put_both(arrays.x, i, p.lane, image);
        put_both(arrays.y, i, p.lane, factors * vec2<f32>(z.x, z.y - share * z.x));
        sum += vec4<f32>(image.x * image.y, image.y * image.y, 0.0, 0.0);
    }
    return total(sum, p.index);
}

// One over the length of a remainder, 0 where it is round-off of a product with the squared length `whole`.
fn factor(squared: f32, whole: f32) -> f32 {
    return select(0.0, inverseSqrt(squared), squared > ROUND_OFF * ROUND_OFF * whole && squared > 0.0);
}

// Makes both new directions orthogonal to those before and to each other, twice, which is enough, and their images of length 1.
fn orthogonal(p: Place) {
    let whole = lengths(p);
    remainders(p);
    let left = remainders(p);
    let first = factor(left.x, whole.x);
    let mixed = separated(select(0.0, left.y / left.x, first > 0.0), vec2<f32>(first, 1.0), p);
    let second = factor(mixed.y - mixed.x * mixed.x, whole.y);
    separated(mixed.x, vec2<f32>(1.0, second), p);
}

// Takes both new directions off both systems; the residuals are the next directions. Squared lengths of the residuals.
fn taken(p: Place) -> vec4<f32> {
    let images = of_round(IMAGES, job.pair);
    var sum = vec4<f32>();
    for (var i = p.strand; i < N; i += STRANDS) {
        let q = both(images, i, p.lane);
        let left = both(LINEAR, i, p.lane);
        sum += vec4<f32>(q.x * left, q.y * left);
    }
    let share = total(sum, p.index);
    sum = vec4<f32>();
    for (var i = p.strand; i < N; i += STRANDS) {
        let q = both(images, i, p.lane);
        let y = both(of_round(DIRECTIONS, job.pair), i, p.lane);
        let left = both(LINEAR, i, p.lane) - q.x * share.xy - q.y * share.zw;
        put_both(LINEAR, i, p.lane, left);
        put_both(SOLUTION, i, p.lane, both(SOLUTION, i, p.lane) + y.x * share.xy + y.y * share.zw);
        if job.pair + 1u < ROUNDS {
            put_both(of_round(DIRECTIONS, job.pair + 1u), i, p.lane, left);
        }
        sum += vec4<f32>(left * left, 0.0, 0.0);
    }
    return total(sum, p.index);
}

// Adds the pair of directions whose images have just been computed.
@compute @workgroup_size(DIRECTION_GROUP)
fn advanced(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let p = place_of(group, index);
    orthogonal(p);
    let left = taken(p);
    if p.strand == 0u {
        told[LEFT * job.lanes + p.lane] = sqrt(left.x);
        told[(LEFT + 1u) * job.lanes + p.lane] = sqrt(left.y);
    }
}
