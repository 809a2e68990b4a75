//! What is measured, and in which unit: names and units as laboratories write them.

/// What a column or channel holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Instant.
    Time,
    /// Relative displacement in the direction of sliding.
    Displacement,
    /// Tangential contact force.
    TangentialForce,
    /// Normal contact force.
    NormalForce,
    /// Relative normal displacement.
    Approach,
    /// Frequency of the motion of a hysteresis test.
    Frequency,
    /// Share of the contact's area whose pressure is within a tenth of its mean.
    EvenArea,
    /// Excitation level of a forced response.
    Level,
    /// Resonance frequency.
    ResonanceFrequency,
    /// Amplitude at the resonance.
    Amplitude,
    /// Standard deviation of a resonance frequency.
    FrequencyDeviation,
    /// Standard deviation of an amplitude.
    AmplitudeDeviation,
    /// Pressure on a cell of a pressure map.
    Pressure,
    /// Area of a cell of a pressure map.
    Area,
}

/// What units measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// In seconds.
    Time,
    /// In metres.
    Length,
    /// In newtons.
    Force,
    /// In hertz.
    Frequency,
    /// A part of a whole.
    Share,
    /// In pascals.
    Pressure,
    /// In square metres.
    Area,
}

/// A unit: the SI unit of its dimension times a power of ten.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    /// What it measures.
    pub dimension: Dimension,
    /// The unit is ten to this power of the SI unit.
    pub power: i32,
}

/// Symbols of the units. The micro sign has two code points.
const UNITS: [(&str, Unit); 32] = [
    ("s", unit(Dimension::Time, 0)),
    ("sec", unit(Dimension::Time, 0)),
    ("ms", unit(Dimension::Time, -3)),
    ("us", unit(Dimension::Time, -6)),
    ("\u{b5}s", unit(Dimension::Time, -6)),
    ("\u{3bc}s", unit(Dimension::Time, -6)),
    ("m", unit(Dimension::Length, 0)),
    ("mm", unit(Dimension::Length, -3)),
    ("um", unit(Dimension::Length, -6)),
    ("\u{b5}m", unit(Dimension::Length, -6)),
    ("\u{3bc}m", unit(Dimension::Length, -6)),
    ("micron", unit(Dimension::Length, -6)),
    ("nm", unit(Dimension::Length, -9)),
    ("N", unit(Dimension::Force, 0)),
    ("n", unit(Dimension::Force, 0)),
    ("mN", unit(Dimension::Force, -3)),
    ("kN", unit(Dimension::Force, 3)),
    ("kn", unit(Dimension::Force, 3)),
    ("Hz", unit(Dimension::Frequency, 0)),
    ("hz", unit(Dimension::Frequency, 0)),
    ("kHz", unit(Dimension::Frequency, 3)),
    ("%", unit(Dimension::Share, -2)),
    ("percent", unit(Dimension::Share, -2)),
    ("Pa", unit(Dimension::Pressure, 0)),
    ("kPa", unit(Dimension::Pressure, 3)),
    ("kpa", unit(Dimension::Pressure, 3)),
    ("MPa", unit(Dimension::Pressure, 6)),
    ("mpa", unit(Dimension::Pressure, 6)),
    ("m2", unit(Dimension::Area, 0)),
    ("cm2", unit(Dimension::Area, -4)),
    ("mm2", unit(Dimension::Area, -6)),
    ("mm\u{b2}", unit(Dimension::Area, -6)),
];

/// Unit of a level that is a factor.
const FACTOR: &str = "-";

const fn unit(dimension: Dimension, power: i32) -> Unit {
    Unit { dimension, power }
}

impl Unit {
    /// The unit of a symbol.
    #[must_use]
    pub fn of(symbol: &str) -> Option<Self> {
        let symbol = symbol.trim();
        let found = UNITS.iter().find(|(known, _)| *known == symbol);
        found.map(|(_, unit)| *unit)
    }

    /// A value in this unit, in the SI unit. A division by a power of ten is rounded once, a product with 1e-6 twice.
    #[must_use]
    pub fn to_si(self, value: f64) -> f64 {
        let factor = 10_f64.powi(self.power.abs());
        if self.power < 0 {
            value / factor
        } else {
            value * factor
        }
    }
}

