//! The documents hold together: links lead to files that are there, and the README stays short.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read the documents fails"
)]

#[path = "common/packages.rs"]
mod packages;

use packages::below_package;
use std::path::{Path, PathBuf};

/// Most lines of the README: all else belongs to the book.
const LONGEST_README: usize = 130;
/// Sources of the book.
const BOOK: &str = "docs/src";

fn in_folder(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

fn documents() -> Vec<PathBuf> {
    let mut all = in_folder(".");
    all.extend(in_folder(BOOK));
    all.extend(in_folder("studies").iter().map(|of| of.join("README.md")));
    all.push(PathBuf::from("benches/README.md"));
    all.retain(|path| path.extension().is_some_and(|e| e == "md") && path.exists());
    all
}

/// Text without blocks and spans of code: these hold examples, no links.
fn prose(text: &str) -> String {
    let mut code = false;
    let lines = text.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !fence && !code && !line.starts_with("    ")
    });
    let lines: Vec<_> = lines.collect();
    let joined = lines.join("\n");
    let parts = joined.split('`');
    parts.step_by(2).collect::<Vec<_>>().join("code")
}

/// Targets of `[text](target)`.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let targets = prose.split("](").skip(1);
    let targets = targets.filter_map(|rest| rest.split(')').next());
    targets.map(str::to_owned).collect()
}

/// Targets of `{{#include target}}`.
fn included(text: &str) -> Vec<String> {
    let targets = text.split("{{#include ").skip(1);
    let targets = targets.filter_map(|rest| rest.split("}}").next());
    targets.map(|target| target.trim().to_owned()).collect()
}

/// Anchor of a heading, as mdBook and code hosts make it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter_map(|c| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
        _ => None,
    });
    kept.collect()
}

fn has_anchor(page: &Path, wanted: &str) -> bool {
    let text = std::fs::read_to_string(page).unwrap();
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let mut anchors = headings.map(|line| anchor(line.trim_start_matches('#')));
    anchors.any(|anchor| anchor == wanted)
}

/// What is wrong with a link of a document; pages of the book must not lead out of it, for its pages are built alone.
fn fault(document: &Path, target: &str) -> Option<&'static str> {
    let web = ["http://", "https://"];
    if web.iter().any(|scheme| target.starts_with(scheme)) {
        return None;
    }
    let (file, heading) = target.split_once('#').unwrap_or((target, ""));
    let page = match file {
        "" => document.to_owned(),
        file => document.parent().unwrap().join(file),
    };
    let leaves = document.starts_with(BOOK) && file.starts_with("..");
    match (page.exists(), leaves) {
        (false, _) => Some("no such file"),
        (_, true) => Some("leaves the book"),
        _ if !heading.is_empty() && !has_anchor(&page, heading) => Some("no such heading"),
        _ => None,
    }
}

