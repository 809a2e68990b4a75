//! Mirror symmetry of a model: which coordinate is the image of which.

/// A signed permutation of the degrees of freedom that maps the model onto itself and is its own inverse.
#[derive(Debug, Clone, PartialEq)]
pub struct Mirror {
    /// Image of the unit displacement of coordinate i: `sign` times that of coordinate j. Shape: `[n]` of (j, sign).
    pub image: Vec<(usize, f64)>,
}

/// Displacements that the mirror keeps (even) or turns round (odd).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parity {
    /// Equal to its image.
    Even,
    /// Equal to minus its image.
    Odd,
}

impl Parity {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::Even, Self::Odd];

    /// Factor between a displacement and its image.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Even => 1.0,
            Self::Odd => -1.0,
        }
    }
}

impl Mirror {
    /// Orthonormal basis of the displacements of one parity: columns of one or two entries (coordinate, weight).
    #[must_use]
    pub fn basis(&self, parity: Parity) -> Vec<Vec<(usize, f64)>> {
        let half = 0.5f64.sqrt();
        (self.image.iter().enumerate())
            .filter_map(|(i, &(j, sign))| match i.cmp(&j) {
                std::cmp::Ordering::Less => Some(vec![(i, half), (j, parity.sign() * sign * half)]),
                std::cmp::Ordering::Equal => (sign == parity.sign()).then(|| vec![(i, 1.0)]),
                std::cmp::Ordering::Greater => None,
            })
            .collect()
    }
}
