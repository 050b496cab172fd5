//! Values that the command line and configuration files write the same way.

use crate::lighting::{MAX_LIGHTS, Role, check_number};
use crate::scene::view::MAX_SIDE;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display};
use std::str::FromStr;

/// Picture size, `WxH` pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Size(pub [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || format!("'{text}' is not a size WxH of 1 to {MAX_SIDE} pixels a side");
        let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(fault)?;
        let side = |text: &str| {
            text.trim().parse().ok().filter(|side| (1..=MAX_SIDE).contains(side)).ok_or_else(fault)
        };
        Ok(Self([side(width)?, side(height)?]))
    }
}

impl Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

/// What computes.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Device {
    /// A discrete GPU, else an integrated one, else the native CPU evaluator.
    #[default]
    Auto,
    /// The best Vulkan device, software ones last.
    Vulkan,
    /// The native CPU evaluator.
    Cpu,
    /// By its number in `klieg devices`.
    Index(usize),
    /// By a part of its name, in any case.
    Name(String),
}

impl FromStr for Device {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "" => return Err("a device needs a name".into()),
            "auto" => Self::Auto,
            "vulkan" => Self::Vulkan,
            "cpu" => Self::Cpu,
            _ => text.parse().map_or_else(|_| Self::Name(text.into()), Self::Index),
        })
    }
}

impl Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Vulkan => f.write_str("vulkan"),
            Self::Cpu => f.write_str("cpu"),
            Self::Index(index) => write!(f, "{index}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

text_form!(Size, Device);

/// Most views that one rig is designed for.
pub const MOST_VIEWS: usize = 64;

/// A moment of an animation, seconds, or several: `start:end:step`, the end included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TimesForm", into = "TimesForm")]
pub struct Times {
    start: f32,
    end: f32,
    step: f32,
}

/// How a configuration file writes [`Times`].
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "times are seconds, or \"start:end:step\"")]
enum TimesForm {
    One(f32),
    Several(String),
}

impl Times {
    /// All of them; never none.
    pub fn all(&self) -> Vec<f32> {
        let at = |number| (f64::from(self.start) + number as f64 * f64::from(self.step)) as f32;
        (0..self.count()).map(at).collect()
    }

    /// The first of them.
    pub fn first(&self) -> f32 {
        self.start
    }

    fn count(&self) -> usize {
        let Self { start, end, step } = self;
        // Steps in decimal fractions reach the end but for rounding.
        let steps = f64::from(end - start) / f64::from(*step);
        if *step > 0.0 { (steps + 1e-4).min(1e6) as usize + 1 } else { 1 }
    }
}

impl From<f32> for Times {
    fn from(time: f32) -> Self {
        Self { start: time, end: time, step: 0.0 }
    }
}

impl FromStr for Times {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = |fault: &str| format!("'{text}' {fault}");
        let number = |text: &str| text.trim().parse::<f32>().ok().filter(|time| time.is_finite());
        let parts: Option<Vec<f32>> = text.split(':').map(number).collect();
        let times = match parts.as_deref() {
            Some(&[time]) => return Ok(time.into()),
            Some(&[start, end, step]) => Self { start, end, step },
            _ => return Err(fault("is neither seconds nor start:end:step in seconds")),
        };
        if times.step <= 0.0 || times.end < times.start {
            return Err(fault(
                "leads nowhere: the step must be above 0, and the end not before the start",
            ));
        }
        match times.count() {
            count if count > MOST_VIEWS => {
                Err(fault(&format!("has {count} moments: there may be {MOST_VIEWS} at most")))
            }
            _ => Ok(times),
        }
    }
}

impl Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { start, end, step } = self;
        if *step > 0.0 { write!(f, "{start}:{end}:{step}") } else { write!(f, "{start}") }
    }
}

impl TryFrom<TimesForm> for Times {
    type Error = String;

    fn try_from(form: TimesForm) -> Result<Self, String> {
        match form {
            TimesForm::One(time) => Ok(time.into()),
            TimesForm::Several(text) => text.parse(),
        }
    }
}

impl From<Times> for TimesForm {
    fn from(times: Times) -> Self {
        match times.step > 0.0 {
            true => Self::Several(times.to_string()),
            false => Self::One(times.start),
        }
    }
}

