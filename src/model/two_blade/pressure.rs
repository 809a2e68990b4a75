//! How the load on the strip is shared out to the contact nodes: the pressure of a rigid punch, and a random field.
//!
//! The strip is thin: the load on a node is nearly the force in its contact.
//!
//! Pressure of a rigid flat punch: p(s) = p̄ / (π √(1/4 − s²)) over the contact width, s from −1/2 to 1/2, infinite at
//! both edges with a finite load (Johnson 1985, Contact Mechanics, sec. 2.8). A node carries the integral over its part of the width.
//!
//! Random field: the relative deviation of the load is a
//! Gaussian field δ with standard deviation σ and correlation exp(−d²/2ℓ²) at the distance d, independent on the two
//! interfaces, expanded in its first modes (Karhunen & Loève; nodes weighed by their area, Ghanem & Spanos 1991, sec. 2.3):
//! δ = σ Σ_k √λ_k φ_k ξ_k with independent standard normal ξ_k. The mean over an interface is taken out, so that every
//! sample has the same load on both; what the modes left out would add is left out.

use super::TwoBladeSettings;
use super::components::Layout;
use crate::linalg::{LinalgError, symmetric_eigen};
use crate::model::{ContactPair, ReducedModel};
use crate::setting::{BadSetting, positive};
use crate::units::mm_to_m;
use faer::Mat;

/// `[pressure_field]` of a study file.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureField {
    /// σ: standard deviation of the pressure over its mean.
    pub standard_deviation: f64,
    /// ℓ (mm).
    pub correlation_length_mm: f64,
    /// Modes per interface; each is a random input.
    #[serde(default = "default_modes")]
    pub modes: usize,
}

fn default_modes() -> usize {
    4
}

/// A field as loads on the model.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureModes {
    /// Static force of ξ_k = 1 (N): first all modes of interface 0, then those of interface 1. Shape: inputs × dofs.
    pub loads: Vec<Vec<f64>>,
    /// Share of the field's variance, averaged over the area, that the modes hold.
    pub variance_share: f64,
}

impl PressureField {
    /// Modes per interface at most.
    pub const MOST_MODES: usize = 8;

    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[pressure_field]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        positive("standard_deviation", self.standard_deviation)?;
        let rule = "must be at most 0.3: a Gaussian field would lift the strip off";
        let small = self.standard_deviation <= 0.3;
        BadSetting::unless(small, "standard_deviation", self.standard_deviation, rule)?;
        positive("correlation_length_mm", self.correlation_length_mm)?;
        let rule = format!("must be from 1 to {}", Self::MOST_MODES);
        let holds = (1..=Self::MOST_MODES).contains(&self.modes);
        BadSetting::unless(holds, "modes", self.modes, &rule)
    }

    /// The field on the rig of `settings`, whose contact pairs and number of degrees of freedom are `pairs` and `n_dofs`.
    ///
    /// # Errors
    /// [`LinalgError`] if the eigenvalues of the covariance do not converge.
    pub fn modes(
        &self,
        settings: &TwoBladeSettings,
        pairs: &[ContactPair],
        n_dofs: usize,
    ) -> Result<PressureModes, LinalgError> {
        let positions: Vec<[f64; 2]> = (Layout::new(settings).contact_nodes().iter())
            .map(|node| [node.x, node.y])
            .collect();
        let half = positions.len();
        let area: Vec<f64> = pairs[..half].iter().map(|pair| pair.area).collect();
        // blade 2 has the mirror image of these nodes, in the same order
        let (deviations, variance_share) = self.deviations(&positions, &area)?;
        let load = |first: usize, deviation: &[f64]| {
            let mean = weighted_mean(deviation, &area);
            let centred: Vec<f64> = deviation.iter().map(|d| d - mean).collect();
            let mut force = vec![0.0; n_dofs];
            add_load(&mut force, settings, &pairs[first..first + half], &centred);
            force
        };
        let loads = [0, half].map(|first| deviations.iter().map(move |d| (first, d)));
        let loads = loads.into_iter().flatten().map(|(first, d)| load(first, d));
        Ok(PressureModes {
            loads: loads.collect(),
            variance_share,
        })
    }

    /// σ √λ_k φ_k at the nodes of one interface, and the share of the variance that these hold.
    fn deviations(
        &self,
        positions: &[[f64; 2]],
        area: &[f64],
    ) -> Result<(Vec<Vec<f64>>, f64), LinalgError> {
        let n = positions.len();
        let length = mm_to_m(self.correlation_length_mm);
        let total: f64 = area.iter().sum();
        let root: Vec<f64> = area.iter().map(|a| (a / total).sqrt()).collect();
        let covariance = Mat::from_fn(n, n, |i, j| {
            let [dx, dy] = [0, 1].map(|axis| positions[i][axis] - positions[j][axis]);
            let correlation = (-0.5 * (dx * dx + dy * dy) / (length * length)).exp();
            root[i] * correlation * root[j]
        });
        let (values, vectors) = symmetric_eigen(covariance.as_ref())?;
        let largest_first: Vec<usize> = (0..n).rev().take(self.modes).collect();
        let held: f64 = largest_first.iter().map(|&k| values[k]).sum();
        let modes = largest_first.iter().map(|&k| {
            let scale = self.standard_deviation * values[k].max(0.0).sqrt();
            // an eigenvector has no sign of its own
            let sum: f64 = (0..n).map(|i| (i + 1) as f64 * vectors[(i, k)]).sum();
            let sign = if sum < 0.0 { -1.0 } else { 1.0 };
            (0..n)
                .map(|i| sign * scale * vectors[(i, k)] / root[i])
                .collect()
        });
        Ok((modes.collect(), held / values.iter().sum::<f64>()))
    }
}

