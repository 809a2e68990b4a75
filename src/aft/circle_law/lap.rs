//! A lap of the slider of the circle law with located events, and its derivative.
//!
//! The tractions at the samples make up the forces, with one term per event: a sum over samples misses of a kink of the
//! integrand, by J in its slope at the share x of a step h, −½ h² B₂(x) J (Euler and Maclaurin; B₂ = x² − x + 1/6).

use super::course::{Course, Node, slip_step};
use super::sensitivity::{
    Base, Basis, Blocks, Mix, Row, Rows, add_mix, add_row, add_step, scale, set_rows,
};
use super::slip::HalfAngle;
use crate::aft::plan::{AftPlan, CHUNK};
use crate::aft::signals::breakpoints::{basis_row, first_sample_from};
use crate::aft::vector::{dot, normal};
use crate::contact::Real;
use pulp::Simd;
use std::f64::consts::TAU;

/// Events between two samples at the most; more are round-off, which lets slip begin and end at one instant for ever.
const MOST_EVENTS: usize = 16;

/// What a closed contact does.
#[derive(Debug, Clone, Copy)]
enum Motion<T> {
    /// The slider (N) rests.
    Stick([T; 2]),
    Slip(HalfAngle<T>),
}

/// A jump of the slope of the tractions.
#[derive(Debug, Clone, Copy)]
struct Kink<T> {
    theta: T,
    jump: [T; 2],
}

/// What a lap leaves behind.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Lap<T> {
    /// Tractions at the samples (N). Shape: `[time]`.
    pub tractions: Vec<[T; 2]>,
    kinks: Vec<Kink<T>>,
    /// Samples that slip.
    pub slip: u32,
    /// Whether anything moved the slider.
    pub moved: bool,
    /// Longest way of the slider in one slip (N); infinite where the contact opens.
    pub way: T,
    pub rows: Rows<T>,
    /// Basis rows at the last event and at the one that is looked for.
    row: Vec<T>,
    next_row: Vec<T>,
    /// Row under construction.
    sliding: Row<T>,
    /// Where the present slip began.
    slider: [T; 2],
    /// First sample of the present stick.
    stick_from: Option<usize>,
}

/// A lap in progress; `target` takes the derivatives.
pub(in crate::aft) struct Walk<'a, S, T> {
    pub simd: S,
    pub course: Course<'a, T>,
    pub lap: &'a mut Lap<T>,
    pub target: Option<&'a mut Blocks<T>>,
}

impl<T: Real> Lap<T> {
    /// Adds what the kinks contribute to the traction coefficients. Shape: `force` `[2][m]`.
    pub(in crate::aft) fn add_kinks(&mut self, plan: &AftPlan<T>, force: &mut [T]) {
        for kink in &self.kinks {
            let weight = kink_weights(plan, kink.theta)[0];
            self.row.resize(plan.m, T::ONE);
            basis_row(plan, kink.theta, &mut self.row);
            for (force, jump) in force.chunks_exact_mut(plan.m).zip(kink.jump) {
                for ((force, &b), &w) in force.iter_mut().zip(&self.row).zip(&plan.weight) {
                    *force += w * (weight * jump * b);
                }
            }
        }
    }
}

/// ½ h B₂(x) and its derivative by the phase.
#[inline(always)]
fn kink_weights<T: Real>(plan: &AftPlan<T>, theta: T) -> [T; 2] {
    let n = plan.n_time() as f64;
    let x = (theta.to_f64() * (n / TAU)).fract();
    [
        T::from_f64(0.5 * TAU / n * (x * x - x + 1.0 / 6.0)),
        T::from_f64(x - 0.5),
    ]
}

/// The basis row at a node: that of its sample, or `row` of an event.
#[inline(always)]
fn basis_at<'a, T: Real>(plan: &AftPlan<T>, node: &Node<T>, row: &'a [T]) -> Basis<'a, T> {
    match node.sample {
        Some(i) if i == plan.n_time() => Basis::Sample(0),
        Some(i) => Basis::Sample(i),
        None => Basis::Event(row),
    }
}

