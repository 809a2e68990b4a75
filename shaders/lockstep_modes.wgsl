// Products with matrices, and the division by the dynamic stiffness of the modes.

// Matrix entries, and columns, of a group of threads at a time.
const TILE_ROWS: u32 = 32u;
const TILE: u32 = 64u;
const DEPTH: u32 = 16u;

var<workgroup> tile_a: array<f32, 512>;
var<workgroup> tile_x: array<vec4<f32>, 256>;

// Rows from `place.z` and columns from `place.w` of the matrix at `place.x`, and the same rows of the array at `place.y`.
fn load_tiles(place: vec4<u32>, index: u32, of_lanes: bool) {
    for (var i = 0u; i < 8u; i++) {
        let entry = i * GROUP + index;
        let row = place.z + entry % TILE_ROWS;
        let k = place.w + entry / TILE_ROWS;
        var value = 0.0;
        if row < job.rows && k < job.inner {
            let from_place = place.x + k * job.rows + row;
            if of_lanes {
                value = inverses[from_place];
            } else {
                value = shared_numbers[from_place];
            }
        }
        tile_a[entry] = value;
    }
    for (var i = 0u; i < 4u; i++) {
        let entry = i * GROUP + index;
        let k = place.w + entry / 16u;
        var value = vec4<f32>();
        if k < job.inner {
            let first = place.y + k * job.columns + 4u * (entry % 16u);
            value = vec4<f32>(numbers[first], numbers[first + 1u], numbers[first + 2u], numbers[first + 3u]);
        }
        tile_x[entry] = value;
    }
}

// y = alpha A x + keep y with a matrix that lies column by column, for all coefficients above 0 or for one: 32 rows and 64 columns
// per group, 8 x 4 per thread. The inverse of the lanes' tile, or the matrix of the coefficient's part
// of the model.
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
    let alpha = select(job.alpha, -job.alpha, job.turns != 0u && group.z % 2u == 0u);
    let x = job.x * job.lanes + (group.z ^ job.turns) * job.x_step * job.columns;
    let y = job.y * job.lanes + group.z * job.y_step * job.columns;
    let rows_of = (index / 16u) * 8u;
    let columns_of = index % 16u;
    var sum = array<vec4<f32>, 8>();
    for (var first = 0u; first < job.inner; first += DEPTH) {
        load_tiles(vec4<u32>(matrix, x + first_column, first_row, first), index, of_lanes);
        workgroupBarrier();
        for (var d = 0u; d < DEPTH; d++) {
            let right = tile_x[d * 16u + columns_of];
            for (var i = 0u; i < 8u; i++) {
                sum[i] += tile_a[d * TILE_ROWS + rows_of + i] * right;
            }
        }
        workgroupBarrier();
    }
    for (var i = 0u; i < 8u; i++) {
        let row = first_row + rows_of + i;
        if row < job.rows {
            let place = y + row * job.columns + first_column + 4u * columns_of;
            for (var l = 0u; l < 4u; l++) {
                var value = alpha * sum[i][l];
                if job.keep != 0.0 {
                    value += job.keep * numbers[place + l];
                }
                numbers[place + l] = value;
            }
        }
    }
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
