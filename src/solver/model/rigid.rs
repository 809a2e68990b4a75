//! Total mass and rigid-body modes of a free structure: the first numbers to compare with the program that made it.
//!
//! Which motions they are follows from names `node.component` of the degrees of freedom; other names say nothing.

use std::fmt;

use faer::Mat;

use super::lower_triangle::{parts, unsigned_energy};
use super::matrix_checks::rounding;
use crate::file::significant_digits;

/// Part of the energy of a mode's displacements, taken without their signs, below which its frequency is zero up to round-off.
const RIGID: f64 = 1e-12;
/// Largest part of the kinetic energy of a translation that is in no rigid-body mode, if the structure can translate so.
const NOT_RIGID: f64 = 1e-3;
/// Digits from which numbers count as not rounded: fewer tell most doubles from each other.
const ALL_DIGITS: u32 = 16;

/// Rigid-body modes, and which motions they are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RigidModes {
    /// Number of modes.
    pub count: usize,
    /// How many parts of the structure can move along x, y and z, where names tell the directions.
    pub translations: Option<[usize; 3]>,
}

impl fmt::Display for RigidModes {
    /// `6 rigid-body modes: translations x, y, z; 3 rotations`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ending = if self.count == 1 { "" } else { "s" };
        write!(f, "{} rigid-body mode{ending}", self.count)?;
        let Some(along) = self.translations.filter(|_| self.count > 0) else {
            return Ok(());
        };
        let others = self.count.saturating_sub(along.iter().sum());
        let word = |(parts, axis): (&usize, &str)| match parts {
            0 => None,
            1 => Some(axis.to_owned()),
            parts => Some(format!("{parts} along {axis}")),
        };
        let words: Vec<_> = along.iter().zip(["x", "y", "z"]).filter_map(word).collect();
        // a part that can move in every direction can also turn
        let free = along == [along[0]; 3] && others == 3 * along[0];
        let others = match (others, free) {
            (0, _) => None,
            (n, true) => Some(format!("{n} rotations")),
            (1, false) => Some("1 other (a rotation or a mechanism)".to_owned()),
            (n, false) => Some(format!("{n} others (rotations or mechanisms)")),
        };
        let words = (!words.is_empty()).then(|| format!("translations {}", words.join(", ")));
        let kinds: Vec<_> = words.into_iter().chain(others).collect();
        write!(f, ": {}", kinds.join("; "))
    }
}

/// Axis (0, 1, 2) of each degree of freedom that is a displacement: the name `node.1` is one along x, `node.2` along y,
/// `node.3` along z, with a node > 0.
pub fn axes(names: impl Iterator<Item = String>) -> Vec<Option<usize>> {
    let axis = |name: String| {
        let (node, component) = name.rsplit_once('.')?;
        node.parse::<i64>().ok().filter(|node| *node > 0)?;
        ["1", "2", "3"].iter().position(|known| *known == component)
    };
    names.map(axis).collect()
}

/// r'Mr of the unit displacement along x, y and z; nothing if no degree of freedom is one.
///
/// `mass` are the entries (row, column, value) of the lower triangle; `axes` has one element per row.
pub fn total_mass(
    mass: impl Iterator<Item = (usize, usize, f64)>,
    axes: &[Option<usize>],
) -> Option<[f64; 3]> {
    axes.iter().any(Option::is_some).then(|| {
        let mut total = [0.0; 3];
        for (row, column, value) in mass {
            if let (Some(a), Some(b)) = (axes[row], axes[column])
                && a == b
            {
                total[a] += if row == column { value } else { 2.0 * value };
            }
        }
        total
    })
}

/// Entries (row, column, value) of the lower triangles of a structure.
pub struct Triangles<S, M> {
    /// Of K.
    pub stiffness: S,
    /// Most significant digits of a number of K.
    pub digits: u32,
    /// Of M.
    pub mass: M,
}

