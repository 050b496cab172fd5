//! The views that one rig is designed for: cameras of the file, or around the scene, in one moment or in several.

mod judged;
mod pictures;

use super::config::Settings;
use super::values::{MOST_VIEWS, Size};
use super::view::{CameraKey, chosen, framing, size, view};
use crate::design::Over;
use crate::lighting::Stand;
use crate::scene::framing::around;
use crate::scene::view::{Camera, View};
use crate::scene::{self, Scene};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use std::sync::Arc;

pub(super) use judged::{evaluator, occluders, small_evaluator};
pub(super) use pictures::write as write_pictures;

/// What the cameras of several views are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "CamerasForm", into = "CamerasForm")]
pub enum Cameras {
    /// So many around the scene, with the angles of the framing for the first.
    Turntable(usize),
    /// All of the file.
    All,
    /// These of the file.
    Listed(Vec<CameraKey>),
}

/// How a configuration file writes [`Cameras`].
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "cameras are a number of them, \"all\", or a list of names")]
enum CamerasForm {
    Number(usize),
    Text(String),
    List(Vec<CameraKey>),
}

impl TryFrom<CamerasForm> for Cameras {
    type Error = String;

    fn try_from(form: CamerasForm) -> Result<Self, String> {
        match form {
            CamerasForm::Text(text) => text.parse(),
            CamerasForm::Number(number) if (2..=MOST_VIEWS).contains(&number) => {
                Ok(Self::Turntable(number))
            }
            CamerasForm::Number(number) => {
                Err(format!("{number} views: a turntable has 2 to {MOST_VIEWS}"))
            }
            CamerasForm::List(keys) if (1..=MOST_VIEWS).contains(&keys.len()) => {
                Ok(Self::Listed(keys))
            }
            CamerasForm::List(keys) => {
                Err(format!("{} cameras: there may be 1 to {MOST_VIEWS}", keys.len()))
            }
        }
    }
}

impl From<Cameras> for CamerasForm {
    fn from(cameras: Cameras) -> Self {
        match cameras {
            Cameras::Turntable(number) => Self::Number(number),
            Cameras::All => Self::Text("all".into()),
            Cameras::Listed(keys) => Self::List(keys),
        }
    }
}

impl FromStr for Cameras {
    type Err = String;

    /// A number is that of a turntable's views; what is neither that nor `all` are names or numbers of cameras.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "all" => Ok(Self::All),
            "" => Err("views are a number of them, all, or names of cameras".into()),
            text => match text.parse::<i64>() {
                Ok(number) => CamerasForm::Number(usize::try_from(number).unwrap_or(0)).try_into(),
                Err(_) => {
                    let keys = text.split(',').map(|name| CameraKey::Name(name.trim().into()));
                    CamerasForm::List(keys.collect()).try_into()
                }
            },
        }
    }
}

/// Several views of one rig.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ViewsSettings {
    /// Their cameras; that of the view alone where absent.
    pub cameras: Option<Cameras>,
    /// Whether the rig stands in the world or goes with the camera.
    pub rig: Stand,
    /// How the scores of all views become one.
    pub over: Over,
}

impl Settings {
    /// Whether several views are asked for.
    pub fn has_views(&self) -> bool {
        self.views.cameras.is_some() || self.times().len() > 1
    }

    /// The moments that are asked for; a single one without a time where none is.
    fn times(&self) -> Vec<Option<f32>> {
        self.pose.time.map_or(vec![None], |times| times.all().into_iter().map(Some).collect())
    }

    /// # Errors
    /// [`Error::Argument`] where several views are asked for.
    pub fn one_view(&self) -> Result<()> {
        if self.has_views() {
            let fault = "several views, of cameras (views) or of moments (time), are for the commands design, batch \
                         and score: this one looks at a single view";
            return Err(Error::Argument(fault.into()));
        }
        Ok(())
    }

