//! A disk from the matrices of one of its sectors, with the boundaries to its neighbours.
//!
//! The right boundary of a sector is the left one of the next: its displacements go, and what they had in the matrices couples
//! the sector with the next one.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::dof_index::DofIndex;
use super::super::matrices::{MatricesError, MatricesSettings, dense, excited, unique};
use super::super::matrix_checks::{dependent_wave_row, positive_semidefinite};
use super::super::{ContactPair, Response};
use super::{CyclicMatrix, Disk};
use crate::contact::ContactParameters;
use crate::linalg::symmetric_generalized_eigen;
use crate::setting::BadSetting;
use faer::Mat;

/// What stands before the name of a degree of freedom of the next sector.
pub(super) const NEXT: &str = "next:";

/// The user's matrices of one sector of a disk. The keys of a model of kind "matrices" hold for the sector, but for `mirror`.
/// Contact rows name a degree of freedom of the next sector with `next:` before it.
#[derive(Debug, Clone, PartialEq)]
pub struct SectorMatrices {
    /// Matrices, contacts, forces and responses.
    pub sector: MatricesSettings,
    /// Degrees of freedom on the left boundary.
    pub left: Vec<String>,
    /// Degrees of freedom of the blade: those that are not held where a blade vibrates alone. None where the disk is tuned.
    pub blade: Vec<String>,
    /// Those on the right boundary, each the one that meets its counterpart of the next sector's left boundary.
    pub right: Vec<String>,
}

/// Where the displacements of a sector's matrices are after its right boundary is that of the next sector.
struct Places {
    /// New number, and whether it is the next sector's.
    of: Vec<(usize, bool)>,
    /// Number of those that are left.
    n: usize,
}

