//! The course of a search as a table.

use crate::design::Progress;

/// `generation,evaluations,best,mean,worst,picture`, one row a generation; `picture` is `whole` or, of every so-manieth
/// pixel along both sides, `1/2`, `1/4` and so on.
///
/// # Errors
/// None in practice: the table is written to memory.
pub fn convergence(history: &[Progress]) -> csv::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(["generation", "evaluations", "best", "mean", "worst", "picture"])?;
    for p in history {
        let picture = match p.step {
            1 => "whole".to_owned(),
            step => format!("1/{step}"),
        };
        table.serialize((p.generation, p.evaluations, p.best, p.mean, p.worst, picture))?;
    }
    table.into_inner().map_err(|e| e.into_error().into())
}
