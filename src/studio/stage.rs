//! A view of a scene that is lit, judged and painted: the stored surface, the shadow table and what reads them.

use super::answers::{Fineness, Judged, Measured};
use super::convert::camera_of;
use super::hall::Hall;
use super::messages::{Camera, Draw, Look};
use super::scenes::Held;
use crate::cpu::{self, CpuEvaluator, Painter, shadows};
use crate::design::coarse;
use crate::lighting::{Light, LightRecord};
use crate::objective::maps::Maps;
use crate::objective::shadows::ShadowSettings;
use crate::objective::terms::TERMS;
use crate::objective::{Objective, Terms};
use crate::render::{BACKGROUND, Background};
use crate::scene::view::View;
use crate::session::config::Settings;
use crate::session::device::Opened;
use crate::session::{Engine, evaluator_on, focus};
use crate::{Error, Result};
use image::RgbaImage;
use std::sync::Arc;

/// Most pixels of a picture whose surface is stored while people look at it: some 500 bytes each.
const MOST_LIVE: u64 = 1 << 21;

/// Most pixels of a final picture.
const MOST_FINAL: u64 = 1 << 25;

/// Longest side of coarse pictures, pixels.
const COARSE: u32 = 128;

/// Directions along a side of the shadow table of coarse pictures, and of the first of whole ones.
const COARSE_SIDE: u32 = 11;

/// What is seen: a stage is for one of these.
#[derive(Debug, Clone, PartialEq)]
pub struct Sight {
    /// From where.
    pub camera: Camera,
    /// Width and height, pixels.
    pub size: [u32; 2],
}

impl Draw {
    /// What is seen.
    pub(super) fn sight(&self) -> Sight {
        Sight { camera: self.look.camera.clone(), size: self.size }
    }
}

impl Sight {
    /// The view of it, for pictures that follow a hand.
    ///
    /// # Errors
    /// [`Error::Argument`] for a camera that shows nothing, and pictures without pixels or too many.
    pub fn view(&self, held: &Held) -> Result<View> {
        self.view_of(held, MOST_LIVE)
    }

    /// The view of it, for final pictures.
    ///
    /// # Errors
    /// The same.
    pub fn final_view(&self, held: &Held) -> Result<View> {
        self.view_of(held, MOST_FINAL)
    }

    fn view_of(&self, held: &Held, most: u64) -> Result<View> {
        let [width, height] = self.size;
        let pixels = u64::from(width) * u64::from(height);
        if pixels > most {
            let fault =
                format!("a picture of {width}x{height} is too large: it may have {most} pixels");
            return Err(Error::Argument(fault));
        }
        let camera = camera_of(&self.camera, &held.scene, held.bounds)?;
        View::new(&held.scene, camera, width, height)
    }
}

/// `usual` with a weight for every term that can be measured, so that all of them are.
pub fn everything(usual: &Objective) -> Objective {
    let mut weights = Terms::default();
    for &term in TERMS {
        if usual.can_measure(term) && !term.needs.target {
            // There are no more terms than there is room for.
            let _ = weights.set(term, 1.0);
        }
    }
    Objective { weights, ..*usual }
}

/// A view that is ready to be lit.
pub struct Stage {
    /// What is seen.
    pub sight: Sight,
    /// The view; a coarse one is smaller than what was asked for.
    pub view: View,
    /// How fine its pictures are.
    pub fineness: Fineness,
    /// Microseconds that its last picture took.
    pub took: u32,
    engine: Engine,
    painter: Painter,
    /// What `engine` measures.
    everything: Objective,
    /// Names of the objects in focus, and of those that are to stay dim, of which `engine` knows.
    wishes: [Vec<String>; 2],
    /// Colour behind the objects.
    background: [u8; 3],
}

/// The colour behind the objects of live pictures, which are opaque.
pub fn background(hall: &Hall) -> [u8; 3] {
    match hall.settings().picture.background {
        Some(Background::Color(color)) => color,
        Some(Background::Transparent) | None => BACKGROUND,
    }
}

impl Stage {
    /// A small stage, at once.
    ///
    /// # Errors
    /// Faults of the scene, the camera and the device.
    pub fn coarse(hall: &Hall, sight: Sight) -> Result<Self> {
        let whole = sight.view(&hall.held)?;
        let view = whole.shrunk(&hall.held.scene, COARSE)?;
        let objective = everything(&coarse::objective(&hall.settings().objective, &whole, &view));
        let shadows = ShadowSettings { side: COARSE_SIDE, ..hall.settings().shadows };
        let occluders = hall.occluders(&sight.camera, &view)?;
        let maps = cpu::draw(&hall.held.scene, &view, &objective, (&shadows, occluders))?;
        Self::of_maps(hall, (sight, view), (maps, objective), Fineness::Coarse)
    }

