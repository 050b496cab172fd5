//! The course of a search as a table.

use crate::design::Progress;

/// `generation,evaluations,best,mean,worst`, one row a generation.
///
/// # Errors
/// None in practice: the table is written to memory.
pub fn convergence(history: &[Progress]) -> csv::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(["generation", "evaluations", "best", "mean", "worst"])?;
    for p in history {
        table.serialize((p.generation, p.evaluations, p.best, p.mean, p.worst))?;
    }
    table.into_inner().map_err(|e| e.into_error().into())
}
