//! `import` and `pairs`: arguments, and what was read for comparison with the finite-element program.

use std::io::Write;
use std::path::PathBuf;

use super::log::Log;
use super::terminal::print;
use super::total_mass::show_mass;
use clap::{Args, ValueEnum};
use microslip::Error;
use microslip::file::refuse_inputs;
use microslip::import::{
    ImportError, Imported, PairConstants, Proposal, Reduction, ReductionFacts, Request, Role,
    Source, Units, import, propose,
};
use microslip::setting::{BadSetting, non_negative, positive, within};
use microslip::study::Study;

#[derive(Args)]
#[command(after_help = FORMATS)]
pub(super) struct ImportArguments {
    /// Files of matrices and of names; K=FILE, M=, C=, R=, F=, F0= say what a matrix is, FILE#NAME which one of a file.
    #[arg(required = true)]
    files: Vec<String>,
    /// Units of all files and tables. They are declared, never guessed; everything is written in SI units.
    #[arg(long, value_enum)]
    units: UnitsName,
    /// Folder that is written: matrices, names and study.toml. It must not exist or be empty.
    #[arg(long)]
    output: PathBuf,
    /// CSV table of contact pairs: node_a, node_b, and nx, ny, nz (from A into B), tx, ty, tz or system, area, interface, k_n,
    /// k_t, mu, n_0 or gap.
    #[arg(long)]
    pairs: Option<PathBuf>,
    /// CSV table of coordinates (node, x, y, z): normals of pairs that state none go from A to B.
    #[arg(long, requires = "pairs")]
    nodes: Option<PathBuf>,
    /// CSV table of coordinate systems (name, nx, ny, nz, and tx, ty, tz), which pairs name in the column system.
    #[arg(long, requires = "pairs")]
    systems: Option<PathBuf>,
    /// Normal stiffness of pairs that do not state it; per area where they state an area.
    #[arg(long, requires = "pairs")]
    k_n: Option<f64>,
    /// Tangential stiffness of pairs that do not state it; per area where they state an area.
    #[arg(long, requires = "pairs")]
    k_t: Option<f64>,
    /// Friction coefficient of pairs that do not state it.
    #[arg(long, requires = "pairs")]
    mu: Option<f64>,
    /// Normal force at zero approach of pairs that state neither it nor a gap; a pressure where they state an area.
    #[arg(long, requires = "pairs", allow_hyphen_values = true)]
    n_0: Option<f64>,
    /// Force of the excitation per unit level: DOF=COSINE or DOF=COSINE,SINE. May be given several times.
    #[arg(long, value_name = "DOF=FORCE")]
    excite: Vec<String>,
    /// CSV table of forces: dof, and cosine, sine, static.
    #[arg(long)]
    forces: Option<PathBuf>,
    /// What the loads in the files are (right-hand side of HBMAT, CLOAD, PAX); they are not used if absent.
    #[arg(long, value_enum)]
    load: Option<LoadKind>,
    /// Degree of freedom whose amplitude is reported; the first one defines the resonance. May be given several times.
    #[arg(long, value_name = "DOF")]
    response: Vec<String>,
    /// Damping ratio of every mode where no file has a damping matrix.
    #[arg(long, default_value_t = 0.002)]
    modal_damping_ratio: f64,
    /// Reduces the model by Craig-Bampton: the degrees of freedom of pairs, forces and responses are kept, and the modes below
    /// this frequency (Hz) with these held. Take three times the highest frequency of interest.
    #[arg(long, value_name = "HZ")]
    cut_off: Option<f64>,
    /// Node or degree of freedom that is kept too, such as 12 or 12.1. May be given several times.
    #[arg(long, requires = "cut_off", value_name = "NODE")]
    keep: Vec<String>,
    /// No list of what was read.
    #[arg(long)]
    quiet: bool,
}

const FORMATS: &str = "\
Formats: Abaqus and CalculiX *MATRIX OUTPUT and *SUBSTRUCTURE MATRIX OUTPUT, CalculiX .sti, .mas, .dof, ANSYS HBMAT with its
.mapping, Matrix Market (ANSYS *EXPORT,,MMF), Nastran DMIG and OUTPUT4 with names of a .pch or .asm beside it,
NumPy .npz and .npy, SciPy save_npz, MATLAB .mat of save -v7.

Example:
  microslip import K=blade_STIF1.mtx M=blade_MASS1.mtx --units mm-t-s --pairs pairs.csv --k-n 1e5 --k-t 1e5 --mu 0.4 \\
      --excite 12.1=1.0 --response 12.1 --output blade/";