impl<S, M, E, F> Triangles<S, M>
where
    S: Fn() -> E,
    M: Fn() -> F,
    E: Iterator<Item = (usize, usize, f64)>,
    F: Iterator<Item = (usize, usize, f64)>,
{
    /// The rigid-body modes among modes λ, Φ with Φ'MΦ = I, λ ascending; Φ n × (at least as many as λ).
    ///
    /// A mode is one if λ is not above what round-off and the rounding of K to its digits explain:
    /// λ ≤ (1e-12 + rounding) Σ |φ_i| |K_ij| |φ_j|.
    pub fn rigid_modes(
        &self,
        lambda: &[f64],
        shapes: &Mat<f64>,
        axes: &[Option<usize>],
    ) -> RigidModes {
        let share = RIGID + rounding(self.digits);
        let is_rigid = |mode: &usize| {
            let energy = unsigned_energy((self.stiffness)(), |i| shapes[(i, *mode)]);
            lambda[*mode] <= share * energy
        };
        let count = (0..lambda.len()).take_while(is_rigid).count();
        let known = count > 0 && axes.iter().any(Option::is_some);
        RigidModes {
            count,
            translations: known
                .then(|| self.translations(&shapes.subcols(0, count).to_owned(), axes)),
        }
    }

    /// How many parts can move along each axis: the unit displacement of a part is then a combination of rigid-body modes.
    fn translations(&self, rigid: &Mat<f64>, axes: &[Option<usize>]) -> [usize; 3] {
        let entries = (self.stiffness)().chain((self.mass)());
        let parts = parts(rigid.nrows(), entries);
        let n = parts.len();
        [0, 1, 2].map(|axis| {
            let along: Vec<bool> = axes.iter().map(|a| *a == Some(axis)).collect();
            // momentum M r; M couples no two parts
            let mut momentum = vec![0.0; n];
            for (row, column, value) in (self.mass)() {
                momentum[row] += if along[column] { value } else { 0.0 };
                if row != column {
                    momentum[column] += if along[row] { value } else { 0.0 };
                }
            }
            let of_parts = |weight: &dyn Fn(usize) -> f64| {
                let mut sums = vec![0.0; n];
                (0..n).for_each(|i| sums[parts[i]] += weight(i) * momentum[i]);
                sums
            };
            let mut missing = of_parts(&|i| f64::from(u8::from(along[i])));
            let energy = missing.clone();
            for mode in 0..rigid.ncols() {
                let shares = of_parts(&|i| rigid[(i, mode)]);
                missing
                    .iter_mut()
                    .zip(shares)
                    .for_each(|(left, share)| *left -= share * share);
            }
            let moves = |(left, energy): &(f64, f64)| *energy > 0.0 && *left <= NOT_RIGID * energy;
            missing.into_iter().zip(energy).filter(moves).count()
        })
    }
}

/// Most significant digits that a number needs to be told from others, at most 17: how exactly a matrix that was read states
/// them.
pub fn digits(values: impl Iterator<Item = (usize, usize, f64)>) -> u32 {
    let mut most = 0;
    for (.., value) in values {
        most = most.max(significant_digits(&format!("{value:e}")));
        if most >= ALL_DIGITS {
            break;
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::symmetric_generalized_eigen;
    use crate::model::lower_triangle::lower;

    /// The modes of springs (between two rows, or one row and the ground) with unit masses.
    fn modes(names: &[&str], springs: &[(usize, usize, f64)]) -> String {
        let n = names.len();
        let mut k = Mat::<f64>::zeros(n, n);
        for &(i, j, spring) in springs {
            k[(i, i)] += spring;
            if i != j {
                k[(j, j)] += spring;
                k[(i, j)] -= spring;
                k[(j, i)] -= spring;
            }
        }
        let mass = Mat::<f64>::identity(n, n);
        let (lambda, shapes) = symmetric_generalized_eigen(k.as_ref(), mass.as_ref()).unwrap();
        let triangles = Triangles {
            stiffness: || lower(&k),
            digits: digits(lower(&k)),
            mass: || lower(&mass),
        };
        let axes = axes(names.iter().map(|name| (*name).to_owned()));
        triangles.rigid_modes(&lambda, &shapes, &axes).to_string()
    }

    /// Two nodes in the plane joined along x and free of each other along y; one of them held; without names.
    ///
    /// Seen to fail with translations of the whole structure instead of its parts.
    #[test]
    fn motions_have_names() {
        let names = ["1.1", "1.2", "2.1", "2.2"];
        let joined = [(0, 2, 5.0), (1, 3, 3.0)];
        assert_eq!(
            modes(&names, &joined),
            "2 rigid-body modes: translations x, y"
        );
        let along_x = [(0, 2, 5.0)];
        assert_eq!(
            modes(&names, &along_x),
            "3 rigid-body modes: translations x, 2 along y"
        );
        let grounded = [(0, 2, 5.0), (0, 0, 1.0), (1, 3, 3.0)];
        assert_eq!(
            modes(&names, &grounded),
            "1 rigid-body mode: translations y"
        );
        let held = [(0, 0, 5.0), (1, 1, 1.0), (2, 2, 3.0), (3, 3, 3.0)];
        assert_eq!(modes(&names, &held), "0 rigid-body modes");
        let turning = ["1.1", "1.4", "2.1", "2.4"];
        assert_eq!(
            modes(&turning, &joined),
            "2 rigid-body modes: translations x; 1 other (a rotation or a mechanism)"
        );
        assert_eq!(modes(&["a", "b", "c", "d"], &joined), "2 rigid-body modes");
    }

    /// A spring of 1/3 N/m that was rounded to six digits at one end is one of nearly 1e-6 to the ground: no frequency; with
    /// all digits it is one. Seen to fail without the rounding of the file.
    #[test]
    fn rounding_is_no_frequency() {
        let rounded = Mat::from_fn(2, 2, |i, j| match (i, j) {
            (0, 0) => 0.333333,
            (1, 1) => 0.333334,
            _ => -0.333333,
        });
        let mass = Mat::<f64>::identity(2, 2);
        let (lambda, shapes) =
            symmetric_generalized_eigen(rounded.as_ref(), mass.as_ref()).unwrap();
        let count = |digits: u32| {
            let triangles = Triangles {
                stiffness: || lower(&rounded),
                digits,
                mass: || lower(&mass),
            };
            triangles.rigid_modes(&lambda, &shapes, &[None, None]).count
        };
        assert_eq!(digits(lower(&rounded)), 6);
        assert_eq!([count(6), count(17)], [1, 0]);
    }
}
