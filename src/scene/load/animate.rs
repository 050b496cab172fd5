//! Animations (glTF 2.0, 3.11): where nodes stand, and what morph weights they have, at one moment.

use super::accessor::{Accessors, NUMBERS, Wanted};
use super::contents::AnimationInfo;
use super::document::{Document, Place};
use super::elements::Elements;
use super::{Parsed, quoted, warn};
use glam::{DMat4, DQuat, DVec3};
use gltf::json::Index;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::animation::{Animation, Channel, Interpolation, Property, Sampler};
use gltf::json::validation::Checked;
use std::collections::HashMap;

/// The moment in which a scene's moving parts are shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Moment {
    /// The first animation's beginning, as viewers show a file that they have just opened; where there is
    /// none, [`Moment::Rest`].
    #[default]
    Start,
    /// As the file's nodes stand, and with its default morph weights, whatever moves them.
    Rest,
    /// A moment of an animation.
    At {
        /// Its name, or its place among the file's animations; the first one where absent.
        animation: Option<String>,
        /// Seconds. Before its first and after its last key frame an animation stands still.
        time: f32,
    },
}

impl Moment {
    /// What is shown of a file with these animations, for people.
    pub fn in_words(&self, animations: &[AnimationInfo]) -> String {
        let (key, time) = match self {
            Self::Start if !animations.is_empty() => (None, 0.0),
            Self::Start | Self::Rest => return "as its nodes stand in the file".into(),
            Self::At { animation, time } => (animation.as_deref(), *time),
        };
        match key.or(animations.first().map(|first| &*first.name)).filter(|name| !name.is_empty()) {
            Some(name) => format!("animation {} at {time} s", quoted(name)),
            None => format!("its first animation at {time} s"),
        }
    }
}

/// What an animation makes of nodes.
#[derive(Default)]
pub struct Moved {
    /// Places of nodes in their parents.
    pub places: HashMap<usize, Place>,
    /// Morph weights of nodes.
    pub weights: HashMap<usize, Vec<f32>>,
}

/// Where `moment` puts the nodes of a file; a first animation that cannot be read moves nothing, with a
/// warning.
///
/// # Errors
/// An animation that was asked for and is not there, or cannot be read.
pub fn at(
    document: &Document,
    accessors: &Accessors,
    moment: &Moment,
    warnings: &mut Vec<String>,
) -> Parsed<Moved> {
    let animations = &document.root.animations;
    let (animation, time) = match moment {
        Moment::Rest => return Ok(Moved::default()),
        Moment::Start => match animations.first() {
            None => return Ok(Moved::default()),
            Some(first) => {
                let moved = moved(document, accessors, first, 0.0);
                return Ok(moved.unwrap_or_else(|fault| {
                    let text = format!("its first animation cannot be read ({fault}): left out");
                    warn(warnings, text);
                    Moved::default()
                }));
            }
        },
        Moment::At { animation, time } => (animation.as_deref(), *time),
    };
    if !(time.is_finite() && time >= 0.0) {
        return Err(format!("time {time}: it must be 0 seconds or more"));
    }
    let animation = chosen(animations, animation)?;
    moved(document, accessors, animation, time).map_err(|fault| match &animation.name {
        Some(name) => format!("animation {}: {fault}", quoted(name)),
        None => format!("its animation: {fault}"),
    })
}

/// The animation of a name, or of a place in the list.
fn chosen<'a>(animations: &'a [Animation], key: Option<&str>) -> Parsed<&'a Animation> {
    let first = animations.first().ok_or("has no animations")?;
    let Some(key) = key else { return Ok(first) };
    let named = animations.iter().find(|animation| animation.name.as_deref() == Some(key));
    let placed = || animations.get(key.parse::<usize>().ok()?);
    named.or_else(placed).ok_or_else(|| {
        let name = |(at, a): (usize, &Animation)| match &a.name {
            Some(name) => format!("{at} {}", quoted(name)),
            None => at.to_string(),
        };
        let names: Vec<_> = animations.iter().enumerate().take(20).map(name).collect();
        format!("has no animation {}: it has {}", quoted(key), names.join(", "))
    })
}

/// What an animation makes of the nodes at `time`.
fn moved(
    document: &Document,
    accessors: &Accessors,
    animation: &Animation,
    time: f32,
) -> Parsed<Moved> {
    let mut moved = Moved::default();
    for (index, channel) in animation.channels.iter().enumerate() {
        move_node(document, accessors, (animation, channel), time, &mut moved)
            .map_err(|fault| format!("channels[{index}]: {fault}"))?;
    }
    Ok(moved)
}

fn move_node(
    document: &Document,
    accessors: &Accessors,
    (animation, channel): (&Animation, &Channel),
    time: f32,
    moved: &mut Moved,
) -> Parsed<()> {
    let node = channel.target.node.value();
    let sampler =
        animation.samplers.get(channel.sampler.value()).ok_or("its sampler is not there")?;
    let own = document.places.get(node).ok_or("its node is not there")?;
    let place = moved.places.entry(node).or_insert_with(|| apart(own));
    let curve = |kind| Curve::open(accessors, sampler, kind);
    match channel.target.path {
        Checked::Valid(Property::Translation) => {
            place.translation = Some(curve(Type::Vec3)?.vector(time)?);
        }
        Checked::Valid(Property::Scale) => place.scale = Some(curve(Type::Vec3)?.vector(time)?),
        Checked::Valid(Property::Rotation) => {
            place.rotation = Some(curve(Type::Vec4)?.rotation(time)?);
        }
        Checked::Valid(Property::MorphTargetWeights) => {
            moved.weights.insert(node, curve(Type::Scalar)?.weights(time)?);
        }
        Checked::Invalid => return Err("its path is none of glTF's".into()),
    }
    Ok(())
}

