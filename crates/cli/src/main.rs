//! The `direkt` command.

fn main() -> std::process::ExitCode {
    direkt_cli::main()
}