/// Sets of units: length, mass, time.
#[derive(Clone, Copy, ValueEnum)]
enum UnitsName {
    /// m, kg, s: force in N.
    #[value(name = "SI", alias = "si")]
    Si,
    /// The same as SI.
    #[value(name = "m-kg-s")]
    MetreKilogramSecond,
    /// mm, t, s: force in N, stress in MPa.
    #[value(name = "mm-t-s")]
    MillimetreTonneSecond,
    /// mm, kg, ms: force in kN, stress in GPa.
    #[value(name = "mm-kg-ms")]
    MillimetreKilogramMillisecond,
}

impl UnitsName {
    fn units(self) -> Units {
        match self {
            Self::Si | Self::MetreKilogramSecond => Units::Si,
            Self::MillimetreTonneSecond => Units::MmTonneSecond,
            Self::MillimetreKilogramMillisecond => Units::MmKilogramMillisecond,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum LoadKind {
    /// Cosine part of the excitation, per unit level.
    Harmonic,
    /// Static force.
    Static,
}

/// An option outside its range.
fn bad(setting: BadSetting) -> Error {
    Error::Import(ImportError::Setting(setting))
}

impl ImportArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let request = self.request()?;
        let imported = import(&request)?;
        let mut warnings = imported.warnings.clone();
        let study = Study::read(&self.output.join("study.toml"));
        if let Err(error) = study.and_then(|study| study.build_model()) {
            warnings.push(format!("what is written cannot be run yet: {error}"));
        }
        Log::default().warn(&warnings);
        if self.quiet {
            return Ok(());
        }
        print(|out| {
            show(out, &imported)?;
            writeln!(out, "study.toml is in {}", self.output.display())
        })
    }

    fn request(&self) -> Result<Request, Error> {
        let constants = [("--k-n", self.k_n), ("--k-t", self.k_t), ("--mu", self.mu)];
        for (key, value) in constants {
            non_negative(key, value.unwrap_or(0.0)).map_err(bad)?;
        }
        let (least, most) = (-microslip::setting::LARGEST, microslip::setting::LARGEST);
        within("--n-0", self.n_0.unwrap_or(0.0), [least, most]).map_err(bad)?;
        let ratio = self.modal_damping_ratio;
        let rule = "must be a number from 0 to below 1";
        let valid = (0.0..1.0).contains(&ratio);
        BadSetting::unless(valid, "--modal-damping-ratio", ratio, rule).map_err(bad)?;
        if let Some(cut_off) = self.cut_off {
            positive("--cut-off", cut_off).map_err(bad)?;
        }
        Ok(Request {
            sources: self.files.iter().map(|word| Source::parse(word)).collect(),
            units: self.units.units(),
            output: self.output.clone(),
            pairs: self.pairs.clone(),
            nodes: self.nodes.clone(),
            systems: self.systems.clone(),
            constants: PairConstants {
                k_n: self.k_n,
                k_t: self.k_t,
                mu: self.mu,
                n_0: self.n_0,
            },
            excite: self.excite.clone(),
            forces: self.forces.clone(),
            load: self.load.map(|load| match load {
                LoadKind::Harmonic => Role::HarmonicForce,
                LoadKind::Static => Role::StaticForce,
            }),
            responses: self.response.clone(),
            damping_ratio: ratio,
            reduction: self.cut_off.map(|cut_off| Reduction {
                cut_off,
                keep: self.keep.clone(),
            }),
        })
    }
}

/// Files, sizes, mass, frequencies.
fn show(out: &mut dyn Write, imported: &Imported) -> std::io::Result<()> {
    show_files(out, imported)?;
    show_facts(out, imported)?;
    if let Some(reduced) = &imported.reduced {
        show_reduction(out, reduced, &imported.facts.frequencies_hz)?;
    }
    writeln!(out, "contact pairs       {}", imported.pairs)
}

fn show_files(out: &mut dyn Write, imported: &Imported) -> std::io::Result<()> {
    for file in &imported.files {
        let mut parts: Vec<String> = Vec::new();
        for (name, role) in &file.matrices {
            let letter = role.map_or("not used", Role::letter);
            parts.push(match name.as_str() {
                "" => letter.to_owned(),
                name => format!("{name} = {letter}"),
            });
        }
        parts.extend(file.names.map(|names| format!("{names} names")));
        writeln!(
            out,
            "read                {}: {}, {}",
            file.path.display(),
            file.format,
            parts.join(", ")
        )?;
    }
    Ok(())
}

fn show_facts(out: &mut dyn Write, imported: &Imported) -> std::io::Result<()> {
    let facts = &imported.facts;
    for matrix in &facts.matrices {
        writeln!(
            out,
            "{:20}{} rows, {} non-zeros, bandwidth {}, {} digits",
            format!("matrix {}", matrix.role.letter()),
            matrix.rows,
            matrix.non_zeros,
            matrix.bandwidth,
            matrix.digits
        )?;
    }
    let names: Vec<_> = imported
        .dofs
        .iter()
        .take(6)
        .map(ToString::to_string)
        .collect();
    writeln!(
        out,
        "degrees of freedom  {}: {} ...",
        imported.dofs.len(),
        names.join(", ")
    )?;
    show_mass(out, facts.total_mass, true)?;
    let numbers: Vec<_> = facts
        .frequencies_hz
        .iter()
        .map(|f| format!("{f:.6}"))
        .collect();
    writeln!(
        out,
        "free frequencies    {} Hz ({})",
        numbers.join(" "),
        facts.rigid
    )
}

/// What was kept, and what that changes.
fn show_reduction(
    out: &mut dyn Write,
    reduced: &ReductionFacts,
    full_hz: &[f64],
) -> std::io::Result<()> {
    writeln!(
        out,
        "reduced to          {} degrees of freedom: {} kept, {} modes below {} Hz (first left out: {:.6} Hz)",
        reduced.n_dofs, reduced.masters, reduced.modes, reduced.cut_off, reduced.first_left_out
    )?;
    if reduced.massless > 0 {
        writeln!(
            out,
            "without mass        {} degrees of freedom, condensed",
            reduced.massless
        )?;
    }
    if let Some(eigenvalue) = reduced.most_negative {
        writeln!(
            out,
            "made semidefinite   eigenvalues down to {eigenvalue:.1e} of a unit diagonal are zero: rounding of the files"
        )?;
    }
    let errors: Vec<_> = full_hz
        .iter()
        .zip(&reduced.frequencies_hz)
        .map(|(full, reduced)| format!("{:.1e}", reduced / full - 1.0))
        .collect();
    writeln!(out, "error of these      {} (relative)", errors.join(" "))
}

/// Nodes that are listed by number.
const LISTED: usize = 12;

#[derive(Args)]
pub(super) struct PairsArguments {
    /// CSV table of coordinates: node, x, y, z.
    nodes: PathBuf,
    /// CSV table of the nodes of surface A: node.
    a: PathBuf,
    /// CSV table of the nodes of surface B: node.
    b: PathBuf,
    /// Largest distance of two nodes of a pair, in the unit of the coordinates.
    #[arg(long)]
    tolerance: f64,
    /// Normal of all pairs, from A into B: x,y,z. If absent it goes from A to B.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    normal: Vec<f64>,
    /// Table that is written, to be checked and given to `import --pairs`.
    #[arg(long, default_value = "pairs.csv")]
    output: PathBuf,
}

impl PairsArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        positive("--tolerance", self.tolerance).map_err(bad)?;
        let are_finite = self.normal.iter().all(|c| c.is_finite());
        let normal = match self.normal[..] {
            [] => None,
            [x, y, z] if are_finite && self.normal.iter().any(|c| *c != 0.0) => Some([x, y, z]),
            _ => {
                let given: Vec<_> = self.normal.iter().map(f64::to_string).collect();
                let rule = "must be three finite numbers, not all 0: x,y,z";
                return Err(bad(BadSetting::new("--normal", given.join(","), rule)));
            }
        };
        let read = [&self.nodes, &self.a, &self.b].map(Clone::clone);
        refuse_inputs([self.output.clone()], &read)?;
        let found = propose(&self.nodes, &self.a, &self.b, self.tolerance, normal);
        let proposal = found.map_err(ImportError::File)?;
        proposal.write(&self.output).map_err(ImportError::File)?;
        print(|out| {
            show_proposal(out, &proposal)?;
            writeln!(
                out,
                "check {} before import --pairs reads it",
                self.output.display()
            )
        })
    }
}

fn show_proposal(out: &mut dyn Write, proposal: &Proposal) -> std::io::Result<()> {
    let farthest = proposal.pairs.iter().map(|pair| pair.distance);
    let farthest = farthest.fold(0.0, f64::max);
    writeln!(
        out,
        "pairs               {}, at most {farthest} apart",
        proposal.pairs.len()
    )?;
    let without = proposal.pairs.iter().filter(|pair| pair.normal.is_none());
    let without = without.count();
    if without > 0 {
        writeln!(
            out,
            "without a normal    {without}: both nodes are at one place; fill in nx, ny, nz, or give --normal"
        )?;
    }
    for (surface, left) in [("A", &proposal.left_a), ("B", &proposal.left_b)] {
        let numbers: Vec<_> = left.iter().take(LISTED).map(i64::to_string).collect();
        let more = if left.len() > LISTED { " ..." } else { "" };
        writeln!(
            out,
            "{:20}{} {}{more}",
            format!("left on surface {surface}"),
            left.len(),
            numbers.join(" ")
        )?;
    }
    Ok(())
}
