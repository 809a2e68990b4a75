//! Constants of a contact interface, shared out to its node pairs.

use super::ContactPair;
use crate::contact::ContactParameters;
use crate::setting::{BadSetting, USUAL_FRICTION, friction_coefficient, unusual, within};
use crate::units::n_per_m_to_n_per_um;

/// How the pairs of an interface share its stiffness.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum StiffnessShare {
    /// Every pair has the same part, whatever its area.
    Equal,
    /// In proportion to the pair's area: the pressure is even under an even approach, on any grid.
    TributaryArea,
}

/// Stiffnesses of an interface that can be meant (N/µm): a millimetre of solid steel under it has 1e5.
pub const STIFFNESS_N_PER_UM: [f64; 2] = [1e-6, 1e6];

/// Constants of every interface of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterfaceSettings {
    /// Normal stiffness of one interface (N/m).
    pub normal_stiffness: f64,
    /// Tangential stiffness of one interface in each direction (N/m).
    pub tangential_stiffness: f64,
    /// Friction coefficient.
    pub friction_coefficient: f64,
    /// How the pairs share the stiffness.
    pub share: StiffnessShare,
}

impl Default for InterfaceSettings {
    fn default() -> Self {
        Self {
            normal_stiffness: 1e9,
            tangential_stiffness: 2.33e8,
            friction_coefficient: 0.6,
            share: StiffnessShare::TributaryArea,
        }
    }
}

impl InterfaceSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with the key of the study file; stiffness in N/µm as there.
    pub fn validate(&self) -> Result<(), BadSetting> {
        for (key, stiffness) in self.stiffnesses() {
            within(key, stiffness, STIFFNESS_N_PER_UM)?;
        }
        friction_coefficient("friction_coefficient", self.friction_coefficient)
    }

    /// What may be meant but is unusual.
    #[must_use]
    pub fn unusual(&self) -> Vec<BadSetting> {
        let stiffnesses = self
            .stiffnesses()
            .map(|(key, k)| unusual(key, k, [1.0, 1e5]));
        let friction = unusual(
            "friction_coefficient",
            self.friction_coefficient,
            USUAL_FRICTION,
        );
        stiffnesses
            .into_iter()
            .chain([friction])
            .flatten()
            .collect()
    }

    fn stiffnesses(&self) -> [(&'static str, f64); 2] {
        [
            (
                "normal_stiffness_n_per_um",
                n_per_m_to_n_per_um(self.normal_stiffness),
            ),
            (
                "tangential_stiffness_n_per_um",
                n_per_m_to_n_per_um(self.tangential_stiffness),
            ),
        ]
    }

    /// Constants of every pair: stiffness shared within the pair's interface, no preload of their own.
    ///
    /// Shape: result `[pairs]`.
    #[must_use]
    pub fn parameters(&self, pairs: &[ContactPair]) -> Vec<ContactParameters<f64>> {
        let weight = |pair: &ContactPair| match self.share {
            StiffnessShare::Equal => 1.0,
            StiffnessShare::TributaryArea => pair.area,
        };
        pairs
            .iter()
            .map(|pair| {
                let same = pairs.iter().filter(|p| p.interface == pair.interface);
                let part = weight(pair) / same.map(weight).sum::<f64>();
                ContactParameters {
                    k_n: part * self.normal_stiffness,
                    k_t: [part * self.tangential_stiffness; 2],
                    mu: self.friction_coefficient,
                    n_0: 0.0,
                    anchor: [0.0; 2],
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(interface: usize, area: f64) -> ContactPair {
        ContactPair {
            name: String::new(),
            t1: Vec::new(),
            t2: Vec::new(),
            n: Vec::new(),
            area,
            interface,
        }
    }

    /// Seen to fail with the sum over all pairs instead of the pairs of the interface.
    #[test]
    fn parts_add_up_to_the_interface() {
        let pairs = [pair(0, 1.0), pair(0, 3.0), pair(1, 5.0)];
        for (share, first) in [
            (StiffnessShare::Equal, 0.5),
            (StiffnessShare::TributaryArea, 0.25),
        ] {
            let settings = InterfaceSettings {
                share,
                ..InterfaceSettings::default()
            };
            let p = settings.parameters(&pairs);
            assert!((p[0].k_n - first * 1e9).abs() < 1.0);
            assert!((p[0].k_n + p[1].k_n - 1e9).abs() < 1.0);
            assert!((p[2].k_t[0] - 2.33e8).abs() < 1.0);
        }
    }
}
