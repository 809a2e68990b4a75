//! Mirror symmetry of a model: which coordinate is the image of which.

use faer::Mat;

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
    /// The mirror whose matrix n × n maps displacements to their images.
    ///
    /// # Errors
    /// The rule, unless each column has one entry, 1 or −1, and the matrix is its own inverse.
    pub fn of_matrix(a: &Mat<f64>) -> Result<Self, String> {
        let rule = "must be a mirror: one entry 1 or -1 in each column, and its own inverse";
        let image = |i: usize| {
            let entries = a
                .col(i)
                .iter()
                .enumerate()
                .filter(|(_, value)| **value != 0.0);
            match entries.collect::<Vec<_>>()[..] {
                [(j, &sign)] if sign.abs() == 1.0 => Ok((j, sign)),
                _ => Err(format!("{rule}; column {} has others", i + 1)),
            }
        };
        let image: Vec<_> = (0..a.ncols()).map(image).collect::<Result<_, _>>()?;
        let back = |(i, &(j, sign)): (usize, &(usize, f64))| image[j] != (i, sign);
        match image.iter().enumerate().find(|image| back(*image)) {
            None => Ok(Self { image }),
            Some((i, _)) => Err(format!(
                "{rule}; the image of the image of row {} is another",
                i + 1
            )),
        }
    }

    /// Entries (row, column, value) of the lower triangle of its matrix, which is symmetric.
    pub fn lower(&self) -> Vec<(usize, usize, f64)> {
        let images = self.image.iter().enumerate();
        let lower = images.filter(|(i, (j, _))| j >= i);
        lower.map(|(i, &(j, sign))| (j, i, sign)).collect()
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    /// A mirror is its matrix; what is none is refused. Seen to fail without the second rule.
    #[test]
    fn a_mirror_is_its_matrix() {
        let matrix = |n: usize, entries: &[(usize, usize, f64)]| {
            let mut a = Mat::zeros(n, n);
            entries.iter().for_each(|&(i, j, value)| a[(i, j)] = value);
            a
        };
        let exchange = [(1, 0, -1.0), (0, 1, -1.0), (2, 2, -1.0), (3, 3, 1.0)];
        let mirror = Mirror::of_matrix(&matrix(4, &exchange)).unwrap();
        assert_eq!(mirror.image, [(1, -1.0), (0, -1.0), (2, -1.0), (3, 1.0)]);
        assert_eq!(mirror.lower(), [(1, 0, -1.0), (2, 2, -1.0), (3, 3, 1.0)]);
        let circle = [(1, 0, 1.0), (2, 1, 1.0), (0, 2, 1.0)];
        let signs = [(1, 0, 1.0), (0, 1, -1.0), (2, 2, 1.0)];
        let half = [(0, 0, 1.0), (1, 1, 0.5), (2, 2, 1.0)];
        for (entries, fragment) in [
            (&circle[..], "of row 1 is another"),
            (&signs[..], "of row 1 is another"),
            (&half[..], "column 2 has others"),
            (&half[..1], "column 2 has others"),
        ] {
            let message = Mirror::of_matrix(&matrix(3, entries)).unwrap_err();
            assert!(message.contains(fragment), "{message}");
        }
    }
}
