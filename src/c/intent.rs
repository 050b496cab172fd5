//! What light is wanted.

use super::design::{as_box, box_in_c, klieg_design};
use super::edge::{Fault, choice, free_call, put};
use super::error::klieg_status;
use super::settings::{klieg_objective, objective_in_c, read_objective};
use crate::design::{Intent, Mood};
use crate::lighting::genome::Boxes;

/// The character of a light: one of `KLIEG_MOOD_...`.
pub type klieg_mood = i32;
/// Large lights, a strong fill, little contrast.
pub const KLIEG_MOOD_SOFT: klieg_mood = 0;
/// As the profile has it.
pub const KLIEG_MOOD_NATURAL: klieg_mood = 1;
/// A small key from anywhere in front, hardly any fill, shadows that may be black.
pub const KLIEG_MOOD_DRAMATIC: klieg_mood = 2;

/// What light is wanted. `klieg_intent_defaults` wants nothing. That no light stands below the horizon is said by
/// `klieg_design::up`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_intent {
    /// Steps of brightness, -2..2; by default 0.
    pub brightness: f32,
    /// Steps of contrast, -2..2; by default 0.
    pub contrast: f32,
    /// The character; by default natural.
    pub mood: klieg_mood,
}

/// Sets the defaults. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_intent_defaults(intent: *mut klieg_intent) -> klieg_status {
    let nothing = klieg_intent { brightness: 0.0, contrast: 0.0, mood: KLIEG_MOOD_NATURAL };
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(intent, nothing, "intent") })
}

/// Changes the targets and weights of `objective` and the boxes of `design`, from which an evaluator and a designer are
/// then made, into those of such light. Where nothing is wanted they stay as they are. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` for a step out of its range and for settings that are wrong already.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_intent_steer(
    intent: *const klieg_intent,
    objective: *mut klieg_objective,
    design: *mut klieg_design,
) -> klieg_status {
    free_call(|| {
        // SAFETY: the caller's pointers.
        let (intent, objective, design) = unsafe {
            let missing = |name: &str| Fault::argument(format!("{name} is NULL"));
            let intent = intent.as_ref().ok_or_else(|| missing("intent"))?;
            let objective = objective.as_mut().ok_or_else(|| missing("objective"))?;
            (intent, objective, design.as_mut().ok_or_else(|| missing("design"))?)
        };
        let &klieg_intent { brightness, contrast, mood } = intent;
        let mood = choice(&Mood::ALL, mood, "mood")?;
        let intent = Intent { brightness, contrast, mood, below: true };
        // SAFETY: the names are the caller's.
        let mut judged = unsafe { read_objective(objective) }?;
        let space = |space| as_box(space, design.intensities);
        let mut boxes = Boxes {
            key: space(&design.key)?,
            fill: space(&design.fill)?,
            rim: space(&design.rim)?,
        };
        intent.steer(&mut judged, &mut boxes)?;
        *objective = objective_in_c(&judged);
        let Boxes { key, fill, rim } = boxes;
        (design.key, design.fill, design.rim) = (box_in_c(&key), box_in_c(&fill), box_in_c(&rim));
        Ok(())
    })
}
