//! The rig's stiffness in series with the contact.

use crate::identify::settings::IdentifySettings;
use crate::units::{n_per_m_to_n_per_um, n_per_um_to_n_per_m};

/// Stiffness in series, where one is stated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series {
    /// N/m; infinite where none is stated.
    stiffness: f64,
}

impl Series {
    /// As stated.
    pub(super) fn of(settings: &IdentifySettings) -> Self {
        let stated = settings.series_stiffness_n_per_um;
        Self {
            stiffness: stated.map_or(f64::INFINITY, n_per_um_to_n_per_m),
        }
    }

    /// Stiffness of the contact from the one measured: 1/k = 1/measured − 1/series.
    ///
    /// # Errors
    /// If the measured one is not below the stated one.
    pub(super) fn contact(&self, measured: f64) -> Result<f64, String> {
        match measured < self.stiffness {
            true => Ok(measured / (1.0 - measured / self.stiffness)),
            false => Err(format!(
                "has a measured stiffness of {:.4e} N/um, which must be below the series stiffness of {:.4e} N/um",
                n_per_m_to_n_per_um(measured),
                n_per_m_to_n_per_um(self.stiffness)
            )),
        }
    }

    /// Derivative of the contact's stiffness with respect to the measured one.
    pub(super) fn derivative(&self, measured: f64) -> f64 {
        (1.0 - measured / self.stiffness).powi(-2)
    }
}
