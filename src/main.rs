//! The program: see [`samara::cli`].

fn main() -> std::process::ExitCode {
    samara::cli::run()
}