/// Static force (N) that makes the load of the rig's contacts that of a rigid flat punch on each platform, instead of even.
///
/// Shape: one entry per degree of freedom of `model`. Keeps the load of each interface.
#[must_use]
pub fn edge_load(settings: &TwoBladeSettings, model: &ReducedModel) -> Vec<f64> {
    let deviation = Layout::new(settings).punch_deviation();
    let mut force = vec![0.0; model.n_dofs()];
    for pairs in model.contacts.chunks(deviation.len()) {
        add_load(&mut force, settings, pairs, &deviation);
    }
    force
}

/// Adds the load of a relative deviation of the pressure from its mean on one interface, on the strip's side.
fn add_load(
    force: &mut [f64],
    settings: &TwoBladeSettings,
    pairs: &[ContactPair],
    deviation: &[f64],
) {
    let total: f64 = 2.0 * pairs.iter().map(|pair| pair.area).sum::<f64>();
    for (pair, deviation) in pairs.iter().zip(deviation) {
        let share = settings.centrifugal_load_n * pair.area / total;
        for &(dof, weight) in pair.n.iter().filter(|(_, weight)| *weight > 0.0) {
            force[dof] += weight * share * deviation;
        }
    }
}

fn weighted_mean(values: &[f64], weights: &[f64]) -> f64 {
    let sum: f64 = values.iter().zip(weights).map(|(x, w)| x * w).sum();
    sum / weights.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn rig(modes: usize) -> (TwoBladeSettings, PressureField, Vec<ContactPair>) {
        let settings = TwoBladeSettings::default();
        let nodes = Layout::new(&settings).contact_nodes();
        let pair = |(i, area): (usize, f64)| ContactPair {
            name: String::new(),
            t1: Vec::new(),
            t2: Vec::new(),
            n: vec![(i, 1.0), (100 + i, -1.0)],
            area,
            interface: i / nodes.len(),
        };
        let areas = nodes.iter().chain(&nodes).map(|node| node.area);
        let pairs = areas.enumerate().map(pair).collect();
        let field = PressureField {
            standard_deviation: 0.1,
            correlation_length_mm: 8.0,
            modes,
        };
        (settings, field, pairs)
    }

    /// The pressure's covariance, from all modes of one interface, is σ² exp(−d²/2ℓ²) less the mean: by its own formula.
    ///
    /// Seen to fail with the areas left out of the eigenproblem.
    #[test]
    fn all_modes_give_the_covariance() {
        let (settings, mut field, pairs) = rig(1);
        let nodes = Layout::new(&settings).contact_nodes();
        field.modes = nodes.len();
        let modes = field.modes(&settings, &pairs, 200).unwrap();
        assert!((modes.variance_share - 1.0).abs() < 1e-12);
        let n = nodes.len();
        let total: f64 = nodes.iter().map(|node| node.area).sum();
        let w: Vec<f64> = nodes.iter().map(|node| node.area / total).collect();
        let c = |i: usize, j: usize| {
            let d2 = (nodes[i].x - nodes[j].x).powi(2) + (nodes[i].y - nodes[j].y).powi(2);
            0.01 * (-0.5 * d2 / 0.008_f64.powi(2)).exp()
        };
        let row_mean = |i: usize| (0..n).map(|j| w[j] * c(i, j)).sum::<f64>();
        let mean: f64 = (0..n).map(|i| w[i] * row_mean(i)).sum();
        for (i, j) in [(0, 0), (0, 1), (3, 7), (14, 14), (2, 12)] {
            let nominal = |i: usize| 0.5 * settings.centrifugal_load_n * w[i];
            let relative = |mode: &Vec<f64>, i: usize| mode[i] / nominal(i);
            let found: f64 = (modes.loads.iter())
                .map(|mode| relative(mode, i) * relative(mode, j))
                .sum();
            let expected = c(i, j) - row_mean(i) - row_mean(j) + mean;
            assert!(
                (found - expected).abs() < 1e-12,
                "{i} {j}: {found}, not {expected}"
            );
        }
    }

    /// On three columns the punch carries a third each; on many it has the profile 2/(π √(1 − 4 s²)) and keeps the load.
    ///
    /// Seen to fail with the load left of s linear in s.
    #[test]
    fn a_punch_presses_at_the_edges() {
        let mut settings = TwoBladeSettings::default();
        let three = Layout::new(&settings).punch_deviation();
        for (deviation, expected) in three.iter().zip([1.0, -1.0, 1.0, 1.0]) {
            assert!((deviation - expected / 3.0).abs() < 1e-12, "{three:?}");
        }
        settings.contact_nodes = [401, 2];
        let layout = Layout::new(&settings);
        let many = layout.punch_deviation();
        for i in [20, 100, 200, 333] {
            let s = i as f64 / 400.0 - 0.5;
            let profile = 2.0 / (PI * (1.0 - 4.0 * s * s).sqrt());
            assert!((1.0 + many[i] - profile).abs() < 1e-3 * profile, "{i}");
        }
        let nodes = layout.contact_nodes();
        let change: f64 = many.iter().zip(&nodes).map(|(d, node)| d * node.area).sum();
        assert!(change.abs() < 1e-12 * nodes[0].area, "{change}");
    }

    /// Each mode loads one interface, leaves its sum and pulls nothing on the blades.
    #[test]
    fn modes_keep_the_load_of_each_interface() {
        let (settings, field, pairs) = rig(3);
        let modes = field.modes(&settings, &pairs, 200).unwrap();
        assert_eq!(modes.loads.len(), 6);
        assert!(modes.variance_share > 0.5 && modes.variance_share < 1.0);
        for (k, load) in modes.loads.iter().enumerate() {
            let (own, other) = if k < 3 {
                (0..15, 15..30)
            } else {
                (15..30, 0..15)
            };
            assert!(load[own.clone()].iter().any(|f| f.abs() > 0.1), "mode {k}");
            assert!(load[own].iter().sum::<f64>().abs() < 1e-12, "mode {k}");
            assert!(load[other].iter().chain(&load[30..]).all(|f| *f == 0.0));
        }
    }
}
