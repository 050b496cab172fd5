//! What a dispersion knows of a rig: its score and its picture, both small.

use crate::cpu;
use crate::design::Dispersion;
use crate::design::dispersion::Candidate;
use crate::design::gallery::{Picture, SIDE};
use crate::evaluate::check_scores;
use crate::lighting::genome::Genome;
use crate::lighting::shading::Shading;
use crate::lighting::{Light, LightRecord, Population, Rig};
use crate::objective::maps::{Maps, PixelType};
use crate::render::BACKGROUND;
use crate::scene::view::{View, proportional};
use crate::session::views::occluders;
use crate::session::{Engine, Session};
use anyhow::Result;
use rayon::prelude::*;

/// Samples along a side of a pixel of the pictures that are compared.
const SAMPLES: u32 = 2;

/// What scores chromosomes and looks at those that are good.
pub(super) struct Judge<'a> {
    pub genome: &'a Genome,
    pub eye: &'a Eye,
    pub evaluator: &'a mut Engine,
}

impl Judge<'_> {
    fn scores(&mut self, rigs: &[Rig]) -> Result<Vec<f32>> {
        let mut population = Population::new(self.genome.rig_lights())?;
        rigs.iter().try_for_each(|rig| population.push(rig))?;
        let mut scores = vec![0.0; rigs.len()];
        self.evaluator.evaluate(&population, &mut scores)?;
        check_scores(&population, &scores)?;
        Ok(scores)
    }

    /// A chromosome as a candidate.
    pub fn one(&mut self, chromosome: Vec<f32>) -> Result<Candidate> {
        let rig = self.genome.decode(&chromosome);
        let score = self.scores(std::slice::from_ref(&rig))?[0];
        Ok(Candidate { chromosome, score, picture: self.eye.see(&rig) })
    }

    /// Offers those of the chromosomes that are good enough.
    pub fn offer(&mut self, dispersion: &mut Dispersion, chromosomes: Vec<Vec<f32>>) -> Result<()> {
        let rigs: Vec<Rig> = chromosomes.iter().map(|one| self.genome.decode(one)).collect();
        let scores = self.scores(&rigs)?;
        let (eye, limit) = (self.eye, dispersion.limit());
        let candidate = |((chromosome, rig), score): ((Vec<f32>, &Rig), f32)| {
            (score <= limit).then(|| Candidate { chromosome, score, picture: eye.see(rig) })
        };
        let all = chromosomes.into_par_iter().zip(&rigs).zip(scores);
        dispersion.add(all.filter_map(candidate).collect::<Vec<_>>());
        Ok(())
    }
}

/// What makes the pictures that are compared, the same on any device.
pub(super) struct Eye {
    view: View,
    maps: Maps,
    object: Vec<bool>,
    shading: Shading,
}

impl Eye {
    pub fn new(session: &mut Session) -> Result<Self> {
        let (camera, settings) = (session.view.camera.clone(), &session.settings);
        let size = [session.view.width, session.view.height];
        let [width, height] = proportional(size, SAMPLES * SIDE);
        let view = View::new(&session.scene, camera, width, height)?;
        let shadows = (&settings.shadows, occluders(&mut session.evaluator)?);
        let maps = cpu::draw(&session.scene, &view, &settings.objective, shadows)?;
        let object = maps.types.iter().map(|kind| *kind != PixelType::Background).collect();
        Ok(Self { view, maps, object, shading: settings.shading })
    }

    pub fn see(&self, rig: &[Light]) -> Picture {
        let records: Vec<LightRecord> = rig.iter().map(Light::record).collect();
        let (maps, view) = (&self.maps, &self.view);
        let picture =
            cpu::population::color_picture(maps, view, &self.shading, &records, BACKGROUND);
        Picture::of(&picture, &self.object, SAMPLES)
    }
}