impl SectorMatrices {
    /// Checks what needs no file.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[model]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        self.sector.validate()?;
        let rule = "must be absent: one sector of a disk is not folded";
        let mirror = self.sector.mirror.as_ref();
        let given = mirror.map(|file| file.display().to_string());
        BadSetting::unless(mirror.is_none(), "mirror", given.unwrap_or_default(), rule)?;
        if self.is_nodal() {
            return self.validate_nodal();
        }
        let (left, right) = (self.left.len(), self.right.len());
        let rule = format!(
            "must be as many as in left ({left}): the boundaries of a sector meet those of its neighbours, in this order"
        );
        BadSetting::unless(left == right, "right", format!("{right} names"), &rule)?;
        for (key, names) in [
            ("left", &self.left),
            ("right", &self.right),
            ("blade", &self.blade),
        ] {
            let names = names.iter().map(String::as_str);
            unique(|i| format!("{key}[{i}]"), names)?;
        }
        for (i, name) in self.right.iter().enumerate() {
            let rule = "must not be on both boundaries";
            let only_right = !self.left.contains(name);
            BadSetting::unless(only_right, &format!("right[{i}]"), name, rule)?;
            let component = |name: &str| name.rsplit_once('.').map(|(_, axis)| axis.to_owned());
            let [ours, theirs] = [name, &self.left[i]].map(|name| component(name));
            let same = ours.is_none() || theirs.is_none() || ours == theirs;
            let rule = format!(
                "must meet a displacement of the same direction, but left[{i}] is {}",
                self.left[i]
            );
            BadSetting::unless(same, &format!("right[{i}]"), name, &rule)?;
        }
        Ok(())
    }

    /// Reads the files and builds the disk. `folder` is the study file's; `name` goes to the model.
    ///
    /// # Errors
    /// [`MatricesError`] on the first rule that a file or a table breaks.
    pub fn build(
        &self,
        name: &str,
        folder: &Path,
        n_sectors: usize,
    ) -> Result<(Disk, Vec<ContactParameters<f64>>), MatricesError> {
        self.validate()?;
        if self.is_nodal() {
            return self.build_nodal(name, folder, n_sectors);
        }
        let of = &self.sector;
        let read = |file: &Path, size| of.checked(folder, file, size, positive_semidefinite);
        let mass = read(&of.mass, None)?;
        let n = mass.nrows();
        let all_names = of.names(folder, n)?;
        let places = self.places(&all_names)?;
        let stiffness = places.coupled(&read(&of.stiffness, Some(n))?);
        let mass = places.coupled(&mass);
        definite(&mass, n_sectors)?;
        let damping = match &of.damping {
            Some(file) => places.coupled(&read(file, Some(n))?),
            None => modal_damping(
                of.modal_damping_ratio.unwrap_or(0.0),
                [&stiffness, &mass],
                n_sectors,
            )?,
        };
        let retention = match &of.retention {
            Some(file) => Some(places.at_rest(&read(file, Some(n))?)),
            None => None,
        };
        let (index, own) = places.index(&all_names);
        let blade_stiffness = self.blade_stiffness(&own, &stiffness)?;
        let vector = |key, vector| dense(folder, key, vector, n, &whole_index(&all_names));
        let harmonic = |key: &str, vector: Vec<f64>| places.harmonic(key, &vector, &all_names);
        let (contacts, parameters) = self.contacts(&index)?;
        let cosine_force = harmonic("cosine_force", vector("cosine_force", &of.cosine_force)?)?;
        let sine_force = harmonic("sine_force", vector("sine_force", &of.sine_force)?)?;
        excited(&cosine_force, &sine_force)?;
        let static_force = places.gathered(&vector("static_force", &of.static_force)?);
        let responses: Vec<Response> = of.response_rows(&own, &index)?;
        self.of_one_blade(&responses, own.len())?;
        let disk = Disk {
            name: name.to_owned(),
            n_sectors,
            dof_names: own,
            mass,
            damping,
            stiffness,
            retention,
            blade_stiffness,
            contacts,
            static_force,
            loads: Vec::new(),
            cosine_force,
            sine_force,
            responses,
        };
        Ok((disk, parameters))
    }

    /// Contact pairs of a sector and their constants.
    pub(super) fn contacts(
        &self,
        index: &DofIndex,
    ) -> Result<(Vec<ContactPair>, Vec<ContactParameters<f64>>), BadSetting> {
        let mut contacts = Vec::new();
        let mut parameters = Vec::new();
        for (i, table) in self.sector.contact.iter().enumerate() {
            for (direction, row) in [("t1", &table.t1), ("t2", &table.t2), ("n", &table.n)] {
                row.iter().flatten().try_for_each(|(name, weight)| {
                    self.within_reach(&format!("contact[{i}].{direction}"), name, *weight)
                })?;
            }
            contacts.push(table.pair(&format!("contact[{i}]"), index)?);
            parameters.push(table.parameters());
        }
        let names = contacts.iter().map(|pair| pair.name.as_str());
        unique(|i| format!("contact[{i}].name"), names)?;
        Ok((contacts, parameters))
    }

    /// Refuses the right boundary of the next sector in the contact row at `key`.
    fn within_reach(&self, key: &str, name: &str, weight: f64) -> Result<(), BadSetting> {
        let of_next = name.strip_prefix(NEXT);
        let beyond = of_next.and_then(|of| self.right.iter().position(|other| other == of));
        let Some(i) = beyond else {
            return Ok(());
        };
        let rule = format!(
            "must lie in the sector or in the next one, but the right boundary of the next sector is {} two sectors on",
            self.left[i]
        );
        Err(BadSetting::new(format!("{key}.{name}"), weight, rule))
    }

    /// Refuses responses on the next sector where blades differ: an amplitude is that of the blade of its sector.
    fn of_one_blade(&self, responses: &[Response], n_own: usize) -> Result<(), BadSetting> {
        let of_next = |response: &Response| response.row.iter().any(|&(dof, _)| dof >= n_own);
        let rule = "must be on the sector itself where blade_frequency_scatter is given: the amplitude is that of its blade";
        responses.iter().enumerate().try_for_each(|(i, response)| {
            let fits = self.blade.is_empty() || !of_next(response);
            BadSetting::unless(fits, &format!("responses[{i}]"), &response.name, rule)
        })
    }

    /// What the stiffness of a sector has among the blade's degrees of freedom.
    fn blade_stiffness(
        &self,
        own: &[String],
        stiffness: &CyclicMatrix,
    ) -> Result<Option<Mat<f64>>, BadSetting> {
        if self.blade.is_empty() {
            return Ok(None);
        }
        let CyclicMatrix::Neighbours { own: of_sector, .. } = stiffness else {
            return Ok(None);
        };
        let mut is_blade = vec![false; own.len()];
        for (i, name) in self.blade.iter().enumerate() {
            let place = own.iter().position(|other| other == name);
            let rule =
                "must name a degree of freedom of the sector that is not on its right boundary";
            BadSetting::unless(place.is_some(), &format!("blade[{i}]"), name, rule)?;
            place.into_iter().for_each(|place| is_blade[place] = true);
        }
        let n = of_sector.nrows();
        let entry = |i: usize, j: usize| match is_blade[i] && is_blade[j] {
            true => of_sector[(i, j)],
            false => 0.0,
        };
        let stiffness = Mat::from_fn(n, n, entry);
        if stiffness.norm_max() == 0.0 {
            let rule = "must name degrees of freedom with a stiffness among them: without one no blade deviates";
            return Err(BadSetting::new("blade", self.blade.join(", "), rule));
        }
        Ok(Some(stiffness))
    }

    fn places(&self, names: &[String]) -> Result<Places, BadSetting> {
        let known = |key: &str, list: &[String]| {
            list.iter().enumerate().try_for_each(|(i, name)| {
                let rule = "must name a degree of freedom of the sector";
                BadSetting::unless(names.contains(name), &format!("{key}[{i}]"), name, rule)
            })
        };
        known("left", &self.left)?;
        known("right", &self.right)?;
        let kept: Vec<&String> = (names.iter())
            .filter(|name| !self.right.contains(name))
            .collect();
        let number = |name: &String| kept.iter().position(|other| *other == name);
        let place = |name: &String| {
            let met = self.right.iter().position(|other| other == name);
            let of = met.map_or(name, |i| &self.left[i]);
            number(of).map(|number| (number, met.is_some()))
        };
        Ok(Places {
            of: names.iter().filter_map(place).collect(),
            n: kept.len(),
        })
    }
}

