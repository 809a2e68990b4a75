//! Geometry, material, damping and loads of the rig, as a user writes them.

use crate::setting::{BadSetting, LARGEST, Plain, positive, unusual, within, without_round_off};

/// Lengths that a part of a rig can have (mm).
const LENGTH_MM: [f64; 2] = [1e-3, 1e4];
/// Young's moduli from rubber to beyond diamond (GPa).
const YOUNGS_MODULUS_GPA: [f64; 2] = [1e-3, 1e4];
/// Densities from foam to beyond osmium (kg/m³).
const DENSITY_KG_M3: [f64; 2] = [1.0, 1e5];
/// Densities of a strip, with what moves with it (kg/m³): a punch weighs a hundred times as much as a thin strip.
const STRIP_DENSITY_KG_M3: [f64; 2] = [1.0, 1e8];
/// Damping ratios: 1 is critical.
const DAMPING_RATIO: [f64; 2] = [0.0, 1.0];
/// Loads on a strip (N).
const LOAD_N: [f64; 2] = [1e-6, 1e9];
/// Usual Young's moduli (GPa) and densities (kg/m³): those of metals.
const USUAL_YOUNGS_MODULUS_GPA: [f64; 2] = [50.0, 500.0];
const USUAL_DENSITY_KG_M3: [f64; 2] = [1500.0, 2.0e4];
/// Usual damping ratios of a part without friction.
const USUAL_DAMPING_RATIO: [f64; 2] = [0.0, 0.05];
/// Usual loads on a strip (N).
const USUAL_LOAD_N: [f64; 2] = [0.1, 1e5];
/// Stiffness of the retention (N/m): round-off would spoil the strip's own stiffness beyond.
const RETENTION_N_PER_M: [f64; 2] = [1e-6, 1e15];
/// Highest cut-off (Hz): above it no mesh of a blade has a mode.
const HIGHEST_CUT_OFF_HZ: f64 = 1e9;
/// Contact nodes in one direction at most.
const MOST_CONTACT_NODES: usize = 50;
/// Spacing of contact nodes at the gap over that of Gauss' rule; below, nodes at the gap would stand for next to nothing.
const SPACING_AT_GAP: [f64; 2] = [0.1, 1.0];
/// Elements of a component at most: some gigabytes of memory.
const MOST_ELEMENTS: f64 = 1e5;

/// Relative sign of the two excitation forces.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Equal forces in x: both blades move the same way, the platforms' edges shear and lift against each other.
    InPhase,
    /// Mirrored forces: the gap opens and closes.
    OutOfPhase,
}

