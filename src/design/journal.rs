//! Searches that survive the end of their process. A search is a function of the scores that it is told: a journal
//! keeps these, generation after generation, and a search that begins anew is told them again in place of being
//! measured, until it is where it was. So any optimiser goes on with all of its state, its random numbers too.

use crate::evaluate::{DeviceInfo, Evaluator, Inspection};
use crate::hash::{FNV_START, fnv1a};
use crate::lighting::{Light, Population};
use crate::objective::Quality;
use crate::objective::maps::Maps;
use crate::scene::load::files;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::cell::RefCell;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Most bytes of a journal that is read.
const MAX_BYTES: u64 = 1 << 30;

/// Scores of populations in a file, in the order in which they were measured: a line of JSON that says what they are
/// scores of, then a line for each population. Each line is written at once when its scores are there; what a
/// killed process has left of its last line counts for nothing.
///
/// The file is this process's alone until the journal is dropped.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// What an earlier process has written, and how much of it has been told again.
    earlier: Vec<u8>,
    told: usize,
}

/// A population's line.
#[derive(Serialize, Deserialize)]
struct Entry {
    /// Checksum of the population and its scores.
    mark: u64,
    /// The bits of each score.
    scores: Vec<u32>,
}

impl Journal {
    /// A new journal of `subject`, which is all that the scores depend on.
    ///
    /// # Errors
    /// [`Error::Input`] for a file that is there already, and [`Error::Output`].
    pub fn create(path: &Path, subject: &Value) -> Result<Self> {
        let file = OpenOptions::new().append(true).create_new(true).open(path);
        let file = file.map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => Error::input(
                path,
                "is there already: --resume goes on with it; remove it to begin anew",
            ),
            _ => Error::Output { path: path.into(), source },
        })?;
        let mut journal = Self::locked(path, file)?;
        let begun = journal.write(&header(subject));
        begun.inspect_err(|_| drop(std::fs::remove_file(path)))?;
        Ok(journal)
    }

    /// The journal that an earlier process has left, or a new one where there is none.
    ///
    /// # Errors
    /// [`Error::Input`] for a file that is no journal, is one of another subject or in use, and
    /// [`Error::Output`].
    pub fn resume(path: &Path, subject: &Value) -> Result<Self> {
        if !path.exists() {
            return Self::create(path, subject);
        }
        let fault = |fault: String| Error::input(path, fault);
        let earlier = files::read(path, MAX_BYTES).map_err(fault)?;
        let file = OpenOptions::new().append(true).open(path);
        let file = file.map_err(|source| Error::Output { path: path.into(), source })?;
        let mut journal = Self::locked(path, file)?;
        let wanted = header(subject);
        if wanted.starts_with(&earlier) && earlier.len() < wanted.len() {
            // Its process was killed before the first line was whole.
            journal.cut(0)?;
            journal.write(&wanted)?;
            return Ok(journal);
        }
        let end = earlier.iter().position(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        let found: Value = serde_json::from_slice(&earlier[..end])
            .map_err(|_| fault("is no checkpoint of klieg".into()))?;
        if let Some(difference) = difference("", &found, subject) {
            return Err(fault(format!(
                "is the checkpoint of something else ({difference}): remove it, or choose another file"
            )));
        }
        (journal.earlier, journal.told) = (earlier, end);
        Ok(journal)
    }

    fn locked(path: &Path, file: File) -> Result<Self> {
        // Where the system has no locks, the user takes care.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(Error::input(path, "is in use by another process"));
        }
        Ok(Self { path: path.into(), file, earlier: Vec::new(), told: 0 })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether all that an earlier process has measured has been told again.
    pub fn is_new(&self) -> bool {
        self.told >= self.earlier.len()
    }

    /// Removes the file: the search has come to its end.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn remove(self) -> Result<()> {
        let Self { path, .. } = self;
        std::fs::remove_file(&path).map_err(|source| Error::Output { path, source })
    }

    /// Tells the scores of a population where they come next in what an earlier process has measured, and says
    /// whether they do. If others come next, these and all after them are forgotten.
    fn recall(&mut self, population: u64, scores: &mut [f32]) -> Result<bool> {
        if self.is_new() {
            return Ok(false);
        }
        let rest = &self.earlier[self.told..];
        let line = rest.iter().position(|&byte| byte == b'\n').map(|at| &rest[..=at]);
        let entry = line.and_then(|line| serde_json::from_slice::<Entry>(line).ok());
        if let (Some(line), Some(Entry { mark, scores: bits })) = (line, entry)
            && mark == self::mark(population, &bits)
            && bits.len() == scores.len()
        {
            self.told += line.len();
            scores.iter_mut().zip(bits).for_each(|(score, bits)| *score = f32::from_bits(bits));
            return Ok(true);
        }
        self.cut(self.told)?;
        Ok(false)
    }

    fn note(&mut self, population: u64, scores: &[f32]) -> Result<()> {
        let scores: Vec<u32> = scores.iter().map(|score| score.to_bits()).collect();
        let entry = Entry { mark: mark(population, &scores), scores };
        self.write(&line(&entry))
    }

    /// Forgets all after the first `bytes`.
    fn cut(&mut self, bytes: usize) -> Result<()> {
        (self.earlier, self.told) = (Vec::new(), 0);
        let cut = self.file.set_len(bytes as u64);
        cut.map_err(|source| Error::Output { path: self.path.clone(), source })
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.file.write_all(bytes);
        written.map_err(|source| Error::Output { path: self.path.clone(), source })
    }
}

