//! `F` of one light in all directions, in one batch.

use super::answers::{Answer, Mapped};
use super::convert::{chosen, rig};
use super::hall::Hall;
use super::messages::Map;
use super::stage::Sight;
use super::worker::Worker;
use crate::Result;
use crate::cpu::{self, CpuEvaluator};
use crate::design::{Dome, coarse, intent};
use crate::error::within;
use crate::lighting::Light;
use crate::objective::maps::Maps;
use crate::objective::shadows::ShadowSettings;
use crate::scene::view::View;
use crate::session::config::Settings;
use crate::session::device::Opened;
use crate::session::{Engine, focus};
use glam::Vec3;

/// Longest side of the pictures that are judged, pixels.
const JUDGED: u32 = 64;

/// Directions along a side of their shadow table.
const SIDE: u32 = 15;

/// Most cells of a side.
const MOST_CELLS: f32 = 129.0;

/// What judges small pictures of a sight.
pub struct Landscape {
    sight: Sight,
    whole: View,
    view: View,
    maps: Maps,
    /// The last look's settings, and what measures for them.
    engine: Option<(Settings, Engine)>,
}

impl Landscape {
    fn new(hall: &Hall, sight: Sight) -> Result<Self> {
        let whole = sight.view(&hall.held)?;
        let view = whole.shrunk(&hall.held.scene, JUDGED)?;
        let settings = hall.settings();
        let objective = coarse::objective(&settings.objective, &whole, &view);
        let shadows = ShadowSettings { side: SIDE, ..settings.shadows };
        let occluders = hall.occluders(&sight.camera, &view)?;
        let maps = cpu::draw(&hall.held.scene, &view, &objective, (&shadows, occluders))?;
        Ok(Self { sight, whole, view, maps, engine: None })
    }

    fn dome(
        &mut self,
        hall: &Hall,
        (settings, rig): (Settings, &[Light]),
        (at, cells): (usize, [u32; 2]),
    ) -> Result<Dome> {
        let known = self.engine.take().filter(|(known, _)| *known == settings);
        let (_, engine) = match known {
            Some(known) => self.engine.insert(known),
            None => {
                let small = coarse::objective(&settings.objective, &self.whole, &self.view);
                let small = Settings { objective: small, ..settings.clone() };
                let (maps, view) = (self.maps.clone(), &self.view);
                let evaluator = CpuEvaluator::new(maps, view, small.objective, small.shading)?;
                let whole = Engine::Cpu(Box::new(evaluator));
                let seen = (&*hall.held.scene, view);
                let engine = focus::wished_in_view(whole, &Opened::Cpu, seen, &small)?;
                self.engine.insert((settings, engine))
            }
        };
        Dome::of(&mut **engine, rig, at, cells)
    }
}

impl Worker {
    /// Judges one light in all directions.
    pub(super) fn map(&mut self, map: &Map) -> Result<()> {
        let hall = self.hall()?;
        let Map { id, light, columns, rows, .. } = *map;
        within("columns", columns as f32, 1.0, MOST_CELLS)?;
        within("rows", rows as f32, 1.0, MOST_CELLS)?;
        let lights = rig(&map.look.lights)?;
        let settings = hall.wanted(&map.look)?;
        chosen(&lights, light)?;
        let sight = Sight { camera: map.look.camera.clone(), size: map.size };
        let mut landscape = match self.landscape.take() {
            Some(known) if known.sight == sight => known,
            _ => Landscape::new(&hall, sight)?,
        };
        let asked = (light as usize, [columns, rows]);
        let dome = landscape.dome(&hall, (settings, &lights), asked)?;
        let up = (!map.look.intent.below).then(|| intent::up(&landscape.whole));
        let above = |direction: Vec3| up.is_none_or(|up| direction.dot(up) >= 0.0);
        let best = dome.lowest(above).unwrap_or(dome.best).to_array();
        self.landscape = Some(landscape);
        let (Dome { columns, rows, values, .. }, up) = (dome, up.map(|up| up.to_array()));
        self.send(Answer::Mapped(Mapped { id, light, columns, rows, values, best, up }))
    }
}
