//! The program `samara`: the command line over the library of the same name.

fn main() -> std::process::ExitCode {
    samara::cli::run(std::env::args_os()).into()
}
