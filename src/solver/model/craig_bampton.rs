//! Component mode synthesis with fixed interfaces.
//!
//! u = T Ψ q with q = (masters, modal coordinates): Ψ = [ I 0 ; −K_ii⁻¹ K_ib Φ_i ] in coordinates among which the masters
//! are ([`super::masters`]). A master is a displacement, or a linear form such as the mean displacement of a contact cell.
//! Source: Craig & Bampton 1968, AIAA J. 6, 1313.

use super::SparseRow;
use super::masters::MasterCoordinates;
use crate::linalg::{
    FactoredPencil, LinalgError, LowestModes, Wanted, symmetric_generalized_eigen,
};
use crate::units::{hz_to_rad_s, rad_s_to_hz};
use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};

/// Most fixed-interface modes that a component may keep.
const MOST_MODES: usize = 200;

/// Why a component cannot be reduced.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReductionError {
    /// Fixing the masters leaves rigid-body motion, or the modes do not converge.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
    /// The cut-off is too high.
    #[error(
        "must leave at most {MOST_MODES} fixed-interface modes below it, but one more is at {frequency:.1} Hz"
    )]
    TooManyModes {
        /// Frequency of the first mode too many (Hz).
        frequency: f64,
    },
}

/// A component reduced to its masters and fixed-interface modes.
#[derive(Debug, Clone)]
pub struct CraigBampton {
    /// Number of masters b; they come first in q, in the order given.
    pub n_masters: usize,
    /// TΨ, n_full × (b + modes): recovers the full displacement.
    pub basis: Mat<f64>,
    /// ΨᵀKΨ: block diagonal, statically condensed masters and λ of the modes.
    pub stiffness: Mat<f64>,
    /// ΨᵀMΨ.
    pub mass: Mat<f64>,
    /// Frequency of the first fixed-interface mode that was left out (Hz); infinite if none was.
    pub first_left_out: f64,
}

impl CraigBampton {
    /// Keeps `masters` (linear forms on the degrees of freedom, each with one of its own) and every mode with masters held
    /// at 0 whose frequency lies below `cut_off` (Hz). Degrees of freedom without mass follow the others statically.
    ///
    /// K and M are n × n, stored with both triangles, M positive semidefinite.
    ///
    /// # Errors
    /// [`ReductionError`] if the modes cannot be computed, or are too many.
    pub fn new(
        stiffness: &SparseColMat<usize, f64>,
        mass: &SparseColMat<usize, f64>,
        masters: &[SparseRow],
        cut_off: f64,
    ) -> Result<Self, ReductionError> {
        let limit = hz_to_rad_s(cut_off).powi(2);
        let fixed = FixedInterface::new(stiffness, mass, masters, Wanted::Below(limit))?;
        if fixed.n_modes > MOST_MODES {
            let frequency = fixed.frequency(MOST_MODES);
            return Err(ReductionError::TooManyModes { frequency });
        }
        Ok(fixed.reduced())
    }

    /// Keeps `masters` and the first `n_modes` modes with masters held at 0, at most as many as [`CraigBampton::new`].
    ///
    /// # Errors
    /// [`LinalgError`] if fixing the masters leaves rigid-body motion, or the modes do not converge.
    pub fn with_modes(
        stiffness: &SparseColMat<usize, f64>,
        mass: &SparseColMat<usize, f64>,
        masters: &[SparseRow],
        n_modes: usize,
    ) -> Result<Self, LinalgError> {
        let wanted = Wanted::First(n_modes.min(MOST_MODES));
        Ok(FixedInterface::new(stiffness, mass, masters, wanted)?.reduced())
    }

    /// Number of reduced coordinates.
    #[must_use]
    pub fn n_dofs(&self) -> usize {
        self.mass.nrows()
    }

    /// λ ascending ((rad/s)²) and M-orthonormal modes of the reduced component.
    ///
    /// # Errors
    /// [`LinalgError`] if the reduced matrices are not definite.
    pub fn modes(&self) -> Result<(Vec<f64>, Mat<f64>), LinalgError> {
        symmetric_generalized_eigen(self.stiffness.as_ref(), self.mass.as_ref())
    }
}

/// A component with its masters held at 0, in the coordinates of its masters.
struct FixedInterface {
    coordinates: MasterCoordinates,
    stiffness: SparseColMat<usize, f64>,
    mass: SparseColMat<usize, f64>,
    parts: Partition,
    /// K_ib.
    coupling: Mat<f64>,
    /// K_ii⁻¹ K_ib.
    follow: Mat<f64>,
    /// Those that are kept, and the next one.
    modes: LowestModes,
    n_modes: usize,
}

