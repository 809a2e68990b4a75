//! What is known of the inputs before the measurement: independent standard normal scores, and what they stand for.

use crate::sampling::correlation::Copula;
use crate::sampling::{Design, Distribution, Input};
use crate::setting::BadSetting;
use crate::special::{normal_cdf, normal_quantile};
use crate::statistics::Polynomials;

/// Probability at which a value may not be that of an end.
const HEAP: f64 = 0.01;
/// Least distance of a probability from 0 and 1: of a value at the end of its distribution.
const END: f64 = 1e-12;

/// Random inputs of a study with their joint distribution.
///
/// Scores z are independent standard normal numbers; the input j has the distribution function Φ((L z)_j), L Lᵀ being the
/// correlation of the study.
#[derive(Debug, Clone)]
pub struct Prior {
    inputs: Vec<(Input, Distribution)>,
    polynomials: Vec<Polynomials>,
    copula: Option<Copula>,
    /// Values of all inputs of the study, the random ones at their medians.
    all: Vec<f64>,
    /// Places of the random inputs among all.
    places: Vec<usize>,
}

impl Prior {
    /// The prior of a study's design.
    ///
    /// # Errors
    /// [`BadSetting`] with a key of the study file: an interval or a file of samples instead of a distribution, or no random input.
    pub fn of(design: &Design) -> Result<Self, BadSetting> {
        let rule = "must be no \"epistemic\" input: an interval is no prior distribution";
        BadSetting::unless(design.outer().is_none(), "inputs", "(interval)", rule)?;
        let numbered = design
            .inputs()
            .iter()
            .find(|(input, _)| input.numbers_draws());
        let key =
            numbered.map_or_else(String::new, |(input, _)| format!("inputs.{}", input.name()));
        let rule = "must be absent: its values only number the draws of a field, which no surrogate follows";
        BadSetting::unless(numbered.is_none(), &key, "(given)", rule)?;
        let places = design.drawn().to_vec();
        let varied = |j: &usize| design.inputs()[*j].1.fixed_value().is_none();
        let random = (0..design.inputs().len()).filter(varied).count();
        let rule = "must have no columns: samples of a file are no prior distribution";
        BadSetting::unless(random == places.len(), "design.path", "(file)", rule)?;
        let rule = "must hold a random input, which a measurement could tell something of";
        BadSetting::unless(!places.is_empty(), "inputs", "(none)", rule)?;
        let inputs: Vec<_> = places.iter().map(|j| design.inputs()[*j].clone()).collect();
        for (input, law) in &inputs {
            let key = format!("inputs.{}", input.name());
            let rule = "must not have 1 % of its probability within the rounding of an end: values there do not tell their place in the distribution";
            BadSetting::unless(!is_heaped(law), &key, law, rule)?;
        }
        Ok(Self {
            polynomials: (inputs.iter())
                .map(|(_, law)| Polynomials::of_law(law.is_gaussian()))
                .collect(),
            inputs,
            copula: design.correlation().and_then(Copula::new),
            all: design.medians(),
            places,
        })
    }

    /// Random inputs with their distributions.
    #[must_use]
    pub fn inputs(&self) -> &[(Input, Distribution)] {
        &self.inputs
    }

    /// Polynomials of each random input in a surrogate.
    #[must_use]
    pub fn polynomials(&self) -> &[Polynomials] {
        &self.polynomials
    }

    /// Correlated scores. Shape: `[random inputs]`, as `scores`.
    fn correlated(&self, scores: &[f64]) -> Vec<f64> {
        match &self.copula {
            Some(copula) => copula.scores(scores),
            None => scores.to_vec(),
        }
    }

    /// Where the random inputs lie in their distributions, from 0 to 1. Shape: `[random inputs]`, as `scores`.
    #[must_use]
    pub fn probabilities(&self, scores: &[f64]) -> Vec<f64> {
        let correlated = self.correlated(scores);
        let inside = |z: &f64| normal_cdf(*z).clamp(END, 1.0 - END);
        correlated.iter().map(inside).collect()
    }

    /// Values of the random inputs. Shape: `[random inputs]`, as `scores`.
    #[must_use]
    pub fn values(&self, scores: &[f64]) -> Vec<f64> {
        let places = self.probabilities(scores).into_iter();
        let laws = self.inputs.iter().map(|(_, law)| law);
        places.zip(laws).map(|(u, law)| law.quantile(u)).collect()
    }

    /// Values of all inputs of the study where the random ones have the given values.
    #[must_use]
    pub fn with_fixed(&self, random: &[f64]) -> Vec<f64> {
        let mut all = self.all.clone();
        for (place, value) in self.places.iter().zip(random) {
            all[*place] = *value;
        }
        all
    }

    /// Coordinates of a surrogate at `scores`. Shape: `[random inputs]`.
    #[must_use]
    pub fn coordinates(&self, scores: &[f64]) -> Vec<f64> {
        let correlated = self.correlated(scores).into_iter();
        let bases = self.polynomials.iter();
        let of = |(z, basis): (f64, &Polynomials)| match basis {
            Polynomials::Hermite => z,
            Polynomials::Legendre => normal_cdf(z),
        };
        correlated.zip(bases).map(of).collect()
    }

    /// Coordinates of a surrogate at the values of all inputs of a sample. Shape: `[random inputs]`.
    #[must_use]
    pub fn coordinates_of_values(&self, all: &[f64]) -> Vec<f64> {
        let places = self.places.iter().zip(&self.inputs).zip(&self.polynomials);
        places
            .map(|((place, (_, law)), basis)| {
                let u = law.cdf(all[*place]).clamp(END, 1.0 - END);
                match basis {
                    Polynomials::Hermite => normal_quantile(u),
                    Polynomials::Legendre => u,
                }
            })
            .collect()
    }
}

/// Whether the values at an end of a distribution, and at a hundredth of its probability from there, are the same number.
fn is_heaped(law: &Distribution) -> bool {
    let same = |a: f64, b: f64| law.quantile(a) == law.quantile(b);
    same(END, HEAP) || same(1.0 - HEAP, 1.0 - END)
}
