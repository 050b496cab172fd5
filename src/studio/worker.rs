//! The thread of a page: it takes requests one after another and keeps what their answers are made of.

use super::answers::{Answer, Fineness};
use super::convert::rig;
use super::hall::{Hall, Studio};
use super::landscape::Landscape;
use super::mailbox::{Mailbox, Next};
use super::messages::{
    Camera, Draw, Follow, Light, PICTURE_HEADER, PICTURE_MAGIC, Preset, Request,
};
use super::opening::DESIGN;
use super::searching::Search;
use super::stage::{Sight, Stage};
use super::task::{Task, said};
use crate::lighting::{self, LightRecord, presets};
use crate::render;
use crate::{Error, Result};
use image::RgbaImage;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::mpsc;

/// What a socket sends.
#[derive(Debug)]
pub enum Frame {
    /// An answer.
    Answer(Box<Answer>),
    /// A picture with its header.
    Picture(Vec<u8>),
}

/// Where answers go.
pub type Outbox = mpsc::Sender<Frame>;

/// Something that was begun is done.
pub enum Event {
    /// A stage is ready.
    Built(Box<Stage>),
    /// Work for the request `id` has failed.
    Failed {
        /// Number of the request.
        id: u32,
        /// What went wrong.
        message: String,
    },
}

/// Pictures that take longer are drawn small while a light is moved, microseconds.
const SLOW: u32 = 33_000;

/// How long a camera stands still before the whole picture is begun.
const STILL: Duration = Duration::from_millis(50);

/// Kinds of pictures in their headers.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// What is shown.
    Picture = 0,
    /// The small picture of an alternative.
    Thumbnail = 1,
}

/// A picture as it is sent.
pub fn frame(
    id: u32,
    (kind, index): (Kind, u32),
    picture: &RgbaImage,
    (fineness, micros): (Fineness, u32),
) -> Frame {
    let (width, height) = picture.dimensions();
    let mut bytes = Vec::with_capacity(PICTURE_HEADER + picture.as_raw().len());
    let header = [PICTURE_MAGIC, id, width, height, kind as u32, index, fineness.into(), micros];
    header.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    bytes.extend_from_slice(picture.as_raw());
    Frame::Picture(bytes)
}

/// Microseconds since `start`.
pub fn micros(start: Instant) -> u32 {
    u32::try_from(start.elapsed().as_micros()).unwrap_or(u32::MAX)
}

/// The state of a page.
pub struct Worker {
    studio: Arc<Studio>,
    mailbox: Arc<Mailbox>,
    outbox: Outbox,
    hall: Option<Hall>,
    /// The last picture that was asked for.
    shown: Option<Draw>,
    coarse: Option<Stage>,
    whole: Option<Stage>,
    /// Whether the whole picture is still to be drawn, after a coarse one.
    owed: bool,
    building: Option<Task>,
    resting: Option<Task>,
    pub(super) dispersing: Option<Task>,
    pub(super) landscape: Option<Landscape>,
    pub(super) searching: Option<Search>,
    /// The best lights of the last search.
    pub(super) design: Option<Vec<Light>>,
}

impl Worker {
    /// Works until the mailbox is closed or nobody takes answers.
    pub fn run(studio: Arc<Studio>, mailbox: Arc<Mailbox>, outbox: Outbox) {
        let mut worker = Self {
            studio,
            mailbox,
            outbox,
            hall: None,
            shown: None,
            coarse: None,
            whole: None,
            owed: false,
            building: None,
            resting: None,
            dispersing: None,
            landscape: None,
            searching: None,
            design: None,
        };
        while worker.step() {}
        worker.mailbox.close();
    }

    /// Takes what comes next; whether to go on.
    fn step(&mut self) -> bool {
        let next = self.mailbox.next(!self.owed && !self.is_searching());
        let id = match &next {
            Next::Closed => return false,
            Next::Request(request) => Some(request.id()),
            Next::Nothing if !self.owed => self.searching.as_ref().map(Search::id),
            Next::Event(_) | Next::Nothing => self.shown.as_ref().map(|draw| draw.id),
        };
        let work = catch_unwind(AssertUnwindSafe(|| match next {
            Next::Request(request) => self.answer(*request),
            Next::Event(event) => self.take(event),
            Next::Nothing if self.owed => self.pay(),
            Next::Nothing => self.advance(),
            Next::Closed => Ok(()),
        }));
        let fault = match work {
            Ok(Ok(())) => return true,
            Ok(Err(Error::Interrupted)) => return !self.outbox.is_closed(),
            Ok(Err(fault)) => fault.to_string(),
            Err(panic) => {
                // Whatever was in work may be half done.
                self.enter(self.hall.clone());
                said(&*panic)
            }
        };
        self.owed = false;
        self.send(Answer::Fault { id, message: fault }).is_ok()
    }