impl FixedInterface {
    fn new(
        stiffness: &SparseColMat<usize, f64>,
        mass: &SparseColMat<usize, f64>,
        masters: &[SparseRow],
        wanted: Wanted,
    ) -> Result<Self, LinalgError> {
        let n = stiffness.nrows();
        let coordinates = MasterCoordinates::new(n, masters);
        let stiffness = coordinates.transformed(stiffness);
        let mass = coordinates.transformed(mass);
        let parts = Partition::new(n, &coordinates.pivots);
        let k_ii = parts.inner_block(&stiffness);
        let m_ii = parts.inner_block(&mass);
        let held = FactoredPencil::new(&k_ii, &m_ii, 0.0).map_err(|_| {
            LinalgError::NotPositiveDefinite {
                matrix: "stiffness with fixed masters",
            }
        })?;
        let modes = held.modes(wanted, MOST_MODES + 1)?;
        let coupling = parts.coupling(&stiffness);
        Ok(Self {
            n_modes: wanted.among(&modes.lambda),
            follow: held.solve(coupling.clone()),
            coordinates,
            stiffness,
            mass,
            parts,
            coupling,
            modes,
        })
    }

    /// Frequency of mode `i` (Hz); infinite if there is none.
    fn frequency(&self, i: usize) -> f64 {
        let lambda = self.modes.lambda.get(i);
        lambda.map_or(f64::INFINITY, |lambda| rad_s_to_hz(lambda.sqrt()))
    }

    fn reduced(&self) -> CraigBampton {
        let b = self.parts.n_masters;
        let n = b + self.n_modes;
        let basis = self.basis();
        let condensed =
            self.parts.masters_block(&self.stiffness) - self.coupling.transpose() * &self.follow;
        let mut stiffness = Mat::zeros(n, n);
        stiffness.submatrix_mut(0, 0, b, b).copy_from(&condensed);
        for (i, lambda) in self.modes.lambda.iter().take(self.n_modes).enumerate() {
            stiffness[(b + i, b + i)] = *lambda;
        }
        CraigBampton {
            n_masters: b,
            mass: symmetric(&(basis.transpose() * (&self.mass * &basis))),
            stiffness: symmetric(&stiffness),
            basis: self.coordinates.displacements(&basis),
            first_left_out: self.frequency(self.n_modes),
        }
    }

    /// Ψ.
    fn basis(&self) -> Mat<f64> {
        let b = self.parts.n_masters;
        let mut basis = Mat::zeros(self.mass.nrows(), b + self.n_modes);
        for (dof, place) in self.parts.place.iter().enumerate() {
            for column in 0..basis.ncols() {
                basis[(dof, column)] = match *place {
                    CoordinatePlace::Master(master) => f64::from(u8::from(column == master)),
                    CoordinatePlace::Inner(row) if column < b => -self.follow[(row, column)],
                    CoordinatePlace::Inner(row) => self.modes.shapes[(row, column - b)],
                };
            }
        }
        basis
    }
}

/// (A + Aᵀ)/2: removes the unsymmetric round-off of products.
fn symmetric(a: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// Where each coordinate went.
#[derive(Clone, Copy)]
enum CoordinatePlace {
    Master(usize),
    Inner(usize),
}

/// Split of the coordinates into masters and inner ones.
struct Partition {
    place: Vec<CoordinatePlace>,
    n_inner: usize,
    n_masters: usize,
}

impl Partition {
    fn new(n_dofs: usize, masters: &[usize]) -> Self {
        let mut place = vec![CoordinatePlace::Inner(0); n_dofs];
        for (i, &dof) in masters.iter().enumerate() {
            assert!(
                matches!(place[dof], CoordinatePlace::Inner(_)),
                "master {dof} is listed twice"
            );
            place[dof] = CoordinatePlace::Master(i);
        }
        let mut n_inner = 0;
        for slot in &mut place {
            if let CoordinatePlace::Inner(i) = slot {
                *i = n_inner;
                n_inner += 1;
            }
        }
        Self {
            place,
            n_inner,
            n_masters: masters.len(),
        }
    }

    /// Entries of the full matrix with the places of row and column.
    fn entries<'a>(
        &'a self,
        full: &'a SparseColMat<usize, f64>,
    ) -> impl Iterator<Item = (CoordinatePlace, CoordinatePlace, f64)> + 'a {
        full.triplet_iter()
            .map(|t| (self.place[t.row], self.place[t.col], *t.val))
    }

    fn inner_block(&self, full: &SparseColMat<usize, f64>) -> SparseColMat<usize, f64> {
        let entries: Vec<_> = self
            .entries(full)
            .filter_map(|entry| match entry {
                (CoordinatePlace::Inner(row), CoordinatePlace::Inner(col), val) => {
                    Some(Triplet { row, col, val })
                }
                _ => None,
            })
            .collect();
        let n = self.n_inner;
        SparseColMat::try_new_from_triplets(n, n, &entries)
            .unwrap_or_else(|_| unreachable!("indices come from the partition"))
    }

    /// Rows inner, columns masters.
    fn coupling(&self, full: &SparseColMat<usize, f64>) -> Mat<f64> {
        let mut block = Mat::zeros(self.n_inner, self.n_masters);
        for entry in self.entries(full) {
            if let (CoordinatePlace::Inner(row), CoordinatePlace::Master(col), val) = entry {
                block[(row, col)] = val;
            }
        }
        block
    }

    fn masters_block(&self, full: &SparseColMat<usize, f64>) -> Mat<f64> {
        let mut block = Mat::zeros(self.n_masters, self.n_masters);
        for entry in self.entries(full) {
            if let (CoordinatePlace::Master(row), CoordinatePlace::Master(col), val) = entry {
                block[(row, col)] = val;
            }
        }
        block
    }
}
