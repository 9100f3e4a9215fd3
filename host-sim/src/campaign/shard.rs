//! A campaign split over machines, and joined again.

use super::tally::Tally;
use anyhow::{Result, anyhow, ensure};
use serde::{Deserialize, Serialize};

/// Changes when the same seed no longer draws the same runs, or the counts mean something else.
pub const SCHEMA: u32 = 1;

/// What decides which runs there are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Campaign {
    /// Of what makes and counts the runs.
    pub schema: u32,
    /// The campaign's seed.
    pub seed: u64,
    /// Runs of all shards together.
    pub runs: u64,
    /// Every run has this fault.
    pub fault: Option<String>,
    /// Every run has this program.
    pub sequence: Option<String>,
}

/// Which of the runs: those whose number leaves `number - 1` when divided by `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// From 1.
    pub number: u64,
    /// How many there are.
    pub of: u64,
}

impl Shard {
    /// All runs.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// From `I/N`.
    ///
    /// # Errors
    /// When it is not of that form with 1 <= I <= N.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} is no shard: I/N with I from 1 to N, as in 2/8");
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let shard = Self { number: number.parse().map_err(|_| wrong())?, of: of.parse().map_err(|_| wrong())? };
        if (1..=shard.of).contains(&shard.number) { Ok(shard) } else { Err(wrong()) }
    }

    /// How many of so many runs are its own.
    #[must_use]
    pub fn runs(self, of_all: u64) -> u64 {
        of_all.saturating_sub(self.number - 1).div_ceil(self.of)
    }

    /// The number of its run at this place.
    #[must_use]
    pub fn index(self, place: u64) -> u64 {
        place * self.of + self.number - 1
    }
}

/// A campaign's result, or a part of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Which campaign.
    pub campaign: Campaign,
    /// Which part of it; none when it is the whole.
    pub shard: Option<Shard>,
    /// What came out.
    pub result: Tally,
}

impl Part {
    /// As it is written to files: the same counts give the same bytes.
    ///
    /// # Errors
    /// When it cannot be serialised.
    pub fn json(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// Joins all parts of one campaign; each comes with its file's name.
///
/// # Errors
/// Names the file that is of another campaign, comes twice or is no part, and the parts that are missing.
pub fn merge(parts: &[(String, String)]) -> Result<Part> {
    let mut read = Vec::new();
    for (name, text) in parts {
        let part: Part =
            serde_json::from_str(text).map_err(|error| anyhow!("{name} is no part of a campaign: {error}"))?;
        ensure!(
            part.campaign.schema == SCHEMA,
            "{name} was made by another version: its schema is {}, this one's {SCHEMA}",
            part.campaign.schema
        );
        let shard = part.shard.unwrap_or(Shard::WHOLE);
        ensure!((1..=shard.of).contains(&shard.number), "{name} says that it is shard {}/{}", shard.number, shard.of);
        let expected = shard.runs(part.campaign.runs);
        ensure!(part.result.runs == expected, "{name} has {} runs where its shard has {expected}", part.result.runs);
        read.push((name, shard, part));
    }
    let Some((first_name, Shard { of, .. }, first)) = read.first() else {
        return Err(anyhow!("nothing to merge: name the shards' files"));
    };
    let mut seen: Vec<Option<&str>> = Vec::new();
    let mut result = Tally::new();
    for (name, shard, part) in &read {
        ensure!(
            part.campaign == first.campaign,
            "{name} is of another campaign than {first_name}: seed, runs or filters differ"
        );
        ensure!(shard.of == *of, "{name} is a shard of {} and {first_name} one of {of}", shard.of);
        let place = shard.number as usize - 1;
        if seen.len() <= place {
            seen.resize(place + 1, None);
        }
        if let Some(other) = seen[place] {
            return Err(anyhow!("{other} and {name} are both shard {}/{of}", shard.number));
        }
        seen[place] = Some(name);
        result.add(&part.result);
    }
    if read.len() as u64 != *of {
        let there = |number: u64| seen.get(number as usize - 1).copied().flatten().is_some();
        let missing: Vec<_> =
            (1..=*of).filter(|&number| !there(number)).take(20).map(|number| format!("{number}/{of}")).collect();
        return Err(anyhow!("missing: shard {}", missing.join(", ")));
    }
    Ok(Part { campaign: first.campaign.clone(), shard: None, result })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(seed: u64, runs: u64, number: u64, of: u64) -> (String, String) {
        let campaign = Campaign { schema: SCHEMA, seed, runs, fault: None, sequence: None };
        let shard = Shard { number, of };
        let result = Tally { runs: shard.runs(runs), ..Tally::new() };
        let part = Part { campaign, shard: Some(shard), result };
        (format!("{number}-of-{of}.json"), part.json().expect("JSON"))
    }

    #[test]
    fn shards_share_the_runs() {
        for (runs, of) in [(10, 3), (3, 5), (7, 7), (100, 1)] {
            let mut all: Vec<u64> = (1..=of)
                .flat_map(|number| {
                    let shard = Shard { number, of };
                    (0..shard.runs(runs)).map(move |place| shard.index(place)).collect::<Vec<_>>()
                })
                .collect();
            all.sort_unstable();
            assert_eq!(all, (0..runs).collect::<Vec<_>>());
        }
        assert_eq!(Shard::parse("2/8"), Ok(Shard { number: 2, of: 8 }));
        for wrong in ["0/3", "4/3", "1", "a/b", "1/0", "-1/2", ""] {
            assert!(Shard::parse(wrong).expect_err("refused").contains("I/N"), "{wrong}");
        }
    }

    #[test]
    fn a_campaign_is_joined_from_all_its_parts_and_no_others() {
        let whole = merge(&[part(1, 10, 2, 3), part(1, 10, 1, 3), part(1, 10, 3, 3)]).expect("all there");
        assert_eq!((whole.result.runs, whole.shard), (10, None));
        let refused = |parts: &[(String, String)], named: &str| {
            let error = merge(parts).expect_err(named).to_string();
            assert!(error.contains(named), "{error}");
        };
        refused(&[part(1, 10, 1, 3), part(1, 10, 3, 3)], "missing: shard 2/3");
        refused(&[part(1, 10, 1, 2), part(1, 10, 1, 2)], "both shard 1/2");
        refused(&[part(1, 10, 1, 2), part(2, 10, 2, 2)], "2-of-2.json is of another campaign");
        refused(&[part(1, 10, 1, 2), part(1, 10, 2, 3)], "2-of-3.json is a shard of 3");
        refused(&[("x.json".to_owned(), "{}".to_owned())], "x.json is no part");
        refused(&[], "nothing to merge");
        let (name, text) = part(1, 10, 1, 1);
        refused(&[(name.clone(), text.replace("\"schema\": 1", "\"schema\": 99"))], "another version");
        refused(
            &[(name, text.replace("\"runs\": 10,\n    \"simulated", "\"runs\": 9,\n    \"simulated"))],
            "has 9 runs",
        );
    }
}
