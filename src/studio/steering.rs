//! What light is wanted, and what comes of it.

use super::answers::Answer;
use super::convert::rig;
use super::messages::{Steer, Targets};
use super::worker::Worker;
use crate::Result;
use crate::lighting::genome::Boxes;
use crate::lighting::{self, Role};

impl Worker {
    /// Tells weights, targets and the lights' sizes that come of what is wanted.
    pub(super) fn steer(&self, steer: &Steer) -> Result<()> {
        let lights = rig(&steer.lights)?;
        let before = self.studio().steered(steer.from)?.lights.boxes;
        let after = self.studio().steered(steer.to)?;
        let sizes = lights.iter().zip(&steer.lights).map(|(light, said)| {
            if said.locked { Ok(light.size) } else { size(light, &before, &after.lights.boxes) }
        });
        self.send(Answer::Steered {
            id: steer.id,
            weights: Box::new(after.objective.weights),
            targets: Targets::of(&after.objective),
            sizes: sizes.collect::<Result<_>>()?,
        })
    }
}

/// The radius of a light where its box has become another.
fn size(light: &lighting::Light, before: &Boxes, after: &Boxes) -> Result<f32> {
    if light.role == Role::Scene {
        return Ok(light.size);
    }
    let (before, after) = (before.of(light.role)?, after.of(light.role)?);
    let same = before.softness == after.softness;
    Ok(if same { light.size } else { after.size() * light.reach().unwrap_or(1.0) })
}
