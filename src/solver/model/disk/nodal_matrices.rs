//! A disk from matrices that are reduced for each of its nodal diameters: one file for each, of one sector.
//!
//! Between 0 and N/2 a nodal diameter has complex Hermitian matrices, K(θ) = A + iB, for displacements φ of sector 0 in the wave
//! φ e^(−iθj). Or it has the same in real numbers, for the cosine and the sine part of a wave: sector j moves by q_c cos θj + q_s sin θj, and
//!
//! ```text
//! [ A  −B ] [ q_c ]
//! [ B   A ] [ q_s ]
//! ```

use std::path::{Path, PathBuf};

use super::super::complex_market::{StatedComplex, read_complex};
use super::super::dof_index::DofIndex;
use super::super::matrices::{MatricesError, dense, excited};
use super::super::matrix_checks::positive_semidefinite;
use super::sector_matrices::{NEXT, definite, modal_damping};
use super::{CyclicMatrix, Disk, SectorMatrices};
use crate::contact::ContactParameters;
use crate::file::FileError;
use crate::setting::BadSetting;
use faer::{Mat, c64};

/// What stands for the nodal diameter in the name of a file.
const NODAL_DIAMETER: &str = "{nd}";
/// Largest difference of entries that must be equal, relative to the largest entry.
const ROUND_OFF: f64 = 1e-8;

/// Whether a name of a file stands for one of each nodal diameter.
pub(super) fn is_nodal(file: &Path) -> bool {
    file.to_string_lossy().contains(NODAL_DIAMETER)
}

/// The file of a nodal diameter.
fn of_diameter(file: &Path, diameter: usize) -> PathBuf {
    let name = file.to_string_lossy();
    PathBuf::from(name.replace(NODAL_DIAMETER, &diameter.to_string()))
}

impl SectorMatrices {
    /// Whether its matrices are reduced for each nodal diameter.
    #[must_use]
    pub fn is_nodal(&self) -> bool {
        let of = &self.sector;
        let matrices = [Some(&of.mass), Some(&of.stiffness), of.damping.as_ref()];
        matrices.into_iter().flatten().any(|file| is_nodal(file))
    }

    /// The files that it names, relative to the study file's folder, one of each nodal diameter where the matrices are such.
    #[must_use]
    pub fn files(&self, n_sectors: usize) -> Vec<PathBuf> {
        let each = |file: &Path| -> Vec<PathBuf> {
            match is_nodal(file) {
                true => (0..=n_sectors / 2).map(|d| of_diameter(file, d)).collect(),
                false => vec![file.to_owned()],
            }
        };
        self.sector.files().into_iter().flat_map(each).collect()
    }

    /// Checks what matrices of nodal diameters need beside the rules of all.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[model]`.
    pub(super) fn validate_nodal(&self) -> Result<(), BadSetting> {
        let of = &self.sector;
        let matrices = [
            ("mass", Some(&of.mass)),
            ("stiffness", Some(&of.stiffness)),
            ("damping", of.damping.as_ref()),
        ];
        for (key, file) in matrices {
            let Some(file) = file else { continue };
            let rule = format!(
                "must have {NODAL_DIAMETER} in its name, as the other matrices have: one file for each nodal diameter"
            );
            BadSetting::unless(is_nodal(file), key, file.display(), &rule)?;
        }
        for (key, names) in [
            ("left", &self.left),
            ("right", &self.right),
            ("blade", &self.blade),
        ] {
            let given = format!("{} names", names.len());
            let rule = "must be absent: the matrices of a nodal diameter have no boundary, and no part of their own for the blade";
            BadSetting::unless(names.is_empty(), key, given, rule)?;
        }
        Ok(())
    }