impl<'a, S: Simd, T: Real> Walk<'a, S, T> {
    /// The lap from the slider k_t w (N); returns where it ends.
    #[inline(always)]
    pub(in crate::aft) fn go(mut self, slider: [T; 2]) -> [T; 2] {
        let n = self.course.plan.n_time();
        let lap = &mut *self.lap;
        lap.tractions.clear();
        lap.tractions.resize(n, [T::ZERO; 2]);
        lap.kinks.clear();
        (lap.slip, lap.moved, lap.way, lap.stick_from) = (0, false, T::ZERO, None);
        let points = self.course.points;
        // Without friction the slider always is where the surface is.
        let smooth = self.course.p.mu == T::ZERO;
        if smooth {
            self.lap.way = T::from_f64(f64::INFINITY);
            let contact = n - self.course.work.separated[self.course.lane].to_f64() as usize;
            (self.lap.moved, self.lap.slip) = (true, contact as u32);
            return self.rest(Motion::Stick(slider), true);
        }
        let mut here = self.course.sample(0);
        let mut motion = Motion::Stick(slider);
        for (k, point) in points.iter().enumerate() {
            let end = points.get(k + 1).map(|p| p.theta);
            if point.open {
                (self.lap.moved, self.lap.way) = (true, T::from_f64(f64::INFINITY));
                if let Some(theta) = end {
                    (here, motion) = self.close(theta);
                }
                continue;
            }
            if k == 0 {
                motion = self.resume(&here, slider);
            }
            (here, motion) = self.contact(here, motion, end);
        }
        let open = points.last().is_some_and(|last| last.open);
        let slider = self.rest(motion, open);
        if let Some(blocks) = self.target {
            blocks.flush(self.simd, self.course.plan);
        }
        slider
    }

    /// Motion of a contact that is closed at the start of the lap.
    fn resume(&mut self, node: &Node<T>, slider: [T; 2]) -> Motion<T> {
        let t = [node.path[0] - slider[0], node.path[1] - slider[1]];
        let size = dot(t, t).sqrt();
        let margin = self.course.work.touch_margin(self.course.lane);
        let e = t.map(|t| t / size);
        let slides = node.sliding(e) > T::ZERO && size > node.limit - margin && size > T::ZERO;
        let beyond = size > node.limit + margin;
        let mut motion = Motion::Stick(slider);
        if slides || beyond {
            self.lap.moved = true;
            self.turn_towards(node, e, size);
            let half = HalfAngle::of(e);
            let slider = self.stop(node, half);
            self.lap.slider = slider;
            motion = if slides {
                Motion::Slip(half)
            } else {
                Motion::Stick(slider)
            };
        }
        self.keep(0, node, motion);
        motion
    }

    /// Angle and its row of a slider that rested at a fixed phase, for the traction direction `e` and size.
    fn turn_towards(&mut self, node: &Node<T>, e: [T; 2], size: T) {
        let base = self.base();
        let (p, lap) = (normal(e), &mut *self.lap);
        let at = basis_at(base.plan, node, &lap.row);
        let [first, second] = &lap.rows.slider;
        let factors = p.map(|p| p / size);
        set_rows(&mut lap.rows.angle, [first, second], |_, a, b| {
            -(factors[0] * a + factors[1] * b)
        });
        let mix = Mix {
            path: factors,
            ..Mix::NONE
        };
        add_mix(base, &mut lap.rows.angle, at, mix);
        lap.rows.instant.fill([T::ZERO; CHUNK]);
    }

