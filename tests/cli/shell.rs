//! `completions` and `man`: what a shell and a manual are told of the program.

use std::path::Path;

use super::microslip;

const COMMANDS: [&str; 12] = [
    "run", "extend", "solve", "report", "compare", "reweight", "schema", "inspect", "devices",
    "import", "pairs", "serve",
];

/// Seen to fail with the completions of another program's name.
#[test]
fn completions_know_the_commands_and_their_options() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = microslip(Path::new("."), &["completions", shell]);
        assert!(output.status.success(), "{output:?}");
        let script = String::from_utf8(output.stdout).unwrap();
        assert!(script.contains("microslip"), "{shell}");
        for word in COMMANDS.iter().chain(&["backend", "threads", "arrow"]) {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    let unknown = microslip(Path::new("."), &["completions", "cmd"]);
    assert_eq!(unknown.status.code(), Some(2));
}

/// Seen to fail with the pages written to the working directory.
#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let output = microslip(folder.path(), &["man", "pages"]);
    assert!(output.status.success(), "{output:?}");
    let page = |name: &str| {
        let path = folder.path().join("pages").join(format!("{name}.1"));
        std::fs::read_to_string(path).unwrap()
    };
    assert!(page("microslip").contains("extend"));
    for command in COMMANDS {
        assert!(
            page(&format!("microslip-{command}")).contains(command),
            "{command}"
        );
    }
    assert!(page("microslip-run").contains("audit"));
    std::fs::write(folder.path().join("file"), "").unwrap();
    let refused = microslip(folder.path(), &["man", "file"]);
    assert_eq!(refused.status.code(), Some(2));
}
