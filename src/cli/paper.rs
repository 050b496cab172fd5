//! `klieg paper`: the paper's figures on the project's own scenes.

use super::options::TargetOptions;
use super::print;
use super::progress::Watch;
use super::session::Session;
use super::values::Size;
use crate::cli::config::Settings;
use crate::design::profile;
use crate::lighting::Role;
use crate::lighting::genome::Genome;
use crate::optimize;
use crate::report::exhibit::{contest as contests, landscape as landscapes, starts as descents};
use crate::report::paper::{self, Paper, SceneExhibits, SceneFigures, ViewFigures};
use crate::report::{Staging, json, picture};
use crate::study::landscape::Grid;
use crate::study::{contest, landscape, seeds, starts};
use anyhow::{Context, Result};
use clap::Args;
use std::path::PathBuf;

/// The scenes: one object, and two.
const SCENES: [(&str, &[u8]); 2] = [
    ("elephant", include_bytes!("../../scenes/elephant.glb")),
    ("pair", include_bytes!("../../scenes/pair.glb")),
];

/// Reproduce the paper's figures
///
/// Runs the experiments of "Perception-based Lighting Design" (Ha and Olivier 2006) on the scenes
/// elephant and pair, and writes index.html, a self-contained page with figures 1 to 8, 10 and 12,
/// the paper's claims and whether they hold, and paper.json, the figures behind it. Without --size the
/// pictures have 512x512 pixels, 96x96 with --quick.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Folder for the results, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// A smoke test in under a minute: small pictures, few runs, verdicts that mean little
    #[arg(long)]
    quick: bool,
    /// Runs of each search, 1 to 1000 [default: 10; quick: 3]
    #[arg(long, value_name = "N")]
    runs: Option<usize>,
    #[command(flatten)]
    target: TargetOptions,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print JSON, and nothing else, on standard output
    #[arg(long)]
    json: bool,
}

/// How much is run.
struct Plan {
    settings: Settings,
    searches: optimize::Settings,
    grid: Grid,
    runs: usize,
}

impl Options {
    fn plan(&self) -> Result<Plan> {
        let mut settings = Settings { seed: self.seed, ..Settings::of(&profile::PAPER) };
        self.target.apply(&mut settings);
        let (side, runs, grid) = if self.quick {
            settings.search.generations = 12;
            (96, 3, Grid { columns: 19, rows: 10 })
        } else {
            (512, 10, Grid::default())
        };
        settings.view.size.get_or_insert(Size([side; 2]));
        let runs = self.runs.unwrap_or(runs);
        seeds(self.seed, runs)?;
        Ok(Plan { searches: settings.optimizers(), settings, grid, runs })
    }
}

impl Plan {
    /// Evaluations that are known beforehand.
    fn evaluations(&self) -> usize {
        let searches = contest::SEARCHES.len() * self.runs * self.searches.genetic.budget();
        SCENES.len() * (self.grid.columns * self.grid.rows + searches)
    }
}

pub(super) fn run(options: &Options) -> Result<()> {
    let plan = options.plan()?;
    let mut staging = Staging::new(&options.out)?;
    let folder = tempfile::tempdir().context("a folder for the scenes")?;
    let watch = Watch::new(Some(plan.evaluations() as u64), options.json)?;
    let mut exhibits = Vec::new();
    let mut device = None;
    for (name, bytes) in SCENES {
        let path = folder.path().join(format!("{name}.glb"));
        std::fs::write(&path, bytes).with_context(|| format!("writing {}", path.display()))?;
        let mut session = Session::open(&path, plan.settings.clone())?;
        exhibits.push(exhibit(name, &mut session, &plan, &watch)?);
        device = Some(session.evaluator.device().clone());
    }
    drop(watch);

    let Size(size) = plan.settings.view.size.context("a plan names its size")?;
    let scenes: Vec<SceneFigures> = exhibits.iter().map(SceneExhibits::figures).collect();
    let paper = Paper {
        schema: Paper::SCHEMA,
        klieg: env!("CARGO_PKG_VERSION"),
        profile: profile::PAPER.name,
        device: device.context("there are scenes")?,
        size,
        seed: options.seed,
        quick: options.quick,
        objective: (&plan.settings.objective).into(),
        claims: paper::claims(&scenes),
        scenes,
    };
    let text = json::text(&paper)?;
    staging.write("index.html", paper::render(&paper, &exhibits)?)?;
    staging.write("paper.json", &text)?;
    let files = staging.publish()?;
    if options.json {
        return print::out(text);
    }
    let mut table = print::columns(&["figures", "claim", "here"], &[]);
    for claim in &paper.claims {
        table.add_row([claim.figures, claim.claim, claim.verdict.words()]);
    }
    print::out(format!("{table}\n\n{}", print::written(&files)))
}

/// Runs all experiments on a scene.
fn exhibit(
    name: &'static str,
    session: &mut Session,
    plan: &Plan,
    watch: &Watch,
) -> Result<SceneExhibits> {
    let lights = &session.settings.lights;
    let position = starts::position_genome(Role::Key, lights.kind, &lights.boxes)?;
    let genome = Genome::new(&lights.roles.0, lights.kind, &lights.boxes)?;
    let (seed, searches) = (plan.settings.seed, &plan.searches);
    let edge_sobel = session.settings.objective.edge_sobel;
    let polygons = session.scene.polygons();
    let maps = session.evaluator.maps()?;
    let view = ViewFigures {
        polygons,
        visible_polygons: maps.visible.len(),
        surface: maps.counts.surface,
        edge: maps.counts.edge,
    };
    let pictures = [picture::code(maps), picture::edges(maps, edge_sobel), picture::types(maps)];

    let made = &mut |evaluations| watch.made(evaluations);
    let subject = &mut session.subject();
    watch.stage(format!("{name}: landscape"));
    let landscape = landscape::run(subject, &position, plan.grid, made)?;
    watch.stage(format!("{name}: descents"));
    let begin = starts::quarters(&position, seed);
    // Nobody knows beforehand how many evaluations these take; they are few.
    let paths =
        starts::run(subject, &position, &begin, searches.greedy.descent(), &mut |_| watch.check())?;
    watch.stage(format!("{name}: searches"));
    let runs = (seed, plan.runs);
    let contest = contest::run(subject, &genome, searches, runs, &contest::SEARCHES, made)?;
    watch.stage(format!("{name}: pictures"));
    let sizes = searches.genetic.generation_sizes();
    Ok(SceneExhibits {
        name,
        view,
        maps: pictures,
        landscape: landscapes::exhibit(&landscape, session)?,
        starts: descents::exhibit(&landscape, &paths, session)?,
        convergence: contests::convergence(&contest, sizes, &genome, session)?,
        compare: contests::compare(&contest, &genome, session)?,
    })
}
