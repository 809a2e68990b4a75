//! The documents hold together: links lead to files that are there, and the README stays short.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read the documents fails"
)]

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
