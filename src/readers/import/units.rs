//! Units of a finite-element model, declared and never guessed, and their conversion to SI.

use super::dof::Kind;

/// A consistent set of units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Units {
    /// m, kg, s, N.
    Si,
    /// mm, t, s, N: stress in MPa.
    MmTonneSecond,
    /// mm, kg, ms, kN: stress in GPa.
    MmKilogramMillisecond,
}

impl Units {
    /// Names as the command line takes them.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("SI", Self::Si),
        ("m-kg-s", Self::Si),
        ("mm-t-s", Self::MmTonneSecond),
        ("mm-kg-ms", Self::MmKilogramMillisecond),
    ];

    /// Length, mass and time in words.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Si => "m, kg, s",
            Self::MmTonneSecond => "mm, t, s",
            Self::MmKilogramMillisecond => "mm, kg, ms",
        }
    }

    /// Powers of ten of length, mass and time: metres, kilograms, seconds per unit.
    fn powers(self) -> [i32; 3] {
        match self {
            Self::Si => [0, 0, 0],
            Self::MmTonneSecond => [-3, 3, 0],
            Self::MmKilogramMillisecond => [-3, 0, -3],
        }
    }

    /// Metres per unit of length.
    #[must_use]
    pub fn length(self) -> f64 {
        ten_to(self.powers()[0])
    }

    /// Newtons per unit of force.
    #[must_use]
    pub fn force(self) -> f64 {
        let [length, mass, time] = self.powers();
        ten_to(mass + length - 2 * time)
    }

    /// Factor of an entry of a matrix, between coordinates that measure `row` and `column`.
    ///
    /// Energy in SI = factor of energy · energy of the file, and a coordinate of the file = its factor · that of SI; so an
    /// entry is multiplied by all three. A mass takes the square of the unit of time, a damping the unit.
    #[must_use]
    pub fn entry(self, of: MatrixKind, row: Kind, column: Kind) -> f64 {
        let [length, mass, time] = self.powers();
        let energy = mass + 2 * length - 2 * time;
        let coordinate = |kind: Kind| match kind {
            Kind::Displacement => -length,
            Kind::Rotation | Kind::Generalized => 0,
        };
        let of_time = match of {
            MatrixKind::Stiffness => 0,
            MatrixKind::Damping => time,
            MatrixKind::Mass => 2 * time,
        };
        ten_to(energy + coordinate(row) + coordinate(column) + of_time)
    }

    /// Factor of a force on a coordinate that measures `kind`.
    #[must_use]
    pub fn load(self, kind: Kind) -> f64 {
        self.entry(MatrixKind::Stiffness, kind, Kind::Generalized)
    }
}

/// What a matrix multiplies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatrixKind {
    /// Displacements.
    Stiffness,
    /// Velocities.
    Damping,
    /// Accelerations.
    Mass,
}

fn ten_to(power: i32) -> f64 {
    10.0_f64.powi(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with the mass without the square of the unit of time.
    #[test]
    fn a_kilogram_and_a_spring_of_each_set() {
        use Kind::{Displacement, Rotation};
        let sets = [
            // N/m per unit of stiffness, kg of mass, N m/rad of rotational stiffness, N of force, N s/m of damping
            (Units::Si, [1.0, 1.0, 1.0, 1.0, 1.0]),
            (Units::MmTonneSecond, [1e3, 1e3, 1e-3, 1.0, 1e3]),
            (Units::MmKilogramMillisecond, [1e6, 1.0, 1.0, 1e3, 1e3]),
        ];
        for (units, expected) in sets {
            let entry = |of| units.entry(of, Displacement, Displacement);
            let found = [
                entry(MatrixKind::Stiffness),
                entry(MatrixKind::Mass),
                units.entry(MatrixKind::Stiffness, Rotation, Rotation),
                units.force(),
                entry(MatrixKind::Damping),
            ];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-12, "{units:?}: {found}");
            }
            assert_eq!(units.load(Displacement), units.force());
        }
    }
}
