//! Import of a large model and its reduction: `cargo bench --bench reduction -- [cells along the thickness]`.
//!
//! A clamped blade of cubes, 1 : 2 : 8, as CalculiX writes its matrices (`.sti`, `.mas`, `.dof`). The nodes of a line across its
//! tip and of a patch on its side are kept, with the modes below three times the tenth frequency. 16 cells have 215 000
//! degrees of freedom.

#![expect(clippy::expect_used, reason = "a benchmark without its state fails")]

#[path = "../tests/common/memory.rs"]
mod memory;

use memory::most_memory_kb;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

use faer::sparse::SparseColMat;
use microslip::fe::{Cuboid, FeModel, Material, grid_lines, tensor_mesh};
use microslip::import::{PairConstants, Reduction, Request, Source, Units, import};

/// Cells along the thickness.
const CELLS: usize = 16;
/// Thickness, width and height (m).
const SIZE: [f64; 3] = [0.01, 0.02, 0.08];
const STEEL: Material = Material {
    youngs_modulus: 2.1e11,
    poisson_ratio: 0.3,
    density: 7800.0,
};
/// Modes are kept below it (Hz): three times the tenth frequency.
const CUT_OFF_HZ: f64 = 1.2e5;
/// Kept nodes of the tip and of the patch, each.
const KEPT: usize = 9;

fn main() {
    let asked = std::env::args().skip(1).find_map(|a| a.parse().ok());
    let step = SIZE[0] / asked.unwrap_or(CELLS) as f64;
    let lines = SIZE.map(|size| grid_lines(&[0.0, size], step));
    let cuboid = Cuboid {
        min: [0.0; 3],
        max: SIZE,
    };
    let mesh = tensor_mesh(&lines, &[cuboid]);
    let fe = FeModel::new(mesh, &STEEL, |x| x[2] == 0.0).expect("a blade");
    let folder = tempfile::tempdir().expect("a folder");
    let megabytes = write_model(folder.path(), &fe) >> 20;
    let request = request(folder.path(), kept(&fe));
    let began = Instant::now();
    let imported = import(&request).expect("a model");
    let reduced = imported.reduced.expect("a reduction");
    println!(
        "{} degrees of freedom, {} MB of matrices; reduced to {} kept and {} modes in {:.1} s, {} MB in memory at most",
        fe.n_dofs(),
        megabytes,
        reduced.masters,
        reduced.modes,
        began.elapsed().as_secs_f64(),
        most_memory_kb() / 1024
    );
    for (full, reduced) in imported
        .facts
        .frequencies_hz
        .iter()
        .zip(&reduced.frequencies_hz)
    {
        println!("{full:12.3} Hz, reduced {:+.1e}", reduced / full - 1.0);
    }
}

/// Matrices and names as CalculiX writes them; the bytes of the matrices.
fn write_model(folder: &Path, fe: &FeModel) -> u64 {
    write(&folder.join("blade.sti"), &fe.stiffness);
    write(&folder.join("blade.mas"), &fe.mass);
    let names: String = (0..fe.n_dofs()).fold(String::new(), |mut names, dof| {
        let _ = writeln!(names, "{}.{}", dof / 3 + 1, dof % 3 + 1);
        names
    });
    std::fs::write(folder.join("blade.dof"), names).expect("names");
    let bytes = |name| std::fs::metadata(folder.join(name)).map_or(0, |m| m.len());
    bytes("blade.sti") + bytes("blade.mas")
}

fn request(folder: &Path, keep: Vec<String>) -> Request {
    let source = |name: &str| Source {
        role: None,
        path: folder.join(name),
        name: None,
    };
    Request {
        sources: vec![source("blade.sti"), source("blade.mas")],
        units: Units::Si,
        output: folder.join("model"),
        pairs: None,
        nodes: None,
        systems: None,
        constants: PairConstants::default(),
        excite: Vec::new(),
        forces: None,
        load: None,
        responses: Vec::new(),
        damping_ratio: 0.002,
        reduction: Some(Reduction {
            cut_off: CUT_OFF_HZ,
            keep,
        }),
    }
}

/// Nodes across the tip and of a patch on the side, by their numbers.
fn kept(fe: &FeModel) -> Vec<String> {
    let at = |position: [f64; 3]| {
        let [first, ..] = fe.dofs_at(position).expect("a free node");
        (first / 3 + 1).to_string()
    };
    let share = |i: usize| i as f64 / (KEPT - 1) as f64;
    let tip = (0..KEPT).map(|i| at([0.0, SIZE[1] * share(i), SIZE[2]]));
    let patch = (0..KEPT).map(|i| {
        let (y, z) = ((i % 3) as f64 / 2.0, (2 + i / 3) as f64 / 8.0);
        at([SIZE[0], SIZE[1] * y, SIZE[2] * z])
    });
    tip.chain(patch).collect()
}

/// The upper triangle, as CalculiX writes it.
fn write(path: &Path, matrix: &SparseColMat<usize, f64>) {
    let file = std::fs::File::create(path).expect("a file");
    let mut out = std::io::BufWriter::new(file);
    for entry in matrix.triplet_iter().filter(|e| e.row <= e.col) {
        let (row, column) = (entry.row + 1, entry.col + 1);
        writeln!(out, "{row} {column} {:.13e}", entry.val).expect("space on the disk");
    }
    out.flush().expect("space on the disk");
}