/// The rig: two mirror-image blades, each a clamped neck, a platform and an airfoil, and a strip under both platforms.
///
/// The default geometry is ours (steel, 0.27 kg per blade); it is tuned to the published relations between free and
/// stuck frequencies and between platform and airfoil motion, not to any published dimension. Damping and the
/// direction of the force (oblique, as on a staggered blade) set the force scale at which the strip slips.
///
/// Axes: x from blade 1 to blade 2, y along the gap, z radially outwards. Blade 1 is the one at x < 0.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TwoBladeSettings {
    /// Neck, x × y × z (mm); clamped at its foot.
    #[serde(deserialize_with = "crate::setting::exactly")]
    #[schemars(inner(range(min = LENGTH_MM[0], max = LENGTH_MM[1])))]
    pub neck_mm: [f64; 3],
    /// Platform on top of the neck, x × y × z (mm).
    #[serde(deserialize_with = "crate::setting::exactly")]
    #[schemars(inner(range(min = LENGTH_MM[0], max = LENGTH_MM[1])))]
    pub platform_mm: [f64; 3],
    /// Airfoil on top of the platform, x × y × z (mm).
    #[serde(deserialize_with = "crate::setting::exactly")]
    #[schemars(inner(range(min = LENGTH_MM[0], max = LENGTH_MM[1])))]
    pub airfoil_mm: [f64; 3],
    /// Offset of the airfoil in y (mm); couples bending and torsion.
    #[schemars(range(min = -LENGTH_MM[1], max = LENGTH_MM[1]))]
    pub airfoil_offset_mm: f64,
    /// Gap between the platforms (mm).
    #[schemars(range(min = LENGTH_MM[0], max = LENGTH_MM[1]))]
    pub gap_mm: f64,
    /// Strip, x × y × z (mm), centred under the gap.
    #[serde(deserialize_with = "crate::setting::exactly")]
    #[schemars(inner(range(min = LENGTH_MM[0], max = LENGTH_MM[1])))]
    pub strip_mm: [f64; 3],
    /// Young's modulus of the blades, and of a strip without its own (GPa).
    #[schemars(range(min = YOUNGS_MODULUS_GPA[0], max = YOUNGS_MODULUS_GPA[1]))]
    pub youngs_modulus_gpa: f64,
    /// Poisson's ratio.
    #[schemars(extend("exclusiveMinimum" = -1, "exclusiveMaximum" = 0.5))]
    pub poisson_ratio: f64,
    /// Density of the blades, and of a strip without its own (kg/m³).
    #[schemars(range(min = DENSITY_KG_M3[0], max = DENSITY_KG_M3[1]))]
    pub density_kg_m3: f64,
    /// Young's modulus of the strip (GPa); that of the blades if absent.
    #[schemars(range(min = YOUNGS_MODULUS_GPA[0], max = YOUNGS_MODULUS_GPA[1]))]
    pub strip_youngs_modulus_gpa: Option<f64>,
    /// Density of the strip, with what moves with it (kg/m³); that of the blades if absent. It changes no load.
    #[schemars(range(min = STRIP_DENSITY_KG_M3[0], max = STRIP_DENSITY_KG_M3[1]))]
    pub strip_density_kg_m3: Option<f64>,
    /// Contact nodes per interface, [across the gap, along it]: points of Gauss' rule, each with a patch around it. At least two along the
    /// gap; one across it holds no moment about the gap.
    #[serde(deserialize_with = "crate::setting::exactly")]
    #[schemars(inner(range(min = 1, max = MOST_CONTACT_NODES)))]
    pub contact_nodes: [usize; 2],
    /// Distance of the contact nodes from each other next to the gap, over that of Gauss' rule; 1 is the rule itself. The strip bends
    /// within some millimetres of the gap, and closer nodes resolve that. Fewer than three nodes across the gap need 1: with others
    /// they would not hold a platform that rotates as the interface does.
    #[schemars(range(min = SPACING_AT_GAP[0], max = SPACING_AT_GAP[1]))]
    pub contact_spacing_at_gap: f64,
    /// Longest element edges in the blades along x, y, z (mm).
    #[serde(deserialize_with = "crate::setting::exactly")]
    #[schemars(inner(range(min = LENGTH_MM[0], max = LENGTH_MM[1])))]
    pub blade_element_mm: [f64; 3],
    /// Longest element edge in the strip (mm); one layer through its thickness. Edges and middles of the contact patches
    /// are grid lines besides, so that across the gap the mesh is finer than the contact grid.
    #[schemars(range(min = LENGTH_MM[0], max = LENGTH_MM[1]))]
    pub strip_element_mm: f64,
    /// Craig-Bampton modes of a blade (contact patches, excited and response nodes held) are kept below this frequency (Hz);
    /// above the band. 18 modes with the default; `inspect` shows how many and the first one left out.
    #[schemars(range(max = HIGHEST_CUT_OFF_HZ), extend("exclusiveMinimum" = 0))]
    pub blade_cut_off_hz: f64,
    /// Craig-Bampton modes of the strip are kept below this frequency (Hz); the mean displacement of every contact patch is at
    /// rest in them. 18 modes with the default.
    #[schemars(range(max = HIGHEST_CUT_OFF_HZ), extend("exclusiveMinimum" = 0))]
    pub strip_cut_off_hz: f64,
    /// Damping ratio of every blade mode.
    #[schemars(range(min = DAMPING_RATIO[0], max = DAMPING_RATIO[1]))]
    pub blade_damping_ratio: f64,
    /// Damping ratio of the strip at 1 kHz; grows with frequency (stiffness-proportional). The default is between steel
    /// (Q of 3000 to 10000) and joints (Q of 15 to 250), Q = 1/(2 ratio) as Gastaldi, Berruti & Gola 2018 have them.
    #[schemars(range(min = DAMPING_RATIO[0], max = DAMPING_RATIO[1]))]
    pub strip_damping_ratio: f64,
    /// Centrifugal load on the strip (N), towards +z; of a strip as thick as `strip_mm` says.
    #[schemars(range(min = LOAD_N[0], max = LOAD_N[1]))]
    pub centrifugal_load_n: f64,
    /// Share of the load of each contact node (any scale), in the order of the contact pairs; without it the load is
    /// a uniform body force.
    #[schemars(inner(range(min = 0)))]
    pub pressure_weights: Option<Vec<f64>>,
    /// Stiffness that holds the mean in-plane motion of the strip, harmonic 0 only (N/m). It decides nothing but
    /// the position at which a strip in gross slip settles.
    #[schemars(range(min = RETENTION_N_PER_M[0], max = RETENTION_N_PER_M[1]))]
    pub retention_n_per_m: f64,
    /// Height of the excited point over the airfoil's root, as a fraction of the airfoil.
    #[schemars(range(min = 0, max = 1))]
    pub excitation_height: f64,
    /// Direction of the force on blade 1.
    #[serde(deserialize_with = "crate::setting::exactly")]
    #[schemars(inner(range(min = -LARGEST, max = LARGEST)))]
    pub excitation_direction: [f64; 3],
    /// Sign of the force on blade 2.
    pub excitation_phase: Phase,
    /// Height of the response point over the airfoil's root, as a fraction of the airfoil.
    #[schemars(range(min = 0, max = 1))]
    pub response_height: f64,
}