impl Places {
    /// A matrix of the sector by what it couples with itself and with the next one.
    fn coupled(&self, a: &Mat<f64>) -> CyclicMatrix {
        let mut own = Mat::zeros(self.n, self.n);
        let mut next = Mat::zeros(self.n, self.n);
        for (j, &(column, column_is_next)) in self.of.iter().enumerate() {
            for (i, &(row, row_is_next)) in self.of.iter().enumerate() {
                match (row_is_next, column_is_next) {
                    (false, true) => next[(row, column)] += a[(i, j)],
                    // the transpose of the case before
                    (true, false) => {}
                    _ => own[(row, column)] += a[(i, j)],
                }
            }
        }
        CyclicMatrix::Neighbours { own, next }
    }

    /// A matrix for displacements that all sectors have in common.
    fn at_rest(&self, a: &Mat<f64>) -> Mat<f64> {
        let mut together = Mat::zeros(self.n, self.n);
        for (j, &(column, _)) in self.of.iter().enumerate() {
            for (i, &(row, _)) in self.of.iter().enumerate() {
                together[(row, column)] += a[(i, j)];
            }
        }
        together
    }

    /// A force that is the same on all sectors.
    fn gathered(&self, f: &[f64]) -> Vec<f64> {
        let mut together = vec![0.0; self.n];
        (self.of.iter().zip(f)).for_each(|(&(place, _), f)| together[place] += f);
        together
    }

    /// A force that comes to the next sector later.
    fn harmonic(&self, key: &str, f: &[f64], names: &[String]) -> Result<Vec<f64>, BadSetting> {
        for ((&(_, is_next), f), name) in self.of.iter().zip(f).zip(names) {
            let rule = "must be 0 on the right boundary: give it on the left one, which is that of the next sector";
            BadSetting::unless(!is_next || *f == 0.0, &format!("{key}.{name}"), f, rule)?;
        }
        Ok(self.gathered(f))
    }

    /// Numbers of the degrees of freedom by name, those of the next sector as well; and the names of those that are left.
    fn index(&self, names: &[String]) -> (DofIndex, Vec<String>) {
        let mut numbers: BTreeMap<String, usize> = BTreeMap::new();
        let mut own = vec![String::new(); self.n];
        for (&(place, is_next), name) in self.of.iter().zip(names) {
            let here = if is_next { self.n + place } else { place };
            numbers.insert(name.clone(), here);
            if !is_next {
                numbers.insert(format!("{NEXT}{name}"), self.n + place);
                own[place].clone_from(name);
            }
        }
        (DofIndex(numbers), own)
    }
}

/// Numbers of all degrees of freedom of the sector's matrices.
fn whole_index(names: &[String]) -> DofIndex {
    DofIndex(names.iter().cloned().zip(0..).collect())
}

/// Requires a mass that is positive definite in every wave.
pub(super) fn definite(mass: &CyclicMatrix, n_sectors: usize) -> Result<(), BadSetting> {
    for diameter in 0..=n_sectors / 2 {
        if let Some(row) = dependent_wave_row(&mass.at(diameter, n_sectors)) {
            let rule = format!(
                "must be positive definite with its neighbours, but for nodal diameter {diameter} row {} is a combination of rows before it",
                row + 1
            );
            return Err(BadSetting::new("mass", "(matrix)", rule));
        }
    }
    Ok(())
}

/// C(θ) = M Φ diag(2ζω) Φᴴ M: the same damping ratio in every free mode of every wave. It couples no sectors that M and K do not couple.
pub(super) fn modal_damping(
    ratio: f64,
    [stiffness, mass]: [&CyclicMatrix; 2],
    n_sectors: usize,
) -> Result<CyclicMatrix, BadSetting> {
    let of_wave = |diameter: usize| {
        let [k, m] = [stiffness, mass].map(|a| a.at(diameter, n_sectors));
        let found = symmetric_generalized_eigen(k.as_ref(), m.as_ref());
        let (lambda, shapes) = found.map_err(|error| {
            let rule = format!("needs the modes of the structure, but {error}");
            BadSetting::new("modal_damping_ratio", ratio, rule)
        })?;
        let weighted = &m * &shapes;
        let scaled = Mat::from_fn(m.nrows(), lambda.len(), |i, mode| {
            weighted[(i, mode)] * (2.0 * ratio * lambda[mode].max(0.0).sqrt())
        });
        Ok(scaled * weighted.adjoint())
    };
    if stiffness.is_uncoupled() && mass.is_uncoupled() {
        let own = of_wave(0)?;
        let real = |i, j| own[(i, j)].re;
        return Ok(CyclicMatrix::uncoupled(Mat::from_fn(
            own.nrows(),
            own.ncols(),
            real,
        )));
    }
    let matrices = (0..=n_sectors / 2).map(of_wave);
    Ok(CyclicMatrix::Nodal(
        matrices.collect::<Result<_, BadSetting>>()?,
    ))
}
