//! The forces of a batch and their derivatives.
//!
//! Arrays run over states fastest, as in the batch.

use super::batch::AftBatch;
use super::plan::AftPlan;
use crate::contact::Real;

/// How the slider repeats from one period to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Periodicity {
    /// Periodic, and the same from any slider start.
    Unique,
    /// Periodic, but the mean tractions depend on the slider's anchor (the contact never slips through).
    DependsOnAnchor,
    /// Not periodic to rounding after the laps that were marched.
    NotPeriodic,
}

/// Samples of a period by what the contact does there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateCounts {
    /// Samples in contact without slip.
    pub stick: u32,
    /// Samples in contact with slip in at least one direction.
    pub slip: u32,
    /// Samples out of contact.
    pub separated: u32,
}

impl StateCounts {
    /// The same of a pair without tangential stiffness: it has no traction that could reach a limit, so that it sticks where it is closed.
    #[must_use]
    pub fn without_traction(self) -> Self {
        Self {
            stick: self.stick + self.slip,
            slip: 0,
            ..self
        }
    }

    /// Of `n_time` samples; those that neither slip nor are out of contact stick.
    #[must_use]
    pub fn new(n_time: usize, slip: u32, separated: u32) -> Self {
        let total = u32::try_from(n_time).unwrap_or(u32::MAX);
        Self {
            stick: total - slip - separated,
            slip,
            separated,
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn total(self) -> u32 {
        self.stick + self.slip + self.separated
    }
}

/// What one state did over the last lap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateSummary {
    /// Its samples.
    pub counts: StateCounts,
    /// Laps marched.
    pub laps: u32,
    /// Whether the slider is periodic.
    pub periodicity: Periodicity,
}

/// Derivative of the force coefficients of one state by its displacement coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tangent {
    /// In contact and stuck all the time: exactly diag(k_t1, k_t2, k_n).
    Stuck,
    /// Seven blocks, starting at this offset of [`AftForces::blocks`].
    Blocks(usize),
}

/// Blocks of a tangent, in the order of storage; T1N = dT₁/dn. The normal force depends on the approach alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TangentBlock {
    /// dT₁/dt₁.
    T1T1,
    /// dT₁/dt₂; zero for the box law.
    T1T2,
    /// dT₂/dt₁; zero for the box law.
    T2T1,
    /// dT₂/dt₂.
    T2T2,
    /// dT₁/dn.
    T1N,
    /// dT₂/dn.
    T2N,
    /// dN/dn.
    NN,
}

impl TangentBlock {
    /// Number of blocks of a tangent.
    pub const COUNT: usize = 7;

    /// Every block, in the order of storage.
    pub const ALL: [Self; Self::COUNT] = [
        Self::T1T1,
        Self::T1T2,
        Self::T2T1,
        Self::T2T2,
        Self::T1N,
        Self::T2N,
        Self::NN,
    ];

    /// Force component of the rows (0, 1, 2 = t1, t2, n).
    #[must_use]
    pub fn row_component(self) -> usize {
        match self {
            Self::T1T1 | Self::T1T2 | Self::T1N => 0,
            Self::T2T1 | Self::T2T2 | Self::T2N => 1,
            Self::NN => 2,
        }
    }

    /// Displacement component of the columns (0, 1, 2 = t1, t2, n).
    #[must_use]
    pub fn column_component(self) -> usize {
        match self {
            Self::T1T1 | Self::T2T1 => 0,
            Self::T1T2 | Self::T2T2 => 1,
            Self::T1N | Self::T2N | Self::NN => 2,
        }
    }
}

/// Contact forces of a batch. Buffers are kept from one evaluation to the next.
#[derive(Debug, Clone, Default)]
pub struct AftForces<T> {
    /// Number of states.
    pub n_states: usize,
    /// Number m of coefficients per component.
    pub n_coefficients: usize,
    /// Total contact forces T₁, T₂, N (N). Shape: `[component t1, t2, n][coefficient][state]`.
    pub forces: Vec<T>,
    /// Shape: `[state]`.
    pub summaries: Vec<StateSummary>,
    /// Shape: `[state]`; empty if only forces were wanted.
    pub tangents: Vec<Tangent>,
    /// Tangent blocks (N/m) of the states that are not stuck. Shape: `[tangent][block][row m][column m]`.
    pub blocks: Vec<T>,
}

impl<T: Real> AftForces<T> {
    /// Adds the tangent of the next state, whose blocks start at `offset`; those of a stuck state are dropped.
    pub(super) fn add_tangent(&mut self, offset: usize, stuck: bool) {
        if stuck {
            self.blocks.truncate(offset);
        }
        self.tangents.push(if stuck {
            Tangent::Stuck
        } else {
            Tangent::Blocks(offset)
        });
    }

    /// One block of the tangent at `offset` (from [`Tangent::Blocks`]).
    ///
    /// Shape: `[force coefficient m][displacement coefficient m]`. Unit: N/m.
    #[must_use]
    pub fn block(&self, offset: usize, block: TangentBlock) -> &[T] {
        let size = self.n_coefficients * self.n_coefficients;
        &self.blocks[offset + block as usize * size..][..size]
    }

    /// Sets the sizes for a batch and forgets the tangents.
    pub(crate) fn reset(&mut self, plan: &AftPlan<T>, batch: &AftBatch<T>) {
        let (n, m) = (batch.n_states, plan.n_coefficients());
        assert_eq!(
            batch.displacement.len(),
            3 * m * n,
            "displacements must have shape [3][coefficient][state]"
        );
        assert_eq!(batch.parameters.len(), n, "one set of parameters per state");
        (self.n_states, self.n_coefficients) = (n, m);
        self.forces.resize(3 * m * n, T::ZERO);
        self.summaries.clear();
        self.tangents.clear();
        self.blocks.clear();
    }
}
