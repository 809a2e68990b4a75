//! What all tests of configuration a share: load, structure and blade.

use super::blade::Blade;
use super::loading::LoadMap;
use super::motion::Structure;
use super::read::Rig;
use crate::model::ModelError;
use crate::units::{n_per_um_to_n_per_m, rad_s_to_hz};
use nalgebra::{DMatrix, SymmetricEigen};

/// Natural frequencies that are listed end here (Hz).
const LISTED_HZ: f64 = 10e3;

/// One blade or a platform that is moved, the strip, and the measuring box.
#[derive(Debug, Clone)]
pub struct Stand {
    /// Load on every contact pair.
    pub map: LoadMap,
    /// Strip, loading and support.
    pub structure: Structure,
    /// What carries the platform, if `[blade]` is given.
    pub blade: Option<Blade>,
}

/// Natural frequencies of the blade (Hz), ascending up to 10 kHz: where its resonances are sought.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BladeFrequencies {
    /// Without strip.
    pub free_hz: Vec<f64>,
    /// With a strip that sticks, on the measuring box; with the medians of the contact.
    pub stuck_hz: Vec<f64>,
}

impl Rig {
    /// Load, structure and blade of configuration a; the blade takes a second.
    ///
    /// # Errors
    /// [`ModelError`] if the contact grid or the blade cannot be made.
    pub fn stand(&self) -> Result<Stand, ModelError> {
        let blade = self.blade.as_ref();
        Ok(Stand {
            map: self.load_map()?,
            structure: Structure::new(&self.strip, &self.loading, &self.support),
            blade: blade
                .map(|settings| Blade::new(settings, &self.strip))
                .transpose()?,
        })
    }

    /// Natural frequencies of the blade of a stand; none without one.
    #[must_use]
    pub fn blade_frequencies(&self, stand: &Stand) -> Option<BladeFrequencies> {
        let k_t = n_per_um_to_n_per_m(self.contact.tangential_stiffness_n_per_um);
        let blade = stand.blade.as_ref()?;
        Some(BladeFrequencies {
            free_hz: listed(blade.modes.iter().map(|mode| mode.omega.powi(2))),
            stuck_hz: listed(stuck_eigenvalues(blade, &stand.structure, k_t)),
        })
    }
}

/// Frequencies (Hz) of eigenvalues ((rad/s)²), ascending, as far as they are listed.
fn listed(eigenvalues: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let each = eigenvalues
        .into_iter()
        .map(|l| rad_s_to_hz(l.max(0.0).sqrt()));
    let mut frequencies: Vec<f64> = each.filter(|f| *f <= LISTED_HZ).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies
}

/// Of blade modes, strip and box with a spring `k_t` (N/m) between platform and strip; modes of the blade at rest are in series with it.
fn stuck_eigenvalues(blade: &Blade, structure: &Structure, k_t: f64) -> Vec<f64> {
    let (mass, stiffness) = structure.matrices();
    let n = blade.modes.len();
    let spring = 1.0 / (1.0 / k_t + blade.at_rest[1]);
    // platform less strip
    let row = |i: usize| match i < n {
        true => blade.modes[i].platform,
        false if i == n => -1.0,
        false => 0.0,
    };
    let root = |i: usize| {
        if i < n {
            1.0
        } else {
            mass[(i - n, i - n)].sqrt()
        }
    };
    let scaled = DMatrix::from_fn(n + mass.nrows(), n + mass.nrows(), |i, j| {
        let own = match (i.checked_sub(n), j.checked_sub(n)) {
            (Some(i), Some(j)) => stiffness[(i, j)],
            (None, None) if i == j => blade.modes[i].omega.powi(2),
            _ => 0.0,
        };
        (own + spring * row(i) * row(j)) / (root(i) * root(j))
    });
    SymmetricEigen::new(scaled)
        .eigenvalues
        .iter()
        .copied()
        .collect()
}