/// A place as its three parts, which animations move one by one.
fn apart(place: &Place) -> Place {
    let Some(matrix) = &place.matrix else { return place.clone() };
    let matrix = DMat4::from_cols_array(matrix);
    let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
    Place {
        matrix: None,
        translation: Some(translation.to_array()),
        rotation: Some(rotation.to_array()),
        scale: Some(scale.to_array()),
    }
}

/// The key frames of a sampler.
struct Curve<'a> {
    times: Elements<'a>,
    values: Elements<'a>,
    interpolation: Interpolation,
    /// Elements of `values` for each key frame.
    each: usize,
}

/// The place of a moment among key frames.
struct Between {
    /// The key frames before and after it; the same where it stands still.
    frames: [usize; 2],
    /// 0 at the first, 1 at the second.
    share: f32,
    /// Seconds between them.
    seconds: f32,
}

impl<'a> Curve<'a> {
    fn open(accessors: &Accessors<'a>, sampler: &Sampler, kind: Type) -> Parsed<Self> {
        let Checked::Valid(interpolation) = sampler.interpolation else {
            return Err("its interpolation is none of glTF's".into());
        };
        let open = |index: Index<Accessor>, types: &[Type], components: &[ComponentType]| {
            accessors.open(index, &Wanted { types, components, normalized: true })
        };
        let times = open(sampler.input, &[Type::Scalar], &[ComponentType::F32])?;
        let values = open(sampler.output, &[kind], NUMBERS)?;
        let each = values.count().checked_div(times.count()).ok_or("it has no key frames")?;
        let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let whole = each > 0
            && each * times.count() == values.count()
            && each % parts == 0
            && (kind == Type::Scalar || each == parts);
        if !whole {
            let (times, values) = (times.count(), values.count());
            return Err(format!("it has {values} values for {times} key frames"));
        }
        Ok(Self { times, values, interpolation, each })
    }

    fn time(&self, frame: usize) -> f32 {
        self.times.floats::<1>(frame)[0]
    }

    fn between(&self, time: f32) -> Between {
        let (mut low, mut high) = (0, self.times.count());
        // The last key frame at or before the moment.
        while low < high {
            let middle = low + (high - low) / 2;
            if self.time(middle) <= time { low = middle + 1 } else { high = middle }
        }
        let first = low.saturating_sub(1);
        let second = if low == 0 { 0 } else { low.min(self.times.count() - 1) };
        let seconds = self.time(second) - self.time(first);
        let share = if seconds > 0.0 { (time - self.time(first)) / seconds } else { 0.0 };
        Between { frames: [first, second], share, seconds }
    }

    /// Value `at` of `count` that each key frame has, of `N` components, at a moment.
    fn value<const N: usize>(&self, between: &Between, at: usize, count: usize) -> [f64; N] {
        let Between { frames: [first, second], share, seconds } = *between;
        let element = |frame: usize, part: usize| {
            self.values.floats::<N>(frame * self.each + part * count + at)
        };
        let t = f64::from(share);
        match self.interpolation {
            Interpolation::Step => element(first, 0).map(f64::from),
            Interpolation::Linear => {
                let (a, b) = (element(first, 0), element(second, 0));
                std::array::from_fn(|k| (1.0 - t) * f64::from(a[k]) + t * f64::from(b[k]))
            }
            Interpolation::CubicSpline => {
                let (a, b) = (element(first, 1), element(second, 1));
                let (leave, arrive) = (element(first, 2), element(second, 0));
                let (t2, t3, d) = (t * t, t * t * t, f64::from(seconds));
                std::array::from_fn(|k| {
                    let [a, b, leave, arrive] = [a[k], b[k], leave[k], arrive[k]].map(f64::from);
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a
                        + d * (t3 - 2.0 * t2 + t) * leave
                        + (3.0 * t2 - 2.0 * t3) * b
                        + d * (t3 - t2) * arrive
                })
            }
        }
    }

    fn vector(&self, time: f32) -> Parsed<[f64; 3]> {
        let value = DVec3::from(self.value::<3>(&self.between(time), 0, 1));
        value.is_finite().then(|| value.to_array()).ok_or_else(|| NOT_FINITE.into())
    }

    fn rotation(&self, time: f32) -> Parsed<[f64; 4]> {
        let between = self.between(time);
        let value = match self.interpolation {
            Interpolation::Linear => {
                let [a, b] = between.frames.map(|frame| {
                    DQuat::from_array(self.values.floats::<4>(frame).map(f64::from)).normalize()
                });
                a.slerp(b, f64::from(between.share))
            }
            _ => DQuat::from_array(self.value::<4>(&between, 0, 1)).normalize(),
        };
        value.is_finite().then(|| value.to_array()).ok_or_else(|| NOT_FINITE.into())
    }

    fn weights(&self, time: f32) -> Parsed<Vec<f32>> {
        let parts = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let (count, between) = (self.each / parts, self.between(time));
        if count > MAX_TARGETS {
            return Err(format!("it has weights of {count} morph targets"));
        }
        let weights: Vec<f32> =
            (0..count).map(|at| self.value::<1>(&between, at, count)[0] as f32).collect();
        let finite = weights.iter().all(|weight| weight.is_finite());
        finite.then_some(weights).ok_or_else(|| NOT_FINITE.into())
    }
}

/// Most morph targets of a mesh.
const MAX_TARGETS: usize = 1 << 16;

const NOT_FINITE: &str = "it has a value that is not finite";
