// Derivatives of the circle law, the twin of aft/circle_law/tangent.rs: one thread per state that moves and column. The
// slider carries its derivative by one coefficient of one signal around the laps.

@compute @workgroup_size(GROUP)
fn circle_sampled_tangents(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    let c = id.y / M;
    let b = id.y % M;
    if slot >= atomicLoad(&n_moving) {
        return;
    }
    let state = moving[slot];
    if atomicLoad(&flags[state]) != MOVED {
        return;
    }
    let zero = real(0.0);
    let one = real(1.0);
    let cycle = take_cycle(state);
    let margin = tolerance + tolerance;
    let anchored = cycle.laps > 0u;
    let laps = select(2u, cycle.laps, anchored);
    let start = cycle.start;
    let unit = select(vec2<real>(zero, zero), vec2<real>(one, zero), c == 0u) + select(vec2<real>(zero, zero), vec2<real>(zero, one), c == 1u);
    var slider = select(start, anchor_of(state), anchored);
    var by = vec2<real>(zero, zero);
    var monodromy = vec4<real>(one, zero, zero, one);
    var sums = array<vec2<real>, M>();
    var normal_sums = array<real, M>();
    for (var lap = 1u; lap <= laps; lap++) {
        if lap == 2u && !anchored {
            by = solve_identity_minus(monodromy, by);
            slider = start;
        }
        for (var i = 0u; i < N_TIME; i++) {
            let s = stick_signal(i, state);
            let gap = sample_of(GAP, i, state);
            let here = basis(b, i);
            let instant = closing(i, anchored && lap == 1u, state);
            if instant != zero {
                let before = (i + N_TIME - 1u) % N_TIME;
                let g0 = sample_of(GAP, before, state);
                let factor = one / ((g0 - gap) * (g0 - gap));
                by = (one - instant) * by + instant * here * unit;
                if c == GAP {
                    by += (factor * (g0 * here - gap * basis(b, before))) * (s - slider);
                }
                slider += instant * (s - slider);
            }
            let step = radial_return(mu * max(gap, zero), margin, s, slider);
            var rate = vec2<real>(zero, zero);
            if gap <= zero {
                slider = s;
                by = here * unit;
                monodromy = vec4<real>(zero, zero, zero, zero);
            } else if step.touches {
                slider = step.slider;
                let normal = normal_to(step.direction);
                let trial = here * unit - by;
                rate = (step.ratio * (normal.x * trial.x + normal.y * trial.y)) * normal;
                if c == GAP {
                    rate += (mu * here) * step.direction;
                }
                by = here * unit - rate;
                monodromy = slid(step.direction, step.ratio, monodromy);
            } else {
                rate = here * unit - by;
            }
            if lap == laps {
                rate -= here * unit;
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
