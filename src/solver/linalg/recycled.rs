//! Conjugate residuals in single precision, for a row of systems that differ little from each other.
//!
//! Solves P A x = P b with a fixed P ≈ A⁻¹ by [`super::gcr`]'s method. What P misses are a few directions: those of the system
//! before are kept, Z with orthonormal products Q, and precondition the next: v is replaced by Z Qᵀv + (v − Q Qᵀv). If A
//! has not changed, these directions need no product any more. Source: Parks et al. 2006, SIAM J. Sci. Comput. 28, 1651–1674.

use super::vector::{axpy, single_dot};
use pulp::{Arch, Simd, WithSimd};

/// Most directions that are kept for the next system.
const MOST_KEPT: usize = 24;
/// Share of an old product that the new ones must leave for its direction to be kept.
const WORTH_KEEPING: f32 = 0.05;
/// Share of a product that the others must leave for its remainder to be orthogonal to them.
const CANCELLED: f32 = 0.5;
/// Share of a product below which its remainder is round-off.
const ROUND_OFF: f32 = 1e-6;

/// Directions Z and their orthonormal products Q.
#[derive(Debug, Default)]
struct Directions {
    z: Vec<Vec<f32>>,
    q: Vec<Vec<f32>>,
}

/// The directions of one system, and those of the systems before.
#[derive(Debug, Default)]
pub struct RecycledSpace {
    old: Directions,
    new: Directions,
    /// Products with P A so far.
    pub products: usize,
}

impl RecycledSpace {
    /// The space for the next system.
    pub fn next_system(&mut self) {
        let old = std::mem::take(&mut self.old);
        let mut kept = std::mem::take(&mut self.new);
        for (mut z, mut q) in old.z.into_iter().zip(old.q) {
            if kept.z.len() >= MOST_KEPT {
                break;
            }
            kept.take(0, -1.0, &mut q, &mut z);
            let left = norm(&q);
            if left > WORTH_KEEPING {
                kept.push(z, q, left);
            }
        }
        self.old = kept;
    }

    /// x with ‖b − P A x‖ ≤ goal for each of the `b`, already multiplied by P, by at most `most` rounds of products; `product`
    /// gives P A v of several v. None if they do not suffice.
    pub fn solve(
        &mut self,
        product: impl Fn(&[Vec<f32>]) -> Vec<Vec<f32>>,
        b: Vec<Vec<f32>>,
        goals: &[f32],
        most: usize,
    ) -> Option<Vec<Vec<f32>>> {
        let mut x: Vec<Vec<f32>> = b.iter().map(|b| vec![0.0; b.len()]).collect();
        let mut left = b;
        let mut from = 0;
        for _ in 0..=most {
            for (left, x) in left.iter_mut().zip(&mut x) {
                self.new.take(from, 1.0, left, x);
            }
            let is_open = |left: &[f32], goal: f32| {
                let left = norm(left);
                left.is_nan() || left > goal
            };
            let open = (left.iter().zip(goals)).filter(|(left, goal)| is_open(left, **goal));
            let directions: Vec<Vec<f32>> = open.map(|(left, _)| self.direction(left)).collect();
            if directions.is_empty() {
                return Some(x);
            }
            from = self.new.z.len();
            let products = product(&directions);
            self.products += products.len();
            for (z, q) in directions.into_iter().zip(products) {
                self.new.add(z, q);
            }
            if self.new.z.len() == from {
                return None;
            }
        }
        None
    }

    /// `v` preconditioned by the directions of the systems before.
    fn direction(&self, v: &[f32]) -> Vec<f32> {
        let (mut left, mut z) = (v.to_vec(), vec![0.0; v.len()]);
        self.old.take(0, 1.0, &mut left, &mut z);
        (z.iter_mut().zip(left)).for_each(|(z, left)| *z += left);
        z
    }
}

