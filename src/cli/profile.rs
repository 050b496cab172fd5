//! The option that names a profile.

use crate::design::profile::{self, Profile};
use crate::session::profile::ProfileName;
use clap::Args;

/// What `--profile` does.
fn help() -> String {
    format!(
        "Defaults of what pictures are judged by, of how surfaces reflect, of the lights and of the values \
         that they may have [default: the configuration file's, else {}; for study and bench paper]",
        profile::DEFAULT.name
    )
}

/// What settings start from.
#[derive(Debug, Args)]
pub(super) struct ProfileOptions {
    #[arg(long, value_name = "PROFILE", value_parser = ProfileName::parser(), help = help())]
    profile: Option<ProfileName>,
}

impl ProfileOptions {
    /// The profile that is asked for.
    pub fn asked(&self) -> Option<&'static Profile> {
        self.profile.map(|name| name.0)
    }
}
