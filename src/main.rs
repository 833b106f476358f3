//! The program: everything is in the library.

fn main() -> std::process::ExitCode {
    lumenwalk::cli::run()
}
