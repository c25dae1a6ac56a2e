//! Parts of a campaign that are flown apart, each a Parquet file: rows for whoever reads Parquet, and in its
//! metadata what the part belongs to and its statistics, for `samara merge`.
//!
//! | file | holds |
//! |---|---|
//! | [`table`] | rows as columns of [Parquet](https://parquet.apache.org/docs/file-format/), in row groups |
//! | [`rows`] | the rows of flights from t = 0 and of whole drops |
//! | [`summary`] | statistics of a part as JSON, to the last bit |
//! | `seal` | the SHA-256 of a part's file in its own metadata |
//! | this one | what a part belongs to |
//!
//! A part's bytes depend on the campaign's inputs and on where it is cut, not on who flies it or when.

pub mod rows;
mod seal;
pub mod summary;
pub mod table;

use std::ops::Range;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::campaign::Keep;
pub use table::{ShardReader, ShardWriter, Table, Values};

/// What a part belongs to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShardHead {
    /// Name of the mission.
    pub mission: String,
    /// Version of samara.
    pub version: String,
    /// Seed of everything random.
    pub seed: u64,
    /// SHA-256 of all inputs, hexadecimal.
    pub input_hash: String,
    /// Name of the autopilot that flew whole drops; `None`: flights from t = 0 by the mission's own gains.
    pub autopilot: Option<String>,
    /// Version of the autopilot, where it reports one.
    pub autopilot_version: Option<String>,
    /// Trials of the whole campaign.
    pub trials: u64,
    /// J_TPF that a safe trial stays below.
    pub bound: f64,
    /// Rows that are kept.
    pub keep: Keep,
    /// First trial of the part.
    pub first: u64,
    /// Trial after the last of the part.
    pub end: u64,
    /// Arguments of `samara assess` that fly the campaign.
    pub arguments: Vec<String>,
}

/// A part is of another campaign.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this shard is of another campaign: {what} {found}, expected {expected}")]
pub struct OtherCampaign {
    /// What differs.
    pub what: &'static str,
    /// The value of the part.
    pub found: String,
    /// The value of the campaign.
    pub expected: String,
}

impl ShardHead {
    /// The trials of the part.
    pub fn range(&self) -> Range<u64> {
        self.first..self.end
    }

    /// SHA-256 of all that makes two parts parts of one campaign, hexadecimal; the version of an autopilot,
    /// which is not known before it flies, is left out.
    pub fn campaign_id(&self) -> String {
        let Self { mission, version, seed, input_hash, autopilot, trials, bound, keep, .. } = self;
        let told = serde_json::json!([mission, version, seed, input_hash, autopilot, trials, bound, keep]);
        let digest = Sha256::digest(told.to_string().as_bytes());
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Refuses a part of another campaign than that of `self`; versions of an autopilot are compared where
    /// both are known.
    ///
    /// # Errors
    /// [`OtherCampaign`] with the first difference.
    pub fn check_same_campaign(&self, part: &Self) -> Result<(), OtherCampaign> {
        let words = |value: &Option<String>| value.clone().unwrap_or_else(|| "none".to_owned());
        let keep = |keep: Keep| format!("{keep:?}").to_lowercase();
        let version = |head: &Self| match (&self.autopilot_version, &part.autopilot_version) {
            (Some(_), Some(_)) => words(&head.autopilot_version),
            _ => String::new(),
        };
        let differs = |what, of: &dyn Fn(&Self) -> String| {
            let (found, expected) = (of(part), of(self));
            (found != expected).then_some(OtherCampaign { what, found, expected })
        };
        let differences = [
            differs("mission", &|head| head.mission.clone()),
            differs("version of samara", &|head| head.version.clone()),
            differs("seed", &|head| head.seed.to_string()),
            differs("hash of the inputs", &|head| head.input_hash.clone()),
            differs("autopilot", &|head| words(&head.autopilot)),
            differs("version of the autopilot", &version),
            differs("number of trials", &|head| head.trials.to_string()),
            differs("bound", &|head| head.bound.to_string()),
            differs("rows that are kept", &|head| keep(head.keep)),
        ];
        differences.into_iter().flatten().next().map_or(Ok(()), Err)
    }
}

/// Why a file is not a part of a campaign.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    /// The file cannot be read or written, or is no Parquet file.
    #[error("as a Parquet file")]
    Parquet(#[from] parquet::errors::ParquetError),
    /// The metadata is not what samara writes.
    #[error("the metadata of a shard, as `samara assess --shard` writes it, is expected")]
    Metadata(#[from] serde_json::Error),
    /// The file is Parquet, but not what samara writes.
    #[error("a shard, as `samara assess --shard` writes it, is expected: {0}")]
    NotAShard(String),
    /// Bytes of the file are others than were written.
    #[error("a shard as it was written is expected: bytes of the file have changed, or are missing")]
    Damaged,
    /// Statistics do not follow each other.
    #[error("the statistics of the shard do not fit its trials")]
    Blocks(#[from] samara_core::assess::BlockError),
}

#[cfg(test)]
pub(super) mod tests;
