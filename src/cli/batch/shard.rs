//! The part of a batch that one machine of many makes.

use std::str::FromStr;

/// Where job arrays say which of their jobs this is, and the number of their first job, or where that stands: Slurm,
/// Kubernetes' indexed jobs, AWS Batch.
const ARRAYS: [(&str, Option<&str>); 3] = [
    ("SLURM_ARRAY_TASK_ID", Some("SLURM_ARRAY_TASK_MIN")),
    ("JOB_COMPLETION_INDEX", None),
    ("AWS_BATCH_JOB_ARRAY_INDEX", None),
];

/// Every so many-th item, from one of the first on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 0.
    index: usize,
    count: usize,
}

impl Shard {
    /// The items of this shard.
    pub fn of<T>(self, items: Vec<T>) -> Vec<T> {
        items.into_iter().skip(self.index).step_by(self.count).collect()
    }

    /// What its files are named after.
    pub fn stem(self) -> String {
        format!("batch-{}-of-{}", self.index + 1, self.count)
    }

    /// `array` has the place that a job array gives, by its variables.
    fn parse(text: &str, variable: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        let (place, count) = text.split_once('/').ok_or("not of the form 3/16")?;
        let count = number(count).filter(|&count| count > 0).ok_or("not so many shards")?;
        let index = if place.trim() == "array" {
            let of = |name: &str| number(&variable(name)?);
            let place = |&(name, first): &(&str, Option<&str>)| {
                of(name)?.checked_sub(first.and_then(of).unwrap_or(0))
            };
            ARRAYS.iter().find_map(place).ok_or_else(|| {
                format!(
                    "this is no job of an array: none of {} is set",
                    ARRAYS.map(|(name, _)| name).join(", ")
                )
            })?
        } else {
            let place = number(place).ok_or("not of the form 3/16")?;
            place.checked_sub(1).ok_or("shards are counted from 1")?
        };
        match index < count {
            true => Ok(Self { index, count }),
            false => Err(format!("there is no shard {} of {count}", index + 1)),
        }
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::parse(text, |name| std::env::var(name).ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str, variables: &[(&str, &str)]) -> Result<Shard, String> {
        let value = |name: &str| variables.iter().find(|(known, _)| *known == name);
        Shard::parse(text, |name| value(name).map(|(_, value)| (*value).to_owned()))
    }

    #[test]
    fn each_item_is_in_one_shard() {
        let shards = (1..=3).map(|place| parse(&format!("{place}/3"), &[]).unwrap());
        let mut all: Vec<_> = shards.flat_map(|shard| shard.of((0..8).collect())).collect();
        assert_eq!(all, [0, 3, 6, 1, 4, 7, 2, 5]);
        all.sort_unstable();
        assert!(all.into_iter().eq(0..8));
        assert_eq!(parse("3/16", &[]).unwrap().stem(), "batch-3-of-16");
        assert!(parse("5/5", &[]).unwrap().of(vec![0, 1]).is_empty());
    }

    #[test]
    fn job_arrays_say_their_place() {
        for (variables, index) in [
            (&[("SLURM_ARRAY_TASK_ID", "7"), ("SLURM_ARRAY_TASK_MIN", "5")][..], 2),
            (&[("SLURM_ARRAY_TASK_ID", "7")], 7),
            (&[("JOB_COMPLETION_INDEX", "0")], 0),
            (&[("AWS_BATCH_JOB_ARRAY_INDEX", "8")], 8),
        ] {
            assert_eq!(parse("array/9", variables), Ok(Shard { index, count: 9 }));
        }
        let faults = ["array/9", "0/3", "4/3", "1/0", "1", "-1/3", "a/b", "1/2/3"];
        assert!(faults.iter().all(|text| parse(text, &[]).is_err()));
        assert!(parse("array/2", &[("JOB_COMPLETION_INDEX", "2")]).is_err());
    }
}
