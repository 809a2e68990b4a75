//! What presses the strip on the platform, as a load on every contact pair.
//!
//! The strip is thin: the load on a pair is the pressure over its area, whatever the contact does. Air presses by the model of
//! `air`; a punch by the pressure of a rigid flat one as wide as the contact, half of the weight on each side of the gap.

use super::air::AirSettings;
use super::settings::StripSettings;
use crate::model::ModelError;
use crate::model::two_blade::{InterfaceCell, TwoBladeSettings, interface_cells};
use crate::record::{PressureCell, PressureMap};
use crate::setting::{BadSetting, positive, within};
use crate::units::STANDARD_GRAVITY;
use std::f64::consts::PI;

/// Weights and masses that can be meant (kg).
const WEIGHT_KG: [f64; 2] = [0.0, 1e4];
/// Stiffnesses of a punch that can be meant (N/µm).
const STIFFNESS_N_PER_UM: [f64; 2] = [0.0, 1e6];
/// Points of a cell in each direction over which its pressure is averaged.
const POINTS_OF_CELL: usize = 16;
/// Distance of the points at which the pressure on a whole strip is counted (mm).
const COUNTED_MM: f64 = 0.1;
/// "About the mean": within this share of it.
const TENTH: f64 = 0.1;
/// Pa in a MPa.
const PA_PER_MPA: f64 = 1e6;

/// Dead weights on a rigid punch.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PunchSettings {
    /// Weights, with what hangs with them (kg).
    pub weight_kg: f64,
    /// Mass of the punch that moves with the strip (kg); the weights hang softly and stay at rest.
    pub punch_mass_kg: f64,
    /// Stiffness of the punch between contact and box, beside the strip's (N/µm).
    pub punch_stiffness_n_per_um: f64,
}

impl Default for PunchSettings {
    fn default() -> Self {
        Self {
            weight_kg: 20.0,
            punch_mass_kg: 0.05,
            punch_stiffness_n_per_um: 50.0,
        }
    }
}

/// `[loading]`, by its `kind`.
#[derive(Debug, Clone, PartialEq)]
pub enum Loading {
    /// Compressed air.
    Air(AirSettings),
    /// Dead weights on a rigid punch.
    Punch(PunchSettings),
}

/// Load on the interface.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadMap {
    /// Cells of the interface.
    pub cells: Vec<InterfaceCell>,
    /// Normal load of each contact pair (N). Shape: `[pairs]`.
    pub loads: Vec<f64>,
    /// Pressure over the strip; over its contact under a punch.
    pub pressure: PressureFacts,
}

/// A pressure map in numbers.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PressureFacts {
    /// Mean (MPa).
    pub mean_mpa: f64,
    /// Largest (MPa); under a punch that of a cell, for at its edge it has no bound.
    pub largest_mpa: f64,
    /// Share of the area within a tenth of the mean, point by point.
    pub within_tenth: f64,
}

