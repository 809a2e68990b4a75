//! Pressure of compressed air on the strip: a nozzle plate with a ring of holes along its edges, a small gap above the strip.
//!
//! Small model. Air leaves each hole through the curtain between its rim and the strip, πdh (or through the hole, πd²/4, where
//! that is smaller), and the film through the gap around the strip, h times its circumference. Both flows are choked: mass
//! flow C A p f(T), the same f for both at one temperature, so that in the steady state
//!
//! p_film / p_in = C n min(πdh, πd²/4) / (2 (b + l) h), absolute pressures.
//!
//! Source of the choked flow: Shapiro 1953, The Dynamics and Thermodynamics of Compressible Fluid Flow, sec. 4.6. Inside the ring of
//! holes no air flows, and the pressure is p_film. Between the ring and the edge the air accelerates to the speed of sound; the
//! pressure falls to 0.528 p_film there, taken linear with the distance. Under a hole it is that of the inlet. Viscosity is
//! left out: with 0.1 mm the flow is limited by the speed of sound, not by friction.

use crate::setting::{BadSetting, positive, within};
use crate::units::mm_to_m;
use std::f64::consts::PI;

/// Pressure over that before a choked throat: (2/(γ + 1))^(γ/(γ − 1)) of air, γ = 1.4.
const CRITICAL_RATIO: f64 = 0.528_282;
/// Standard atmosphere (MPa).
const ATMOSPHERE_MPA: f64 = 0.101_325;
/// Supplies that can be meant (MPa).
const MOST_MPA: f64 = 100.0;
/// Largest standard deviation of the load (%): its distance from 0 is then five of them.
const MOST_NOISE_PERCENT: f64 = 20.0;
/// Holes at most.
const MOST_HOLES: usize = 1000;

/// The nozzle plate and its supply. Pressures are above the atmosphere, as a gauge shows them.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AirSettings {
    /// Pressure before the holes (MPa).
    pub inlet_mpa: f64,
    /// Gap between plate and strip (mm).
    pub gap_mm: f64,
    /// Holes, evenly along the ring.
    pub holes: usize,
    /// Diameter of a hole (mm).
    pub hole_mm: f64,
    /// Distance of the ring from the edges of the strip (mm).
    pub margin_mm: f64,
    /// Discharge coefficient of the curtain under a hole over that of the gap around the strip.
    pub discharge: f64,
    /// Standard deviation of the load by the pressure regulator (%).
    pub regulator_noise_percent: f64,
    /// Time constant of the regulator (s).
    pub regulator_time_s: f64,
}

impl Default for AirSettings {
    fn default() -> Self {
        Self {
            inlet_mpa: 0.75,
            gap_mm: 0.1,
            holes: 20,
            hole_mm: 1.0,
            margin_mm: 1.0,
            discharge: 0.87,
            regulator_noise_percent: 0.3,
            regulator_time_s: 0.1,
        }
    }
}

/// Pressure on a strip of a size.
#[derive(Debug, Clone, PartialEq)]
pub struct AirFilm {
    /// Half of the strip's sides (m).
    half: [f64; 2],
    margin: f64,
    /// Centres of the holes (m).
    holes: Vec<[f64; 2]>,
    radius: f64,
    /// Inside the ring, at the edge and under a hole (MPa).
    film: f64,
    edge: f64,
    inlet: f64,
}

