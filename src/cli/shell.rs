//! `klieg completions` and `klieg man`: what shells and `man` know of klieg.

use super::{Cli, print};
use crate::report::Staging;
use anyhow::{Context as _, Result};
use clap::{Args, CommandFactory as _};
use clap_complete::Shell;
use std::path::PathBuf;

/// Print completions for a shell
///
/// Bash reads them from ~/.local/share/bash-completion/completions/klieg, fish from
/// ~/.config/fish/completions/klieg.fish, zsh from a file _klieg in a folder of its fpath.
#[derive(Debug, Args)]
pub(super) struct Completions {
    /// The shell
    shell: Shell,
}

/// Print the manual page, or write those of all commands
#[derive(Debug, Args)]
pub(super) struct Man {
    /// Folder for the pages klieg.1, klieg-design.1 and so on, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(super) fn completions(options: &Completions) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(options.shell, &mut Cli::command(), "klieg", &mut text);
    print::bytes(&text)
}

pub(super) fn man(options: &Man) -> Result<()> {
    let command = Cli::command();
    let Some(out) = &options.out else {
        let mut page = Vec::new();
        clap_mangen::Man::new(command).render(&mut page).context("the manual page")?;
        return print::bytes(&page);
    };
    let mut pages = Staging::new(out)?;
    let mut command = command.disable_help_subcommand(true);
    command.build();
    write(&command, &mut pages)?;
    print::out(print::written(&pages.publish()?))
}

/// The pages of a command and all below it that people see.
fn write(command: &clap::Command, pages: &mut Staging) -> Result<()> {
    let page = clap_mangen::Man::new(command.clone());
    let mut text = Vec::new();
    page.render(&mut text).context("a manual page")?;
    pages.write(page.get_filename(), text)?;
    command.get_subcommands().filter(|c| !c.is_hide_set()).try_for_each(|c| write(c, pages))
}
