//! `klieg`: parses the command line, runs it and exits with 0, 2 for bad input, or 1.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    match klieg::cli::run(klieg::cli::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            klieg::cli::tell(&error);
            ExitCode::from(klieg::cli::exit_code(&error))
        }
    }
}
