//! How a batch stands: `batch.json`, and the same for people.

use super::items::Item;
use super::stamp::Scores;
use crate::Error;
use crate::cli::print;
use crate::design::profile::Profile;
use crate::report::{Staging, overview};
use anyhow::{Context, Result, anyhow};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// `batch.json`.
#[derive(Debug, Serialize)]
pub struct Record {
    schema: &'static str,
    klieg: &'static str,
    /// The profile that the settings started from.
    profile: &'static str,
    /// What computes; none where nothing was to do.
    pub device: Option<Value>,
    done: usize,
    skipped: usize,
    failed: usize,
    waiting: usize,
    /// Wall time of the run.
    milliseconds: f64,
    designs_per_minute: f64,
    items: Vec<Row>,
}

/// An item and what became of it.
#[derive(Debug, Serialize)]
struct Row {
    name: String,
    scene: String,
    state: State,
    #[serde(flatten)]
    scores: Option<Scores>,
    #[serde(skip_serializing_if = "Option::is_none")]
    milliseconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    /// Whether the scene is at fault rather than the machine.
    #[serde(skip)]
    input: bool,
}

impl Row {
    /// The same for people.
    fn entry(&self) -> overview::Entry<'_> {
        overview::Entry {
            name: &self.name,
            scene: &self.scene,
            state: self.state.name(),
            headlight: self.scores.map(|scores| scores.headlight),
            score: self.scores.map(|scores| scores.score),
            seconds: self.milliseconds.map(|milliseconds| milliseconds / 1e3),
            reason: self.reason.as_deref(),
        }
    }
}

/// What became of an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Not reached yet.
    Waiting,
    /// Designed in this run.
    Done,
    /// Finished by an earlier run.
    Skipped,
    /// Not to be had.
    Failed,
}

impl State {
    /// Its name in files.
    fn name(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Done => "done",
            Self::Skipped => "skipped",
            Self::Failed => "failed",
        }
    }
}

/// What the process of an item reports of it: nothing where the user ended the search.
#[derive(Debug, Serialize, Deserialize)]
pub struct Report {
    /// What computed.
    pub device: Option<Value>,
    /// `F`, where the design is there.
    pub scores: Option<Scores>,
    /// Time of the design.
    pub milliseconds: Option<f64>,
    /// Why it is not there.
    pub reason: Option<String>,
    /// Whether the scene is at fault then.
    pub input: bool,
}

impl Record {
    /// What there is to report of an item.
    pub fn report(&self, index: usize) -> Report {
        let Row { scores, milliseconds, ref reason, input, .. } = self.items[index];
        Report { device: self.device.clone(), scores, milliseconds, reason: reason.clone(), input }
    }

    /// A batch at its start: `finished` has the scores of items that need no work.
    pub fn new(profile: &Profile, items: &[Item], finished: &[Option<Scores>]) -> Self {
        let row = |(item, &scores): (&Item, &Option<Scores>)| Row {
            name: item.name.clone(),
            scene: item.scene.display().to_string(),
            state: if scores.is_some() { State::Skipped } else { State::Waiting },
            scores,
            milliseconds: None,
            reason: None,
            input: false,
        };
        let mut record = Self {
            schema: "klieg.batch/1",
            klieg: env!("CARGO_PKG_VERSION"),
            profile: profile.name,
            device: None,
            done: 0,
            skipped: 0,
            failed: 0,
            waiting: 0,
            milliseconds: 0.0,
            designs_per_minute: 0.0,
            items: items.iter().zip(finished).map(row).collect(),
        };
        record.count(0.0);
        record
    }

    /// Takes note of a design, and of the milliseconds that it took.
    pub fn done(&mut self, index: usize, scores: Scores, milliseconds: f64) {
        let row = &mut self.items[index];
        (row.state, row.scores) = (State::Done, Some(scores));
        row.milliseconds = Some(milliseconds);
    }

    /// Takes note of a failure.
    pub fn failed(&mut self, index: usize, error: &anyhow::Error) {
        let row = &mut self.items[index];
        row.state = State::Failed;
        row.reason = Some(crate::cli::describe(error));
        row.input = crate::cli::exit_code(error) == 2;
    }

