//! Lights one after another (Gumhold 2002, *Maximum Entropy Light Source Placement*): each is the best addition to those
//! before it, which stay as they are.

use super::{Outcome, Progress};
use crate::lighting::Light;
use crate::lighting::genome::Genome;
use crate::{Error, Result};
use std::ops::ControlFlow;

/// Searches the first light of a genome alone, then the second beside it, and so on: `search` runs the search of one of these
/// genomes, which begins with the given lights where it needs any, and passes what it is given as `observe` on.
/// Generations and evaluations are counted through. Where `observe` breaks a search off, no light follows.
///
/// # Errors
/// What `search` reports, and as [`Genome::hold`].
pub fn one_by_one<E: From<Error>>(
    genome: &Genome,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    search: &mut Search<E>,
) -> Result<Outcome, E> {
    let mut found = Outcome { rig: Vec::new(), score: 0.0, history: Vec::new(), stopped: false };
    let mut broken = false;
    for lights in 1..=genome.lights() {
        let genome = held(genome.of_first(lights), &found.rig[..lights - 1])?;
        let (generations, evaluations) = (found.history.len(), found.evaluations());
        let counted = |progress: &Progress| Progress {
            generation: generations + progress.generation,
            evaluations: evaluations + progress.evaluations,
            ..*progress
        };
        let mut outcome = search(&genome, &mut |progress| {
            let flow = observe(&counted(progress));
            broken = flow.is_break();
            flow
        })?;
        found.history.extend(outcome.history.iter().map(counted));
        outcome.history = found.history;
        found = outcome;
        if broken {
            break;
        }
    }
    Ok(Outcome { stopped: broken, ..found })
}

/// Runs the search of a genome, under the eyes of an observer.
pub type Search<'a, E> =
    dyn FnMut(&Genome, &mut dyn FnMut(&Progress) -> ControlFlow<()>) -> Result<Outcome, E> + 'a;

/// The genome with its first lights as they are in `lights`.
fn held(genome: Genome, lights: &[Light]) -> Result<Genome> {
    lights.iter().enumerate().try_fold(genome, |genome, (at, light)| genome.hold(at, light, None))
}
