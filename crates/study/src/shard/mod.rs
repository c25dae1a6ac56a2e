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

use crate::asked::{Asked, sha256_hex};
use crate::campaign::settings::CampaignSettings;
pub(crate) use table::undamaged;
pub use table::{ShardReader, ShardWriter, Table, Values};

/// What a part belongs to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShardHead {
    /// The campaign as it was asked for.
    pub asked: Asked,
    /// Name of the mission.
    pub mission: String,
    /// Name of the autopilot that flew whole drops; `None`: flights from t = 0 by the mission's own gains.
    pub autopilot: Option<String>,
    /// Version of the autopilot, where it reports one.
    pub autopilot_version: Option<String>,
    /// First trial of the part.
    pub first: u64,
    /// Trial after the last of the part.
    pub end: u64,
}

/// A part is of another campaign.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this shard is of another campaign: {what} {found}, expected {expected}")]
pub struct OtherCampaign {
    /// What differs.
    pub what: String,
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

    /// What is asked of the campaign.
    ///
    /// # Errors
    /// [`ShardError`] where the settings are none of a campaign.
    pub fn settings(&self) -> Result<CampaignSettings, ShardError> {
        let settings = self.asked.values(CampaignSettings::TABLE);
        settings.and_then(|values| CampaignSettings::of(&values)).map_err(ShardError::NotAShard)
    }

    /// All that makes two parts parts of one campaign: what it is called, and its text.
    fn told(&self) -> Vec<(String, String)> {
        let Asked { study, version, input_hash, seed, settings, .. } = &self.asked;
        let told = [
            ("mission", self.mission.clone()),
            ("kind", study.clone()),
            ("version of samara", version.clone()),
            ("seed", seed.to_string()),
            ("hash of the inputs", input_hash.clone()),
            ("autopilot", self.autopilot.clone().unwrap_or_else(|| "none".to_owned())),
        ];
        let told = told.map(|(what, text)| (what.to_owned(), text));
        told.into_iter().chain(settings.iter().cloned()).collect()
    }

    /// SHA-256 of all that makes two parts parts of one campaign, hexadecimal; the version of an autopilot,
    /// which is not known before it flies, is left out.
    pub fn campaign_id(&self) -> String {
        sha256_hex(&serde_json::json!(self.told()).to_string())
    }

    /// Refuses a part of another campaign than that of `self`; versions of an autopilot are compared where
    /// both are known.
    ///
    /// # Errors
    /// [`OtherCampaign`] with the first difference.
    pub fn check_same_campaign(&self, part: &Self) -> Result<(), OtherCampaign> {
        let (ours, theirs) = (self.told(), part.told());
        let differs = ours.into_iter().zip(theirs).find(|(ours, theirs)| ours != theirs);
        if let Some(((what, expected), (_, found))) = differs {
            return Err(OtherCampaign { what, found, expected });
        }
        match (&self.autopilot_version, &part.autopilot_version) {
            (Some(expected), Some(found)) if expected != found => Err(OtherCampaign {
                what: "version of the autopilot".to_owned(),
                found: found.clone(),
                expected: expected.clone(),
            }),
            _ => Ok(()),
        }
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
