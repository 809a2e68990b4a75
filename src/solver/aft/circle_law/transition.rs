//! Transitions of a contact between open, stick and slip: the slider after each of them, with its derivatives.

use super::kink::Kink;
use super::lap::{ClosedMotion, Lap, LapMarch};
use super::node::{At, Node, slip_step};
use super::sensitivity::{
    Base, Basis, KinkRows, Row, SignalWeights, add_row, add_signals, add_step, scale, set_rows,
};
use super::slip::HalfAngle;
use crate::aft::plan::CHUNK;
use crate::aft::vector::{dot, normal};
use crate::contact::Real;
use pulp::Simd;

impl<S: Simd, T: Real> LapMarch<'_, S, T> {
    /// Motion at the start of the lap of a contact that is closed there.
    pub(super) fn resume(&mut self, node: &Node<T>, slider: [T; 2]) -> ClosedMotion<T> {
        let t = [node.path[0] - slider[0], node.path[1] - slider[1]];
        let size = dot(t, t).sqrt();
        let margin = self.course.work.touch_margin(self.course.lane);
        let e = t.map(|t| t / size);
        let slides = node.sliding(e) > T::ZERO && size > node.limit - margin && size > T::ZERO;
        let beyond = size > node.limit + margin;
        let mut motion = ClosedMotion::Stick(slider);
        if slides || beyond {
            self.lap.moved = true;
            self.turn_towards(node, e, size);
            let half = HalfAngle::of(e);
            let slider = self.stop(node, half);
            self.lap.slip_from = slider;
            motion = if slides {
                ClosedMotion::Slip(half)
            } else {
                ClosedMotion::Stick(slider)
            };
        }
        motion
    }

    /// Row of the angle of the traction where a slider that rested begins to move; the phase is fixed. The traction has the
    /// direction `e` and this size.
    fn turn_towards(&mut self, node: &Node<T>, e: [T; 2], size: T) {
        let base = self.base();
        let (p, lap) = (normal(e), &mut *self.lap);
        let at = self.course.basis(node, &lap.row);
        let [first, second] = &lap.rows.slider;
        let factors = p.map(|p| p / size);
        set_rows(&mut lap.rows.angle, [first, second], |_, a, b| {
            -(factors[0] * a + factors[1] * b)
        });
        let weights = SignalWeights {
            path: factors,
            ..SignalWeights::NONE
        };
        add_signals(base, &mut lap.rows.angle, at, weights);
        lap.rows.instant.fill([T::ZERO; CHUNK]);
    }

    /// A slider that rested begins to slip at `node`, whose basis row is `next_row` of the lap.
    pub(super) fn start_slip(&mut self, node: &Node<T>, slider: [T; 2]) -> ClosedMotion<T> {
        let base = self.base();
        let t = [node.path[0] - slider[0], node.path[1] - slider[1]];
        let size = dot(t, t).sqrt();
        let e = t.map(|t| t / size);
        let p = normal(e);
        let sliding = node.sliding(e);
        let inverse = if sliding > T::ZERO {
            T::ONE / sliding
        } else {
            T::ZERO
        };
        (self.lap.moved, self.lap.slip_from) = (true, slider);
        std::mem::swap(&mut self.lap.row, &mut self.lap.next_row);
        self.turn_towards(node, e, size);
        let lap = &mut *self.lap;
        // e·(ds + s' dθ − dz) = dL + L' dθ.
        let [first, second] = &lap.rows.slider;
        set_rows(&mut lap.rows.instant, [first, second], |_, a, b| {
            inverse * (e[0] * a + e[1] * b)
        });
        let weights = SignalWeights {
            path: e.map(|e| -(inverse * e)),
            limit: inverse,
            ..SignalWeights::NONE
        };
        add_signals(base, &mut lap.rows.instant, Basis::Event(&lap.row), weights);
        let turning = dot(p, node.rate) / size;
        add_row(&mut lap.rows.angle, turning, &lap.rows.instant);
        let bending = node.bending(e);
        let jumps = [sliding, bending].map(|x| e.map(|e| -(x * e)));
        self.kink(node, jumps, |lap, out| {
            lap.sliding_row(base, node, e);
            add_row(&mut lap.sliding, bending, &lap.rows.instant);
            lap.turning_row(&mut out.jump, e, [-sliding, -T::ONE]);
            lap.bending_row(base, node, e);
            lap.turning_row(&mut out.bend, e, [-bending, -T::ONE]);
        });
        ClosedMotion::Slip(HalfAngle::of(e))
    }

    /// Slip from `here` on, in the direction `half`, ends at `node`, whose basis row is `next_row` of the lap.
    pub(super) fn end_slip(
        &mut self,
        [here, node]: [&Node<T>; 2],
        half: HalfAngle<T>,
    ) -> ClosedMotion<T> {
        let base = self.base();
        let after = half.after(self.course.map(here, node));
        let turning = self.slide([here, node], half, after);
        let e = after.e;
        let lap = &mut *self.lap;
        lap.sliding_row(base, node, e);
        let fall = node.sliding_rate(e, turning);
        let factor = if fall < T::ZERO {
            -(T::ONE / fall)
        } else {
            T::ZERO
        };
        lap.rows.instant.copy_from_slice(&lap.sliding);
        scale(&mut lap.rows.instant, factor);
        add_row(&mut lap.rows.angle, turning, &lap.rows.instant);
        let slider = self.stop(node, after);
        self.lap.note_slip(slider);
        let bending = node.bending(e);
        let jumps = [[T::ZERO; 2], e.map(|e| bending * e)];
        self.kink(node, jumps, |lap, out| {
            for row in &mut out.jump {
                row.fill([T::ZERO; CHUNK]);
            }
            lap.bending_row(base, node, e);
            lap.turning_row(&mut out.bend, e, [bending, T::ONE]);
        });
        ClosedMotion::Stick(slider)
    }

    /// The slider and its rows at `node`, where slip in the direction `half` ends.
    fn stop(&mut self, node: &Node<T>, half: HalfAngle<T>) -> [T; 2] {
        let base = self.base();
        let e = half.e;
        let p = normal(e);
        let lap = &mut *self.lap;
        let at = self.course.basis(node, &lap.row);
        for (d, slider) in lap.rows.slider.iter_mut().enumerate() {
            let (turned, moved) = (node.limit * p[d], node.rate[d] - e[d] * node.limit_rate);
            let rows: [&[_]; 2] = [&lap.rows.angle, &lap.rows.instant];
            set_rows(slider, rows, |_, angle, instant| {
                moved * instant - turned * angle
            });
            let mut weights = SignalWeights::NONE;
            (weights.path[d], weights.limit) = (T::ONE, -e[d]);
            add_signals(base, slider, at, weights);
        }
        [0, 1].map(|d| node.path[d] - node.limit * e[d])
    }

    /// Row of the angle after a step of slip. Returns the derivative of the angle by the phase of the end of the step. If the step
    /// starts at an event, that event moves with the inputs. If it ends at one, the row holds for a fixed phase of the end; the
    /// basis row there is `next_row` of the lap before and `row` after.
    #[inline(always)]
    pub(super) fn slide(
        &mut self,
        [here, next]: [&Node<T>; 2],
        half: HalfAngle<T>,
        after: HalfAngle<T>,
    ) -> T {
        let base = self.base();
        let lap = &mut *self.lap;
        let factor = half.angle_rate(self.course.map(here, next), after);
        scale(&mut lap.rows.angle, factor);
        let is_fixed = here.at != At::Event && next.at != At::Event;
        if is_fixed && !lap.rows.full {
            return T::ZERO;
        }
        let by = slip_step(here, next).angle_rates(half);
        let (path, rate, length) = (by.path, by.rate, by.length);
        let limit = T::from_f64(0.5) * by.limit;
        let ends = [
            self.course.basis(here, &lap.row),
            self.course.basis(next, &lap.next_row),
        ];
        if let [Basis::Sample(here), Basis::Sample(next)] = ends {
            add_step(base, &mut lap.rows.angle, [here, next], path, rate, limit);
            return T::ZERO;
        }
        let mut weights = SignalWeights {
            path: path.map(|x| -x),
            limit,
            ..SignalWeights::NONE
        };
        add_signals(base, &mut lap.rows.angle, ends[0], weights);
        if here.at == At::Event {
            let moved = limit * here.limit_rate - dot(path, here.rate) - length;
            add_row(&mut lap.rows.angle, moved, &lap.rows.instant);
        }
        (weights.path, weights.rate) = (path, rate);
        add_signals(base, &mut lap.rows.angle, ends[1], weights);
        if next.at == At::Event {
            std::mem::swap(&mut lap.row, &mut lap.next_row);
        }
        next.turning(&by)
    }

    /// The contact closes: until then the slider has followed the surface. It then rests or slips at once.
    pub(super) fn close(&mut self, theta: T) -> (Node<T>, ClosedMotion<T>) {
        let base = self.base();
        let lap = &mut *self.lap;
        let node = self.course.gap_root(theta, &mut lap.row);
        lap.instant_of_gap_root(base, &node);
        let speed = dot(node.rate, node.rate).sqrt();
        if speed <= node.limit_rate {
            for (d, slider) in lap.rows.slider.iter_mut().enumerate() {
                slider.fill([T::ZERO; CHUNK]);
                add_row(slider, node.rate[d], &lap.rows.instant);
                let mut weights = SignalWeights::NONE;
                weights.path[d] = T::ONE;
                add_signals(base, slider, Basis::Event(&lap.row), weights);
            }
            self.kink(&node, [node.rate, node.bend], |lap, out| {
                for d in 0..2 {
                    let mut weights = [SignalWeights::NONE; 2];
                    (weights[0].rate[d], weights[1].bend[d]) = (T::ONE, T::ONE);
                    let rows = [
                        (&mut out.jump[d], node.bend[d]),
                        (&mut out.bend[d], node.jerk[d]),
                    ];
                    for ((row, moved), weights) in rows.into_iter().zip(weights) {
                        row.fill([T::ZERO; CHUNK]);
                        add_row(row, moved, &lap.rows.instant);
                        add_signals(base, row, Basis::Event(&lap.row), weights);
                    }
                }
            });
            return (node, ClosedMotion::Stick(node.path));
        }
        let e = node.rate.map(|v| v / speed);
        let p = normal(e);
        lap.rows.angle.fill([T::ZERO; CHUNK]);
        let turning = dot(p, node.bend) / speed;
        add_row(&mut lap.rows.angle, turning, &lap.rows.instant);
        let weights = SignalWeights {
            rate: p.map(|p| p / speed),
            ..SignalWeights::NONE
        };
        add_signals(base, &mut lap.rows.angle, Basis::Event(&lap.row), weights);
        lap.slip_from = node.path;
        self.limit_kink(&node, e, T::ONE);
        (node, ClosedMotion::Slip(HalfAngle::of(e)))
    }

    /// The contact, which slips in the direction `half`, opens; `turning` is the rate of the angle.
    pub(super) fn open(&mut self, node: &Node<T>, half: HalfAngle<T>, turning: T) {
        let base = self.base();
        let lap = &mut *self.lap;
        lap.note_slip(node.path);
        lap.instant_of_gap_root(base, node);
        add_row(&mut lap.rows.angle, turning, &lap.rows.instant);
        self.limit_kink(node, half.e, -T::ONE);
    }

    /// Kink at a root of the gap function in slip: the derivatives of the tractions jump by ± L' e and ± L'' e.
    fn limit_kink(&mut self, node: &Node<T>, e: [T; 2], sign: T) {
        let base = self.base();
        let rates = [node.limit_rate, node.limit_bend].map(|x| sign * x);
        let jumps = rates.map(|x| e.map(|e| x * e));
        self.kink(node, jumps, |lap, out| {
            let mut weights = [SignalWeights::NONE; 2];
            (weights[0].limit_rate, weights[1].limit_bend) = (T::ONE, T::ONE);
            let moved = [node.limit_bend, node.limit_jerk];
            let outs = [&mut out.jump, &mut out.bend];
            for (k, out) in outs.into_iter().enumerate() {
                lap.sliding.clone_from(&lap.rows.instant);
                scale(&mut lap.sliding, moved[k]);
                add_signals(base, &mut lap.sliding, Basis::Event(&lap.row), weights[k]);
                lap.turning_row(out, e, [rates[k], sign]);
            }
        });
    }

    /// The first two derivatives of the tractions jump by `jumps` at an event, whose basis row is `row` of the lap and whose phase
    /// has the row `instant`; `jump_rows` writes the derivatives of the jumps.
    fn kink(
        &mut self,
        node: &Node<T>,
        [jump, bend]: [[T; 2]; 2],
        jump_rows: impl FnOnce(&mut Lap<T>, &mut KinkRows<T>),
    ) {
        let theta = node.theta;
        let kink = Kink {
            theta,
            cell: self.lap.cell,
            jump,
            bend,
        };
        self.lap.kinks.push(kink);
        let Some(blocks) = &mut self.target else {
            return;
        };
        jump_rows(self.lap, &mut blocks.kink);
        let (row, instant) = (&self.lap.row, &self.lap.rows.instant);
        kink.add_tangent(self.simd, self.course.plan, blocks, row, instant);
    }

    /// The slider and its rows at the end of the lap; `open` says whether the contact is open there.
    pub(super) fn end_lap(&mut self, motion: ClosedMotion<T>, open: bool) -> [T; 2] {
        let base = self.base();
        let node = self.course.sample(base.plan.n_time());
        if open {
            for (d, slider) in self.lap.rows.slider.iter_mut().enumerate() {
                slider.fill([T::ZERO; CHUNK]);
                let mut weights = SignalWeights::NONE;
                weights.path[d] = T::ONE;
                add_signals(base, slider, Basis::Sample(0), weights);
            }
            return node.path;
        }
        match motion {
            ClosedMotion::Stick(slider) => slider,
            ClosedMotion::Slip(half) => {
                self.lap.rows.instant.fill([T::ZERO; CHUNK]);
                let slider = self.stop(&node, half);
                self.lap.note_slip(slider);
                slider
            }
        }
    }
}