impl Loading {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[loading]`.
    pub fn validate(&self, strip: &StripSettings) -> Result<(), BadSetting> {
        match self {
            Self::Air(air) => {
                air.validate()?;
                air.film([strip.strip_mm[0], strip.strip_mm[1]])?;
                Ok(())
            }
            Self::Punch(punch) => {
                positive("weight_kg", punch.weight_kg)?;
                within("weight_kg", punch.weight_kg, WEIGHT_KG)?;
                within("punch_mass_kg", punch.punch_mass_kg, WEIGHT_KG)?;
                let stiffness = punch.punch_stiffness_n_per_um;
                within("punch_stiffness_n_per_um", stiffness, STIFFNESS_N_PER_UM)
            }
        }
    }

    /// Load on every contact pair.
    ///
    /// # Errors
    /// [`ModelError`] on a strip that breaks a rule.
    pub fn map(&self, strip: &StripSettings) -> Result<LoadMap, ModelError> {
        self.map_on(strip, interface_cells(&strip.model())?)
    }

    /// The same on these cells of the interface.
    fn map_on(
        &self,
        strip: &StripSettings,
        cells: Vec<InterfaceCell>,
    ) -> Result<LoadMap, ModelError> {
        match self {
            Self::Air(air) => air_map(air, strip, cells),
            Self::Punch(punch) => Ok(punch_map(punch, cells)),
        }
    }

    /// Two blades whose strip is pressed so: by the load on every contact pair, and with what a punch adds to the mass of the strip and to
    /// its stiffness across the gap.
    ///
    /// # Errors
    /// [`ModelError`] on a strip that breaks a rule, or that this cannot press.
    pub fn pressed(&self, blades: &TwoBladeSettings) -> Result<TwoBladeSettings, ModelError> {
        let strip = StripSettings::of(blades);
        let loads = self.map_on(&strip, interface_cells(blades)?)?.loads;
        let (mass, stiffness) = self.added();
        let heavier = 1.0 + mass / strip.mass();
        let stiffer = 1.0 + stiffness / strip.stiffness_between_blades();
        Ok(TwoBladeSettings {
            centrifugal_load_n: 2.0 * loads.iter().sum::<f64>(),
            pressure_weights: Some([&loads[..], &loads[..]].concat()),
            strip_density_kg_m3: Some(heavier * strip.density_kg_m3),
            strip_youngs_modulus_gpa: Some(stiffer * strip.youngs_modulus_gpa),
            // the same modes of the strip
            strip_cut_off_hz: (stiffer / heavier).sqrt() * blades.strip_cut_off_hz,
            ..blades.clone()
        })
    }

    /// Standard deviation of the load over its mean, and its time constant (s).
    #[must_use]
    pub fn fluctuation(&self) -> Option<(f64, f64)> {
        match self {
            Self::Air(air) => Some((1e-2 * air.regulator_noise_percent, air.regulator_time_s)),
            Self::Punch(_) => None,
        }
    }

    /// Mass (kg) and stiffness (N/m) that it adds to the strip.
    #[must_use]
    pub fn added(&self) -> (f64, f64) {
        match self {
            Self::Air(_) => (0.0, 0.0),
            Self::Punch(punch) => (
                punch.punch_mass_kg,
                crate::units::n_per_um_to_n_per_m(punch.punch_stiffness_n_per_um),
            ),
        }
    }
}

impl LoadMap {
    /// The pressure on the cells of the interface, as the contact pairs feel it.
    #[must_use]
    pub fn pressure_map(&self) -> PressureMap {
        let cells = self.cells.iter().zip(&self.loads);
        let cells = cells.map(|(cell, load)| PressureCell {
            pressure_pa: load / cell.area,
            area_m2: cell.area,
        });
        PressureMap {
            cells: cells.collect(),
        }
    }

    /// Share of the area of the contact pairs within a tenth of their mean pressure: what a test states. A pair has the mean pressure of
    /// its cell, so that this share differs from that of the pressure point by point.
    #[must_use]
    pub fn even_area(&self) -> f64 {
        let cells = self.pressure_map().cells;
        let pressures = cells
            .iter()
            .map(|cell| (cell.pressure_pa / PA_PER_MPA, cell.area_m2));
        facts(&pressures.collect::<Vec<_>>()).within_tenth
    }
}

fn air_map(
    air: &AirSettings,
    strip: &StripSettings,
    cells: Vec<InterfaceCell>,
) -> Result<LoadMap, ModelError> {
    let [width, length, _] = strip.strip_mm;
    let film = air.film([width, length])?;
    let middle =
        |[from, to]: [f64; 2], i: usize, n: usize| from + (to - from) * (i as f64 + 0.5) / n as f64;
    let n = POINTS_OF_CELL;
    let mean = |cell: &InterfaceCell| {
        let [x, y] = cell.span;
        let points = (0..n * n).map(|k| [middle(x, k % n, n), middle(y, k / n, n)]);
        points.map(|point| film.pressure(point)).sum::<f64>() / (n * n) as f64
    };
    let loads = cells.iter().map(|cell| PA_PER_MPA * mean(cell) * cell.area);
    let counts = [width, length].map(|side| ((side / COUNTED_MM).ceil() as usize).max(1));
    let spans = [width, length].map(|side| [-0.5e-3 * side, 0.5e-3 * side]);
    let at = |k: usize| {
        let [i, j] = [k % counts[0], k / counts[0]];
        film.pressure([
            middle(spans[0], i, counts[0]),
            middle(spans[1], j, counts[1]),
        ])
    };
    let pressures: Vec<(f64, f64)> = (0..counts[0] * counts[1]).map(|k| (at(k), 1.0)).collect();
    Ok(LoadMap {
        loads: loads.collect(),
        cells,
        pressure: facts(&pressures),
    })
}

fn punch_map(punch: &PunchSettings, cells: Vec<InterfaceCell>) -> LoadMap {
    let load = 0.5 * punch.weight_kg * STANDARD_GRAVITY;
    let whole: f64 = cells.iter().map(|cell| cell.punch * cell.area).sum();
    let loads: Vec<f64> = (cells.iter())
        .map(|cell| load * cell.punch * cell.area / whole)
        .collect();
    let pressures: Vec<(f64, f64)> = (cells.iter().zip(&loads))
        .map(|(cell, load)| (load / cell.area / PA_PER_MPA, cell.area))
        .collect();
    LoadMap {
        pressure: PressureFacts {
            within_tenth: even_under_punch(),
            ..facts(&pressures)
        },
        loads,
        cells,
    }
}

/// Share of the area under a rigid flat punch within a tenth of the mean: that between the places s where p/p̄ = 2/(π √(1 − 4 s²)) is 0.9
/// and 1.1.
fn even_under_punch() -> f64 {
    let place = |ratio: f64| (1.0 - (2.0 / (PI * ratio)).powi(2)).sqrt();
    place(1.0 + TENTH) - place(1.0 - TENTH)
}

/// From pressures (MPa) with their areas, in any unit.
fn facts(pressures: &[(f64, f64)]) -> PressureFacts {
    let area: f64 = pressures.iter().map(|(_, area)| area).sum();
    let mean_mpa = pressures.iter().map(|(p, area)| p * area).sum::<f64>() / area;
    let near = pressures
        .iter()
        .filter(|(p, _)| (p / mean_mpa - 1.0).abs() <= TENTH);
    PressureFacts {
        mean_mpa,
        largest_mpa: pressures.iter().fold(0.0, |most, (p, _)| p.max(most)),
        within_tenth: near.fold(0.0, |sum, (_, area)| sum + area) / area,
    }
}
