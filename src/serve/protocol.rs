//! What the requests of UM-Bridge 1.0 mean, and their replies.

use super::http::{Code, Request};
use crate::ensemble::outcome::LevelOutcome;
use crate::ensemble::stop::Stop;
use crate::study::{EvaluationError, Evaluator};
use serde::Deserialize;
use serde_json::{Value, json};

/// Name of the model.
pub const MODEL: &str = "forward";

/// Kinds of errors that the protocol knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    ModelNotFound,
    UnsupportedFeature,
    InvalidInput,
    InvalidOutput,
    InternalError,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::ModelNotFound => "ModelNotFound",
            Self::UnsupportedFeature => "UnsupportedFeature",
            Self::InvalidInput => "InvalidInput",
            Self::InvalidOutput => "InvalidOutput",
            Self::InternalError => "InternalError",
        }
    }
}

/// Why there is no answer.
struct Failure {
    code: Code,
    kind: Kind,
    message: String,
}

impl Failure {
    fn of_client(kind: Kind, message: String) -> Self {
        Self {
            code: Code::BadRequest,
            kind,
            message,
        }
    }

    fn of_input(message: impl std::fmt::Display) -> Self {
        Self::of_client(Kind::InvalidInput, message.to_string())
    }
}

/// What is not random, in the words of a request.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {
    /// One level of the study in place of all.
    level: Option<f64>,
}

/// Code and body of the reply to a request.
pub(super) fn reply(model: &Evaluator<'_>, request: &Request) -> (Code, String) {
    match answer(model, request) {
        Ok(value) => (Code::Ok, value.to_string()),
        Err(failure) => (failure.code, error(failure.kind, &failure.message)),
    }
}

/// Body of the reply to a request that could not be read.
pub(super) fn unreadable(message: &str) -> String {
    error(Kind::InvalidInput, message)
}

/// Body of the reply where the program met a defect of its own.
pub(super) fn defect() -> String {
    let message = "the program met a defect of its own: please report it with the request";
    error(Kind::InternalError, message)
}

fn error(kind: Kind, message: &str) -> String {
    json!({ "error": { "type": kind.name(), "message": message } }).to_string()
}

fn answer(model: &Evaluator<'_>, request: &Request) -> Result<Value, Failure> {
    let path = request.path.as_str();
    let wanted = match path {
        "/Info" => "GET",
        "/ModelInfo" | "/InputSizes" | "/OutputSizes" | "/Evaluate" | "/Gradient"
        | "/ApplyJacobian" | "/ApplyHessian" => "POST",
        _ => return Err(elsewhere(Code::NotFound, format!("{path}: no such path"))),
    };
    if request.method != wanted {
        let message = format!("{path}: must be asked by {wanted}");
        return Err(elsewhere(Code::MethodNotAllowed, message));
    }
    if path == "/Info" {
        return Ok(json!({ "protocolVersion": 1.0, "models": [MODEL] }));
    }
    let mut body: Value = serde_json::from_slice(&request.body).map_err(Failure::of_input)?;
    require_model(&body)?;
    let config: Option<Config> = part(&mut body, "config")?;
    let level = place(model, &config.unwrap_or_default())?;
    let n = level.map_or(model.levels().len(), |_| 1);
    match path {
        "/ModelInfo" => Ok(json!({ "support": {
            "Evaluate": true, "Gradient": false, "ApplyJacobian": false, "ApplyHessian": false,
        } })),
        "/InputSizes" => Ok(json!({ "inputSizes": [model.input_names().len()] })),
        "/OutputSizes" => Ok(json!({ "outputSizes": [n, n] })),
        "/Evaluate" => evaluate(model, part(&mut body, "input")?, level),
        _ => {
            let message = format!("{}: the model has no derivatives", &path[1..]);
            Err(Failure::of_client(Kind::UnsupportedFeature, message))
        }
    }
}

fn elsewhere(code: Code, message: String) -> Failure {
    Failure {
        code,
        kind: Kind::InvalidInput,
        message,
    }
}

fn require_model(body: &Value) -> Result<(), Failure> {
    match body.get("name").map(Value::as_str) {
        Some(Some(MODEL)) => Ok(()),
        Some(Some(other)) => {
            let message = format!("{other:?}: no such model; there is {MODEL:?}");
            Err(Failure::of_client(Kind::ModelNotFound, message))
        }
        Some(None) => Err(Failure::of_input("name: must be a text")),
        None => Err(Failure::of_input("name: must be given")),
    }
}

/// A part of the body; nothing where it is absent or null.
fn part<T: for<'de> Deserialize<'de>>(body: &mut Value, key: &str) -> Result<Option<T>, Failure> {
    let given = body.get_mut(key).map(Value::take).unwrap_or_default();
    let read = serde_json::from_value(given);
    read.map_err(|error| Failure::of_input(format!("{key}: {error}")))
}

/// Place of the one level that is asked for; nothing for all.
fn place(model: &Evaluator<'_>, config: &Config) -> Result<Option<usize>, Failure> {
    let Some(level) = config.level else {
        return Ok(None);
    };
    let levels = model.levels();
    let known = levels.iter().map(f64::to_string).collect::<Vec<_>>();
    let place = levels.iter().position(|other| *other == level);
    place.map(Some).ok_or_else(|| {
        let known = known.join(", ");
        let message = format!("config.level = {level}: must be a level of the study: {known}");
        Failure::of_input(message)
    })
}

fn evaluate(
    model: &Evaluator<'_>,
    input: Option<Vec<Vec<f64>>>,
    level: Option<usize>,
) -> Result<Value, Failure> {
    let input = input.ok_or_else(|| Failure::of_input("input: must be given"))?;
    let [point] = input.as_slice() else {
        let message = format!("input: must be one vector, not {}", input.len());
        return Err(Failure::of_input(message));
    };
    let checked = model.study().check_values(point);
    checked.map_err(Failure::of_input)?;
    // a server that ends still answers what it was asked
    let levels = model.evaluate(&[point], &Stop::default());
    let levels: Vec<LevelOutcome> = levels.map_err(failed)?.into_iter().flatten().collect();
    let wanted = match level {
        Some(place) => &levels[place..=place],
        None => &levels[..],
    };
    let peaks: Result<Vec<_>, _> = wanted.iter().map(|o| o.peak.ok_or(o)).collect();
    let Ok(peaks) = peaks else {
        return Err(without_peak(wanted));
    };
    let frequencies: Vec<f64> = peaks.iter().map(|peak| peak.frequency_hz).collect();
    let amplitudes: Vec<f64> = peaks.iter().map(|peak| peak.amplitude_m).collect();
    Ok(json!({ "output": [frequencies, amplitudes] }))
}

fn failed(error: EvaluationError) -> Failure {
    Failure {
        code: Code::ServerError,
        kind: Kind::InternalError,
        message: error.to_string(),
    }
}

/// JSON has no number for what was not found.
fn without_peak(levels: &[LevelOutcome]) -> Failure {
    let missing = levels.iter().filter(|outcome| outcome.peak.is_none());
    let said = missing.map(|outcome| {
        let (level, status) = (outcome.level, outcome.status);
        format!("level {level}: {}: {}", status.name(), status.explanation())
    });
    Failure {
        code: Code::ServerError,
        kind: Kind::InvalidOutput,
        message: said.collect::<Vec<_>>().join("; "),
    }
}
