//! Shader texts for one harmonic set and time grid, and what naga reads in them.
//!
//! The texts are the files of `shaders/` behind a few generated constants. Binding numbers, sizes of elements, numbers of
//! elements per state and workgroup sizes are read from the parsed text: nothing of it is written a second time here.

use super::error::GpuError;
use super::settings::Precision;
use crate::aft::AftPlan;
use crate::aft::Laps;
use crate::aft::TangentBlock;
use crate::contact::{Events, FrictionLaw, Real};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write;
use wgpu::naga;

/// Which march a shader does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum MarchKind {
    /// Box law with located events.
    Box,
    /// Circle law decided at the samples; whether the instant of closing is interpolated.
    SampledCircle {
        /// See above.
        interpolated: bool,
    },
    /// Circle law with located events.
    LocatedCircle,
}

/// A pass over a batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pass {
    /// Entry point.
    pub name: &'static str,
    /// Threads per state, of a shape.
    pub rows: fn(&ShaderKey) -> u32,
    /// Whether it is for derivatives alone.
    pub only_tangents: bool,
}

/// What decides a shader text.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ShaderKey {
    /// Harmonic orders above 0.
    pub(super) orders: Vec<u32>,
    /// Samples per period.
    pub(super) n_time: u32,
    /// Passes over the period; 0 = until the slider is periodic.
    pub(super) laps: u32,
    /// Law, and how it is decided.
    pub(super) march: MarchKind,
    /// Numbers.
    pub(super) precision: Precision,
}

/// Loop iterations that one invocation may need at most on a software adapter: a widespread one ends loops silently after
/// 65 535 in all.
const MOST_ITERATIONS: usize = 60_000;

/// Highest harmonic for which kernels are compiled for a software adapter: each set of harmonics takes it about 10 s.
const HIGHEST_ON_SOFTWARE: u32 = 21;

/// Laps after which the shader of the circle law gives up.
const MOST_CIRCLE_LAPS: usize = 40;

const fn always(name: &'static str, rows: fn(&ShaderKey) -> u32) -> Pass {
    Pass {
        name,
        rows,
        only_tangents: false,
    }
}

const fn for_tangents(name: &'static str, rows: fn(&ShaderKey) -> u32) -> Pass {
    Pass {
        name,
        rows,
        only_tangents: true,
    }
}

const BOX_PASSES: [Pass; 5] = [
    always("transform", |shape| shape.n_time),
    always("box_march", |_| 2),
    always("spectra_of_runs", |_| 2),
    always("forces", |shape| 3 * shape.rows()),
    for_tangents("tangents_of_moving", ShaderKey::rows),
];
const SAMPLED_CIRCLE_PASSES: [Pass; 4] = [
    always("transform", |shape| shape.n_time),
    always("circle_march", |_| 1),
    always("forces", |shape| 3 * shape.rows()),
    for_tangents("circle_sampled_tangents", |shape| 3 * shape.rows()),
];
const LOCATED_CIRCLE_PASSES: [Pass; 7] = [
    always("transform", |shape| shape.n_time),
    always("gap_roots", |_| 1),
    always("circle_march", |_| 1),
    always("forces", |shape| 3 * shape.rows()),
    for_tangents("circle_steps", |shape| shape.n_time),
    for_tangents("circle_located_tangents", |shape| 3 * shape.rows()),
    for_tangents("circle_anchored_tangents", |shape| 3 * shape.rows()),
];

/// Evaluations of polynomials in the root searches of one event. Seen cut: 13 harmonics at 256 samples, all in motion.
const ROOT_LOOPS: usize = 60;