/// The lights of a rig: a number of them, or their roles.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "LightsForm", into = "Vec<Role>")]
pub struct Lights(pub Vec<Role>);

/// How a configuration file writes [`Lights`].
#[derive(Deserialize)]
#[serde(untagged, expecting = "lights are a number of them, or a list of roles: key, fill, rim")]
enum LightsForm {
    Number(usize),
    Roles(Vec<Role>),
}

impl Lights {
    /// Key, fill, rim, then fill and rim in turn.
    pub fn number(n: usize) -> Result<Self, String> {
        let role = |i| match i {
            0 => Role::Key,
            i if i % 2 == 1 => Role::Fill,
            _ => Role::Rim,
        };
        Self::of((0..n.min(MAX_LIGHTS + 1)).map(role).collect(), n)
    }

    fn of(roles: Vec<Role>, n: usize) -> Result<Self, String> {
        check_number(n).map_err(|fault| fault.to_string())?;
        Ok(Self(roles))
    }
}

impl Default for Lights {
    /// A key and a fill.
    fn default() -> Self {
        Self(vec![Role::Key, Role::Fill])
    }
}

impl TryFrom<LightsForm> for Lights {
    type Error = String;

    fn try_from(form: LightsForm) -> Result<Self, String> {
        match form {
            LightsForm::Number(n) => Self::number(n),
            LightsForm::Roles(roles) => {
                let n = roles.len();
                Self::of(roles, n)
            }
        }
    }
}

impl From<Lights> for Vec<Role> {
    fn from(lights: Lights) -> Self {
        lights.0
    }
}

impl FromStr for Lights {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Ok(n) = text.trim().parse() {
            return Self::number(n);
        }
        let roles = text.split(',').map(role).collect::<Result<Vec<_>, _>>()?;
        let n = roles.len();
        Self::of(roles, n)
    }
}

/// A role that is searched, by its name.
///
/// # Errors
/// The names that there are.
pub fn role(name: &str) -> Result<Role, String> {
    let searched = Role::ALL.into_iter().filter(|role| *role != Role::Scene);
    searched.clone().find(|role| role.name() == name.trim()).ok_or_else(|| {
        let names: Vec<_> = searched.map(Role::name).collect();
        format!("'{name}' is none of {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused<T: FromStr>(texts: &[&str]) {
        texts.iter().for_each(|text| assert!(text.parse::<T>().is_err(), "{text}"));
    }

    #[test]
    fn sizes() {
        assert_eq!("640x360".parse(), Ok(Size([640, 360])));
        refused::<Size>(&["", "0x1", "1x16385", "-1x5", "512", "1x2x3", "axb"]);
    }

    #[test]
    fn times_are_one_or_several() {
        let all = |text: &str| text.parse::<Times>().unwrap().all();
        assert_eq!(all("0.5"), [0.5]);
        assert_eq!(all("0:2:0.25"), [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0]);
        assert_eq!(all("0:0.3:0.1"), [0.0, 0.1, 0.2, 0.3]);
        assert_eq!((all("1:2:0.6"), all("1:1:1")), (vec![1.0, 1.6], vec![1.0]));
        refused::<Times>(&["", "a", "0:1", "0:1:0", "0:1:-1", "2:1:1", "0:inf:1", "0:1:1:1"]);
        refused::<Times>(&["0:65:1", "0:1:1e-30"]);
        assert_eq!(all("0:63:1").len(), MOST_VIEWS);
        for text in ["0:2:0.25", "1.5"] {
            assert_eq!(text.parse::<Times>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn devices() {
        let parse = |text: &str| text.parse::<Device>().unwrap();
        assert_eq!(parse("auto"), Device::Auto);
        assert_eq!(parse("2"), Device::Index(2));
        assert_eq!(parse("llvmpipe"), Device::Name("llvmpipe".into()));
        refused::<Device>(&[""]);
    }

    #[test]
    fn lights_by_number_and_by_role() {
        use Role::{Fill, Key, Rim};
        assert_eq!("5".parse(), Ok(Lights(vec![Key, Fill, Rim, Fill, Rim])));
        assert_eq!("key, rim".parse(), Ok(Lights(vec![Key, Rim])));
        assert_eq!(Lights::number(2), Ok(Lights::default()));
        refused::<Lights>(&["0", "17", "99999999999", "", "key,", "back", &["rim"; 17].join(",")]);
    }
}