    /// Sends an answer.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when nobody takes it.
    pub(super) fn send(&self, answer: Answer) -> Result<()> {
        self.deliver(Frame::Answer(Box::new(answer)))
    }

    fn deliver(&self, frame: Frame) -> Result<()> {
        self.outbox.blocking_send(frame).map_err(|_| Error::Interrupted)
    }

    /// What all pages share.
    pub(super) fn studio(&self) -> &Arc<Studio> {
        &self.studio
    }

    /// Looks at another scene.
    pub(super) fn enter(&mut self, hall: Option<Hall>) {
        self.hall = hall;
        self.owed = false;
        self.shown = None;
        (self.coarse, self.whole, self.building, self.resting) = Default::default();
        (self.dispersing, self.landscape, self.searching, self.design) = Default::default();
    }

    /// Where answers go.
    pub(super) fn outbox(&self) -> &Outbox {
        &self.outbox
    }

    /// Where requests wait.
    pub(super) fn mailbox(&self) -> &Arc<Mailbox> {
        &self.mailbox
    }

    /// Whether the whole stage of that sight is on its way.
    pub(super) fn is_coming(&self, sight: &Sight) -> bool {
        let is_here = |stage: &Stage| stage.fineness == Fineness::Full;
        self.building.is_some()
            && self.shown.as_ref().is_some_and(|draw| draw.sight() == *sight)
            && !self.whole.as_ref().is_some_and(is_here)
    }

    /// The whole stage, where it is of that sight.
    pub(super) fn whole_of(&mut self, sight: &Sight) -> Option<&mut Stage> {
        self.whole.as_mut().filter(|stage| stage.sight == *sight)
    }

    /// The scene that the page looks at.
    ///
    /// # Errors
    /// [`Error::Argument`] before one is open.
    pub(super) fn hall(&self) -> Result<Hall> {
        let fault = || Error::Argument("no scene is open".into());
        self.hall.clone().ok_or_else(fault)
    }

    fn answer(&mut self, request: Request) -> Result<()> {
        match request {
            Request::Open(open) => self.open(&open),
            Request::Draw(draw) => self.draw(draw),
            Request::Map(map) => self.map(&map),
            Request::Place(place) => self.place(&place),
            Request::Pick(pick) => self.pick(&pick),
            Request::Search(search) => self.search(search),
            Request::Alternatives(asked) => self.alternatives(asked),
            Request::Preset(preset) => self.preset(&preset),
            Request::Follow(follow) => self.follow(&follow),
            Request::Steer(steer) => self.steer(&steer),
        }
    }

    fn preset(&self, preset: &Preset) -> Result<()> {
        let lights = match preset.name.as_str() {
            DESIGN => self.found()?,
            name => Light::all(&presets::Preset::named(name)?.rig()),
        };
        self.send(Answer::Rig { id: preset.id, lights })
    }

    /// Keeps lights where they are in the world while the camera moves.
    fn follow(&self, follow: &Follow) -> Result<()> {
        let hall = self.hall()?;
        let frame = |camera: &Camera| {
            let sight = Sight { camera: camera.clone(), size: [1, 1] };
            sight.view(&hall.held).map(|view| view.frame)
        };
        let (from, to) = (frame(&follow.from)?, frame(&follow.to)?);
        let moved = |(light, said): (&lighting::Light, &Light)| Light {
            locked: said.locked,
            ..Light::of(&light.moved(&from, &to))
        };
        let lights = rig(&follow.lights)?.iter().zip(&follow.lights).map(moved).collect();
        self.send(Answer::Rig { id: follow.id, lights })
    }

    fn take(&mut self, event: Event) -> Result<()> {
        match event {
            Event::Failed { id, message } => {
                self.building = None;
                self.send(Answer::Fault { id: Some(id), message })
            }
            Event::Built(stage) => {
                let wanted = self.shown.as_ref().is_some_and(|draw| draw.sight() == stage.sight);
                if wanted {
                    self.whole = Some(*stage);
                    self.show_whole()?;
                }
                Ok(())
            }
        }
    }

    /// Draws the whole picture that is owed.
    fn pay(&mut self) -> Result<()> {
        self.owed = false;
        self.show_whole()
    }

