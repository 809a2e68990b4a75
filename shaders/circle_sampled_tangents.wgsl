// Derivatives of the circle law, the twin of aft/circle_law/tangent.rs: one thread per state that moves and column. The
// slider carries its derivative by one coefficient of one signal around the laps.

// One coefficient of one signal, and the direction in which that signal moves the contact: none for the gap.
struct Column {
    signal: u32,
    coefficient: u32,
    unit: vec2<real>,
}

// The slider with its derivatives by the column and by its own place at the start of the lap.
struct SliderWithRates {
    place: vec2<real>,
    by: vec2<real>,
    monodromy: vec4<real>,
    // Derivative of the traction at the last sample by the column.
    rate: vec2<real>,
}

fn column_of(c: u32, b: u32) -> Column {
    let zero = real(0.0);
    let one = real(1.0);
    let unit = select(vec2<real>(zero, zero), vec2<real>(one, zero), c == 0u) + select(vec2<real>(zero, zero), vec2<real>(zero, one), c == 1u);
    return Column(c, b, unit);
}

fn slider_from(place: vec2<real>) -> SliderWithRates {
    let zero = real(0.0);
    let one = real(1.0);
    return SliderWithRates(place, vec2<real>(zero, zero), vec4<real>(one, zero, zero, one), vec2<real>(zero, zero));
}

// The slider where the contact closes at the share `instant` of the interval that ends at sample i.
fn after_closing(before_it: SliderWithRates, column: Column, instant: real, i: u32, state: u32) -> SliderWithRates {
    let one = real(1.0);
    var slider = before_it;
    let s = stick_signal(i, state);
    let gap = sample_of(GAP, i, state);
    let here = basis(column.coefficient, i);
    let before = (i + N_TIME - 1u) % N_TIME;
    let g0 = sample_of(GAP, before, state);
    let factor = one / ((g0 - gap) * (g0 - gap));
    slider.by = (one - instant) * slider.by + instant * here * column.unit;
    if column.signal == GAP {
        slider.by += (factor * (g0 * here - gap * basis(column.coefficient, before))) * (s - slider.place);
    }
    slider.place += instant * (s - slider.place);
    return slider;
}

// The slider after the law has acted at sample i: open, slipping or sticking.
fn after_sample(before_it: SliderWithRates, column: Column, i: u32, state: u32) -> SliderWithRates {
    let zero = real(0.0);
    var slider = before_it;
    let s = stick_signal(i, state);
    let gap = sample_of(GAP, i, state);
    let here = basis(column.coefficient, i);
    let margin = tolerance + tolerance;
    let step = radial_return(mu * max(gap, zero), margin, s, slider.place);
    slider.rate = vec2<real>(zero, zero);
    if gap <= zero {
        slider.place = s;
        slider.by = here * column.unit;
        slider.monodromy = vec4<real>(zero, zero, zero, zero);
    } else if step.touches {
        slider.place = step.slider;
        let normal = normal_to(step.direction);
        let trial = here * column.unit - slider.by;
        slider.rate = (step.ratio * (normal.x * trial.x + normal.y * trial.y)) * normal;
        if column.signal == GAP {
            slider.rate += (mu * here) * step.direction;
        }
        slider.by = here * column.unit - slider.rate;
        slider.monodromy = slid(step.direction, step.ratio, slider.monodromy);
    } else {
        slider.rate = here * column.unit - slider.by;
    }
    return slider;
}

@compute @workgroup_size(GROUP)
fn circle_sampled_tangents(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    let c = id.y / M;
    let b = id.y % M;
    if slot >= atomicLoad(&n_moving) {
        return;
    }
    let state = moving[slot];
    if !moved_and_fitted(state) {
        return;
    }
    let zero = real(0.0);
    let cycle = take_cycle(state);
    let anchored = cycle.laps > 0u;
    let laps = select(2u, cycle.laps, anchored);
    let start = cycle.start;
    let column = column_of(c, b);
    var slider = slider_from(select(start, anchor_of(state), anchored));
    var sums = array<vec2<real>, M>();
    var normal_sums = array<real, M>();
    for (var lap = 1u; lap <= laps; lap++) {
        if lap == 2u && !anchored {
            slider.by = solve_identity_minus(slider.monodromy, slider.by);
            slider.place = start;
        }
        for (var i = 0u; i < N_TIME; i++) {
            let gap = sample_of(GAP, i, state);
            let here = basis(b, i);
            let instant = closing(i, anchored && lap == 1u, state);
            if instant != zero {
                slider = after_closing(slider, column, instant, i, state);
            }
            slider = after_sample(slider, column, i, state);
            if lap == laps {
                let rate = slider.rate - here * column.unit;
                let open = select(zero, -here, gap <= zero);
                for (var a = 0u; a < M; a++) {
                    let row = basis(a, i);
                    sums[a] += row * rate;
                    normal_sums[a] += row * open;
                }
            }
        }
    }
    for (var a = 0u; a < M; a++) {
        let w = weight(a);
        tangents[tangent_at(slot, block_of(0u, c), a, b)] = w * sums[a].x;
        tangents[tangent_at(slot, block_of(1u, c), a, b)] = w * sums[a].y;
        if c == GAP {
            tangents[tangent_at(slot, 6u, a, b)] = w * normal_sums[a];
        }
    }
}