    #[inline(always)]
    fn base(&self) -> Base<'a, T> {
        Base {
            plan: self.course.plan,
            p: self.course.p,
        }
    }

    /// A contact closed from `here` to the phase `end`, where it opens, or to the end of the lap.
    #[inline(always)]
    fn contact(
        &mut self,
        here: Node<T>,
        mut motion: Motion<T>,
        end: Option<T>,
    ) -> (Node<T>, Motion<T>) {
        let course = self.course;
        let n = course.plan.n_time();
        // Samples are not copied: most nodes are samples.
        let (mut event, mut at) = (here, here.sample);
        let mut i = at.map_or_else(
            || first_sample_from(here.theta.to_f64(), n as f64),
            |sample| sample + 1,
        );
        let mut events = 0;
        loop {
            let here = at.map_or(&event, |sample| &course.nodes[sample]);
            let inside = end.is_none_or(|end| i < n && course.phase(i) < end);
            let root;
            let next = match end {
                Some(end) if !inside => {
                    root = course.gap_root(end, &mut self.lap.next_row);
                    &root
                }
                _ => &course.nodes[i],
            };
            match motion {
                Motion::Stick(slider) => {
                    let row = &mut self.lap.next_row;
                    if let Some(start) = course.slip_start([here, next], slider, row) {
                        self.end_stick(i);
                        motion = self.start_slip(&start, slider);
                        (event, at) = (start, None);
                        events += 1;
                        continue;
                    }
                }
                Motion::Slip(half) => {
                    let after = half.after(course.map(here, next));
                    if inside && events < MOST_EVENTS && next.sliding(after.e) <= T::ZERO {
                        let row = &mut self.lap.next_row;
                        let stop = course.slip_end([here, next], half, after, row);
                        motion = self.end_slip([here, &stop], half);
                        (event, at) = (stop, None);
                        events += 1;
                        continue;
                    }
                    let turning = self.slide([here, next], half, after);
                    if !inside {
                        self.open(next, after, turning);
                    }
                    motion = Motion::Slip(after);
                }
            }
            if !inside || i == n {
                self.end_stick(i);
                return (*next, motion);
            }
            self.keep(i, next, motion);
            at = Some(i);
            i += 1;
            events = 0;
        }
    }

    /// Traction of a sample in contact.
    #[inline(always)]
    fn keep(&mut self, i: usize, node: &Node<T>, motion: Motion<T>) {
        match motion {
            Motion::Stick(slider) => {
                let t = [node.path[0] - slider[0], node.path[1] - slider[1]];
                self.lap.tractions[i] = t;
                self.lap.stick_from = self.lap.stick_from.or(Some(i));
            }
            Motion::Slip(half) => {
                let e = half.e;
                self.lap.tractions[i] = e.map(|e| node.limit * e);
                self.lap.slip += 1;
                let base = self.base();
                if let Some(blocks) = &mut self.target {
                    let turned = normal(e).map(|p| node.limit * p);
                    let angle = &self.lap.rows.angle;
                    blocks.slip(self.simd, base, i, (angle, turned), e);
                }
            }
        }
    }

    /// The samples before i that stick.
    fn end_stick(&mut self, i: usize) {
        if let Some(from) = self.lap.stick_from.take()
            && let Some(blocks) = &mut self.target
        {
            let plan = self.course.plan;
            blocks.stick(self.simd, plan, from..i, &self.lap.rows.slider);
        }
    }

    /// Slip from `node` on, whose basis row is in `next_row`, of a slider that rested until then.
    fn start_slip(&mut self, node: &Node<T>, slider: [T; 2]) -> Motion<T> {
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
        (self.lap.moved, self.lap.slider) = (true, slider);
        std::mem::swap(&mut self.lap.row, &mut self.lap.next_row);
        self.turn_towards(node, e, size);
        let lap = &mut *self.lap;
        // e·(ds + s' dθ − dz) = dL + L' dθ.
        let [first, second] = &lap.rows.slider;
        set_rows(&mut lap.rows.instant, [first, second], |_, a, b| {
            inverse * (e[0] * a + e[1] * b)
        });
        let mix = Mix {
            path: e.map(|e| -(inverse * e)),
            limit: inverse,
            ..Mix::NONE
        };
        add_mix(base, &mut lap.rows.instant, Basis::Event(&lap.row), mix);
        let turning = dot(p, node.rate) / size;
        add_row(&mut lap.rows.angle, turning, &lap.rows.instant);
        let jump = e.map(|e| -(sliding * e));
        self.kink(node, jump, |lap, out| {
            lap.sliding_row(base, node, e);
            let moved = dot(e, node.bend) - node.limit_bend;
            add_row(&mut lap.sliding, moved, &lap.rows.instant);
            for (d, row) in out.iter_mut().enumerate() {
                set_rows(row, [&lap.sliding, &lap.rows.angle], |_, dl, angle| {
                    -(e[d] * dl + sliding * p[d] * angle)
                });
            }
        });
        Motion::Slip(HalfAngle::of(e))
    }

    /// Slip from `here` in the direction `half` to the end of slip at `node`, whose basis row is in `next_row`.
    fn end_slip(&mut self, [here, node]: [&Node<T>; 2], half: HalfAngle<T>) -> Motion<T> {
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
        let lap = &mut *self.lap;
        lap.note_way(slider);
        Motion::Stick(slider)
    }

    /// The slider at `node`, and its rows, where slip in the direction `half` ends.
    fn stop(&mut self, node: &Node<T>, half: HalfAngle<T>) -> [T; 2] {
        let base = self.base();
        let e = half.e;
        let p = normal(e);
        let lap = &mut *self.lap;
        let at = basis_at(base.plan, node, &lap.row);
        for (d, slider) in lap.rows.slider.iter_mut().enumerate() {
            let (turned, moved) = (node.limit * p[d], node.rate[d] - e[d] * node.limit_rate);
            let rows: [&[_]; 2] = [&lap.rows.angle, &lap.rows.instant];
            set_rows(slider, rows, |_, angle, instant| {
                moved * instant - turned * angle
            });
            let mut mix = Mix::NONE;
            (mix.path[d], mix.limit) = (T::ONE, -e[d]);
            add_mix(base, slider, at, mix);
        }
        [0, 1].map(|d| node.path[d] - node.limit * e[d])
    }

    /// Row of the angle after a step of slip; returns the derivative of the angle by the phase of the end. An event at
    /// the start moves, one at the end (basis row in `next_row`, then in `row`) does not.
    #[inline(always)]
    fn slide(&mut self, [here, next]: [&Node<T>; 2], half: HalfAngle<T>, after: HalfAngle<T>) -> T {
        let base = self.base();
        let lap = &mut *self.lap;
        let factor = half.angle_rate(self.course.map(here, next), after);
        scale(&mut lap.rows.angle, factor);
        let between_samples = here.sample.is_some() && next.sample.is_some();
        if between_samples && !lap.rows.full {
            return T::ZERO;
        }
        let by = slip_step(here, next).angle_rates(half);
        let (path, rate, length) = (by.path, by.rate, by.length);
        let limit = T::from_f64(0.5) * by.limit;
        let ends = [
            basis_at(base.plan, here, &lap.row),
            basis_at(base.plan, next, &lap.next_row),
        ];
        if let [Basis::Sample(here), Basis::Sample(next)] = ends {
            add_step(base, &mut lap.rows.angle, [here, next], path, rate, limit);
            return T::ZERO;
        }
        let mut mix = Mix {
            path: path.map(|x| -x),
            limit,
            ..Mix::NONE
        };
        add_mix(base, &mut lap.rows.angle, ends[0], mix);
        if here.sample.is_none() {
            let moved = limit * here.limit_rate - dot(path, here.rate) - length;
            add_row(&mut lap.rows.angle, moved, &lap.rows.instant);
        }
        (mix.path, mix.rate) = (path, rate);
        add_mix(base, &mut lap.rows.angle, ends[1], mix);
        if next.sample.is_none() {
            std::mem::swap(&mut lap.row, &mut lap.next_row);
        }
        next.turning(&by)
    }

    /// The contact closes: the slider stood where the surface is, at rest or already sliding.
    fn close(&mut self, theta: T) -> (Node<T>, Motion<T>) {
        let base = self.base();
        let lap = &mut *self.lap;
        let node = self.course.gap_root(theta, &mut lap.row);
        lap.instant_of_gap_root(base, &node);
        let speed = dot(node.rate, node.rate).sqrt();
        if speed <= node.limit_rate {
            for (d, slider) in lap.rows.slider.iter_mut().enumerate() {
                slider.fill([T::ZERO; CHUNK]);
                add_row(slider, node.rate[d], &lap.rows.instant);
                let mut mix = Mix::NONE;
                mix.path[d] = T::ONE;
                add_mix(base, slider, Basis::Event(&lap.row), mix);
            }
            self.kink(&node, node.rate, |lap, out| {
                for (d, row) in out.iter_mut().enumerate() {
                    row.fill([T::ZERO; CHUNK]);
                    add_row(row, node.bend[d], &lap.rows.instant);
                    let mut mix = Mix::NONE;
                    mix.rate[d] = T::ONE;
                    add_mix(base, row, Basis::Event(&lap.row), mix);
                }
            });
            return (node, Motion::Stick(node.path));
        }
        let e = node.rate.map(|v| v / speed);
        let p = normal(e);
        lap.rows.angle.fill([T::ZERO; CHUNK]);
        let turning = dot(p, node.bend) / speed;
        add_row(&mut lap.rows.angle, turning, &lap.rows.instant);
        let mix = Mix {
            rate: p.map(|p| p / speed),
            ..Mix::NONE
        };
        add_mix(base, &mut lap.rows.angle, Basis::Event(&lap.row), mix);
        lap.slider = node.path;
        self.limit_kink(&node, e, T::ONE);
        (node, Motion::Slip(HalfAngle::of(e)))
    }

    /// The contact, which slips in the direction `half`, opens; `turning` is the rate of its angle.
    fn open(&mut self, node: &Node<T>, half: HalfAngle<T>, turning: T) {
        let base = self.base();
        let lap = &mut *self.lap;
        lap.note_way(node.path);
        lap.instant_of_gap_root(base, node);
        add_row(&mut lap.rows.angle, turning, &lap.rows.instant);
        self.limit_kink(node, half.e, -T::ONE);
    }

    /// Kink at a root of the gap function in slip: ± L' e.
    fn limit_kink(&mut self, node: &Node<T>, e: [T; 2], sign: T) {
        let base = self.base();
        let p = normal(e);
        let jump = e.map(|e| sign * node.limit_rate * e);
        self.kink(node, jump, |lap, out| {
            for (d, row) in out.iter_mut().enumerate() {
                let (moved, turned) =
                    (sign * e[d] * node.limit_bend, sign * node.limit_rate * p[d]);
                let rows: [&[_]; 2] = [&lap.rows.instant, &lap.rows.angle];
                set_rows(row, rows, |_, instant, angle| {
                    moved * instant + turned * angle
                });
                let mix = Mix {
                    limit_rate: sign * e[d],
                    ..Mix::NONE
                };
                add_mix(base, row, Basis::Event(&lap.row), mix);
            }
        });
    }

    /// Jump of the slope of the tractions at an event, whose basis row is in `row` and whose phase moves as `instant`;
    /// `jump_rows` writes the derivatives of the jump.
    fn kink(
        &mut self,
        node: &Node<T>,
        jump: [T; 2],
        jump_rows: impl FnOnce(&mut Lap<T>, &mut [Row<T>; 2]),
    ) {
        let plan = self.course.plan;
        let theta = node.theta;
        self.lap.kinks.push(Kink { theta, jump });
        let Some(blocks) = &mut self.target else {
            return;
        };
        let [weight, slope] = kink_weights(plan, theta);
        jump_rows(self.lap, &mut blocks.traction);
        for (row, &jump) in blocks.traction.iter_mut().zip(&jump) {
            scale(row, weight);
            add_row(row, slope * jump, &self.lap.rows.instant);
        }
        blocks.weigh(self.simd, plan, &self.lap.row, [T::ONE, T::ZERO]);
        for (row, &jump) in blocks.traction.iter_mut().zip(&jump) {
            let instant = &self.lap.rows.instant;
            set_rows(row, [instant, instant], |_, instant, _| {
                weight * jump * instant
            });
        }
        blocks.weigh(self.simd, plan, &self.lap.row, [T::ZERO, T::ONE]);
    }

    /// The slider at the end of the lap, and its rows.
    fn rest(&mut self, motion: Motion<T>, open: bool) -> [T; 2] {
        let base = self.base();
        let node = self.course.sample(base.plan.n_time());
        if open {
            for (d, slider) in self.lap.rows.slider.iter_mut().enumerate() {
                slider.fill([T::ZERO; CHUNK]);
                let mut mix = Mix::NONE;
                mix.path[d] = T::ONE;
                add_mix(base, slider, Basis::Sample(0), mix);
            }
            return node.path;
        }
        match motion {
            Motion::Stick(slider) => slider,
            Motion::Slip(half) => {
                self.lap.rows.instant.fill([T::ZERO; CHUNK]);
                let slider = self.stop(&node, half);
                self.lap.note_way(slider);
                slider
            }
        }
    }
}

