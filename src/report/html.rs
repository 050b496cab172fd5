//! The sheet of a design: one self-contained page with the pictures under the designed lights and under usual
//! ones, their terms, the lights, where they stand, and the course of the search.

use super::dome::Disc;
use super::gallery::{Thumbnail, cards};
use super::json::{Design, ViewRecord};
use super::text::visible;
use super::{picture, plot};
use crate::design::{Dome, Progress};
use crate::lighting::{Light, Role};
use crate::objective::{Quality, Term};
use anyhow::{Context, Result, anyhow};
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, context};
use serde::Serialize;

/// Size of the inline plot: text stays legible at a phone's width.
const PLOT: (u32, u32) = (480, 440);

/// What the sheet shows.
#[derive(Debug)]
pub struct Sheet<'a> {
    /// The result.
    pub design: &'a Design,
    /// The best rig.
    pub rig: &'a [Light],
    /// Pictures of rigs in the order of the page, the designed one among them.
    pub pictures: &'a [Shown],
    /// Small pictures of each of several views.
    pub sights: &'a [Sight],
    /// How good every direction is for the rig's lights, those of the scene's own excepted, in their order; none where the
    /// picture is too small to tell.
    pub domes: &'a [Dome],
    /// The design's alternatives.
    pub alternatives: &'a [Thumbnail<'a>],
    /// The course of the search.
    pub history: &'a [Progress],
    /// The search's settings, in words.
    pub settings: String,
    /// Whether its first generations looked at small pictures.
    pub coarse: bool,
}

/// A final picture and what is known of it.
#[derive(Debug)]
pub struct Shown {
    /// The rig's name, for people.
    pub title: String,
    /// Whether it is the designed one.
    pub designed: bool,
    /// The picture, a PNG file.
    pub png: Vec<u8>,
    /// `F` and the terms of what the search saw.
    pub quality: Quality,
    /// Intensity of the key lights to that of the fill lights at the scene's centre, where there are both.
    pub ratio: Option<f32>,
    /// Share of the object that is burnt out in the picture.
    pub burnt: f32,
    /// Share of the object that no light reaches.
    pub unlit: f32,
}

/// One of several views.
#[derive(Debug)]
pub struct Sight {
    /// What it shows, for people.
    pub title: String,
    /// Under a headlight, a PNG file.
    pub before: Vec<u8>,
    /// Under the rig, a PNG file.
    pub after: Vec<u8>,
}

/// The same on the page.
#[derive(Serialize)]
struct SightCard {
    title: String,
    before: String,
    after: String,
    /// Of headlight and rig.
    scores: [Option<f32>; 2],
}

/// Intensity of the key lights of a rig to that of its fill lights at the scene's centre; `None` where it
/// lacks either.
pub fn light_ratio(rig: &[Light]) -> Option<f32> {
    let of = |role: Role| -> f32 {
        rig.iter().filter(|light| light.role == role).map(|light| light.diffuse).sum()
    };
    let (key, fill) = (of(Role::Key), of(Role::Fill));
    (key > 0.0 && fill > 0.0).then_some(key / fill)
}

/// One picture of the page.
#[derive(Serialize)]
struct PictureCard<'a> {
    title: &'a str,
    designed: bool,
    source: String,
    score: f32,
    ratio: Option<f32>,
    burnt: f32,
    unlit: f32,
}

impl<'a> PictureCard<'a> {
    fn of(shown: &'a Shown) -> Self {
        Self {
            title: &shown.title,
            designed: shown.designed,
            source: picture::uri(&shown.png),
            score: shown.quality.score,
            ratio: shown.ratio,
            burnt: shown.burnt,
            unlit: shown.unlit,
        }
    }
}

/// One term of all pictures.
#[derive(Serialize)]
struct TermRow {
    name: &'static str,
    title: &'static str,
    meaning: &'static str,
    weight: f32,
    /// Of the pictures in the order of the page.
    values: Vec<f32>,
}

/// A light's place in the diagrams: pixels from the scene's centre, for the plan (seen from above,
/// the viewer below) and the side view (seen from the viewer's right, the viewer on the left).
#[derive(Serialize)]
struct Spot {
    plan: [f32; 2],
    side: [f32; 2],
    point: bool,
    /// Its colour, for the style sheet.
    hex: String,
}

