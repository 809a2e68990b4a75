//! `microslip serve`: how it begins and ends.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use super::super::{folder, microslip};
use super::quick;
use assert_cmd::cargo::CommandCargoExt;

/// A server at a free port, and the address that it names.
fn start(folder: &std::path::Path, more: &[&str]) -> (Child, String) {
    let mut child = std::process::Command::cargo_bin("microslip")
        .unwrap()
        .current_dir(folder)
        .args(["serve", "study.toml", "--port", "0"])
        .args(more)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let mut said = BufReader::new(child.stdout.take().unwrap());
    said.read_line(&mut line).unwrap();
    let (_, address) = line.trim().rsplit_once("http://").unwrap();
    (child, address.to_owned())
}

/// It answers, and a signal ends it with exit code 0, though a client keeps a connection open.
/// Seen to fail with threads that wait for a connection for ever: it then ends by force after four seconds.
#[cfg(unix)]
#[test]
fn a_signal_ends_it() {
    let study = folder("study.toml", "", "");
    let (mut child, address) = start(study.path(), &["--anchors", "0"]);
    let mut stream = TcpStream::connect(&address).unwrap();
    stream.write_all(b"GET /Info HTTP/1.1\r\n\r\n").unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    assert!(
        text.ends_with(r#"{"models":["forward"],"protocolVersion":1.0}"#),
        "{text}"
    );
    let clock = Instant::now();
    crate::terminate(&child);
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(0), "{status:?}");
    assert!(
        clock.elapsed() < Duration::from_secs(3),
        "{:?}",
        clock.elapsed()
    );
}

/// Seen to fail, by waiting for ever, with results that are not looked at.
#[test]
fn it_starts_from_results_without_solving() {
    let study = quick(3);
    let missing = ["serve", "study.toml", "--port", "0", "--results", "results"];
    let output = microslip(study.path(), &missing);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let run = microslip(study.path(), &["run", "study.toml", "--quiet"]);
    assert!(run.status.success(), "{run:?}");
    let (mut child, _) = start(study.path(), &["--results", "results"]);
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Seen to fail with the port taken after the anchors are solved.
#[test]
fn a_port_that_is_taken_is_refused_before_any_work() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let study = folder("study.toml", "mass = \"mass.mtx\"", "mass = \"absent.mtx\"");
    let output = microslip(study.path(), &["serve", "study.toml", "--port", &port]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let expected = format!("127.0.0.1:{port}: cannot listen there");
    assert!(message.contains(&expected), "{message}");
    let wrong = microslip(study.path(), &["serve", "study.toml", "--anchors", "1025"]);
    assert_eq!(wrong.status.code(), Some(2), "{wrong:?}");
}
