//! The command `microslip`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
