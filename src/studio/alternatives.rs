//! Other lights that are as good, and different.

use super::answers::{Answer, Fineness};
use super::hall::Hall;
use super::messages::{Alternatives, Light};
use super::searching::genome;
use super::stage::{Sight, background};
use super::task::Task;
use super::worker::{Event, Frame, Kind, Outbox, Worker, frame, micros};
use crate::cpu::{Painter, visibility};
use crate::design::{Progress, coarse};
use crate::error::within;
use crate::lighting::LightRecord;
use crate::session::gallery::{self, SLACK, Wanted};
use crate::session::{Loaded, Session};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Longest side of the pictures that are judged and shown, pixels.
const SIDE: u32 = 192;

/// Most alternatives.
const MOST: u32 = 24;

impl Worker {
    /// Begins to look for other lights.
    pub(super) fn alternatives(&mut self, asked: Alternatives) -> crate::Result<()> {
        within("count", asked.count as f32, 2.0, MOST as f32)?;
        let hall = self.hall()?;
        let id = asked.id;
        let outbox = self.outbox().clone();
        let work = move |go_on: &(dyn Fn() -> bool + Sync)| {
            if let Err(fault) = find(&hall, &asked, &outbox, go_on)
                && go_on()
            {
                let message = crate::session::describe(&fault);
                let fault = Answer::Fault { id: Some(id), message };
                // A page that has gone needs no answer.
                let _ = outbox.blocking_send(Frame::Answer(Box::new(fault)));
            }
        };
        let mailbox = Arc::clone(self.mailbox());
        let failed = move |message| mailbox.tell(Event::Failed { id, message });
        self.dispersing = None;
        self.dispersing = Some(Task::spawn((self.studio(), Duration::ZERO), work, failed));
        Ok(())
    }
}

fn find(
    hall: &Hall,
    asked: &Alternatives,
    outbox: &Outbox,
    go_on: &(dyn Fn() -> bool + Sync),
) -> anyhow::Result<()> {
    let start = Instant::now();
    let sight = Sight { camera: asked.look.camera.clone(), size: asked.size };
    let whole = sight.view(&hall.held)?;
    let view = whole.shrunk(&hall.held.scene, SIDE)?;
    let (genome, order, chromosome) = genome(hall, &asked.look, &view)?;
    let mut settings = hall.wanted(&asked.look)?;
    settings.objective = coarse::objective(&settings.objective, &whole, &view);
    let mut codes = visibility::draw(&hall.held.scene, &view).code;
    codes.retain(|&code| code != 0);
    let settings = settings.seen_by(&hall.held.scene, &codes)?;
    let loaded = Loaded { scene: Arc::clone(&hall.held.scene), load: 0.0 };
    let device = &crate::session::device::Opened::Cpu;
    let mut session = Session::of_view(device, (loaded, view), settings, start)?;
    let origin = gallery::from_anywhere(&session, &genome, &genome.decode(&chromosome));
    let wanted = Wanted { count: asked.count as usize, slack: SLACK };
    let mut observe = |_: &Progress| match go_on() {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    let found = gallery::disperse(&mut session, &origin, wanted, &mut observe)?;
    if !go_on() {
        return Ok(());
    }
    let (view, shading) = (session.view.clone(), session.settings.shading);
    let maps = session.evaluator.maps()?;
    let painter = Painter::new(maps, &view, &shading);
    let mut count = 0;
    for (index, shown) in (0..).zip(&found.rigs) {
        let mut lights = asked.look.lights.clone();
        for (light, &at) in shown.rig.iter().zip(&order) {
            if !lights[at].locked {
                lights[at] = Light::of(light);
            }
        }
        let records: Vec<LightRecord> =
            shown.rig.iter().map(crate::lighting::Light::record).collect();
        let picture = painter.paint(maps.shadows.as_ref(), &records, background(hall));
        let score = shown.quality.score;
        let answer = Answer::Alternative { id: asked.id, index, lights, score };
        outbox.blocking_send(Frame::Answer(Box::new(answer)))?;
        let fineness = (Fineness::Full, micros(start));
        outbox.blocking_send(frame(asked.id, (Kind::Thumbnail, index), &picture, fineness))?;
        count = index + 1;
    }
    let done = Answer::AlternativesDone { id: asked.id, count };
    outbox.blocking_send(Frame::Answer(Box::new(done)))?;
    Ok(())
}
