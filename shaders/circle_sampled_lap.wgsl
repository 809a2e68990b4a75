// Lap of the circle law decided at the samples, the twin of `circle_lap` in aft/circle_law/march.rs.

// Row of `signals` with the tractions: rates are not needed.
const TRACTION: u32 = 3u;
const SIGNAL_ROWS: u32 = 6u;

// Radial return, in forces: the slider's place is k_t w.
struct Step {
    traction: vec2<real>,
    slider: vec2<real>,
    direction: vec2<real>,
    ratio: real,
    slips: bool,
    touches: bool,
}

fn radial_return(limit: real, margin: real, s: vec2<real>, slider: vec2<real>) -> Step {
    let trial = s - slider;
    let square = inner(trial, trial);
    let inside = max(limit - margin, real(0.0));
    var step = Step(trial, slider, vec2<real>(real(0.0), real(0.0)), real(1.0), false, false);
    step.slips = square > limit * limit;
    step.touches = square > inside * inside;
    if step.touches {
        let length = sqrt(square);
        step.direction = trial / length;
        if step.slips {
            step.ratio = limit / length;
            step.traction = step.ratio * trial;
            step.slider = s - step.traction;
        }
    }
    return step;
}

// Instant of closing before a sample as a share of the interval; 0 where the contact does not close there.
fn closing(i: u32, first: bool, state: u32) -> real {
    if !INTERPOLATED || (first && i == 0u) {
        return real(0.0);
    }
    let before = sample_of(GAP, (i + N_TIME - 1u) % N_TIME, state);
    let here = sample_of(GAP, i, state);
    if before <= real(0.0) && here > real(0.0) {
        return before / (before - here);
    }
    return real(0.0);
}

// Derivative of a slip step times a matrix: ratio p p' m with p normal to the direction.
fn slid(direction: vec2<real>, ratio: real, m: vec4<real>) -> vec4<real> {
    let normal = normal_to(direction);
    let row = ratio * vec2<real>(normal.x * m.x + normal.y * m.z, normal.x * m.y + normal.y * m.w);
    return vec4<real>(normal.x * row.x, normal.x * row.y, normal.y * row.x, normal.y * row.y);
}

fn lap_from(start: vec2<real>, first: bool, state: u32) -> Lap {
    let zero = real(0.0);
    let one = real(1.0);
    let margin = tolerance + tolerance;
    var overshoot = zero;
    var lap = Lap(start, vec4<real>(one, zero, zero, one), false, false, false, false);
    for (var i = 0u; i < N_TIME; i++) {
        let s = stick_signal(i, state);
        let gap = sample_of(GAP, i, state);
        lap.end += closing(i, first, state) * (s - lap.end);
        let step = radial_return(mu * max(gap, zero), margin, s, lap.end);
        lap.end = step.slider;
        if gap <= zero {
            lap.moves = true;
            lap.monodromy = vec4<real>(zero, zero, zero, zero);
        } else {
            lap.moves = lap.moves || step.slips;
            overshoot = max(overshoot, one - step.ratio);
            if step.touches {
                lap.monodromy = slid(step.direction, step.ratio, lap.monodromy);
            }
        }
        store_traction(i, state, step.traction);
    }
    lap.rests = overshoot <= ROOT_OF_RESOLUTION;
    return lap;
}
