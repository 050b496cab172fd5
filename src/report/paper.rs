//! The paper's figures, made anew: one self-contained page, and the figures behind it as JSON. What
//! the page claims is tested: each claim of the paper stands beside what was measured.

use super::exhibit::contest::{Courses, GENETIC, Pairs};
use super::exhibit::{Exhibit, landscape, starts};
use super::json::ObjectiveRecord;
use super::{html, picture};
use crate::evaluate::DeviceInfo;
use crate::objective::Term;
use crate::study::contest::Finding;
use anyhow::{Context, Result, anyhow};
use image::RgbImage;
use minijinja::value::Serde;
use minijinja::{Error, ErrorKind, Value, context};
use serde::Serialize;
use std::collections::BTreeMap;

/// Minima whose pictures the page shows.
const SHOWN_MINIMA: usize = 4;

/// `paper.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Paper {
    /// Schema `klieg.paper/1`.
    pub schema: &'static str,
    /// klieg's version.
    pub klieg: &'static str,
    /// The profile that the settings start from.
    pub profile: &'static str,
    /// What computed.
    pub device: DeviceInfo,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// The first seed.
    pub seed: u64,
    /// Whether the studies were cut down to a smoke test, whose verdicts mean little.
    pub quick: bool,
    /// Settings of the quality function.
    pub objective: ObjectiveRecord,
    /// The claims and whether they hold.
    pub claims: Vec<Claim>,
    /// The scenes.
    pub scenes: Vec<SceneFigures>,
}

impl Paper {
    /// The schema's name.
    pub const SCHEMA: &'static str = "klieg.paper/1";
}

/// The figures of a scene.
#[derive(Debug, Clone, Serialize)]
pub struct SceneFigures {
    /// Its name.
    pub name: &'static str,
    /// What the view shows.
    pub view: ViewFigures,
    /// One light over its box.
    pub landscape: landscape::Figures,
    /// Descents of that light.
    pub starts: starts::Figures,
    /// Searches of whole rigs.
    pub convergence: Courses,
    /// The genetic algorithm against greedy descents.
    pub compare: Pairs,
}

/// What the colour code, the edges and the pixel types show.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ViewFigures {
    /// Polygons of the scene.
    pub polygons: u32,
    /// Of these, visible ones.
    pub visible_polygons: usize,
    /// SURFACE pixels.
    pub surface: u32,
    /// EDGE pixels.
    pub edge: u32,
}

/// A scene's figures with their plots and pictures.
#[derive(Debug)]
pub struct SceneExhibits {
    /// Its name.
    pub name: &'static str,
    /// What the view shows.
    pub view: ViewFigures,
    /// Colour code, edges and pixel types.
    pub maps: [RgbImage; 3],
    /// One light over its box.
    pub landscape: Exhibit<landscape::Figures>,
    /// Descents of that light.
    pub starts: Exhibit<starts::Figures>,
    /// Searches of whole rigs.
    pub convergence: Exhibit<Courses>,
    /// The genetic algorithm against greedy descents.
    pub compare: Exhibit<Pairs>,
}

impl SceneExhibits {
    /// The figures alone.
    pub fn figures(&self) -> SceneFigures {
        SceneFigures {
            name: self.name,
            view: self.view,
            landscape: self.landscape.data.clone(),
            starts: self.starts.data.clone(),
            convergence: self.convergence.data.clone(),
            compare: self.compare.data.clone(),
        }
    }
}

/// Whether what a claim says was seen here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// In all that was measured.
    Holds,
    /// In some of it.
    Partly,
    /// In none of it.
    Fails,
    /// There were too few runs to tell.
    TooFewRuns,
}

impl Verdict {
    fn of(cases: &[bool]) -> Self {
        match cases.iter().filter(|case| **case).count() {
            0 => Self::Fails,
            n if n == cases.len() => Self::Holds,
            _ => Self::Partly,
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Partly => "holds in part",
            Self::Fails => "does not hold",
            Self::TooFewRuns => "too few runs to tell",
        }
    }
}

