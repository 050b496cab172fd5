//! Optimisers as the command line and configuration files name them.

use crate::optimize::{Entry, OPTIMIZERS, find};
use crate::{Error, Result};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::{Deserialize, Serialize};

/// An optimiser by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct OptimizerName(pub &'static Entry);

impl TryFrom<String> for OptimizerName {
    type Error = Error;

    fn try_from(name: String) -> Result<Self> {
        find(&name).map(Self)
    }
}

impl From<OptimizerName> for String {
    fn from(OptimizerName(entry): OptimizerName) -> Self {
        entry.name.into()
    }
}

impl OptimizerName {
    /// How clap reads it: help lists all of them.
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        let value = |entry: &Entry| PossibleValue::new(entry.name).help(entry.description);
        PossibleValuesParser::new(OPTIMIZERS.iter().map(value)).try_map(Self::try_from)
    }
}