impl ShaderKey {
    /// The shape that evaluates `plan`; `None` where there is no shader for it.
    #[must_use]
    pub fn of<T: Real>(plan: &AftPlan<T>, precision: Precision) -> Option<Self> {
        let settings = plan.settings();
        let march = match (settings.law, settings.events) {
            (FrictionLaw::Box, Events::Located) => MarchKind::Box,
            (FrictionLaw::Circle, Events::Located) => MarchKind::LocatedCircle,
            (FrictionLaw::Circle, Events::Interpolated) => {
                MarchKind::SampledCircle { interpolated: true }
            }
            (FrictionLaw::Circle, Events::Sampled) => MarchKind::SampledCircle {
                interpolated: false,
            },
            (FrictionLaw::Box, Events::Interpolated | Events::Sampled) => return None,
        };
        let whole = |x: usize| u32::try_from(x).ok();
        let shape = Self {
            orders: (plan.orders[1..].iter().map(|&k| whole(k))).collect::<Option<_>>()?,
            n_time: whole(settings.n_time)?,
            laps: match (settings.laps, march) {
                (Laps::Fixed(n), _) => whole(n)?,
                (Laps::Periodic, MarchKind::Box) => 2,
                (Laps::Periodic, _) => 0,
            },
            march,
            precision,
        };
        Some(shape)
    }

    /// Highest order.
    fn highest(&self) -> u32 {
        self.orders.last().copied().unwrap_or(1)
    }

    /// Coefficients per displacement, m.
    pub(super) fn n_coefficients(&self) -> usize {
        2 * self.orders.len() + 1
    }

    /// Rows of a block.
    fn rows(&self) -> u32 {
        2 * self.orders.len() as u32 + 1
    }

    /// Terms of a Taylor series over one interval that reach rounding for the highest order.
    fn terms(&self) -> usize {
        let reach = f64::from(self.highest()) * TAU / f64::from(self.n_time);
        let (mut term, mut n) = (1.0, 1);
        while term > 0.1 * self.precision.epsilon() {
            term *= reach / n as f64;
            n += 1;
        }
        n.max(4)
    }

    /// Names and sizes of the arrays for what a state may do over a period; per direction in the box law.
    fn capacities(&self) -> Vec<(&'static str, usize)> {
        let highest = self.highest() as usize;
        match self.march {
            MarchKind::Box => self.box_capacities().into(),
            MarchKind::SampledCircle { .. } => Vec::new(),
            // a gap function of this order has no more roots, but for one counted twice at a sample
            MarchKind::LocatedCircle => vec![
                ("MAX_ROOTS", 4 + 2 * highest),
                ("MAX_EVENTS", 24 + 4 * highest),
            ],
        }
    }

    fn box_capacities(&self) -> [(&'static str, usize); 3] {
        let highest = self.highest() as usize;
        [
            ("MAX_POINTS", 24 + 4 * highest),
            ("MAX_RUNS", 24 + 2 * highest),
            ("MAX_STICKS", 8 + highest / 2),
        ]
    }

    /// Whether the kernels are worth compiling for a software adapter, and no invocation can need more loop iterations than it
    /// counts, silently. Box law: the march with
    /// its whole capacity for events used, series and root searches at every one of them. Circle law: all laps, and the sums of
    /// the last one; with located events the shader counts what it spends, and leaves what would be too much undecided.
    #[must_use]
    pub fn suits_software(&self) -> bool {
        let (n_time, m) = (self.n_time as usize, self.n_coefficients());
        let iterations = match self.march {
            MarchKind::Box => {
                let [(_, points), (_, runs), _] = self.box_capacities();
                let event = self.terms() * (2 * self.orders.len() + ROOT_LOOPS);
                3 * n_time + (points + runs) * event + self.laps as usize * points
            }
            MarchKind::SampledCircle { .. } => {
                n_time * (MOST_CIRCLE_LAPS.max(self.laps as usize) + m + 2)
            }
            MarchKind::LocatedCircle => n_time * (MOST_CIRCLE_LAPS + m + 2),
        };
        self.highest() <= HIGHEST_ON_SOFTWARE && iterations <= MOST_ITERATIONS
    }

    /// Blocks of a derivative in the order of the shaders.
    pub(crate) fn blocks(&self) -> &'static [TangentBlock] {
        match self.march {
            MarchKind::Box => &[
                TangentBlock::T1T1,
                TangentBlock::T2T2,
                TangentBlock::T1N,
                TangentBlock::T2N,
                TangentBlock::NN,
            ],
            MarchKind::SampledCircle { .. } | MarchKind::LocatedCircle => &TangentBlock::ALL,
        }
    }