impl<T: Real> Lap<T> {
    /// Row of the phase of a root of the gap function.
    fn instant_of_gap_root(&mut self, base: Base<T>, node: &Node<T>) {
        let instant = &mut self.rows.instant;
        instant.fill([T::ZERO; CHUNK]);
        if node.limit_rate != T::ZERO {
            let weights = SignalWeights {
                limit: -(T::ONE / node.limit_rate),
                ..SignalWeights::NONE
            };
            add_signals(base, instant, Basis::Event(&self.row), weights);
        }
    }

    /// Row of λ = e·s' − L' at a fixed phase, into `sliding`.
    fn sliding_row(&mut self, base: Base<T>, node: &Node<T>, e: [T; 2]) {
        self.sliding.clone_from(&self.rows.angle);
        scale(&mut self.sliding, dot(normal(e), node.rate));
        let weights = SignalWeights {
            rate: e,
            limit_rate: -T::ONE,
            ..SignalWeights::NONE
        };
        add_signals(base, &mut self.sliding, Basis::Event(&self.row), weights);
    }

    /// Row of e·s'' − L'', into `sliding`.
    fn bending_row(&mut self, base: Base<T>, node: &Node<T>, e: [T; 2]) {
        self.sliding.clone_from(&self.rows.angle);
        scale(&mut self.sliding, dot(normal(e), node.bend));
        let moved = dot(e, node.jerk) - node.limit_jerk;
        add_row(&mut self.sliding, moved, &self.rows.instant);
        let weights = SignalWeights {
            bend: e,
            limit_bend: -T::ONE,
            ..SignalWeights::NONE
        };
        add_signals(base, &mut self.sliding, Basis::Event(&self.row), weights);
    }

    /// Rows of `size` e, where e turns with the traction and `size` has `sign` times the row `sliding`.
    fn turning_row(&self, out: &mut [Row<T>; 2], e: [T; 2], [size, sign]: [T; 2]) {
        for ((row, e), p) in out.iter_mut().zip(e).zip(normal(e)) {
            let (grown, turned) = (sign * e, size * p);
            set_rows(
                row,
                [&self.sliding, &self.rows.angle],
                |_, by_size, angle| grown * by_size + turned * angle,
            );
        }
    }
}