impl Directions {
    /// v −= Q Qᵀv, x += `sign` Z Qᵀv, with the directions from number `from`.
    fn take(&self, from: usize, sign: f32, v: &mut [f32], x: &mut [f32]) {
        Arch::new().dispatch(Take {
            z: &self.z[from..],
            q: &self.q[from..],
            sign,
            v,
            x,
        });
    }

    fn push(&mut self, mut z: Vec<f32>, mut q: Vec<f32>, length: f32) {
        for x in z.iter_mut().chain(&mut q) {
            *x /= length;
        }
        self.z.push(z);
        self.q.push(q);
    }

    /// Adds a direction z with its product, unless the others leave nothing of that.
    fn add(&mut self, mut z: Vec<f32>, mut q: Vec<f32>) {
        let whole = norm(&q);
        self.take(0, -1.0, &mut q, &mut z);
        let mut left = norm(&q);
        if left < CANCELLED * whole {
            self.take(0, -1.0, &mut q, &mut z);
            left = norm(&q);
        }
        if left > ROUND_OFF * whole {
            self.push(z, q, left);
        }
    }
}

/// ‖v‖₂.
#[must_use]
pub fn norm(v: &[f32]) -> f32 {
    Arch::new().dispatch(Norm(v))
}

struct Norm<'a>(&'a [f32]);

impl WithSimd for Norm<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f32 {
        single_dot(self.0, self.0).sqrt()
    }
}

/// The arguments of [`Directions::take`], for the instruction set that is found at run time.
struct Take<'a> {
    z: &'a [Vec<f32>],
    q: &'a [Vec<f32>],
    sign: f32,
    v: &'a mut [f32],
    x: &'a mut [f32],
}

impl WithSimd for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        // loops: a closure would not be compiled for the instruction set
        let mut lengths = Vec::with_capacity(self.q.len());
        for q in self.q {
            lengths.push(single_dot(q, self.v));
        }
        for ((length, q), z) in lengths.iter().zip(self.q).zip(self.z) {
            axpy(-length, q, self.v);
            axpy(self.sign * length, z, self.x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 90;

    /// The identity with a dense disturbance of rank six, `turn` times as strong.
    fn times(turn: f32, v: &[f32]) -> Vec<f32> {
        let shape = |k: usize, i: usize| ((k + 1) as f32 * i as f32 * 0.37).sin();
        let mut out = v.to_vec();
        for k in 0..6 {
            let along: f32 = (0..N).map(|i| shape(k, i) * v[i]).sum();
            for (i, out) in out.iter_mut().enumerate() {
                *out += turn * 0.3 * along * shape((k + 1) % 6, i);
            }
        }
        out
    }

    /// Two right-hand sides together, of a system and of one that differs from it by a hundredth: solved to the goal, and the
    /// second takes fewer products. Seen to fail with the second system's space empty and with x taken without its sign.
    #[test]
    fn close_systems_share_their_directions() {
        let b: Vec<Vec<f32>> = [0.3f32, 0.7]
            .iter()
            .map(|f| (0..N).map(|i| (f * i as f32).cos() + 0.5).collect())
            .collect();
        let goals = [1e-4 * norm(&b[0]), 1e-4 * norm(&b[1])];
        let mut space = RecycledSpace::default();
        let mut spent = Vec::new();
        for turn in [1.0, 1.01] {
            space.next_system();
            let before = space.products;
            let product = |v: &[Vec<f32>]| v.iter().map(|v| times(turn, v)).collect();
            let x = space.solve(product, b.clone(), &goals, 40).unwrap();
            spent.push(space.products - before);
            for (x, b) in x.iter().zip(&b) {
                let left: Vec<f32> = times(turn, x).iter().zip(b).map(|(p, b)| b - p).collect();
                assert!(norm(&left) < 2e-4 * norm(b), "{}", norm(&left) / norm(b));
            }
        }
        assert!(spent[1] < spent[0], "{spent:?}");
    }
}