impl Default for TwoBladeSettings {
    fn default() -> Self {
        Self {
            neck_mm: [25.1, 15.2, 18.4],
            platform_mm: [38.8, 50.0, 9.0],
            airfoil_mm: [4.6, 25.2, 94.1],
            airfoil_offset_mm: 8.6,
            gap_mm: 0.6,
            strip_mm: [10.0, 50.0, 0.4],
            youngs_modulus_gpa: 210.0,
            poisson_ratio: 0.3,
            density_kg_m3: 7850.0,
            strip_youngs_modulus_gpa: None,
            strip_density_kg_m3: None,
            contact_nodes: [5, 3],
            contact_spacing_at_gap: 1.0,
            blade_element_mm: [5.0, 12.5, 5.0],
            strip_element_mm: 5.0,
            blade_cut_off_hz: 35e3,
            strip_cut_off_hz: 5e4,
            blade_damping_ratio: 2e-4,
            strip_damping_ratio: 2e-3,
            centrifugal_load_n: 180.0,
            pressure_weights: None,
            retention_n_per_m: 1e7,
            excitation_height: 0.0,
            excitation_direction: [0.8, -0.6, 0.0],
            excitation_phase: Phase::InPhase,
            response_height: 0.738,
        }
    }
}

impl TwoBladeSettings {
    /// Checks every rule, also those between the parts of the geometry.
    ///
    /// # Errors
    /// The first [`BadSetting`].
    pub fn validate(&self) -> Result<(), BadSetting> {
        self.validate_geometry()?;
        self.validate_discretisation()?;
        self.validate_physics()
    }

    /// What may be meant but is unusual; keys relative to `[model]`.
    #[must_use]
    pub fn unusual(&self) -> Vec<BadSetting> {
        let values = [
            (
                "youngs_modulus_gpa",
                self.youngs_modulus_gpa,
                USUAL_YOUNGS_MODULUS_GPA,
            ),
            ("density_kg_m3", self.density_kg_m3, USUAL_DENSITY_KG_M3),
            (
                "blade_damping_ratio",
                self.blade_damping_ratio,
                USUAL_DAMPING_RATIO,
            ),
            (
                "strip_damping_ratio",
                self.strip_damping_ratio,
                USUAL_DAMPING_RATIO,
            ),
            ("centrifugal_load_n", self.centrifugal_load_n, USUAL_LOAD_N),
        ];
        let of_strip = [
            (
                "strip_youngs_modulus_gpa",
                self.strip_youngs_modulus_gpa,
                USUAL_YOUNGS_MODULUS_GPA,
            ),
            (
                "strip_density_kg_m3",
                self.strip_density_kg_m3,
                USUAL_DENSITY_KG_M3,
            ),
        ];
        let given = of_strip
            .into_iter()
            .filter_map(|(key, value, usual)| Some((key, value?, usual)));
        let found = (values.into_iter().chain(given))
            .filter_map(|(key, value, usual)| unusual(key, value, usual));
        found.collect()
    }