    /// Passes in their order.
    pub(super) fn passes(&self) -> &'static [Pass] {
        match self.march {
            MarchKind::Box => &BOX_PASSES,
            MarchKind::SampledCircle { .. } => &SAMPLED_CIRCLE_PASSES,
            MarchKind::LocatedCircle => &LOCATED_CIRCLE_PASSES,
        }
    }

    /// The whole shader text, for `hardware` or for a software adapter, on which the iterations of loops are bounded.
    #[must_use]
    pub fn text(&self, hardware: bool) -> String {
        let mut text = self.constants(hardware);
        text.push_str(include_str!("../../../shaders/shared.wgsl"));
        text.push_str(include_str!("../../../shaders/transform.wgsl"));
        text.push_str(include_str!("../../../shaders/forces.wgsl"));
        self.parts().iter().for_each(|part| text.push_str(part));
        text
    }

    /// The generated constants.
    fn constants(&self, hardware: bool) -> String {
        let most_iterations = if hardware {
            u32::MAX as usize
        } else {
            MOST_ITERATIONS
        };
        let mut text = format!("alias real = {};\n", self.precision.name());
        let whole = [
            ("HARMONICS", self.orders.len()),
            ("HIGHEST", self.highest() as usize),
            ("N_TIME", self.n_time as usize),
            ("TERMS", self.terms()),
            ("LAPS", self.laps as usize),
            ("BLOCKS", self.blocks().len()),
            ("MAX_ITERATIONS", most_iterations),
        ];
        for (name, value) in whole.into_iter().chain(self.capacities()) {
            // writing to a string cannot fail
            let _ = writeln!(text, "const {name}: u32 = {value}u;");
        }
        for (name, value) in [
            ("STEP", TAU / f64::from(self.n_time)),
            ("RESOLUTION", 2.0 * self.precision.epsilon()),
            // the front end takes no roots of constants in double precision
            (
                "ROOT_OF_RESOLUTION",
                (2.0 * self.precision.epsilon()).sqrt(),
            ),
        ] {
            let _ = writeln!(text, "const {name}: real = {value:e};");
        }
        let interpolated = self.march == MarchKind::SampledCircle { interpolated: true };
        let _ = writeln!(text, "const INTERPOLATED: bool = {interpolated};");
        text
    }

    /// The texts of the law.
    fn parts(&self) -> &'static [&'static str] {
        match self.march {
            MarchKind::Box => &[
                include_str!("../../../shaders/polynomial.wgsl"),
                include_str!("../../../shaders/masks.wgsl"),
                include_str!("../../../shaders/box_march.wgsl"),
                include_str!("../../../shaders/box_spectra.wgsl"),
                include_str!("../../../shaders/box_forces.wgsl"),
                include_str!("../../../shaders/box_tangents.wgsl"),
            ],
            MarchKind::SampledCircle { .. } => &[
                include_str!("../../../shaders/circle.wgsl"),
                include_str!("../../../shaders/circle_sampled_lap.wgsl"),
                include_str!("../../../shaders/circle_sampled_forces.wgsl"),
                include_str!("../../../shaders/circle_sampled_tangents.wgsl"),
            ],
            MarchKind::LocatedCircle => &[
                include_str!("../../../shaders/polynomial.wgsl"),
                include_str!("../../../shaders/masks.wgsl"),
                include_str!("../../../shaders/circle.wgsl"),
                include_str!("../../../shaders/circle_slip.wgsl"),
                include_str!("../../../shaders/roots.wgsl"),
                include_str!("../../../shaders/circle_located_lap.wgsl"),
                include_str!("../../../shaders/circle_located_sensitivity.wgsl"),
                include_str!("../../../shaders/circle_located_node.wgsl"),
                include_str!("../../../shaders/circle_located_course.wgsl"),
                include_str!("../../../shaders/circle_located_kink.wgsl"),
                include_str!("../../../shaders/circle_located_transition.wgsl"),
                include_str!("../../../shaders/circle_located_lap_march.wgsl"),
                include_str!("../../../shaders/circle_gap_roots.wgsl"),
                include_str!("../../../shaders/circle_located_forces.wgsl"),
                include_str!("../../../shaders/circle_located_tangents.wgsl"),
            ],
        }
    }

    /// cos and sin of the n-th parts of a turn. Shape: `[2][n_time]`.
    pub(super) fn circle(&self) -> Vec<f64> {
        let phases = crate::harmonics::phases(self.n_time as usize);
        let cosines = phases.iter().map(|phase| phase.cos());
        cosines
            .chain(phases.iter().map(|phase| phase.sin()))
            .collect()
    }
}

