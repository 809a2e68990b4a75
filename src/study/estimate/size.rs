//! Size of one nonlinear solve of a study: unknowns and memory.

use crate::aft::AftPlan;
use crate::harmonics::HarmonicSet;
use crate::hb::HbSettings;
use crate::hb::equations::balance::evaluation_on;
use crate::hb::equations::jacobian::{DENSE_FALLBACK_LIMIT, DENSE_LIMIT};
use crate::hb::peak::alert::searched_on;
use crate::study::built::StudyDisk;
use crate::study::prepared::PreparedStudy;
use crate::study::settings::read::Study;

/// Size of one nonlinear solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SolveSize {
    /// Contact pairs that are solved together: of a mistuned disk those of all sectors.
    pub(super) contacts: usize,
    /// Blades of a mistuned disk.
    pub(super) mistuned_blades: Option<usize>,
    /// Of a disk: sectors, and degrees of freedom of one.
    pub(super) ring: Option<[usize; 2]>,
    /// Unknowns on the first harmonics: three relative displacements per pair and coefficient.
    pub(super) unknowns: usize,
    /// Unknowns on the highest harmonics.
    pub(super) most_unknowns: usize,
    /// Numbers in the tables of the contact evaluation on all harmonic sets.
    tabulated: usize,
}

impl SolveSize {
    /// Of a study whose model, or what is solved of it, has so many contact pairs.
    pub(super) fn of(study: &Study, n_contacts: usize, disk: Option<&StudyDisk>) -> Self {
        let mistuned = disk.filter(|_| study.is_mistuned());
        let mistuned_blades = mistuned.map(|of| of.disk.n_sectors);
        let contacts = n_contacts * mistuned_blades.unwrap_or(1);
        let first = study.solver.harmonics.n_coefficients();
        let highest = study.solver.alert.map_or(first, |alert| {
            let compared = alert.most_compared(alert.highest_harmonic);
            first.max(HarmonicSet::up_to(compared).n_coefficients())
        });
        Self {
            contacts,
            mistuned_blades,
            ring: disk.map(|of| [of.disk.n_sectors, of.disk.n_dofs()]),
            unknowns: 3 * contacts * first,
            most_unknowns: 3 * contacts * highest,
            tabulated: tabulated(&study.solver),
        }
    }

    /// Unknowns on the harmonics up to `highest`.
    pub(super) fn unknowns_up_to(self, highest: usize) -> usize {
        3 * self.contacts * HarmonicSet::up_to(highest).n_coefficients()
    }

    /// Bytes on the highest harmonics: usually, and at most.
    pub(super) fn memory(self) -> [f64; 2] {
        let tables = 8.0 * self.tabulated as f64;
        solve_memory(self.contacts, self.most_unknowns).map(|bytes| bytes + tables)
    }
}

/// Numbers in the tables of the contact evaluation: a sample keeps those of every harmonic set that it was searched on.
fn tabulated(solver: &HbSettings) -> usize {
    let of_set = |set: &HarmonicSet| {
        let aft = evaluation_on(solver, set);
        AftPlan::<f64>::n_tabulated(set, aft)
    };
    let sets = searched_on(&solver.harmonics, solver.alert);
    sets.iter().map(of_set).sum()
}

impl PreparedStudy<'_> {
    /// Bytes of one solve on the highest harmonics: usually, and at most.
    pub(in crate::study) fn solve_memory(&self) -> [f64; 2] {
        SolveSize::of(&self.study, self.linear.n_contacts(), self.disk.as_ref()).memory()
    }
}

/// Bytes of one solve with all pairs in motion: usually, and where iterations do not converge and the system is factorised
/// densely, which systems of up to [`DENSE_FALLBACK_LIMIT`] unknowns are (matrix, copy, factors).
///
/// Compliances of all harmonics, from which the springs of the contacts are taken and which sweeps have in single precision,
/// too. Derivatives of the contact forces, seven blocks per pair in four copies. Of a large system also factors of the
/// blocks of the sweep and the directions of an exact solve. Small ones are factorised densely
/// (`hb::equations::jacobian`).
fn solve_memory(n_contacts: usize, unknowns: usize) -> [f64; 2] {
    let (n, rows) = (unknowns as f64, 3.0 * n_contacts as f64);
    let m = n / rows;
    let compliances = 0.5 * (m + 1.0) * rows.powi(2) * (16.0 + 16.0 + 8.0);
    let derivatives = n_contacts as f64 * 7.0 * m.powi(2) * (3.0 * 8.0 + 4.0);
    let (block_slots, directions) = (6.0, 60.0);
    let iterative = rows * block_slots * m.powi(2) * 4.0 + 2.0 * 8.0 * directions * n;
    let dense = 3.0 * 8.0 * n.min(DENSE_FALLBACK_LIMIT as f64).powi(2);
    let shared = compliances + derivatives;
    match unknowns {
        ..=DENSE_LIMIT => [shared + dense; 2],
        _ => [shared + iterative, shared + iterative + dense],
    }
}
