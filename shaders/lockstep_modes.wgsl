// Products with matrices, and the division by the dynamic stiffness of the modes.

// Rows of the matrix, and columns, of a group of threads; entries of a sum at a time.
const TILE_ROWS: u32 = 64u;
const TILE: u32 = 64u;
const DEPTH: u32 = 16u;

// Entries of the matrix and of x. Shape: [DEPTH][16]
var<workgroup> tile_a: array<vec4<f32>, 256>;
var<workgroup> tile_x: array<vec4<f32>, 256>;

// DEPTH columns from `place.w` of the matrix at `place.x`, rows from `place.z`, and the same rows of x at `place.y`: each thread loads
// one row of the matrix and one column of x, side by side in memory with those of the threads beside it.
fn load_tiles(place: vec4<u32>, index: u32, of_lanes: bool) {
    let row = place.z + index;
    for (var i = 0u; i < DEPTH; i++) {
        let k = place.w + i;
        var entry = 0.0;
        var value = 0.0;
        if k < job.inner {
            if row < job.rows {
                let from_place = place.x + k * job.rows + row;
                if of_lanes {
                    entry = inverses[from_place];
                } else {
                    entry = shared_numbers[from_place];
                }
            }
            value = numbers[place.y + k * job.columns + index];
        }
        tile_a[i * 16u + index / 4u][index % 4u] = entry;
        tile_x[i * 16u + index / 4u][index % 4u] = value;
    }
}

// y = alpha value + keep y for four columns.
fn put(place: u32, value: vec4<f32>) {
    for (var l = 0u; l < 4u; l++) {
        var y = job.alpha * value[l];
        if job.keep != 0.0 {
            y += job.keep * numbers[place + l];
        }
        numbers[place + l] = y;
    }
}

// The same for both fours of columns of a thread, if the matrix has the row.
fn put_row(row: u32, y: u32, first: vec4<f32>, second: vec4<f32>) {
    if row < job.rows {
        put(y + row * job.columns, first);
        put(y + row * job.columns + 32u, second);
    }
}

// The same for four rows from `row` on.
fn put_rows(row: u32, y: u32, first: mat4x4<f32>, second: mat4x4<f32>) {
    put_row(row, y, first[0], second[0]);
    put_row(row + 1u, y, first[1], second[1]);
    put_row(row + 2u, y, first[2], second[2]);
    put_row(row + 3u, y, first[3], second[3]);
}

// Sums of a thread: fours of rows a and b by fours of columns u and v. Not an array: a compiler keeps none in registers whose index
// it does not know.
struct Sums {
    au: mat4x4<f32>,
    av: mat4x4<f32>,
    bu: mat4x4<f32>,
    bv: mat4x4<f32>,
}

// Every a times every u.
fn outer(a: vec4<f32>, u: vec4<f32>) -> mat4x4<f32> {
    return mat4x4<f32>(a.x * u, a.y * u, a.z * u, a.w * u);
}

// y = alpha A x + keep y with a matrix that lies column by column, for all coefficients above 0 or for one: 64 rows and 64 columns
// per group, 8 x 8 per thread: rows 4 r to 4 r + 3 and 32 further, columns likewise. The inverse of the lanes' tile, or the matrix of the
// coefficient's part of the model.
fn columns_times(group: vec3<u32>, index: u32, of_lanes: bool) {
    let first_column = group.x * TILE;
    let first_row = group.y * TILE_ROWS;
    var matrix = job.matrix;
    if of_lanes {
        matrix += inverse_of[(first_column % job.lanes) / TILE] * job.stride;
    } else {
        matrix += parts[group.z / 2u] * job.stride;
    }
    // -i (x_c - i x_s) has the cosine -x_s and the sine x_c
    let sign = select(1.0, -1.0, job.turns != 0u && group.z % 2u == 0u);
    let x = job.x * job.lanes + (group.z ^ job.turns) * job.x_step * job.columns;
    let r = index / 8u;
    let c = index % 8u;
    var sums = Sums();
    for (var first = 0u; first < job.inner; first += DEPTH) {
        load_tiles(vec4<u32>(matrix, x + first_column, first_row, first), index, of_lanes);
        workgroupBarrier();
        for (var d = 0u; d < DEPTH; d++) {
            let a = tile_a[d * 16u + r];
            let b = tile_a[d * 16u + 8u + r];
            let u = tile_x[d * 16u + c];
            let v = tile_x[d * 16u + 8u + c];
            sums.au += outer(a, u);
            sums.av += outer(a, v);
            sums.bu += outer(b, u);
            sums.bv += outer(b, v);
        }
        workgroupBarrier();
    }
    let row = first_row + 4u * r;
    let y = job.y * job.lanes + group.z * job.y_step * job.columns + first_column + 4u * c;
    put_rows(row, y, sign * sums.au, sign * sums.av);
    put_rows(row + 32u, y, sign * sums.bu, sign * sums.bv);
}