    /// As [`SectorMatrices::build`], from matrices for each nodal diameter.
    pub(super) fn build_nodal(
        &self,
        name: &str,
        folder: &Path,
        n_sectors: usize,
    ) -> Result<(Disk, Vec<ContactParameters<f64>>), MatricesError> {
        let of = &self.sector;
        let mass = read_all(folder, &of.mass, n_sectors, None)?;
        let n = mass[0].nrows();
        let read = |file: &Path| {
            let matrices = read_all(folder, file, n_sectors, Some(n));
            matrices.map(CyclicMatrix::Nodal)
        };
        let mass = CyclicMatrix::Nodal(mass);
        definite(&mass, n_sectors)?;
        let stiffness = read(&of.stiffness)?;
        let damping = match &of.damping {
            Some(file) => read(file)?,
            None => {
                let ratio = of.modal_damping_ratio.unwrap_or(0.0);
                modal_damping(ratio, [&stiffness, &mass], n_sectors)?
            }
        };
        let dof_names = of.first_names(folder, n)?;
        let named = dof_names.len();
        let retention = match &of.retention {
            Some(file) => Some(of.checked(folder, file, Some(named), positive_semidefinite)?),
            None => None,
        };
        let next = dof_names.iter().map(|name| format!("{NEXT}{name}"));
        let both = dof_names.iter().cloned().chain(next);
        let index = DofIndex(both.zip(0..).collect());
        let own = DofIndex(dof_names.iter().cloned().zip(0..).collect());
        let vector = |key, vector| dense(folder, key, vector, named, &own);
        let (contacts, parameters) = self.contacts(&index)?;
        let cosine_force = vector("cosine_force", &of.cosine_force)?;
        let sine_force = vector("sine_force", &of.sine_force)?;
        excited(&cosine_force, &sine_force)?;
        let disk = Disk {
            name: name.to_owned(),
            n_sectors,
            mass,
            damping,
            stiffness,
            retention,
            blade_stiffness: None,
            contacts,
            static_force: vector("static_force", &of.static_force)?,
            loads: Vec::new(),
            cosine_force,
            sine_force,
            responses: of.response_rows(&dof_names, &index)?,
            dof_names,
        };
        Ok((disk, parameters))
    }
}

/// The matrices of all nodal diameters, each with `size` rows; the first one decides that where it is not known. Their files tell of how many
/// sectors the disk is: the highest nodal diameter stands still where the number is even, and none is above it.
fn read_all(
    folder: &Path,
    file: &Path,
    n_sectors: usize,
    size: Option<usize>,
) -> Result<Vec<Mat<c64>>, FileError> {
    let highest = n_sectors / 2;
    let at = |diameter| folder.join(of_diameter(file, diameter));
    let above = at(highest + 1);
    if above.exists() {
        let rule = format!(
            "is of nodal diameter {}, which is above N/2 = {highest} of model.sectors = {n_sectors}",
            highest + 1
        );
        return Err(FileError::content(&above, None, rule));
    }
    let mut matrices: Vec<Mat<c64>> = Vec::new();
    for diameter in 0..=highest {
        let path = at(diameter);
        if !path.exists() {
            let rule = format!(
                "must exist: there must be a file for each nodal diameter from 0 to N/2 = {highest} of model.sectors = {n_sectors}"
            );
            return Err(FileError::content(&path, None, rule));
        }
        let stated = read_complex(&path)?;
        let size = size.or(matrices.first().map(Mat::nrows));
        let stands = 2 * diameter % n_sectors == 0;
        let matrix = hermitian(stated, size, stands).map_err(|rule| match rule {
            Unfit::Rule(rule) => rule,
            Unfit::Moves => {
                format!("must be real: nodal diameter {diameter} of model.sectors = {n_sectors} stands still")
            }
        });
        matrices.push(matrix.map_err(|rule| FileError::content(&path, None, rule))?);
    }
    // of an odd number of sectors every wave but that of nodal diameter 0 travels
    let travels =
        |matrix: &Mat<c64>| (0..matrix.ncols()).any(|j| matrix.col(j).iter().any(|z| z.im != 0.0));
    if n_sectors % 2 == 1 && matrices.iter().any(travels) && !travels(&matrices[highest]) {
        let rule = format!(
            "is real, as that of nodal diameter N/2 of an even number of sectors, and lower ones are not: model.sectors = {n_sectors} is odd"
        );
        return Err(FileError::content(&at(highest), None, rule));
    }
    Ok(matrices)
}

