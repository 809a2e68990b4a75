//! Which matrix of the equation of motion a matrix of a file is.

use std::path::Path;

use super::matrix::ImportedMatrix;

/// Part of the equation of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// K.
    Stiffness,
    /// M.
    Mass,
    /// C.
    Damping,
    /// Stiffness on the mean position only.
    Retention,
    /// Force of the excitation, cosine part.
    HarmonicForce,
    /// Static force.
    StaticForce,
    /// A force of which the file does not say what it does.
    Load,
}

/// Words for each role: of the command line, names in files, and parts of file names.
const WORDS: [(Role, &str, &[&str]); 7] = [
    (
        Role::Stiffness,
        "K",
        &[
            "K",
            "STIFFNESS",
            "STIFF",
            "STIF",
            "STI",
            "KMATRIX",
            "KAAX",
            "KAA",
            "KXX",
            "KGG",
            "KGGX",
            "KRED",
            "K2GG",
        ],
    ),
    (
        Role::Mass,
        "M",
        &[
            "M", "MASS", "MAS", "MMATRIX", "MAAX", "MAA", "MXX", "MGG", "MGGX", "MRED", "M2GG",
        ],
    ),
    (
        Role::Damping,
        "C",
        &[
            "C",
            "D",
            "DAMPING",
            "DAMP",
            "VISCOUS DAMPING",
            "DMPV",
            "CMATRIX",
            "BAAX",
            "BAA",
            "BXX",
            "BGG",
            "B2GG",
        ],
    ),
    (Role::Retention, "R", &["R", "RETENTION"]),
    (Role::HarmonicForce, "F", &["F"]),
    (Role::StaticForce, "F0", &["F0"]),
    (
        Role::Load,
        "LOAD",
        &[
            "LOAD", "RHS", "CLOAD", "P", "PA", "PAX", "PAX1", "PG", "FV", "FORCE",
        ],
    ),
];

impl Role {
    /// The role that the command line names: K, M, C, R, F or F0.
    #[must_use]
    pub fn named(word: &str) -> Option<Self> {
        let listed = WORDS.iter().filter(|(role, ..)| *role != Self::Load);
        let mut listed = listed.filter(|(_, own, _)| own.eq_ignore_ascii_case(word));
        listed.next().map(|(role, ..)| *role)
    }

    /// Its letter.
    #[must_use]
    pub fn letter(self) -> &'static str {
        let own = WORDS.iter().find(|(role, ..)| *role == self);
        own.map_or("", |(_, letter, _)| letter)
    }

    /// Whether it is a vector.
    #[must_use]
    pub fn is_vector(self) -> bool {
        matches!(self, Self::HarmonicForce | Self::StaticForce | Self::Load)
    }

    /// The role of a matrix by its name in the file, which may be that of an array, else by the name of the file; none where these
    /// say nothing.
    pub(super) fn of(matrix: &ImportedMatrix, array: bool) -> Option<Self> {
        match matrix.name.as_str() {
            "" => Self::of_file(&matrix.path),
            name if array => Self::of_array(name),
            name => Self::of_word(name),
        }
    }

    /// The role of a matrix of this name.
    fn of_word(word: &str) -> Option<Self> {
        let upper = word.trim().to_ascii_uppercase();
        let mut listed = WORDS.iter();
        listed
            .find(|(_, _, words)| words.contains(&upper.as_str()))
            .map(|(role, ..)| *role)
    }

    /// The role of an array of MATLAB or NumPy: K, M, C, R, F or F0. People name other arrays as they like, such as D of eigenvalues,
    /// and these programs tell k from K.
    pub(super) fn of_array(name: &str) -> Option<Self> {
        Self::named(name).filter(|_| !name.contains(char::is_lowercase))
    }

    /// By the words of the file's name, if they name one role only. `_STIF1` is the stiffness of step 1.
    fn of_file(path: &Path) -> Option<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        if ["sti", "mas"].contains(&extension.to_ascii_lowercase().as_str()) {
            return Self::of_word(&extension);
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let words = stem.split(|c: char| !c.is_alphanumeric());
        let plain = |word: &'_ str| {
            let without_step = word.trim_end_matches(|c: char| c.is_ascii_digit());
            Self::of_word(word).or_else(|| Self::of_word(without_step))
        };
        let mut roles: Vec<Self> = words.filter_map(plain).collect();
        roles.sort();
        roles.dedup();
        match roles[..] {
            [role] => Some(role),
            _ => None,
        }
    }
}