impl Dimension {
    /// Its name and the units that files may use, for messages.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Time => "time: s, ms, us",
            Self::Length => "length: m, mm, um, nm",
            Self::Force => "force: N, mN, kN",
            Self::Frequency => "frequency: Hz, kHz",
            Self::Share => "a share: %",
            Self::Pressure => "pressure: Pa, kPa, MPa",
            Self::Area => "area: m2, cm2, mm2",
        }
    }

    /// Symbol of its SI unit; of a share that of files.
    #[must_use]
    pub fn si(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Length => "m",
            Self::Force => "N",
            Self::Frequency => "Hz",
            Self::Share => "%",
            Self::Pressure => "Pa",
            Self::Area => "m2",
        }
    }
}

impl Quantity {
    /// Those that are sampled in a hysteresis test.
    pub const SIGNALS: [Self; 5] = [
        Self::Time,
        Self::Displacement,
        Self::TangentialForce,
        Self::NormalForce,
        Self::Approach,
    ];

    /// Those that are stated once for a hysteresis test.
    pub const CONDITIONS: [Self; 2] = [Self::Frequency, Self::EvenArea];

    /// Those of a forced response.
    pub const RESPONSE: [Self; 5] = [
        Self::Level,
        Self::ResonanceFrequency,
        Self::Amplitude,
        Self::FrequencyDeviation,
        Self::AmplitudeDeviation,
    ];

    /// Names that it may have in a file; the first is its own.
    #[must_use]
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Time => &["time", "t"],
            Self::Displacement => &[
                "relative displacement",
                "displacement",
                "tangential displacement",
                "relative tangential displacement",
                "sliding displacement",
                "x",
            ],
            Self::TangentialForce => &[
                "tangential force",
                "tangential contact force",
                "tangential",
                "friction force",
                "T",
            ],
            Self::NormalForce => &[
                "normal force",
                "normal contact force",
                "normal load",
                "normal",
                "N",
            ],
            Self::Approach => &[
                "normal displacement",
                "relative normal displacement",
                "normal approach",
                "approach",
            ],
            Self::Frequency => &["frequency", "excitation frequency", "f"],
            Self::EvenArea => &["area within a tenth of the mean pressure", "even area"],
            Self::Level => &["level", "excitation level", "excitation", "force"],
            Self::ResonanceFrequency => &["resonance frequency", "frequency"],
            Self::Amplitude => &["amplitude", "resonance amplitude", "peak amplitude"],
            Self::FrequencyDeviation => &["frequency deviation", "frequency standard deviation"],
            Self::AmplitudeDeviation => &["amplitude deviation", "amplitude standard deviation"],
            Self::Pressure => &["pressure", "contact pressure"],
            Self::Area => &["area", "cell area"],
        }
    }

    /// Its own name.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.names()[0]
    }

    /// What its units measure.
    #[must_use]
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Time => Dimension::Time,
            Self::TangentialForce | Self::NormalForce | Self::Level => Dimension::Force,
            Self::Displacement | Self::Approach | Self::Amplitude | Self::AmplitudeDeviation => {
                Dimension::Length
            }
            Self::Frequency | Self::ResonanceFrequency | Self::FrequencyDeviation => {
                Dimension::Frequency
            }
            Self::EvenArea => Dimension::Share,
            Self::Pressure => Dimension::Pressure,
            Self::Area => Dimension::Area,
        }
    }

    /// The quantity among `known` that has this name.
    #[must_use]
    pub fn named(name: &str, known: &[Self]) -> Option<Self> {
        let has = |quantity: &&Self| quantity.names().iter().any(|own| is_name(name, own));
        known.iter().find(has).copied()
    }

    /// Its unit, from the symbol that follows its name in a file. The level of a model of one's own matrices is a factor on its forces.
    ///
    /// # Errors
    /// The rule, if there is none or it measures something else.
    pub fn unit(self, symbol: Option<&str>) -> Result<Unit, String> {
        let (name, words) = (self.name(), self.dimension().in_words());
        let symbol = symbol.filter(|symbol| !symbol.trim().is_empty());
        let Some(symbol) = symbol else {
            let si = self.dimension().si();
            return Err(format!(
                "{name}: has no unit: must have one in brackets, as {name} [{si}]; units of {words}"
            ));
        };
        if self == Self::Level && symbol.trim() == FACTOR {
            return Ok(unit(Dimension::Force, 0));
        }
        let unit = Unit::of(symbol).filter(|unit| unit.dimension == self.dimension());
        unit.ok_or_else(|| {
            let or = if self == Self::Level {
                ", or - for a factor on the forces of a model"
            } else {
                ""
            };
            format!("{name} [{symbol:.20}]: must be in a unit of {words}{or}")
        })
    }
}