    fn validate_geometry(&self) -> Result<(), BadSetting> {
        let solids = [
            ("neck_mm", self.neck_mm),
            ("platform_mm", self.platform_mm),
            ("airfoil_mm", self.airfoil_mm),
            ("strip_mm", self.strip_mm),
        ];
        for (key, lengths) in solids {
            for length in lengths {
                within(key, length, LENGTH_MM)?;
            }
        }
        within("gap_mm", self.gap_mm, LENGTH_MM)?;
        let (offset, most) = (self.airfoil_offset_mm, LENGTH_MM[1]);
        within("airfoil_offset_mm", offset, [-most, most])?;
        let (thickness, height) = (self.strip_mm[2], self.neck_mm[2]);
        let rule = "must not be thicker than the neck is high";
        BadSetting::unless(thickness <= height, "strip_mm", thickness, rule)?;
        let fits = |part: f64, offset: f64, whole: f64| part + 2.0 * offset.abs() <= whole + 1e-9;
        for axis in 0..2 {
            BadSetting::unless(
                fits(self.neck_mm[axis], 0.0, self.platform_mm[axis]),
                "neck_mm",
                self.neck_mm[axis],
                "must not be wider than the platform",
            )?;
        }
        BadSetting::unless(
            self.airfoil_mm[0] <= self.platform_mm[0]
                && fits(
                    self.airfoil_mm[1],
                    self.airfoil_offset_mm,
                    self.platform_mm[1],
                ),
            "airfoil_offset_mm",
            self.airfoil_offset_mm,
            "the airfoil must stand on the platform",
        )?;
        BadSetting::unless(
            self.gap_mm < self.strip_mm[0],
            "gap_mm",
            self.gap_mm,
            "must be narrower than the strip",
        )?;
        BadSetting::unless(
            self.strip_mm[1] <= self.platform_mm[1] + 1e-9,
            "strip_mm",
            self.strip_mm[1],
            "must not be longer than the platform",
        )?;
        let overhang = 0.5 * (self.platform_mm[0] - self.neck_mm[0]);
        BadSetting::unless(
            overhang + 1e-9 >= self.strip_overlap_mm(),
            "strip_mm",
            self.strip_mm[0],
            "must fit under the platform without touching the neck",
        )
    }

    fn validate_discretisation(&self) -> Result<(), BadSetting> {
        for edge in self.blade_element_mm {
            within("blade_element_mm", edge, LENGTH_MM)?;
        }
        within("strip_element_mm", self.strip_element_mm, LENGTH_MM)?;
        for (key, cut_off) in self.cut_offs() {
            positive(key, cut_off)?;
            within(key, cut_off, [0.0, HIGHEST_CUT_OFF_HZ])?;
        }
        let [across, along] = self.contact_nodes;
        BadSetting::unless(
            (1..=MOST_CONTACT_NODES).contains(&across) && (2..=MOST_CONTACT_NODES).contains(&along),
            "contact_nodes",
            format!("{:?}", self.contact_nodes),
            &format!(
                "needs 2 to {MOST_CONTACT_NODES} nodes along the gap, 1 to {MOST_CONTACT_NODES} across it"
            ),
        )?;
        within(
            "contact_spacing_at_gap",
            self.contact_spacing_at_gap,
            SPACING_AT_GAP,
        )?;
        BadSetting::unless(
            across >= 3 || self.contact_spacing_at_gap == 1.0,
            "contact_spacing_at_gap",
            self.contact_spacing_at_gap,
            "must be 1 with fewer than three contact_nodes across the gap",
        )?;
        self.validate_elements()?;
        for (key, height) in [
            ("excitation_height", self.excitation_height),
            ("response_height", self.response_height),
        ] {
            BadSetting::unless(
                (0.0..=1.0).contains(&height),
                key,
                height,
                "must lie in 0 ..= 1",
            )?;
        }
        Ok(())
    }

    /// Bounds the meshes before they are made.
    fn validate_elements(&self) -> Result<(), BadSetting> {
        let elements = |solid: [f64; 3], edges: [f64; 3]| -> f64 {
            (0..3).map(|i| (solid[i] / edges[i]).ceil()).product()
        };
        let blade = [self.neck_mm, self.platform_mm, self.airfoil_mm];
        let of_blade = blade.map(|solid| elements(solid, self.blade_element_mm));
        let [x, y, z] = self.strip_mm;
        let edge = self.strip_element_mm;
        let of_strip = elements([x, y, z], [edge, edge, z]);
        let meshes = [
            ("blade_element_mm", of_blade.iter().sum::<f64>()),
            ("strip_element_mm", of_strip),
        ];
        for (key, count) in meshes {
            let rule = format!("must be longer: they give more than {MOST_ELEMENTS:e} elements");
            let written = format!("edges for {count:.0} elements");
            BadSetting::unless(count <= MOST_ELEMENTS, key, written, &rule)?;
        }
        Ok(())
    }

