//! Profiles as the command line and configuration files name them.

use crate::design::profile::{self, PROFILES, Profile};
use crate::{Error, Result};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::{Deserialize, Serialize};

/// A profile by its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ProfileName(pub &'static Profile);

impl Default for ProfileName {
    fn default() -> Self {
        Self(profile::DEFAULT)
    }
}

impl TryFrom<String> for ProfileName {
    type Error = Error;

    fn try_from(name: String) -> Result<Self> {
        Profile::named(&name).map(Self)
    }
}

impl From<ProfileName> for String {
    fn from(ProfileName(profile): ProfileName) -> Self {
        profile.name.into()
    }
}

impl ProfileName {
    /// How clap reads it: help lists all of them.
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        let value = |profile: &&Profile| PossibleValue::new(profile.name).help(profile.meaning);
        PossibleValuesParser::new(PROFILES.iter().map(value)).try_map(Self::try_from)
    }
}