/// Why a matrix is none of its nodal diameter.
enum Unfit {
    Rule(String),
    /// It belongs to a wave that travels, and this one stands still.
    Moves,
}

impl From<String> for Unfit {
    fn from(rule: String) -> Self {
        Self::Rule(rule)
    }
}

/// A positive semidefinite Hermitian matrix of `size` rows, real where the wave `stands`; else also from its real form of twice the size.
fn hermitian(stated: StatedComplex, size: Option<usize>, stands: bool) -> Result<Mat<c64>, Unfit> {
    let StatedComplex { matrix, digits } = stated;
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    if rows != columns {
        return Err(format!("is {rows} x {columns}: must be square").into());
    }
    let n = size.unwrap_or(rows);
    let largest = matrix.norm_max();
    let is_real =
        (0..rows).all(|j| (0..rows).all(|i| matrix[(i, j)].im.abs() <= ROUND_OFF * largest));
    let matrix = match (rows == n, rows == 2 * n && is_real && !stands) {
        (true, _) => matrix,
        (_, true) => from_pairs(&matrix, ROUND_OFF * largest)?,
        _ => {
            let pairs = match stands {
                true => String::new(),
                false => format!(", or real and {0} x {0} (cosine and sine parts)", 2 * n),
            };
            return Err(format!(
                "is {rows} x {rows}: must be {n} x {n}{pairs}, as nodal diameter 0 of the mass"
            )
            .into());
        }
    };
    if stands && !is_real {
        return Err(Unfit::Moves);
    }
    for (i, j) in (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        let [a, b] = [matrix[(i, j)], matrix[(j, i)]];
        if (a - b.conj()).norm() > ROUND_OFF * largest {
            return Err(format!(
                "must be Hermitian: entry ({0}, {1}) = {a} is not the conjugate of ({1}, {0}) = {b}",
                i + 1,
                j + 1
            )
            .into());
        }
    }
    let matrix = Mat::from_fn(n, n, |i, j| {
        let mean = (matrix[(i, j)] + matrix[(j, i)].conj()) * 0.5;
        if stands { c64::new(mean.re, 0.0) } else { mean }
    });
    positive_semidefinite(&in_pairs(&matrix), digits)?;
    Ok(matrix)
}

/// A + iB from its real form [A, −B; B, A].
fn from_pairs(pairs: &Mat<c64>, tolerance: f64) -> Result<Mat<c64>, String> {
    let n = pairs.nrows() / 2;
    let entry = |i: usize, j: usize| pairs[(i, j)].re;
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let same = (entry(i, j) - entry(n + i, n + j)).abs() <= tolerance;
        let turned = (entry(i, n + j) + entry(n + i, j)).abs() <= tolerance;
        if !(same && turned) {
            let ((row, column), sign) = match same {
                true => ((n + i + 1, j + 1), "-"),
                false => ((n + i + 1, n + j + 1), ""),
            };
            let other = if same { n + j + 1 } else { j + 1 };
            return Err(format!(
                "must be [A, -B; B, A] for the cosine and the sine part of a wave: entry ({row}, {column}) must be {sign}({}, {other})",
                i + 1
            ));
        }
    }
    Ok(Mat::from_fn(n, n, |i, j| {
        c64::new(entry(i, j), entry(n + i, j))
    }))
}

/// The real form of A + iB.
fn in_pairs(a: &Mat<c64>) -> Mat<f64> {
    let n = a.nrows();
    Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => a[(i, j)].re,
        (false, false) => a[(i - n, j - n)].re,
        (true, false) => -a[(i, j - n)].im,
        (false, true) => a[(i - n, j)].im,
    })
}
