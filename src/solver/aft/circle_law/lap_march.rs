//! One lap: from sample to sample, and from event to event between them.

use super::lap::{ClosedMotion, LapMarch};
use super::node::{At, Node};
use super::sensitivity::{Basis, SignalWeights, add_signals, set_rows};
use super::slip::HalfAngle;
use crate::aft::vector::normal;
use crate::contact::Real;
use pulp::Simd;

/// Most events between two samples; more are rounding, which lets slip begin and end at one phase for ever.
const MOST_EVENTS: usize = 16;

/// What is at the end of a step between two nodes.
enum Step<T> {
    /// An event before the second node, and the motion after it.
    Event(Node<T>, ClosedMotion<T>),
    /// The second node, and the motion there.
    Whole(ClosedMotion<T>),
}

impl<S: Simd, T: Real> LapMarch<'_, S, T> {
    /// The lap from the slider k_t w (N); returns the slider at its end.
    #[inline(always)]
    pub(in crate::aft) fn go(mut self, slider: [T; 2]) -> [T; 2] {
        let n = self.course.plan.n_time();
        let lap = &mut *self.lap;
        lap.tractions.clear();
        lap.tractions.resize(n, [T::ZERO; 2]);
        lap.kinks.clear();
        lap.between.clear();
        lap.cell = None;
        (lap.slip, lap.moved, lap.longest_slip, lap.stick_from) = (0, false, T::ZERO, None);
        let points = self.course.points;
        // Without friction the slider follows the surface all the time.
        let smooth = self.course.p.mu == T::ZERO;
        if smooth {
            self.lap.longest_slip = T::from_f64(f64::INFINITY);
            let contact = n - self.course.work.separated[self.course.lane].to_f64() as usize;
            (self.lap.moved, self.lap.slip) = (true, contact as u32);
            return self.end_lap(ClosedMotion::Stick(slider), true);
        }
        let mut here = self.course.sample(0);
        let mut motion = ClosedMotion::Stick(slider);
        for (k, point) in points.iter().enumerate() {
            let end = points.get(k + 1).map(|p| p.theta);
            if point.open {
                (self.lap.moved, self.lap.longest_slip) = (true, T::from_f64(f64::INFINITY));
                if let Some(theta) = end {
                    (here, motion) = self.close(theta);
                }
                continue;
            }
            if k == 0 {
                motion = self.resume(&here, slider);
                self.keep(0, &here, motion);
            }
            (here, motion) = self.contact(here, motion, end);
        }
        let open = points.last().is_some_and(|last| last.open);
        let slider = self.end_lap(motion, open);
        if let Some(blocks) = self.target {
            blocks.flush(self.simd, self.course.plan);
        }
        slider
    }

    /// The contact is closed from `here` to the phase `end`, where it opens, or to the end of the lap.
    #[inline(always)]
    fn contact(
        &mut self,
        here: Node<T>,
        mut motion: ClosedMotion<T>,
        end: Option<T>,
    ) -> (Node<T>, ClosedMotion<T>) {
        let course = self.course;
        let n = course.plan.n_time();
        // Samples are not copied: most nodes are samples.
        let (mut event, mut at) = (here, here.at);
        let (mut i, mut k) = course.after(&here);
        let mut events = 0;
        loop {
            let here = course.node(at).unwrap_or(&event);
            self.lap.cell = course.cell(i, k);
            let finer = course.between.filter(|between| k < between.before[i]);
            let inside = end.is_none_or(|end| i < n && course.phase(i) < end);
            let root;
            let next = match (finer, end) {
                (Some(between), _) => &between.nodes[k],
                (None, Some(end)) if !inside => {
                    root = course.gap_root(end, &mut self.lap.next_row);
                    &root
                }
                _ => &course.nodes[i],
            };
            let step = match motion {
                ClosedMotion::Stick(slider) => self.stick_step([here, next], slider, i),
                ClosedMotion::Slip(half) => {
                    self.slip_step([here, next], half, inside, events < MOST_EVENTS)
                }
            };
            match step {
                Step::Event(node, after) => {
                    (event, at, motion) = (node, At::Event, after);
                    events += 1;
                    continue;
                }
                Step::Whole(after) => motion = after,
            }
            if finer.is_some() {
                self.keep_between(k, next, motion);
                (at, events) = (next.at, 0);
                k += 1;
                continue;
            }
            if !inside || i == n {
                self.end_stick(i);
                return (*next, motion);
            }
            self.keep(i, next, motion);
            at = At::Sample(i);
            i += 1;
            events = 0;
        }
    }

    /// A step of a contact that sticks at its start; i is the first sample at or after its end.
    #[inline(always)]
    fn stick_step(&mut self, [here, next]: [&Node<T>; 2], slider: [T; 2], i: usize) -> Step<T> {
        let row = &mut self.lap.next_row;
        match self.course.slip_start([here, next], slider, row) {
            Some(start) => {
                self.end_stick(i);
                let motion = self.start_slip(&start, slider);
                Step::Event(start, motion)
            }
            None => Step::Whole(ClosedMotion::Stick(slider)),
        }
    }

    /// A step of a contact that slips at its start, in the direction `half`. If it is not `inside` the closed stretch, the contact
    /// opens at its end; `may_stop` allows slip to end before.
    #[inline(always)]
    fn slip_step(
        &mut self,
        [here, next]: [&Node<T>; 2],
        half: HalfAngle<T>,
        inside: bool,
        may_stop: bool,
    ) -> Step<T> {
        let course = self.course;
        let after = half.after(course.map(here, next));
        if inside && may_stop && next.sliding(after.e) <= T::ZERO {
            let row = &mut self.lap.next_row;
            let stop = course.slip_end([here, next], half, after, row);
            let motion = self.end_slip([here, &stop], half);
            return Step::Event(stop, motion);
        }
        let turning = self.slide([here, next], half, after);
        if !inside {
            self.open(next, after, turning);
        }
        Step::Whole(ClosedMotion::Slip(after))
    }

    /// Traction of sample i, which is in contact.
    #[inline(always)]
    fn keep(&mut self, i: usize, node: &Node<T>, motion: ClosedMotion<T>) {
        match motion {
            ClosedMotion::Stick(slider) => {
                let t = [node.path[0] - slider[0], node.path[1] - slider[1]];
                self.lap.tractions[i] = t;
                self.lap.stick_from = self.lap.stick_from.or(Some(i));
            }
            ClosedMotion::Slip(half) => {
                let e = half.e;
                self.lap.tractions[i] = e.map(|e| node.limit * e);
                self.lap.slip += 1;
                let base = self.base();
                if let Some(blocks) = &mut self.target {
                    let turned = normal(e).map(|p| node.limit * p);
                    let angle = &self.lap.rows.angle;
                    blocks.slip(self.simd, base, i, angle, turned, e);
                }
            }
        }
        if let Some(between) = self.course.between
            && between.sample_weights[i] != T::ZERO
        {
            let weight = between.sample_weights[i];
            let traction = &mut self.lap.tractions[i];
            *traction = traction.map(|t| t + weight * t);
            self.weigh(node, motion, weight);
        }
    }

    /// Traction of node k between samples.
    #[inline(never)]
    fn keep_between(&mut self, k: usize, node: &Node<T>, motion: ClosedMotion<T>) {
        let weight = self.course.between.map_or(T::ZERO, |b| b.weights[k]);
        let traction = match motion {
            ClosedMotion::Stick(slider) => [0, 1].map(|d| node.path[d] - slider[d]),
            ClosedMotion::Slip(half) => half.e.map(|e| node.limit * e),
        };
        self.lap.between.push(traction.map(|t| weight * t));
        self.weigh(node, motion, weight);
    }

    /// Adds the derivatives of the traction at a node, times `weight`.
    #[inline(never)]
    fn weigh(&mut self, node: &Node<T>, motion: ClosedMotion<T>, weight: T) {
        let (base, course) = (self.base(), self.course);
        let Some(blocks) = &mut self.target else {
            return;
        };
        let at = course.basis(node, &[]);
        for d in 0..2 {
            let row = &mut blocks.traction[d];
            let mut weights = SignalWeights::NONE;
            match motion {
                ClosedMotion::Stick(_) => {
                    let slider = &self.lap.rows.slider[d];
                    set_rows(row, [slider, slider], |_, z, _| -z);
                    weights.path[d] = T::ONE;
                }
                ClosedMotion::Slip(half) => {
                    let turned = node.limit * normal(half.e)[d];
                    let angle = &self.lap.rows.angle;
                    set_rows(row, [angle, angle], |_, angle, _| turned * angle);
                    weights.limit = half.e[d];
                }
            }
            add_signals(base, row, at, weights);
        }
        let b = match at {
            Basis::Sample(i) => course.plan.row(i),
            Basis::Event(row) => row,
        };
        let factors = [weight, T::ZERO, T::ZERO];
        blocks.weigh(self.simd, course.plan, b, factors);
    }

    /// Stick ends before sample i: adds the derivatives of all samples of this stick.
    fn end_stick(&mut self, i: usize) {
        if let Some(from) = self.lap.stick_from.take()
            && let Some(blocks) = &mut self.target
        {
            let plan = self.course.plan;
            blocks.stick(self.simd, plan, from..i, &self.lap.rows.slider);
        }
    }
}
