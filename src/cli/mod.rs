//! The command line: one module a subcommand.

mod analyze;
mod batch;
mod bench;
mod checkpoint;
mod design;
mod devices;
mod file_stamp;
mod gallery;
mod inspect;
pub mod intent;
mod lights;
mod messages;
mod options;
mod paper;
mod picture;
mod print;
mod profile;
mod progress;
#[doc(hidden)]
pub mod readers;
mod render;
mod score;
mod shell;
#[cfg(feature = "studio")]
mod studio;
mod study;
mod terms;
mod thumbnail;
pub mod values;
mod views;

use crate::session::{
    self, config, describe, designer, device, input, is_input, optimizer, painter, rig,
};
use clap::{Parser, Subcommand};

/// Finds the lights that make a glTF scene easiest to see.
#[derive(Debug, Parser)]
#[command(name = "klieg", version, about, propagate_version = true)]
pub struct Cli {
    #[command(flatten)]
    verbosity: messages::Verbosity,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Design(design::Options),
    Batch(batch::Options),
    Gallery(gallery::Options),
    /// Make the item on standard input, for 'klieg batch --isolate'
    #[command(hide = true)]
    BatchItem,
    #[cfg(feature = "studio")]
    Studio(studio::Options),
    Render(render::Options),
    Thumbnail(thumbnail::Options),
    Score(score::Options),
    Inspect(inspect::Options),
    Analyze(analyze::Options),
    Devices(devices::Options),
    Terms(terms::Options),
    Study(study::Options),
    Paper(paper::Options),
    Bench(bench::Options),
    Completions(shell::Completions),
    Man(shell::Man),
}

/// Runs a command.
///
/// # Errors
/// What went wrong, with what was being done; [`exit_code`] tells whose fault it is.
pub fn run(cli: Cli) -> anyhow::Result<()> {
    cli.verbosity.listen();
    match cli.command {
        Command::Design(options) => design::run(&options),
        Command::Gallery(options) => gallery::run(&options),
        Command::Batch(options) => batch::run(&options),
        Command::BatchItem => batch::run_item(),
        #[cfg(feature = "studio")]
        Command::Studio(options) => studio::run(&options),
        Command::Render(options) => render::run(&options),
        Command::Thumbnail(options) => thumbnail::run(&options),
        Command::Score(options) => score::run(&options),
        Command::Inspect(options) => inspect::run(&options),
        Command::Analyze(options) => analyze::run(&options),
        Command::Devices(options) => devices::run(&options),
        Command::Terms(options) => terms::run(&options),
        Command::Study(options) => study::run(&options),
        Command::Paper(options) => paper::run(&options),
        Command::Bench(options) => bench::run(&options),
        Command::Completions(options) => shell::completions(&options),
        Command::Man(options) => shell::man(&options),
    }
}

/// 2 where what the user gave is at fault, 1 otherwise.
pub fn exit_code(error: &anyhow::Error) -> u8 {
    if is_input(error) { 2 } else { 1 }
}

/// Tells of an error on standard error.
pub fn tell(error: &anyhow::Error) {
    tracing::error!("{}", describe(error));
}