    /// Counts anew, `milliseconds` after the beginning.
    pub fn count(&mut self, milliseconds: f64) {
        let of = |state| self.items.iter().filter(|row| row.state == state).count();
        (self.done, self.skipped) = (of(State::Done), of(State::Skipped));
        (self.failed, self.waiting) = (of(State::Failed), of(State::Waiting));
        self.milliseconds = milliseconds;
        let minutes = milliseconds / 60e3;
        self.designs_per_minute = if minutes > 0.0 { self.done as f64 / minutes } else { 0.0 };
    }

    /// An item in a line.
    pub fn line(&self, index: usize) -> String {
        let Row { name, state, scores, milliseconds, .. } = &self.items[index];
        let all = self.items.len();
        let state = state.name();
        let scores = scores.map_or(String::new(), |Scores { headlight, score }| {
            format!(", F {score:.4} (headlight {headlight:.4})")
        });
        let time = milliseconds.map_or(String::new(), |ms| format!(" in {:.1} s", ms / 1e3));
        format!("{} of {all}: {name} {state}{time}{scores}", index + 1)
    }

    /// All items in a table, and the reasons of failures below.
    pub fn show(&self) -> String {
        let mut table = print::columns(&["item", "", "headlight", "designed", "seconds"], &[]);
        let number = |x: Option<f32>| x.map_or(String::new(), |x| format!("{x:.4}"));
        for row in &self.items {
            table.add_row([
                row.name.clone(),
                row.state.name().to_owned(),
                number(row.scores.map(|scores| scores.headlight)),
                number(row.scores.map(|scores| scores.score)),
                row.milliseconds.map_or(String::new(), |x| format!("{:.1}", x / 1e3)),
            ]);
        }
        let table = print::wrapped(table);
        let Self { done, skipped, failed, waiting, designs_per_minute, .. } = self;
        let rate = if *done > 0 {
            format!(": {designs_per_minute:.1} designs a minute")
        } else {
            String::new()
        };
        let waiting = if *waiting > 0 { format!(", {waiting} waiting") } else { String::new() };
        let reason = |row: &Row| Some(format!("  {}: {}\n", row.name, row.reason.as_ref()?));
        let reasons: String = self.items.iter().filter_map(reason).collect();
        format!(
            "{table}\n\n{done} done, {skipped} skipped, {failed} failed{waiting} in {:.1} s{rate}\n{reasons}",
            self.milliseconds / 1e3
        )
    }

    /// Puts the record in its place, as JSON, which is there as `text`, as a table and as a page.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn write(&self, text: &str, files: &Files, out: &Path) -> Result<()> {
        let rows: Vec<_> = self.items.iter().map(Row::entry).collect();
        let mut staging = Staging::new(out)?;
        staging.write(&files.json, text)?;
        staging.write(&files.csv, overview::table(&rows)?)?;
        staging.write(&files.page, overview::page(&rows)?)?;
        staging.publish()?;
        Ok(())
    }

    /// Whether all is well.
    ///
    /// # Errors
    /// Where items wait or have failed; an input's fault where all failures are.
    pub fn verdict(&self) -> Result<()> {
        let all = self.items.len();
        if self.waiting > 0 {
            let left = format!("{} of {all} designs are left", self.waiting);
            return Err(Error::Interrupted).context(left);
        }
        let mut failures = self.items.iter().filter(|row| row.state == State::Failed).peekable();
        if failures.peek().is_none() {
            return Ok(());
        }
        let text = format!("{} of {all} designs failed", self.failed);
        if failures.all(|row| row.input) {
            Err(Error::Argument(text).into())
        } else {
            Err(anyhow!(text))
        }
    }
}

/// The names of a record's files.
#[derive(Debug)]
pub struct Files {
    json: String,
    csv: String,
    page: String,
}

impl Default for Files {
    fn default() -> Self {
        Self { page: "index.html".into(), ..Self::named("batch") }
    }
}

impl Files {
    /// All after one name.
    pub fn named(stem: &str) -> Self {
        let [json, csv, page] = ["json", "csv", "html"].map(|end| format!("{stem}.{end}"));
        Self { json, csv, page }
    }

    /// All of them.
    pub fn names(&self) -> [String; 3] {
        [self.json.clone(), self.csv.clone(), self.page.clone()]
    }
}