/// How a shader reaches a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Uniform.
    Uniform,
    /// Storage, read only.
    Read,
    /// Storage.
    ReadWrite,
}

/// A buffer as the shader declares it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// Binding number.
    pub number: u32,
    /// Access.
    pub access: Access,
    /// Bytes of an array's element, or of the whole where it is no array.
    pub element_bytes: u64,
    /// Elements per state of an array that the text gives them for.
    pub per_state: Option<u64>,
}

/// What a shader text declares.
#[derive(Debug, Clone)]
pub struct Reflection {
    /// Buffers by name.
    pub bindings: BTreeMap<String, Binding>,
    /// Threads per workgroup, the same for every entry point.
    pub group: u32,
    /// Entry points.
    pub entry_points: Vec<String>,
}

impl Reflection {
    /// Parses and validates a shader text.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with what naga says.
    pub fn of(text: &str) -> Result<Self, GpuError> {
        let refused = |message: String| GpuError::Shader { message };
        let module = naga::front::wgsl::parse_str(text)
            .map_err(|error| refused(error.emit_to_string(text)))?;
        let capabilities = naga::valid::Capabilities::FLOAT64;
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
            .validate(&module)
            .map_err(|error| refused(error.emit_to_string(text)))?;
        let mut layouter = naga::proc::Layouter::default();
        layouter
            .update(module.to_ctx())
            .map_err(|error| refused(error.to_string()))?;
        let mut bindings = BTreeMap::new();
        for (_, variable) in module.global_variables.iter() {
            let (Some(name), Some(binding)) = (&variable.name, &variable.binding) else {
                continue;
            };
            let access = match variable.space {
                naga::AddressSpace::Uniform => Access::Uniform,
                naga::AddressSpace::Storage { access } => {
                    match access.contains(naga::StorageAccess::STORE) {
                        true => Access::ReadWrite,
                        false => Access::Read,
                    }
                }
                _ => continue,
            };
            let element_bytes = match module.types[variable.ty].inner {
                naga::TypeInner::Array { stride, .. } => stride,
                _ => layouter[variable.ty].size,
            };
            let per_state = constant(&module, &format!("{}_PER_STATE", name.to_uppercase()));
            bindings.insert(
                name.clone(),
                Binding {
                    number: binding.binding,
                    access,
                    element_bytes: u64::from(element_bytes),
                    per_state: per_state.map(u64::from),
                },
            );
        }
        let groups = module.entry_points.iter().map(|entry| entry.workgroup_size);
        let group = match groups.clone().next() {
            Some([group, 1, 1]) if groups.clone().all(|other| other == [group, 1, 1]) => group,
            _ => {
                return Err(refused(
                    "entry points must share one workgroup size".to_owned(),
                ));
            }
        };
        Ok(Self {
            bindings,
            group,
            entry_points: (module.entry_points.iter().map(|entry| entry.name.clone())).collect(),
        })
    }
}

/// Value of a whole constant of the module.
fn constant(module: &naga::Module, name: &str) -> Option<u32> {
    let (_, constant) = (module.constants.iter()).find(|(_, c)| c.name.as_deref() == Some(name))?;
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(naga::Literal::U32(value)) => Some(value),
        _ => None,
    }
}
