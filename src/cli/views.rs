//! Options of rigs for several views.

use super::config::{Cameras, Settings};
use crate::design::Over;
use crate::lighting::Stand;
use clap::Args;

/// The views that one rig is for.
#[derive(Debug, Args)]
pub(super) struct ViewsOptions {
    /// Judge one rig by several views: by so many around the scene, from the framing's azimuth on; by 'all' cameras of the
    /// file; or by some, such as front,back [default: one view]
    #[arg(long, value_name = "N|all|NAMES", conflicts_with = "camera", allow_hyphen_values = true)]
    views: Option<Cameras>,
    /// What the rig of several views stands in: the world, where it stays in its place, or the camera, with which it goes
    /// [default: world]
    #[arg(long = "rig", value_name = "world|camera")]
    stand: Option<Stand>,
    /// How the scores of several views become one: their mean, or that of the worst [default: mean]
    #[arg(long, value_name = "mean|worst")]
    over: Option<Over>,
}

impl ViewsOptions {
    /// Puts these options in the place of `settings`.
    pub fn apply(&self, settings: &mut Settings) {
        let views = &mut settings.views;
        if self.views.is_some() {
            settings.view.camera = None;
        }
        views.cameras = self.views.clone().or(views.cameras.take());
        views.rig = self.stand.unwrap_or(views.rig);
        views.over = self.over.unwrap_or(views.over);
    }
}