    /// # Errors
    /// [`Error::Argument`] for views that exclude each other, and too many.
    pub fn check_views(&self) -> Result<()> {
        if self.views.cameras.is_some() && self.view.camera.is_some() {
            let fault = "a single camera and the cameras of several views exclude each other";
            return Err(Error::Argument(fault.into()));
        }
        let listed = matches!(self.views.cameras, Some(Cameras::All | Cameras::Listed(_)));
        if listed && self.view.framed() {
            let fault = "cameras of the file and the angles of a framing exclude each other";
            return Err(Error::Argument(fault.into()));
        }
        let cameras = match &self.views.cameras {
            Some(Cameras::Turntable(number)) => *number,
            Some(Cameras::Listed(keys)) => keys.len(),
            Some(Cameras::All) | None => 1,
        };
        check_number(self.times().len(), cameras)
    }
}

fn check_number(times: usize, cameras: usize) -> Result<()> {
    let views = times * cameras;
    if views <= MOST_VIEWS {
        return Ok(());
    }
    let product =
        if times > 1 { format!("{times} moments of {cameras} cameras, ") } else { String::new() };
    Err(Error::Argument(format!("{product}{views} views: there may be {MOST_VIEWS} at most")))
}

/// One of several views.
#[derive(Debug, Clone)]
pub struct Seen {
    /// What it shows, for people.
    pub title: String,
    /// The moment, seconds, where there are several.
    pub time: Option<f32>,
    /// The scene in that moment.
    pub scene: Arc<Scene>,
    /// The view.
    pub view: View,
}

impl Seen {
    /// The only view.
    pub fn single(scene: Arc<Scene>, view: View) -> Self {
        Self { title: title(&view.camera), time: None, scene, view }
    }
}

/// The views that the settings ask for, moment after moment, of a scene in the first moment: one where they ask for no
/// more.
///
/// # Errors
/// Faults of the settings and of the scene, and [`Error::Argument`] for a single view where several are asked for.
pub fn all(scene: &Arc<Scene>, settings: &Settings) -> Result<Vec<Seen>> {
    if !settings.has_views() {
        return Ok(vec![Seen::single(Arc::clone(scene), view(scene, &settings.view)?)]);
    }
    let moments = moments(scene, settings)?;
    let (size, cameras) = cameras(&moments, settings)?;
    let several = moments.len() > 1;
    let mut views = Vec::new();
    for ((time, scene), cameras) in moments.into_iter().zip(cameras) {
        for (mut title, camera) in cameras {
            if let (true, Some(time)) = (several, time) {
                title = format!("{title}, {time} s");
            }
            let view = View::new(&scene, camera, size[0], size[1])?;
            views.push(Seen { title, time, scene: Arc::clone(&scene), view });
        }
    }
    if views.len() < 2 {
        let fault =
            "there is one view alone: a rig for several wants two or more cameras, or moments";
        return Err(Error::input(&scene.path, fault));
    }
    Ok(views)
}

/// The scene in each moment; the first is there.
fn moments(scene: &Arc<Scene>, settings: &Settings) -> Result<Vec<(Option<f32>, Arc<Scene>)>> {
    let moment = |(at, time): (usize, Option<f32>)| match at {
        0 => Ok((time, Arc::clone(scene))),
        _ => {
            let loaded = scene::load::load_with(&scene.path, settings.loading_at(time))?;
            Ok((time, Arc::new(loaded)))
        }
    };
    settings.times().into_iter().enumerate().map(moment).collect()
}

/// A camera and what it shows, for people.
type Titled = (String, Camera);

