//! The `direkt` command.

fn main() -> std::process::ExitCode {
    direkt::cli::main()
}
