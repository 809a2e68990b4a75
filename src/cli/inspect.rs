//! `inspect`: what a study would compute.

use std::io::Write;

use super::log::Event;
use super::study_arguments::StudyArguments;
use super::terminal::print;
use super::total_mass::show_mass;
use microslip::Error;
use microslip::study::{FrequencyUnit, Inspection, Study, inspect};
use microslip::units::count;
use serde_json::json;

pub(super) fn execute(arguments: &StudyArguments) -> Result<(), Error> {
    arguments.threads.start()?;
    let study = Study::read(&arguments.study)?;
    let facts = inspect(&study)?;
    let log = arguments.messages.log;
    log.warn(&facts.warnings);
    // what was asked for: shown with `--quiet`, too
    print(|out| show(out, &facts))?;
    log.write(&Event::Finished(json!({
        "study": arguments.study.display().to_string(),
    })));
    Ok(())
}

fn show(out: &mut dyn Write, facts: &Inspection) -> std::io::Result<()> {
    show_structure(out, facts)?;
    show_samples(out, facts)?;
    show_cost(out, facts)
}

/// The model and its natural frequencies.
fn show_structure(out: &mut dyn Write, facts: &Inspection) -> std::io::Result<()> {
    let list = |names: &[String]| abbreviated(names);
    let numbers = |values: &[f64]| {
        let words: Vec<_> = values.iter().map(|f| format!("{f:.6}")).collect();
        words.join(" ")
    };
    writeln!(out, "study               {}", facts.name)?;
    writeln!(
        out,
        "degrees of freedom  {}: {}",
        facts.dof_names.len(),
        list(&facts.dof_names)
    )?;
    writeln!(
        out,
        "contact pairs       {}: {}",
        facts.contact_names.len(),
        list(&facts.contact_names)
    )?;
    writeln!(out, "responses           {}", list(&facts.response_names))?;
    for (name, component) in &facts.components {
        let next = match component.first_left_out {
            f if f.is_finite() => format!("the first one left out is at {f:.1} Hz"),
            _ => "none is left out".to_owned(),
        };
        let (modes, cut_off) = (component.n_modes, component.cut_off);
        writeln!(
            out,
            "{:20}{modes} below {cut_off} Hz; {next}",
            format!("{name} fixed modes"),
        )?;
    }
    show_mass(out, facts.total_mass, facts.unit == FrequencyUnit::Hertz)?;
    let unit = facts.unit.name();
    if let Some((order, diameter)) = facts.excited {
        writeln!(
            out,
            "excited             engine order {order}: nodal diameter {diameter}, which the frequencies below are of"
        )?;
    }
    writeln!(
        out,
        "free frequencies    {} {unit} ({})",
        numbers(&facts.free),
        facts.rigid
    )?;
    writeln!(out, "stuck frequencies   {} {unit}", numbers(&facts.stuck))?;
    for of in &facts.nodal_diameters {
        let (free, stuck) = (numbers(&of.free), numbers(&of.stuck));
        let name = format!("nodal diameter {}", of.number);
        writeln!(out, "  {name:26}free {free}, stuck {stuck} {unit}")?;
    }
    Ok(())
}

/// Random inputs, and how many samples are solved at which levels.
fn show_samples(out: &mut dyn Write, facts: &Inspection) -> std::io::Result<()> {
    let inputs = match facts.inputs.as_slice() {
        [] => "none".to_owned(),
        names => names.join(", "),
    };
    writeln!(out, "random inputs       {inputs}")?;
    let longest = facts.inputs.iter().map(|name| name.len()).max();
    let width = longest.unwrap_or(0).max(24);
    for (name, distribution) in facts.inputs.iter().zip(&facts.distributions) {
        writeln!(out, "  {name:width$}  {distribution}")?;
    }
    writeln!(out, "design              {}", facts.design)?;
    if let Some(field) = &facts.pressure_field {
        writeln!(out, "pressure field      {field}")?;
    }
    let levels: Vec<_> = facts.levels.iter().map(f64::to_string).collect();
    let most = match &facts.stopping {
        Some(_) => "at most ",
        None => "",
    };
    writeln!(
        out,
        "samples x levels    {most}{} x {} ({})",
        facts.samples,
        levels.len(),
        levels.join(", ")
    )?;
    if let Some(stopping) = &facts.stopping {
        let looks: Vec<_> = stopping.looks.iter().map(u64::to_string).collect();
        let (looks, goal) = (looks.join(", "), stopping.goal());
        writeln!(out, "judged at           {looks} samples, until {goal}")?;
    }
    if facts.further_samples > 0 {
        writeln!(
            out,
            "worst-case search   up to {} samples more",
            facts.further_samples
        )?;
    }
    Ok(())
}

/// Size of one solve, memory and time.
fn show_cost(out: &mut dyn Write, facts: &Inspection) -> std::io::Result<()> {
    let [first, highest] = facts.unknowns;
    writeln!(
        out,
        "unknowns per solve  {first}, up to {highest} with more harmonics"
    )?;
    let [usual, most] = facts.memory_bytes.map(|bytes| bytes / 1e6);
    writeln!(
        out,
        "memory per thread   {usual:.0} MB, at most {most:.0} MB"
    )?;
    writeln!(
        out,
        "processor time      about {} of `run` (within a factor of two; nearly twice that where threads share cores)",
        duration(facts.processor_time_s)
    )?;
    if let Some(pilot) = facts.pilot {
        writeln!(
            out,
            "pilot               {} solved for it in {:.1} s of processor time",
            count(pilot.samples, "sample"),
            pilot.processor_time_s
        )?;
    }
    let threads = match facts.threads {
        1 => "1 thread with a core of its own".to_owned(),
        n => format!("{n} threads, each with a core of its own"),
    };
    writeln!(
        out,
        "wall time           about {} on {threads}",
        duration(facts.wall_time_s)
    )
}

/// The first names and how many more there are.
fn abbreviated(names: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(", and {} more", names.len() - SHOWN));
    }
    text
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "a second".to_owned(),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 600.0 => format!("{:.1} min", s / 60.0),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