/// Half the width of a diagram, pixels, with room for a mark at the border.
const REACH: f32 = 132.0;

impl Sheet<'_> {
    /// The page.
    ///
    /// # Errors
    /// None in practice: the template is the program's own.
    pub fn render(&self) -> Result<String> {
        let mut environment = environment()?;
        environment.add_template("report.html", include_str!("report.html.j2"))?;
        environment.add_template("wiper.js", include_str!("wiper.js"))?;
        let (radius, spots) = self.spots();
        let (weighed, others): (Vec<_>, Vec<_>) =
            self.terms().into_iter().partition(|term| term.weight > 0.0);
        let search = plot::convergence(self.history, PLOT).map_err(|e| anyhow!("plotting: {e}"))?;
        let title = std::path::Path::new(&self.design.header.scene).file_name();
        let page = context! {
            title => title.map_or("scene".into(), |name| name.to_string_lossy()),
            result => Serde(self.design),
            change => self.change(),
            pictures => Serde(self.cards()),
            terms => Serde(weighed),
            others => Serde(others),
            sights => Serde(self.sights()),
            domes => Serde(self.discs()?),
            alternatives => Serde(cards(self.alternatives, &self.design.objective)),
            plot => search,
            spots => Serde(spots),
            radius => radius,
            own_lights => self.design.scene_lights.in_words(),
            settings => self.settings.clone(),
            coarse => self.coarse,
        };
        let page = environment.get_template("report.html")?.render(page);
        Ok(visible(&page.context("the report's template")?).into_owned())
    }

    /// How far `F` fell, percent.
    fn change(&self) -> f32 {
        let before = self.design.headlight.score;
        if before > 0.0 { 100.0 * (1.0 - self.design.quality.score / before) } else { 0.0 }
    }

    /// The terms that were measured.
    fn terms(&self) -> Vec<TermRow> {
        let Design { objective, quality, .. } = self.design;
        let row = |(term, _): (&'static Term, f32)| {
            let &Term { name, title, meaning, .. } = term;
            let weight = objective.weights.get(name)?;
            let values = self.pictures.iter().map(|shown| shown.quality.terms.get(name));
            Some(TermRow { name, title, meaning, weight, values: values.collect::<Option<_>>()? })
        };
        quality.terms.iter().filter_map(row).collect()
    }

    fn sights(&self) -> Vec<SightCard> {
        let records = self.design.views.iter().flat_map(|views| &views.each);
        let card = |(sight, record): (&Sight, &ViewRecord)| SightCard {
            title: sight.title.clone(),
            before: picture::uri(&sight.before),
            after: picture::uri(&sight.after),
            scores: [record.headlight.map(|quality| quality.score), Some(record.quality.score)],
        };
        self.sights.iter().zip(records).map(card).collect()
    }

    fn discs(&self) -> Result<Vec<Disc>> {
        let disc = |(at, dome)| Ok(Disc::new(self.rig, at, dome)?);
        self.domes.iter().enumerate().map(disc).collect()
    }

    fn cards(&self) -> Vec<PictureCard<'_>> {
        self.pictures.iter().map(PictureCard::of).collect()
    }

    /// The scene's radius and the lights in the diagrams, pixels.
    fn spots(&self) -> (f32, Vec<Spot>) {
        let extent = self.rig.iter().filter_map(Light::reach).fold(2.0, f32::max);
        let scale = REACH / extent;
        let spot = |light: &Light| {
            let reach = light.reach().map_or(REACH, |reach| reach * scale);
            let [x, y, z] = (light.direction() * reach).to_array();
            let (point, hex) = (!light.kind.parallel, light.color.hex());
            Spot { plan: [x, z], side: [-z, -y], point, hex }
        };
        (scale, self.rig.iter().map(spot).collect())
    }
}

/// What all pages are rendered by: the filter `fixed(digits)`, and their common style, `page.css`, and the cards of rigs. A
/// name without a value is an error.
pub(super) fn environment() -> Result<Environment<'static>> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.add_filter("fixed", |value: f64, digits: usize| format!("{value:.digits$}"));
    environment.add_template("page.css", include_str!("page.css"))?;
    environment.add_template("theme.css", plot::theme::THEME_CSS)?;
    environment.add_template("cards.css", include_str!("cards.css"))?;
    environment.add_template("cards.html", include_str!("cards.html.j2"))?;
    Ok(environment)
}