    fn cut_offs(&self) -> [(&'static str, f64); 2] {
        [
            ("blade_cut_off_hz", self.blade_cut_off_hz),
            ("strip_cut_off_hz", self.strip_cut_off_hz),
        ]
    }

    /// Refuses a cut-off of the blades inside the band up to `highest_hz` (Hz), where modes would be missing.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[model]`.
    pub fn check_band(&self, highest_hz: f64) -> Result<(), BadSetting> {
        let end = Plain(without_round_off(highest_hz));
        let rule = format!("must be above the band of [frequency], which ends at {end} Hz");
        let value = self.blade_cut_off_hz;
        BadSetting::unless(value > highest_hz, "blade_cut_off_hz", value, &rule)
    }

    fn validate_physics(&self) -> Result<(), BadSetting> {
        within(
            "youngs_modulus_gpa",
            self.youngs_modulus_gpa,
            YOUNGS_MODULUS_GPA,
        )?;
        within("density_kg_m3", self.density_kg_m3, DENSITY_KG_M3)?;
        let (key, modulus) = ("strip_youngs_modulus_gpa", self.strip_youngs_modulus_gpa);
        modulus.map_or(Ok(()), |gpa| within(key, gpa, YOUNGS_MODULUS_GPA))?;
        let (key, density) = ("strip_density_kg_m3", self.strip_density_kg_m3);
        density.map_or(Ok(()), |rho| within(key, rho, STRIP_DENSITY_KG_M3))?;
        BadSetting::unless(
            self.poisson_ratio > -1.0 && self.poisson_ratio < 0.5,
            "poisson_ratio",
            self.poisson_ratio,
            "must lie between -1 and 0.5",
        )?;
        within(
            "blade_damping_ratio",
            self.blade_damping_ratio,
            DAMPING_RATIO,
        )?;
        within(
            "strip_damping_ratio",
            self.strip_damping_ratio,
            DAMPING_RATIO,
        )?;
        within("centrifugal_load_n", self.centrifugal_load_n, LOAD_N)?;
        within(
            "retention_n_per_m",
            self.retention_n_per_m,
            RETENTION_N_PER_M,
        )?;
        BadSetting::unless(
            self.excitation_direction.iter().all(|d| d.abs() <= LARGEST)
                && self.excitation_direction.iter().any(|d| *d != 0.0),
            "excitation_direction",
            format!("{:?}", self.excitation_direction),
            "must be a vector of numbers up to 1e30, not zero",
        )?;
        let Some(weights) = &self.pressure_weights else {
            return Ok(());
        };
        let n_pairs = 2 * self.contact_nodes[0] * self.contact_nodes[1];
        BadSetting::unless(
            weights.len() == n_pairs
                && weights.iter().all(|w| w.is_finite() && *w >= 0.0)
                && weights.iter().sum::<f64>() > 0.0,
            "pressure_weights",
            format!("{} values", weights.len()),
            &format!("needs {n_pairs} values >= 0, one per contact pair, not all zero"),
        )
    }

    /// The same rig at the same speed with a strip of another thickness (mm).
    ///
    /// The centrifugal load m r Ω² grows with the mass of the strip; that r changes by half of the thickness is left out.
    #[must_use]
    pub fn with_strip_thickness(&self, thickness_mm: f64) -> Self {
        let [x, y, nominal_mm] = self.strip_mm;
        Self {
            strip_mm: [x, y, thickness_mm],
            centrifugal_load_n: self.centrifugal_load_n * (thickness_mm / nominal_mm),
            ..self.clone()
        }
    }

    /// Young's modulus (GPa) and density (kg/m³) of the strip.
    #[must_use]
    pub fn strip_material(&self) -> (f64, f64) {
        (
            self.strip_youngs_modulus_gpa
                .unwrap_or(self.youngs_modulus_gpa),
            self.strip_density_kg_m3.unwrap_or(self.density_kg_m3),
        )
    }

    /// Width of the strip under one platform (mm).
    #[must_use]
    pub fn strip_overlap_mm(&self) -> f64 {
        0.5 * (self.strip_mm[0] - self.gap_mm)
    }
}