impl AirSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[loading]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        positive("inlet_mpa", self.inlet_mpa)?;
        within("inlet_mpa", self.inlet_mpa, [0.0, MOST_MPA])?;
        positive("gap_mm", self.gap_mm)?;
        let rule = format!("must be from 1 to {MOST_HOLES}");
        let some = (1..=MOST_HOLES).contains(&self.holes);
        BadSetting::unless(some, "holes", self.holes, &rule)?;
        positive("hole_mm", self.hole_mm)?;
        positive("margin_mm", self.margin_mm)?;
        positive("discharge", self.discharge)?;
        let percent = self.regulator_noise_percent;
        let rule = format!("must be from 0 to {MOST_NOISE_PERCENT}: beyond, the load may vanish");
        let small = (0.0..=MOST_NOISE_PERCENT).contains(&percent);
        BadSetting::unless(small, "regulator_noise_percent", percent, &rule)?;
        positive("regulator_time_s", self.regulator_time_s)?;
        let rule = format!(
            "must be at least half of hole_mm, {}: the holes are above the strip",
            0.5 * self.hole_mm
        );
        let above = self.margin_mm >= 0.5 * self.hole_mm;
        BadSetting::unless(above, "margin_mm", self.margin_mm, &rule)
    }

    /// The film on a strip with the sides `strip_mm`.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[loading]`: a ring that is no ring, or a flow that is not choked.
    pub fn film(&self, strip_mm: [f64; 2]) -> Result<AirFilm, BadSetting> {
        let [width, length] = strip_mm;
        let rule = format!(
            "must be below half of the strip's width, {} mm",
            0.5 * width
        );
        let inside = self.margin_mm < 0.5 * width.min(length);
        BadSetting::unless(inside, "margin_mm", self.margin_mm, &rule)?;
        let (d, h) = (self.hole_mm, self.gap_mm);
        let throat = self.holes as f64 * (PI * d * h).min(0.25 * PI * d * d);
        let ratio = self.discharge * throat / (2.0 * (width + length) * h);
        let inlet = self.inlet_mpa + ATMOSPHERE_MPA;
        let plate = format!(
            "with hole_mm = {d}, gap_mm = {h} and discharge = {}",
            self.discharge
        );
        let rule = format!(
            "must leave a film below {CRITICAL_RATIO} of the inlet's absolute pressure ({plate} it has {ratio:.3}): else the flow is not choked"
        );
        BadSetting::unless(ratio < CRITICAL_RATIO, "holes", self.holes, &rule)?;
        let film = ratio * inlet;
        let edge = CRITICAL_RATIO * film;
        let rule = format!(
            "gives {film:.3} MPa in the film {plate} and holes = {}: too little for a choked gap",
            self.holes
        );
        BadSetting::unless(edge > ATMOSPHERE_MPA, "inlet_mpa", self.inlet_mpa, &rule)?;
        Ok(AirFilm {
            half: [0.5 * mm_to_m(width), 0.5 * mm_to_m(length)],
            margin: mm_to_m(self.margin_mm),
            holes: ring(self.holes, strip_mm.map(|side| side - 2.0 * self.margin_mm)),
            radius: 0.5 * mm_to_m(d),
            film: film - ATMOSPHERE_MPA,
            edge: edge - ATMOSPHERE_MPA,
            inlet: self.inlet_mpa,
        })
    }
}

/// Points evenly along a rectangle around the origin with the given sides (mm), the first one half a step from a corner. In m.
fn ring(points: usize, [width, length]: [f64; 2]) -> Vec<[f64; 2]> {
    let step = 2.0 * (width + length) / points as f64;
    let [right, top] = [0.5 * width, 0.5 * length];
    let place = |k: usize| {
        let along = (k as f64 + 0.5) * step;
        let point = match along {
            s if s < width => [s - right, -top],
            s if s < width + length => [right, s - width - top],
            s if s < 2.0 * width + length => [right - (s - width - length), top],
            s => [-right, top - (s - 2.0 * width - length)],
        };
        point.map(mm_to_m)
    };
    (0..points).map(place).collect()
}

impl AirFilm {
    /// Pressure (MPa) at a point of the strip (m from its middle).
    #[must_use]
    pub fn pressure(&self, [x, y]: [f64; 2]) -> f64 {
        let in_hole = |hole: &[f64; 2]| {
            let (dx, dy) = (x - hole[0], y - hole[1]);
            dx * dx + dy * dy < self.radius * self.radius
        };
        if self.holes.iter().any(in_hole) {
            return self.inlet;
        }
        let from_edge = (self.half[0] - x.abs()).min(self.half[1] - y.abs());
        let share = (from_edge / self.margin).clamp(0.0, 1.0);
        self.edge + share * (self.film - self.edge)
    }
}