@compute @workgroup_size(GROUP)
fn product(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    columns_times(group, index, false);
}

// The same with the inverse Jacobian of the lanes' anchor.
@compute @workgroup_size(GROUP)
fn preconditioned(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    columns_times(group, index, true);
}

// Coefficients (cosine, sine) of harmonic number h on mode j.
fn load_of(h: u32, j: u32, column: u32) -> vec2<f32> {
    let c = at(MODAL, 2u * h * MODES + j, column, job.columns);
    return vec2<f32>(numbers[c], numbers[c + MODES * job.columns]);
}

fn store_modal(h: u32, j: u32, column: u32, x: vec2<f32>) {
    let c = at(MODAL, 2u * h * MODES + j, column, job.columns);
    numbers[c] = x.x;
    numbers[c + MODES * job.columns] = x.y;
}

// Motion D of the modes under their loads, in their place.
@compute @workgroup_size(GROUP)
fn divided(@builtin(global_invocation_id) id: vec3<u32>) {
    let d = spectrum(id.z, id.y, id.x % job.lanes);
    store_modal(id.z, id.y, id.x, turned(d[0], load_of(id.z, id.y, id.x)));
}

// The same for the residual and its derivative by the frequency, columns of one lane: -η = D (contact load - level f), and D of
// (dF/dr) t + (dZ/dω) η.
@compute @workgroup_size(GROUP)
fn divided_residual(@builtin(global_invocation_id) id: vec3<u32>) {
    let lane = id.x;
    let j = id.y;
    let h = id.z;
    let d = spectrum(h, j, lane);
    var load = load_of(h, j, lane);
    if h == 0u {
        load -= own[LEVEL * job.lanes + lane] * vec2<f32>(shared_numbers[EXCITATION + j], shared_numbers[EXCITATION + MODES + j]);
    }
    let opposite = turned(d[0], load);
    store_modal(h, j, lane, opposite);
    if h == 0u {
        numbers[at(FIRST, j, lane, job.lanes)] = opposite.x;
        numbers[at(FIRST, MODES + j, lane, job.lanes)] = opposite.y;
    }
    let slope = load_of(h, j, lane + job.lanes) - turned(d[1], opposite);
    store_modal(h, j, lane + job.lanes, turned(d[0], slope));
}

// Response, and its derivatives along correction and tangent; loads of both are in their columns.
@compute @workgroup_size(GROUP)
fn responded(@builtin(global_invocation_id) id: vec3<u32>) {
    let lane = id.x;
    var response = vec2<f32>();
    var by_correction = vec2<f32>();
    var by_tangent = vec2<f32>();
    for (var j = 0u; j < MODES; j++) {
        let d = spectrum(0u, j, lane);
        let opposite = vec2<f32>(numbers[at(FIRST, j, lane, job.lanes)], numbers[at(FIRST, MODES + j, lane, job.lanes)]);
        let weight = vec2<f32>(shared_numbers[RESPONSES + j], shared_numbers[RESPONSES + MODES + j]);
        response -= turned(weight, opposite);
        by_correction -= turned(weight, turned(d[0], load_of(0u, j, lane)));
        by_tangent -= turned(weight, turned(d[0], load_of(0u, j, lane + job.lanes) - turned(d[1], opposite)));
    }
    let all = array<vec2<f32>, 3>(response, by_correction, by_tangent);
    for (var i = 0u; i < 3u; i++) {
        told[(RESPONSE + 2u * i) * job.lanes + lane] = all[i].x;
        told[(RESPONSE + 2u * i + 1u) * job.lanes + lane] = all[i].y;
    }
    var undecided = 0.0;
    for (var pair = 0u; pair < PAIRS; pair++) {
        undecided += select(0.0, 1.0, (flags[pair * job.lanes + lane] & OVERFLOW) != 0u);
    }
    told[UNDECIDED * job.lanes + lane] = undecided;
    told[FREQUENCY * job.lanes + lane] = numbers[DETUNING * job.lanes + lane];
}