    fn draw(&mut self, draw: Draw) -> Result<()> {
        let hall = self.hall()?;
        rig(&draw.look.lights)?;
        draw.look.objective(&hall.settings().objective)?;
        let sight = draw.sight();
        self.resting = None;
        self.owed = false;
        let at_rest = draw.at_rest;
        self.shown = Some(draw);
        let is_here = |stage: &Option<Stage>| stage.as_ref().is_some_and(|s| s.sight == sight);
        if is_here(&self.whole) {
            let slow = self.whole.as_ref().is_some_and(|stage| stage.took > SLOW);
            if slow && !at_rest && is_here(&self.coarse) {
                self.owed = true;
                return self.show_coarse();
            }
            return self.show_whole();
        }
        self.whole = None;
        if !is_here(&self.coarse) {
            self.building = None;
            self.coarse = None;
            self.coarse = Some(Stage::coarse(&hall, sight.clone())?);
            self.building = Some(self.build(&hall, sight));
        }
        self.show_coarse()
    }

    /// Begins the whole stage.
    fn build(&self, hall: &Hall, sight: Sight) -> Task {
        let (hall, mailbox) = (hall.clone(), Arc::clone(&self.mailbox));
        let id = self.shown.as_ref().map_or(0, |draw| draw.id);
        let failing = Arc::clone(&mailbox);
        let work = move |go_on: &(dyn Fn() -> bool + Sync)| {
            let mut take = |stage| mailbox.tell(Event::Built(Box::new(stage)));
            match Stage::whole(&hall, &sight, go_on, &mut take) {
                Ok(()) | Err(Error::Interrupted) => {}
                Err(fault) => mailbox.tell(Event::Failed { id, message: fault.to_string() }),
            }
        };
        let failed = move |message| failing.tell(Event::Failed { id, message });
        Task::spawn((&self.studio, STILL), work, failed)
    }

    /// The stage with the wishes for objects of what is shown.
    fn wishing(&self, stage: Stage) -> Result<Stage> {
        match (&self.shown, &self.hall) {
            (Some(draw), Some(hall)) => stage.wishing(hall, &draw.look),
            _ => Ok(stage),
        }
    }

    fn show_coarse(&mut self) -> Result<()> {
        let Some(stage) = self.coarse.take() else { return Ok(()) };
        let mut stage = self.wishing(stage)?;
        let shown = self.show(&mut stage);
        self.coarse = Some(stage);
        shown
    }

    fn show_whole(&mut self) -> Result<()> {
        let Some(stage) = self.whole.take() else { return Ok(()) };
        let mut stage = self.wishing(stage)?;
        let shown = self.show(&mut stage);
        let is_final = stage.fineness == Fineness::Full;
        self.whole = Some(stage);
        shown?;
        if is_final && self.shown.as_ref().is_some_and(|draw| draw.at_rest) {
            self.rest()?;
        }
        Ok(())
    }

    /// Sends the picture that was asked for last, and how good it is.
    fn show(&self, stage: &mut Stage) -> Result<()> {
        let Some(draw) = &self.shown else { return Ok(()) };
        let rig = rig(&draw.look.lights)?;
        let objective = draw.look.objective(&self.studio.settings.objective)?;
        let start = Instant::now();
        let picture = stage.paint(&rig)?;
        let judged = stage.judge(draw.id, &rig, &objective)?;
        stage.took = micros(start);
        let fineness = (stage.fineness, stage.took);
        self.deliver(frame(draw.id, (Kind::Picture, 0), &picture, fineness))?;
        self.send(Answer::Judged(Box::new(judged)))
    }

    /// Begins the final picture.
    fn rest(&mut self) -> Result<()> {
        let (Some(draw), Some(stage), hall) = (&self.shown, &mut self.whole, self.hall.clone())
        else {
            return Ok(());
        };
        let Some(hall) = hall else { return Ok(()) };
        let (id, rig) = (draw.id, rig(&draw.look.lights)?);
        let view = match draw.rest {
            Some(size) => Sight { size, ..stage.sight.clone() }.final_view(&hall.held)?,
            None => stage.view.clone(),
        };
        let occluders = hall.occluders(&stage.sight.camera, &view)?;
        let (outbox, mailbox) = (self.outbox.clone(), Arc::clone(&self.mailbox));
        let work = move |go_on: &(dyn Fn() -> bool + Sync)| {
            let start = Instant::now();
            let settings = hall.settings();
            let records: Vec<LightRecord> = rig.iter().map(lighting::Light::record).collect();
            let seen = render::Stage {
                scene: &hall.held.scene,
                view: &view,
                shading: &settings.shading,
                occluders: occluders.as_deref(),
            };
            if let Ok(picture) = render::draw_while(&seen, &records, &settings.picture, go_on) {
                let fineness = (Fineness::AtRest, micros(start));
                let frame = frame(id, (Kind::Picture, 0), &picture.image, fineness);
                // A page that has gone needs no picture.
                let _ = outbox.blocking_send(frame);
            }
        };
        let failed = move |message| mailbox.tell(Event::Failed { id, message });
        self.resting = Some(Task::spawn((&self.studio, Duration::ZERO), work, failed));
        Ok(())
    }
}