fn header(subject: &Value) -> Vec<u8> {
    line(subject)
}

/// A line of JSON.
fn line(value: &impl Serialize) -> Vec<u8> {
    // Of string keys and numbers there is always a text.
    let mut line = serde_json::to_vec(value).unwrap_or_default();
    line.push(b'\n');
    line
}

fn mark(population: u64, scores: &[u32]) -> u64 {
    fnv1a(population, bytemuck::cast_slice(scores))
}

/// The first place where two values differ, in words.
fn difference(name: &str, found: &Value, wanted: &Value) -> Option<String> {
    if let (Value::Object(found), Value::Object(wanted)) = (found, wanted) {
        let keys = wanted.keys().chain(found.keys().filter(|key| !wanted.contains_key(*key)));
        let part = |key: &String| {
            let name = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
            let value = |map: &serde_json::Map<_, _>| map.get(key).cloned().unwrap_or_default();
            difference(&name, &value(found), &value(wanted))
        };
        return keys.into_iter().find_map(part);
    }
    (found != wanted).then(|| format!("{name} is {found} there, {wanted} here"))
}

/// An evaluator that takes scores from a journal while it has any, and writes down those that it measures.
pub struct Remembered<'a> {
    evaluator: &'a mut dyn Evaluator,
    journal: Option<&'a RefCell<Journal>>,
    number: u32,
}

impl<'a> Remembered<'a> {
    /// The evaluator of this `number`, another one for each that shares the journal; without one it remembers nothing.
    pub fn new(
        evaluator: &'a mut dyn Evaluator,
        journal: Option<&'a RefCell<Journal>>,
        number: u32,
    ) -> Self {
        Self { evaluator, journal, number }
    }
}

