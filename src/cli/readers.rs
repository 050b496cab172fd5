//! What reads files that people write, without the commands around it: for the fuzz targets.

use super::batch;
use super::config::Settings;
use super::rig as rigs;
use crate::Result;
use crate::design::profile;
use crate::lighting::Rig;
use crate::scene::view::View;
use std::path::Path;

/// A configuration file, checked.
///
/// # Errors
/// [`crate::Error::Input`], and [`crate::Error::Argument`] for a setting out of its range.
pub fn settings(path: &Path) -> Result<Settings> {
    let settings = Settings::read(path, None, profile::DEFAULT)?;
    settings.check()?;
    settings.genome()?;
    Ok(settings)
}

/// The number of designs that a list asks for.
///
/// # Errors
/// [`crate::Error::Input`].
pub fn list(path: &Path) -> Result<usize> {
    let out = path.with_file_name("out");
    Ok(batch::gather(&[path.into()], &out, &Settings::default())?.len())
}

/// The rig of a file, as `klieg render` takes it.
///
/// # Errors
/// [`crate::Error::Input`], and [`crate::Error::Argument`] for too many lights.
pub fn rig(path: &Path, view: &View) -> Result<Rig> {
    rigs::read(path, view)
}