    /// The whole stage, first with a rough shadow table, then with the one that the settings ask for; each is passed to
    /// `take`.
    ///
    /// # Errors
    /// As [`Stage::coarse`], and [`Error::Interrupted`] as soon as `go_on` says no.
    pub fn whole(
        hall: &Hall,
        sight: &Sight,
        go_on: &(dyn Fn() -> bool + Sync),
        take: &mut dyn FnMut(Self),
    ) -> Result<()> {
        let view = sight.view(&hall.held)?;
        let objective = everything(&hall.settings().objective);
        if let Opened::Vulkan(_) = hall.studio.device {
            take(Self::on_device(hall, (sight.clone(), view), objective)?);
            return Ok(());
        }
        let settings = hall.settings().shadows;
        let scene = &hall.held.scene;
        let none = ShadowSettings { on: false, ..settings };
        let maps = cpu::draw(scene, &view, &objective, (&none, None))?;
        let Some(occluders) = hall.occluders(&sight.camera, &view)? else {
            let seen = (sight.clone(), view);
            take(Self::of_maps(hall, seen, (maps, objective), Fineness::Full)?);
            return Ok(());
        };
        let sides = [(COARSE_SIDE, Fineness::Coarse), (settings.side, Fineness::Full)];
        for (side, fineness) in sides {
            if fineness == Fineness::Coarse && side >= settings.side {
                continue;
            }
            let settings = ShadowSettings { side, ..settings };
            let occluders = Arc::clone(&occluders);
            let table = shadows::table_while(&maps.surface, occluders, &settings, go_on)?;
            let maps = Maps { shadows: Some(table), ..maps.clone() };
            let seen = (sight.clone(), view.clone());
            take(Self::of_maps(hall, seen, (maps, objective), fineness)?);
        }
        Ok(())
    }

    fn of_maps(
        hall: &Hall,
        (sight, view): (Sight, View),
        (maps, everything): (Maps, Objective),
        fineness: Fineness,
    ) -> Result<Self> {
        let engine = CpuEvaluator::new(maps, &view, everything, hall.settings().shading)?;
        let engine = Engine::Cpu(Box::new(engine));
        Self::of_engine(hall, (sight, view), (engine, everything), fineness)
    }

    fn on_device(hall: &Hall, (sight, view): (Sight, View), everything: Objective) -> Result<Self> {
        let mut settings = hall.settings().clone();
        settings.objective = everything;
        let seen = (&*hall.held.scene, &view);
        let engine = evaluator_on(&hall.studio.device, seen, &settings, None)?;
        Self::of_engine(hall, (sight, view), (engine, everything), Fineness::Full)
    }

    fn of_engine(
        hall: &Hall,
        (sight, view): (Sight, View),
        (mut engine, everything): (Engine, Objective),
        fineness: Fineness,
    ) -> Result<Self> {
        let painter = Painter::new(engine.maps()?, &view, &hall.settings().shading);
        let background = background(hall);
        let wishes = Default::default();
        Ok(Self { sight, view, fineness, took: 0, engine, painter, everything, wishes, background })
    }

    /// The same stage, which judges pictures by a look's wishes for objects.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that no object has, and what the device reports.
    pub fn wishing(self, hall: &Hall, look: &Look) -> Result<Self> {
        let wishes = [look.focus.clone(), look.dim.clone()];
        if self.wishes == wishes {
            return Ok(self);
        }
        let device = match self.engine {
            Engine::Cpu(_) => Opened::Cpu,
            _ => hall.studio.device.clone(),
        };
        let settings = Settings { objective: self.everything, ..hall.wanted(look)? };
        let seen = (&*hall.held.scene, &self.view);
        let engine = focus::wished_in_view(self.engine.into_whole(), &device, seen, &settings)?;
        Ok(Self { engine, wishes, ..self })
    }

    /// The view's maps.
    ///
    /// # Errors
    /// What the device reports.
    pub fn maps(&mut self) -> Result<&Maps> {
        self.engine.maps()
    }

    /// The picture of a rig.
    ///
    /// # Errors
    /// What the device reports.
    pub fn paint(&mut self, rig: &[Light]) -> Result<RgbaImage> {
        let records: Vec<LightRecord> = rig.iter().map(Light::record).collect();
        let shadows = self.engine.maps()?.shadows.as_ref();
        Ok(self.painter.paint(shadows, &records, self.background))
    }

    /// How good the picture of a rig is by `objective`.
    ///
    /// # Errors
    /// What the device reports.
    pub fn judge(&mut self, id: u32, rig: &[Light], objective: &Objective) -> Result<Judged> {
        let measured = self.engine.measure(rig)?;
        let (statistics, view) = measured.whole();
        let Objective { edge_sobel, edge_laplace, example, .. } = self.everything;
        let objective = Objective { edge_sobel, edge_laplace, example, ..*objective };
        let all = Objective { weights: self.everything.weights, ..objective };
        Ok(Judged {
            id,
            score: measured.quality(&objective)?.score,
            terms: measured.quality(&all)?.terms,
            measured: Measured {
                mean: statistics.mean,
                mean_target: objective.mean_of(view),
                spread: statistics.variance.max(0.0).sqrt(),
                spread_target: objective.spread_target,
                burnt: statistics.burnt,
                unlit: statistics.unlit,
            },
            quality: self.fineness,
        })
    }
}