impl<T: Real> Lap<T> {
    /// The slider, which slipped, has come to `slider`.
    fn note_way(&mut self, slider: [T; 2]) {
        let way = [slider[0] - self.slider[0], slider[1] - self.slider[1]];
        self.way = self.way.or_larger(dot(way, way).sqrt());
    }

    /// Row of the phase of a root of the gap function.
    fn instant_of_gap_root(&mut self, base: Base<T>, node: &Node<T>) {
        let instant = &mut self.rows.instant;
        instant.fill([T::ZERO; CHUNK]);
        if node.limit_rate != T::ZERO {
            let mix = Mix {
                limit: -(T::ONE / node.limit_rate),
                ..Mix::NONE
            };
            add_mix(base, instant, Basis::Event(&self.row), mix);
        }
    }

    /// Row of λ = e·s' − L' at a fixed phase, into `sliding`.
    fn sliding_row(&mut self, base: Base<T>, node: &Node<T>, e: [T; 2]) {
        self.sliding.clone_from(&self.rows.angle);
        scale(&mut self.sliding, dot(normal(e), node.rate));
        let mix = Mix {
            rate: e,
            limit_rate: -T::ONE,
            ..Mix::NONE
        };
        add_mix(base, &mut self.sliding, Basis::Event(&self.row), mix);
    }
}