/// Seen to fail with a page of the book renamed, a link out of the book, a heading changed and an included file away.
#[test]
fn links_lead_somewhere() {
    let mut broken = Vec::new();
    let (mut found, documents) = (0, documents());
    for document in &documents {
        let text = std::fs::read_to_string(document).unwrap();
        for target in links(&text) {
            found += 1;
            if let Some(fault) = fault(document, &target) {
                broken.push(format!("{}: {target}: {fault}", document.display()));
            }
        }
        for target in included(&text) {
            if !document.parent().unwrap().join(&target).exists() {
                broken.push(format!("{}: {target}: no such file", document.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(found > 50, "{found} links in {} documents", documents.len());
}

/// Ends of names of files that the folder `studies` holds from the start; results are there only after a run.
const SHIPPED: [&str; 4] = [".toml", ".sh", ".md", ".mtx"];

/// Files below `studies` that a text names from the root of the project.
fn shipped_files(text: &str) -> Vec<String> {
    let part_of_name = |c: char| c.is_ascii_alphanumeric() || "-_./".contains(c);
    let names = text.match_indices("studies/").map(|(at, _)| {
        let rest = &text[at..];
        let end = rest.find(|c| !part_of_name(c)).unwrap_or(rest.len());
        rest[..end].trim_end_matches('.').to_owned()
    });
    let shipped = |name: &String| SHIPPED.iter().any(|end| name.ends_with(end));
    names.filter(shipped).collect()
}

/// Commands in blocks and spans of code name files that are there. Seen to fail with `studies/performance-curves/study.toml` in the README of
/// the two blades, as it stood there.
#[test]
fn files_of_studies_that_documents_name_are_there() {
    let mut found = 0;
    let mut absent = Vec::new();
    for document in documents() {
        let text = std::fs::read_to_string(&document).unwrap();
        for name in shipped_files(&text) {
            found += 1;
            if !Path::new(&name).exists() {
                absent.push(format!("{}: {name}", document.display()));
            }
        }
    }
    assert!(absent.is_empty(), "{}", absent.join("\n"));
    assert!(found > 20, "{found} names");
}

/// Every page stands in the table of contents: mdBook builds no other. Seen to fail with `limits.md` taken out of it.
#[test]
fn every_page_is_in_the_book() {
    let summary = std::fs::read_to_string(Path::new(BOOK).join("SUMMARY.md")).unwrap();
    let listed = links(&summary);
    for page in in_folder(BOOK) {
        let name = page.file_name().unwrap().to_str().unwrap().to_owned();
        assert!(
            name == "SUMMARY.md" || listed.contains(&name),
            "{name} is not in SUMMARY.md"
        );
    }
}

/// Seen to fail with a limit of 50 lines.
#[test]
fn the_readme_is_short() {
    let lines = std::fs::read_to_string("README.md")
        .unwrap()
        .lines()
        .count();
    assert!(lines <= LONGEST_README, "README.md has {lines} lines");
}

/// The page of constants.
const CONSTANTS: &str = "docs/src/constants.md";
/// Folders and files of `src` whose constants are no choices: layout of the pages, words of the program, sizes of a matrix.
const NOT_LISTED: [&str; 5] = [
    "cli",
    "contact/real.rs",
    "identify/page",
    "page",
    "report/page",
];
/// Types of numbers.
const NUMBERS: [&str; 14] = [
    "f64",
    "f32",
    "i64",
    "usize",
    "u8",
    "u32",
    "u64",
    "Range<f64>",
    "Duration",
    "Damping",
    "[f64;",
    "[f32;",
    "[i64;",
    "[usize;",
];

/// File, name and value of a constant.
type Constant = (String, String, String);

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let (folders, files): (Vec<_>, Vec<_>) = in_folder(folder.to_str().unwrap())
        .into_iter()
        .partition(|path| path.is_dir());
    let inside = folders.iter().flat_map(|folder| rust_files(folder));
    let sources = files
        .into_iter()
        .filter(|path| path.extension().is_some_and(|e| e == "rs"));
    sources.chain(inside).collect()
}

/// `NAME: type = value` of a line that begins a constant of a file.
fn declared(line: &str) -> Option<&str> {
    let visible = match line.strip_prefix("pub(") {
        Some(rest) => rest.split_once(") ")?.1,
        None => line.strip_prefix("pub ").unwrap_or(line),
    };
    visible.strip_prefix("const ")
}

/// Numbers that a file declares, outside of functions and tests.
fn numbers_of(file: &Path) -> Vec<Constant> {
    let text = std::fs::read_to_string(file).unwrap();
    let code = text.split("\n#[cfg(test)]").next().unwrap();
    let name = below_package(file).with_extension("");
    let name = name.to_str().unwrap().trim_end_matches("/mod").to_owned();
    let mut found = Vec::new();
    let starts = code.match_indices('\n').map(|(at, _)| &code[at + 1..]);
    for declaration in starts.filter_map(declared) {
        let whole = declaration.split(";\n").next().unwrap();
        let Some((head, value)) = whole.split_once(" =") else {
            continue;
        };
        let Some((constant, kind)) = head.split_once(": ") else {
            continue;
        };
        let kind = kind.trim_start_matches("std::ops::");
        if NUMBERS.iter().any(|number| kind.starts_with(number)) {
            let value: Vec<_> = value.split_whitespace().collect();
            found.push((name.clone(), constant.to_owned(), value.join(" ")));
        }
    }
    found
}

/// File, name and value of every row of the page.
fn listed_constants() -> Vec<Constant> {
    let text = std::fs::read_to_string(CONSTANTS).unwrap();
    let tables = text.split("\n## Half and twice").next().unwrap();
    let rows = tables.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| {
        let cells: Vec<_> = row
            .split(" | ")
            .map(|cell| cell.trim_matches(['|', ' ', '`']))
            .collect();
        (
            cells[0].to_owned(),
            cells[1].to_owned(),
            cells[2].to_owned(),
        )
    })
    .collect()
}

/// Seen to fail with a value changed in the source, a row taken out and a row of a constant that is not there.
#[test]
fn the_page_of_constants_is_that_of_the_source() {
    let listed = |file: &PathBuf| {
        let below = below_package(file);
        !NOT_LISTED.iter().any(|no| below.starts_with(no))
    };
    let files = rust_files(Path::new("src"));
    let source: Vec<_> = files
        .iter()
        .filter(|f| listed(f))
        .flat_map(|f| numbers_of(f))
        .collect();
    let page = listed_constants();
    let mut faults = Vec::new();
    for (file, name, value) in source.iter().filter(|constant| !page.contains(constant)) {
        faults.push(format!(
            "{CONSTANTS} lacks `{file}` `{name}` with the value `{value}`"
        ));
    }
    for (file, name, value) in page.iter().filter(|constant| !source.contains(constant)) {
        faults.push(format!(
            "{CONSTANTS}: the source has no `{file}` `{name}` with the value `{value}`"
        ));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(source.len() > 150, "{} constants found", source.len());
}