/// The size of the pictures, and the cameras of each moment.
fn cameras(
    moments: &[(Option<f32>, Arc<Scene>)],
    settings: &Settings,
) -> Result<([u32; 2], Vec<Vec<Titled>>)> {
    let first = &moments[0].1;
    let in_each = |keys: &[CameraKey]| {
        let of = |scene: &Scene| {
            let camera = |key: &CameraKey| scene::camera::choose(scene, &key.text());
            keys.iter().map(camera).map(|camera| camera.map(|c| (title(&c), c))).collect()
        };
        moments.iter().map(|(_, scene)| of(scene)).collect::<Result<Vec<Vec<Titled>>>>()
    };
    let listed = match &settings.views.cameras {
        Some(Cameras::Listed(keys)) => Some(in_each(keys)?),
        Some(Cameras::All) => Some(in_each(&own_cameras(first, moments.len())?)?),
        None if chosen(first, &settings.view)?.is_some() => {
            let of = |scene: &Scene| {
                let camera = chosen(scene, &settings.view)?;
                Ok(camera.map(|camera| (title(&camera), camera)).into_iter().collect())
            };
            Some(moments.iter().map(|(_, scene)| of(scene)).collect::<Result<_>>()?)
        }
        _ => None,
    };
    let camera = listed.iter().flatten().flatten().next().map(|(_, camera)| camera);
    let Size([width, height]) = size(&settings.view, camera);
    let cameras = match listed {
        Some(listed) => listed,
        None => {
            let aspect = f64::from(width) / f64::from(height);
            vec![turntable(moments, settings, aspect, None)?; moments.len()]
        }
    };
    Ok(([width, height], cameras))
}

/// The numbers of all cameras of a file; not of klieg's own where it has others.
fn own_cameras(scene: &Scene, moments: usize) -> Result<Vec<CameraKey>> {
    let all = || scene.cameras.iter().enumerate();
    let others = all().any(|(_, camera)| camera.designed.is_none());
    let wanted = all().filter(|(_, camera)| !others || camera.designed.is_none());
    let keys: Vec<_> = wanted.map(|(at, _)| CameraKey::Index(at)).collect();
    if keys.is_empty() {
        let fault = "has no cameras: a number of views asks for a turntable, such as --views 8";
        return Err(Error::input(&scene.path, fault));
    }
    check_number(moments, keys.len()).map(|()| keys)
}

/// The cameras of the framing, in sight of all moments: as many as the settings' turntable has, or `count`.
fn turntable(
    moments: &[(Option<f32>, Arc<Scene>)],
    settings: &Settings,
    aspect: f64,
    count: Option<usize>,
) -> Result<Vec<Titled>> {
    let own = match settings.views.cameras {
        Some(Cameras::Turntable(number)) => number,
        _ => 1,
    };
    let scenes: Vec<&Scene> = moments.iter().map(|(_, scene)| &**scene).collect();
    let framing = framing(&settings.view);
    let count = count.unwrap_or(own);
    let titled = |(at, camera): (usize, Camera)| {
        let turned = framing.azimuth.to_degrees() + 360.0 * at as f64 / count as f64;
        (format!("azimuth {:.0}°", turned.rem_euclid(360.0)), camera)
    };
    Ok(around(&scenes, &framing, aspect, count)?.into_iter().enumerate().map(titled).collect())
}

/// The views of a turntable that turns in smaller steps than that of the settings, `steps` for each of its views; `None`
/// where the settings ask for something else.
///
/// # Errors
/// As [`all`].
pub(super) fn turning(
    first: &Seen,
    settings: &Settings,
    steps: usize,
) -> Result<Option<Vec<Seen>>> {
    let Some(Cameras::Turntable(number)) = settings.views.cameras else { return Ok(None) };
    if settings.times().len() > 1 {
        return Ok(None);
    }
    let View { width, height, .. } = first.view;
    let moments = [(first.time, Arc::clone(&first.scene))];
    let aspect = f64::from(width) / f64::from(height);
    let seen = |(title, camera): Titled| {
        let view = View::new(&first.scene, camera, width, height)?;
        Ok(Seen { title, view, ..first.clone() })
    };
    let cameras = turntable(&moments, settings, aspect, Some(number * steps))?;
    cameras.into_iter().map(seen).collect::<Result<_>>().map(Some)
}

fn title(camera: &Camera) -> String {
    if camera.name.is_empty() { "unnamed camera".into() } else { camera.name.clone() }
}