/// A claim of the paper, in our words.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Claim {
    /// Its name in the page.
    pub id: &'static str,
    /// The paper's figures.
    pub figures: &'static str,
    /// What the paper says.
    pub claim: &'static str,
    /// What it is tested by.
    pub test: &'static str,
    /// Whether it holds here.
    pub verdict: Verdict,
}

/// All claims, tested on the scenes: the first has one object, the second two.
pub fn claims(scenes: &[SceneFigures]) -> Vec<Claim> {
    let verdict = |test: &dyn Fn(&SceneFigures) -> bool| {
        Verdict::of(&scenes.iter().map(test).collect::<Vec<_>>())
    };
    let valleys = |scene: Option<&SceneFigures>| {
        let strict = scene.is_some_and(|scene| scene.landscape.local_minima > 1);
        let deep = scene.is_some_and(|scene| scene.landscape.deep_minima > 1);
        Verdict::of(&[strict, deep])
    };
    vec![
        Claim {
            id: "starts",
            figures: "1 to 4",
            claim: "Where a greedy search ends depends on where it starts.",
            test: "four descents of one light end at least 0.01 apart in F, in each scene",
            verdict: verdict(&|scene| scene.starts.spread >= scene.starts.apart),
        },
        Claim {
            id: "one",
            figures: "5",
            claim: "Even for one object and one light, F has many local minima.",
            test: "there is more than one strict local minimum, and more than one that is deeper \
                   than 0.01",
            verdict: valleys(scenes.first()),
        },
        Claim {
            id: "two",
            figures: "6 and 7",
            claim: "With two objects there are more, and their pictures differ.",
            test: "as before, on the scene of two objects",
            verdict: valleys(scenes.get(1)),
        },
        Claim {
            id: "converges",
            figures: "8",
            claim: "The genetic algorithm converges.",
            test: "the mean over the runs is within 5 % of its whole fall after three quarters of \
                   the evaluations, in each scene",
            verdict: verdict(&converges),
        },
        Claim {
            id: "better",
            figures: "12",
            claim: "The genetic algorithm ends consistently lower than the greedy search.",
            test: "its median F is lower and a Wilcoxon signed-rank test gives p below 0.05, in \
                   each scene",
            verdict: ends_lower(scenes.iter().map(|scene| scene.compare.comparison.verdict)),
        },
        Claim {
            id: "picture",
            figures: "12",
            claim: "Its pictures are better too.",
            test: "most terms of the median run's picture are lower, in each scene",
            verdict: verdict(&|scene| {
                let genetic = scene.compare.genetic.median_quality.terms.values();
                let greedy = scene.compare.greedy.median_quality.terms.values();
                let lower = genetic.clone().zip(greedy).filter(|(a, b)| a < b).count();
                2 * lower > genetic.count()
            }),
        },
    ]
}

/// Whether the genetic algorithm ends lower in each scene, as its comparisons find.
fn ends_lower(findings: impl Iterator<Item = Finding> + Clone) -> Verdict {
    if findings.clone().any(|finding| finding == Finding::TooFewRuns) {
        return Verdict::TooFewRuns;
    }
    Verdict::of(&findings.map(|finding| finding == Finding::Lower).collect::<Vec<_>>())
}

fn converges(scene: &SceneFigures) -> bool {
    let courses = &scene.convergence;
    let genetic = courses.methods.iter().find(|course| course.method == GENETIC);
    genetic.is_some_and(|course| 4 * course.settled <= 3 * courses.budget)
}

/// A scene's plots and pictures for the page.
#[derive(Serialize)]
struct SceneParts {
    plots: Vec<(String, String)>,
    pictures: Vec<(String, String)>,
}

