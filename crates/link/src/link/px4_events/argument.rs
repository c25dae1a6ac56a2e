//! The kinds of an event's arguments.

use std::collections::BTreeMap;
use std::sync::Arc;

/// A kind of argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Argument {
    Unsigned(u8),
    Signed(u8),
    Float,
    /// One of the names, or where `bits` all whose bits are set; so many bytes. All arguments of an enum
    /// share its names.
    Named {
        bytes: u8,
        bits: bool,
        names: Arc<BTreeMap<u64, String>>,
    },
}

impl Argument {
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Unsigned(bytes) | Self::Signed(bytes) | Self::Named { bytes, .. } => usize::from(*bytes),
            Self::Float => 4,
        }
    }
}
