//! Nodes between two samples, where the velocity turns around within a step and the traction with it.
//!
//! At the tips of a narrow ellipse far beyond the friction limit one step of slip does not tell where between two samples the
//! traction turns. Such an interval is halved until in each cell the velocity turns little, the contact moves little, or its path is
//! straight ([`Node::turns_around`]). Cells beside each other differ by a factor of two at most.
//!
//! The force coefficients are then sums over cells. With f at the nodes, in units of the interval between samples, a cell of the
//! width d adds ½ d to the weights of its ends. Where the widths d₁ and d₂ meet, the sum has (d₁² − d₂²)/12 f' too much (Euler and
//! Maclaurin); f' is the derivative of the parabola through the three nodes. So cells on which f is smooth leave the sum over the
//! samples as it is, to fourth order.

use super::between::Between;
use super::course::Course;
use super::node::{At, Node};
use crate::aft::signals::polynomial::basis_row;
use crate::contact::Real;
use std::f64::consts::TAU;

/// A cell of the period; it ends where the next one begins.
#[derive(Debug, Clone, Copy)]
struct Cell<T> {
    start: Node<T>,
    /// Number of the sample before it.
    interval: usize,
    /// Width over that of the interval.
    width: f64,
}

/// Search for the nodes of a state.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Cells<T> {
    cells: Vec<Cell<T>>,
    /// Basis row of the present node.
    row: Vec<T>,
}

impl<T: Real> Cells<T> {
    /// Finds the nodes of a state; none where the velocity turns around in no interval.
    #[inline(never)]
    pub(in crate::aft) fn find<'b>(
        &mut self,
        course: Course<T>,
        between: &'b mut Between<T>,
    ) -> Option<&'b Between<T>> {
        let n = course.plan.n_time();
        let turns = |i: usize| turns_around(course, i, [&course.nodes[i], &course.nodes[i + 1]]);
        if course.p.mu == T::ZERO || !(0..n).any(turns) {
            return None;
        }
        self.cells.clear();
        let samples = course.nodes[..n].iter().enumerate();
        self.cells.extend(samples.map(|(interval, &start)| Cell {
            start,
            interval,
            width: 1.0,
        }));
        self.halve(course);
        self.balance(course);
        self.number(course, between);
        self.weigh(between);
        Some(between)
    }

    /// Halves cells until the velocity turns around in none.
    fn halve(&mut self, course: Course<T>) {
        let least = T::EPSILON.sqrt().to_f64() * course.plan.n_time() as f64 / TAU;
        let mut j = 0;
        while let Some(&Cell {
            start,
            interval,
            width,
        }) = self.cells.get(j)
        {
            let next = match self.cells.get(j + 1) {
                Some(next) => next.start,
                None => course.sample(course.plan.n_time()),
            };
            if 0.5 * width >= least && turns_around(course, interval, [&start, &next]) {
                self.split(course, j);
            } else {
                j += 1;
            }
        }
    }

    /// Halves cells that are more than twice as wide as one beside them.
    fn balance(&mut self, course: Course<T>) {
        loop {
            let count = self.cells.len();
            let width = |j: usize| self.cells[j % count].width;
            let is_wide = |j: &usize| {
                let widest = 2.0 * width(j + 1).min(width(j + count - 1));
                width(*j) > widest && is_closed(course, self.cells[*j].interval)
            };
            let Some(wide) = (0..count).find(is_wide) else {
                return;
            };
            self.split(course, wide);
        }
    }

    fn split(&mut self, course: Course<T>, j: usize) {
        let cell = &mut self.cells[j];
        cell.width *= 0.5;
        let length = T::from_f64(cell.width * TAU / course.plan.n_time() as f64);
        let start = course.event_node(cell.start.theta + length, &mut self.row);
        let half = Cell { start, ..*cell };
        self.cells.insert(j + 1, half);
    }

    /// Numbers the nodes and computes their basis rows.
    fn number(&self, course: Course<T>, out: &mut Between<T>) {
        out.nodes.clear();
        out.before.clear();
        for cell in &self.cells {
            match cell.start.at {
                At::Sample(_) => out.before.push(out.nodes.len()),
                _ => out.nodes.push(Node {
                    at: At::Between(out.nodes.len()),
                    ..cell.start
                }),
            }
        }
        out.before.push(out.nodes.len());
        let m = course.plan.m;
        out.rows.clear();
        out.rows.resize(out.nodes.len() * m, T::ONE);
        for (node, row) in out.nodes.iter().zip(out.rows.chunks_exact_mut(m)) {
            basis_row(course.plan, node.theta, row);
        }
    }

    /// Weights of the nodes and what is added to those of the samples.
    fn weigh(&self, out: &mut Between<T>) {
        let count = self.cells.len();
        let mut weights = vec![0.0; count];
        for j in 0..count {
            let (before, next) = ((j + count - 1) % count, (j + 1) % count);
            let [left, right] = [before, j].map(|j| self.cells[j].width);
            weights[j] += 0.5 * (left + right);
            // Beside a cell that cannot be halved widths may differ by more; then the derivative is not known.
            if left != right && left <= 2.0 * right && right <= 2.0 * left {
                let factor = (right - left) / 12.0;
                let (rise, further) = (factor * right / left, factor * left / right);
                weights[before] -= rise;
                weights[j] += rise - further;
                weights[next] += further;
            }
        }
        out.weights.clear();
        out.sample_weights.clear();
        for (cell, weight) in self.cells.iter().zip(weights) {
            match cell.start.at {
                At::Sample(_) => out.sample_weights.push(T::from_f64(weight - 1.0)),
                _ => out.weights.push(T::from_f64(weight)),
            }
        }
    }
}

/// Whether the contact is closed in the whole interval after sample i.
fn is_closed<T: Real>(course: Course<T>, i: usize) -> bool {
    let [here, next] = [&course.nodes[i], &course.nodes[i + 1]];
    let is_root_between = || {
        let mut points = course.points.iter();
        points.any(|p| p.theta > here.theta && p.theta < next.theta)
    };
    here.limit > T::ZERO && next.limit > T::ZERO && !is_root_between()
}

/// Whether the velocity turns around in a step within the interval after sample i, in which the contact is closed.
fn turns_around<T: Real>(course: Course<T>, i: usize, [here, next]: [&Node<T>; 2]) -> bool {
    here.turns_around(next) && is_closed(course, i)
}
