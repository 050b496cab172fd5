//! The pictures of several views: of each the final one, and small ones before and after, in a strip and as an animation.

use super::judged::Casting;
use super::{Seen, turning};
use crate::design::views::in_view;
use crate::lighting::presets::Preset;
use crate::lighting::{Light, LightRecord, Stand};
use crate::render::Picture;
use crate::report::animation::{self, Frame};
use crate::report::html::Sight;
use crate::report::{Staging, picture};
use crate::session::Session;
use crate::session::picture::draw_records;
use anyhow::Result;

/// The animation.
const TURNTABLE: &str = "turntable.png";

/// Longest side of the small pictures, pixels,
const SIDE: u32 = 256;
/// and most samples of a pixel of theirs.
const SAMPLES: u32 = 4;

/// Pictures of a turn, at least: fewer views have others between them.
const FRAMES: usize = 24;
/// Seconds of a turn.
const TURN: f32 = 6.0;
/// Seconds of a picture of one of several cameras, and at most of one moment of an animation.
const STILL: f32 = 1.0;

/// The file of a view by its number from 0.
pub fn name(number: usize) -> String {
    format!("view-{:02}.png", number + 1)
}

/// Writes the final picture of each view under `rig`, of which `first` is the first, and the animation under a headlight and
/// under `rig`; gives the same small pictures of each view.
///
/// # Errors
/// What drawing reports, and files that cannot be written.
pub fn write(
    session: &mut Session,
    (rig, first): (&[Light], &[u8]),
    staging: &mut Staging,
) -> Result<Vec<Sight>> {
    let occluders = session.occluders()?;
    let frame = session.view.frame;
    let stand = session.settings.views.rig;
    staging.write(name(0), first)?;
    for (number, seen) in session.views.iter().enumerate().skip(1) {
        let Seen { scene, view, .. } = seen;
        let records = in_view(rig, stand, &frame, &view.frame);
        let drawn = draw_records(
            (scene, view),
            occluders[number].as_deref(),
            &session.settings,
            &[&records],
        )?;
        staging.write(name(number), picture::final_png(&drawn[0].image)?)?;
    }
    let steps = FRAMES.div_ceil(session.views.len());
    let between = turning(&session.views[0], &session.settings, steps)?;
    let (frames, steps) = match &between {
        Some(frames) => (frames, steps),
        None => (&session.views, 1),
    };
    let mut casting = Casting::default();
    let mut drawn = Vec::with_capacity(frames.len());
    for (at, seen) in frames.iter().enumerate() {
        if at % steps == 0 {
            casting.keep(seen, occluders[at / steps].clone());
        }
        drawn.push(both(session, rig, seen, &casting)?);
    }
    let seconds =
        if between.is_some() { TURN / frames.len() as f32 } else { pause(&session.views) };
    staging.write(TURNTABLE, animation::beside(&drawn, seconds)?)?;
    let sight = |(drawn, seen): (&Frame, &Seen)| {
        let title = seen.title.clone();
        let [before, after] = [&drawn[0], &drawn[1]].map(picture::final_png);
        Ok(Sight { title, before: before?, after: after? })
    };
    drawn.iter().step_by(steps).zip(&session.views).map(sight).collect()
}

/// Small pictures of a view under a headlight and under the rig.
fn both(session: &Session, rig: &[Light], seen: &Seen, casting: &Casting) -> Result<Frame> {
    let Seen { scene, view, .. } = seen;
    let first = &session.view.frame;
    let small = view.shrunk(scene, SIDE)?;
    let headlight = session.with_kept(Preset::Headlight.rig());
    let before = in_view(&headlight, Stand::Camera, first, &view.frame);
    let after = in_view(rig, session.settings.views.rig, first, &view.frame);
    let records: [&[LightRecord]; 2] = [&before, &after];
    let mut settings = session.settings.clone();
    settings.picture.samples = settings.picture.samples.min(SAMPLES);
    let occluders = casting.turned(seen);
    let drawn = draw_records((scene, &small), occluders.as_deref(), &settings, &records)?;
    let mut images = drawn.into_iter().map(|Picture { image, .. }| image);
    Ok([images.next().unwrap_or_default(), images.next().unwrap_or_default()])
}

/// Seconds of a picture of views that are no turn: the time between moments of one camera, where they are such.
fn pause(views: &[Seen]) -> f32 {
    match (views[0].time, views[1].time) {
        (Some(first), Some(next)) if next > first => (next - first).min(STILL),
        _ => STILL,
    }
}
