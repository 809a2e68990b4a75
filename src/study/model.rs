//! The structure that a study asks for: `[model]`, with `[contact]` and `[pressure_field]`.

use super::document::Document;
use super::tables::ContactSection;
use crate::Error;
use crate::model::interface::InterfaceSettings;
use crate::model::matrices::MatricesSettings;
use crate::model::two_blade::{PressureField, TwoBladeSettings};
use crate::setting::BadSetting;

/// Why a pressure cannot be shaped.
pub(super) const NO_POSITIONS: &str =
    "a model of kind \"matrices\" has no positions of its contacts";

/// Which structure is computed.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelSettings {
    /// The built-in two blades with a strip.
    TwoBladeStrip {
        /// Geometry and material.
        blades: TwoBladeSettings,
        /// Constants of both interfaces.
        interface: InterfaceSettings,
        /// Random field of the contact pressure.
        pressure: Option<PressureField>,
    },
    /// The user's own matrices.
    Matrices(MatricesSettings),
}

/// Reads `[model]` by its `kind`.
pub(super) fn model(
    document: &mut Document<'_>,
    contact: &ContactSection,
) -> Result<ModelSettings, Error> {
    let kind = document.take_string("model", "kind")?;
    let of_contact = |bad: BadSetting| bad.under("contact");
    match kind.as_str() {
        "two-blade-strip" => {
            let blades: TwoBladeSettings = document.required("model")?;
            document.checked(blades.validate().map_err(|b| b.under("model")))?;
            let interface = document.checked(contact.interface().map_err(of_contact))?;
            let pressure: Option<PressureField> = document.take("pressure_field")?;
            if let Some(field) = &pressure {
                let nodes = blades.contact_nodes.iter().product();
                let valid = field.validate(nodes);
                let valid = valid.map_err(|b| b.under("pressure_field"));
                document.checked(valid)?;
            }
            Ok(ModelSettings::TwoBladeStrip {
                blades,
                interface,
                pressure,
            })
        }
        "matrices" => {
            if document.take::<PressureField>("pressure_field")?.is_some() {
                let rule = format!("must be absent: {NO_POSITIONS}");
                return Err(document.at_key("pressure_field", rule));
            }
            let settings: MatricesSettings = document.required("model")?;
            document.checked(settings.validate().map_err(|b| b.under("model")))?;
            document.checked(contact.refuse_interface().map_err(of_contact))?;
            Ok(ModelSettings::Matrices(settings))
        }
        _ => Err(document.bad_setting(&BadSetting {
            key: "model.kind".to_owned(),
            value: kind,
            rule: "must be \"two-blade-strip\" or \"matrices\"".to_owned(),
        })),
    }
}