impl Evaluator for Remembered<'_> {
    fn device(&self) -> &DeviceInfo {
        self.evaluator.device()
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        let Some(journal) = self.journal else {
            return self.evaluator.evaluate(population, scores);
        };
        let start = fnv1a(FNV_START, &self.number.to_le_bytes());
        let key = fnv1a(start, bytemuck::cast_slice(population.records()));
        if journal.borrow_mut().recall(key, scores)? {
            return Ok(());
        }
        self.evaluator.evaluate(population, scores)?;
        journal.borrow_mut().note(key, scores)
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        self.evaluator.qualities(population)
    }

    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        self.evaluator.inspect(rig)
    }

    fn maps(&mut self) -> Result<&Maps> {
        self.evaluator.maps()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::coarse::{CoarseSettings, Small, run_coarse_first};
    use crate::design::testing::{Hills, genome};
    use crate::design::{Outcome, Progress};
    use crate::math::range::Range;
    use crate::optimize::{self, GeneticSettings, Settings, Setup};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use serde_json::json;
    use std::ops::ControlFlow;

    const GENERATIONS: usize = 12;

    /// A search that begins on small pictures and stops after generation `stop`; gives its outcome and the number
    /// of populations that were measured.
    fn search(name: &str, journal: Option<Journal>, stop: usize) -> (Outcome, usize) {
        let genome = genome();
        let genetic =
            GeneticSettings { population: 6, generations: GENERATIONS, ..Default::default() };
        let settings = &Settings { genetic, ..Settings::default() };
        let first = genome.bounds().iter().map(Range::middle).collect();
        let rng = ChaCha8Rng::seed_from_u64(4);
        let setup = Setup { bounds: genome.bounds(), first, settings, rng };
        let mut search = optimize::create(name, setup).unwrap();
        let hills = || Hills { base: 10.0, ..Hills::default() };
        let (mut small, mut larger, mut whole) = (hills(), hills(), Hills::default());
        let mut run = |small: &mut [Small<Remembered<'_>>], whole: &mut dyn Evaluator| {
            let coarse = CoarseSettings { side: 16, share: 0.5, settled: 0.0, searches: 1 };
            let mut observe = |progress: &Progress| match progress.generation == stop {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            let settings = (&coarse, GENERATIONS);
            let evaluators = (small, whole);
            run_coarse_first(&mut *search, &genome, evaluators, settings, &mut observe).unwrap()
        };
        let journal = journal.map(RefCell::new);
        let outcome = run(
            &mut [
                Small { step: 4, evaluator: Remembered::new(&mut small, journal.as_ref(), 4) },
                Small { step: 2, evaluator: Remembered::new(&mut larger, journal.as_ref(), 2) },
            ],
            &mut Remembered::new(&mut whole, journal.as_ref(), 1),
        );
        (outcome, small.calls + larger.calls + whole.calls)
    }

    fn subject() -> Value {
        json!({"scene": "ball.glb", "settings": {"seed": 4, "search": {"population": 6}}})
    }

    #[test]
    fn whatever_a_killed_process_has_written_the_search_goes_on_to_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        for entry in optimize::OPTIMIZERS {
            let expected = search(entry.name, None, usize::MAX);
            let journal = Journal::create(&path, &subject()).unwrap();
            assert_eq!(search(entry.name, Some(journal), usize::MAX), expected, "{}", entry.name);
            let whole = std::fs::read(&path).unwrap();
            for length in (0..whole.len()).step_by(41).chain([whole.len()]) {
                std::fs::write(&path, &whole[..length]).unwrap();
                let journal = Journal::resume(&path, &subject()).unwrap();
                let (outcome, measured) = search(entry.name, Some(journal), usize::MAX);
                assert_eq!(outcome, expected.0, "{} from {length} bytes", entry.name);
                let lines = whole[..length].iter().filter(|&&byte| byte == b'\n').count();
                assert_eq!(measured + lines.saturating_sub(1), expected.1);
                assert_eq!(std::fs::read(&path).unwrap(), whole);
            }
            std::fs::remove_file(&path).unwrap();
        }
    }

    #[test]
    fn a_search_that_was_stopped_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let expected = search("shade", None, usize::MAX).0;
        // On small pictures of either size, where the stop itself measures one rig more, and on whole ones.
        for stop in [3, 7, 11] {
            let journal = Journal::create(&path, &subject()).unwrap();
            assert!(search("shade", Some(journal), stop).0.stopped);
            let journal = Journal::resume(&path, &subject()).unwrap();
            let (outcome, measured) = search("shade", Some(journal), usize::MAX);
            assert_eq!((outcome, measured), (expected.clone(), GENERATIONS - stop));
            std::fs::remove_file(&path).unwrap();
        }
    }

    #[test]
    fn scores_that_were_changed_are_measured_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let journal = Journal::create(&path, &subject()).unwrap();
        let expected = search("ga", Some(journal), usize::MAX);
        let whole = std::fs::read_to_string(&path).unwrap();
        let at = whole.rfind("[").unwrap() + 1;
        let digit = if &whole[at..=at] == "1" { "2" } else { "1" };
        let changed = format!("{}{digit}{}", &whole[..at], &whole[at + 1..]);
        std::fs::write(&path, changed).unwrap();
        let journal = Journal::resume(&path, &subject()).unwrap();
        assert_eq!(search("ga", Some(journal), usize::MAX), (expected.0, 1));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
    }

    #[test]
    fn journals_of_something_else_are_refused_and_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let refused = |result: Result<Journal>, words: &str| {
            let fault = result.unwrap_err();
            assert!(fault.is_input() && fault.to_string().contains(words), "{fault}");
        };
        let open = Journal::create(&path, &subject()).unwrap();
        refused(Journal::resume(&path, &subject()), "in use");
        drop(open);
        refused(Journal::create(&path, &subject()), "--resume");
        let mut other = subject();
        other["settings"]["search"]["population"] = json!(7);
        let words = "settings.search.population is 6 there, 7 here";
        refused(Journal::resume(&path, &other), words);
        std::fs::write(&path, "a diary\n").unwrap();
        refused(Journal::resume(&path, &subject()), "no checkpoint");
        assert_eq!(std::fs::read(&path).unwrap(), b"a diary\n");
        refused(Journal::resume(folder.path(), &subject()), "directory");
        let nowhere = Journal::create(&folder.path().join("gone/journal"), &subject());
        assert!(matches!(nowhere, Err(Error::Output { .. })));
    }
}