/// Unit in which files are written, and its power of ten.
#[must_use]
pub fn written_unit(quantity: Quantity) -> (&'static str, i32) {
    match quantity.dimension() {
        Dimension::Length => ("um", -6),
        Dimension::Share => ("%", -2),
        Dimension::Pressure => ("MPa", 6),
        Dimension::Area => ("mm2", -6),
        dimension => (dimension.si(), 0),
    }
}

/// Whether a file's name is a known one. Case, `_` and `-` do not count, but T is a force and t the time.
#[must_use]
pub fn is_name(name: &str, known: &str) -> bool {
    let mut words = name.split([' ', '_', '-', '\t']).filter(|w| !w.is_empty());
    let mut own = known.split(' ');
    if known.len() == 1 {
        return words.next() == Some(known) && words.next().is_none();
    }
    loop {
        match (words.next(), own.next()) {
            (None, None) => return true,
            (Some(word), Some(own)) if word.eq_ignore_ascii_case(own) => {}
            _ => return false,
        }
    }
}

/// Name and unit of `name [unit]`, `name (unit)` or `name_unit`.
#[must_use]
pub fn name_and_unit(heading: &str) -> (&str, Option<&str>) {
    let heading = heading.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        let inside = heading.strip_suffix(close);
        if let Some((name, unit)) = inside.and_then(|inside| inside.split_once(open)) {
            return (name.trim(), Some(unit.trim()));
        }
    }
    match heading.rsplit_once('_') {
        Some((name, unit)) if Unit::of(unit).is_some() => (name, Some(unit)),
        _ => (heading, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with single letters compared without their case: T was the time.
    #[test]
    fn names_are_those_of_laboratories() {
        let names = [
            ("Time", Some(Quantity::Time)),
            ("t", Some(Quantity::Time)),
            ("T", Some(Quantity::TangentialForce)),
            ("N", Some(Quantity::NormalForce)),
            ("n", None),
            ("RELATIVE_Displacement", Some(Quantity::Displacement)),
            ("normal-displacement", Some(Quantity::Approach)),
            ("normal  load", Some(Quantity::NormalForce)),
            ("Friction Force", Some(Quantity::TangentialForce)),
            ("normal dispalcement", None),
            ("frequency", None),
            ("", None),
        ];
        for (name, expected) in names {
            assert_eq!(
                Quantity::named(name, &Quantity::SIGNALS),
                expected,
                "{name}"
            );
        }
    }

    /// Seen to fail with a suffix that is no unit taken for one: `normal_force` was `normal` in force.
    #[test]
    fn units_follow_names() {
        let headings = [
            ("time [s]", ("time", Some("s"))),
            (
                "relative displacement (um)",
                ("relative displacement", Some("um")),
            ),
            ("displacement_um", ("displacement", Some("um"))),
            ("normal_force_n", ("normal_force", Some("n"))),
            ("normal_force", ("normal_force", None)),
            ("time []", ("time", Some(""))),
            ("time [s", ("time [s", None)),
        ];
        for (heading, expected) in headings {
            assert_eq!(name_and_unit(heading), expected, "{heading}");
        }
    }

    /// Seen to fail with a product: 5 um became 4.9999999999999996e-6 m.
    #[test]
    fn values_are_in_si_units() {
        for (symbol, value, si) in [
            ("um", 5.0, 5e-6),
            ("\u{b5}m", 7.0, 7e-6),
            ("\u{3bc}m", 7.0, 7e-6),
            ("mm", 9.0, 9e-3),
            ("kN", 1.5, 1500.0),
            ("mN", 20.0, 0.02),
            ("ms", 5.0, 0.005),
        ] {
            assert_eq!(Unit::of(symbol).unwrap().to_si(value), si, "{symbol}");
        }
        assert!(Unit::of("MN").is_none() && Unit::of("lbf").is_none());
        let rule = Quantity::Time.unit(Some("um")).unwrap_err();
        assert_eq!(rule, "time [um]: must be in a unit of time: s, ms, us");
        let rule = Quantity::Level.unit(Some("mm")).unwrap_err();
        assert!(
            rule.ends_with("kN, or - for a factor on the forces of a model"),
            "{rule}"
        );
        let factor = Quantity::Level.unit(Some("-")).unwrap();
        assert_eq!(factor.to_si(2.5), 2.5, "a level without a unit");
        assert!(
            Quantity::NormalForce.unit(Some("-")).is_err(),
            "a force needs a unit"
        );
        let rule = Quantity::NormalForce.unit(None).unwrap_err();
        assert!(
            rule.starts_with("normal force: has no unit: must have"),
            "{rule}"
        );
    }
}
