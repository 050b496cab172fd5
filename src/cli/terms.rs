//! `klieg terms`: what pictures can be judged by.

use super::print;
use super::profile::ProfileOptions;
use crate::design::profile;
use crate::objective::terms::TERMS;
use crate::objective::{Objective, Term};
use crate::report::json;
use anyhow::Result;
use clap::Args;
use comfy_table::CellAlignment;
use serde::Serialize;

/// List the terms that pictures can be judged by
///
/// F is the sum of the terms, each times its weight. A term is 0 to 1, lower is better. All are measured
/// on brightness and gradients of the picture; what a term needs besides takes time only where its
/// weight is above 0. Weights are the profile's, or set by --weights or in a configuration file.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    profile: ProfileOptions,
    /// Print JSON on standard output
    #[arg(long)]
    json: bool,
}

/// What `klieg terms --json` prints.
#[derive(Serialize)]
struct Listing {
    schema: &'static str,
    klieg: &'static str,
    profile: &'static str,
    terms: Vec<Entry>,
}

/// A term.
#[derive(Serialize)]
struct Entry {
    name: &'static str,
    title: &'static str,
    meaning: &'static str,
    /// What pictures have to be measured for besides brightness and gradients.
    needs: Vec<&'static str>,
    /// Its weight in the profile.
    weight: f32,
}

impl Entry {
    fn new(term: &Term, objective: &Objective) -> Self {
        let &Term { name, title, meaning, needs, .. } = term;
        let weight = objective.weights.get(name).unwrap_or(0.0);
        Self { name, title, meaning, needs: needs.names().collect(), weight }
    }
}

pub(super) fn run(options: &Options) -> Result<()> {
    let profile = options.profile.asked().unwrap_or(profile::DEFAULT);
    let objective = (profile.objective)();
    let listing = Listing {
        schema: "klieg.terms/1",
        klieg: env!("CARGO_PKG_VERSION"),
        profile: profile.name,
        terms: TERMS.iter().map(|term| Entry::new(term, &objective)).collect(),
    };
    if options.json { print::out(json::text(&listing)?) } else { print::out(show(&listing)) }
}

fn show(listing: &Listing) -> String {
    let mut table = print::columns(&["term", "says", "needs besides", "weight"], &[]);
    for column in table.column_iter_mut().take(3) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    for &Entry { name, meaning, ref needs, weight, .. } in &listing.terms {
        table.add_row([name.into(), meaning.into(), needs.join(", "), format!("{weight:.2}")]);
    }
    format!("{}\n", print::wrapped(table))
}