fn parts(scene: &SceneExhibits) -> Result<SceneParts> {
    let mut parts = SceneParts { plots: Vec::new(), pictures: Vec::new() };
    let landscape = &scene.landscape;
    let terms = scene.compare.data.genetic.median_quality.terms.names();
    let terms: Vec<_> = terms.map(|name| format!("term-{name}")).collect();
    for stem in ["landscape", "surface"].into_iter().chain(terms.iter().map(String::as_str)) {
        let plot = landscape.plot(stem).with_context(|| format!("no plot {stem}"))?;
        parts.plots.push((stem.into(), plot.into()));
    }
    let others = [
        ("starts", scene.starts.plot("starts")),
        ("convergence", scene.convergence.plot("convergence")),
        ("compare", scene.compare.plot("compare")),
    ];
    for (stem, plot) in others {
        parts.plots.push((stem.into(), plot.with_context(|| format!("no plot {stem}"))?.into()));
    }
    let mut add = |stem: &str, image: &RgbImage| -> Result<()> {
        parts.pictures.push((stem.into(), picture::data_uri(image)?));
        Ok(())
    };
    for (stem, picture) in ["code", "edges", "types"].iter().zip(&scene.maps) {
        add(stem, picture)?;
    }
    let minima = landscape.pictures.iter().filter(|(stem, _)| stem.starts_with("minimum-"));
    let ends = landscape.pictures.iter().filter(|(stem, _)| stem == "best" || stem == "worst");
    for (stem, picture) in ends.chain(minima.take(SHOWN_MINIMA)) {
        add(stem, picture)?;
    }
    for (stem, picture) in &scene.starts.pictures {
        add(stem, picture)?;
    }
    for (stem, picture) in &scene.convergence.pictures {
        add(stem, picture)?;
    }
    Ok(parts)
}

/// A term as the page names it.
#[derive(Serialize)]
struct TermName {
    name: &'static str,
    meaning: &'static str,
}

/// The terms of the scenes' pictures.
fn terms(scenes: &[SceneExhibits]) -> Vec<TermName> {
    let terms = scenes.first().map(|scene| scene.compare.data.genetic.median_quality.terms);
    let named = |(term, _): (&Term, f32)| TermName { name: term.name, meaning: term.meaning };
    terms.unwrap_or_default().iter().map(named).collect()
}

/// The page. Every number in it stands in an element whose `data-value` is its JSON pointer in the
/// paper's figures.
///
/// # Errors
/// When a picture is too large for PNG.
pub fn render(paper: &Paper, scenes: &[SceneExhibits]) -> Result<String> {
    let figures = serde_json::to_value(paper)?;
    let mut environment = html::environment()?;
    environment.add_function(
        "value",
        move |pointer: String, digits: usize, factor: Option<f64>| {
            let missing = || Error::new(ErrorKind::UndefinedError, format!("no figure {pointer}"));
            let number = figures.pointer(&pointer).and_then(serde_json::Value::as_f64);
            let number = number.ok_or_else(missing)? * factor.unwrap_or(1.0);
            let text = format!("<span data-value=\"{pointer}\">{number:.digits$}</span>");
            Ok(Value::from_safe_string(text))
        },
    );
    environment.add_template("paper.html", include_str!("paper.html.j2"))?;
    let parts = scenes.iter().map(parts).collect::<Result<Vec<_>>>()?;
    let parts = parts.into_iter().map(|parts| {
        let plots = parts.plots.into_iter();
        let plots = plots.map(|(stem, svg)| (stem, Value::from_safe_string(svg)));
        let pictures = parts.pictures.into_iter();
        let pictures = pictures.map(|(stem, uri)| (stem, Value::from_safe_string(uri)));
        context! {
            plots => plots.collect::<BTreeMap<_, _>>(),
            pictures => pictures.collect::<BTreeMap<_, _>>(),
        }
    });
    let page = context! {
        paper => Serde(paper),
        terms => Serde(terms(scenes)),
        parts => parts.collect::<Vec<_>>(),
        shown_minima => SHOWN_MINIMA,
    };
    environment.get_template("paper.html")?.render(page).map_err(|e| anyhow!("{e:#}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_on_too_few_runs_is_not_judged() {
        use Finding::{Alike, Higher, Lower, TooFewRuns};
        let verdict = |findings: &[Finding]| ends_lower(findings.iter().copied());
        assert_eq!(verdict(&[Lower, Lower]), Verdict::Holds);
        assert_eq!(verdict(&[Lower, Alike]), Verdict::Partly);
        assert_eq!(verdict(&[Higher, Alike]), Verdict::Fails);
        assert_eq!(verdict(&[TooFewRuns, TooFewRuns]), Verdict::TooFewRuns);
        assert_eq!(serde_json::to_value(Verdict::TooFewRuns).unwrap(), "too-few-runs");
    }
}
