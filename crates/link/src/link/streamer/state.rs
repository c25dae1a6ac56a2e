//! The states of a drop, as the streamer goes through them.

/// State of the streamer in the drop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StreamerState {
    /// Neither heartbeat nor clock of the vehicle yet.
    #[default]
    WaitingForVehicle,
    /// Streaming the level attitude; parameters are given and asked for.
    Parameters,
    /// Streaming the level attitude, before anything else is asked.
    Streaming,
    /// The estimator has no velocity yet.
    Aligning,
    /// In HOLD, where PX4's tilt limit comes up.
    Holding,
    /// OFFBOARD asked for.
    RequestingOffboard,
    /// Arming asked for.
    Arming,
    /// Armed under the canopy.
    Hanging,
    /// Release asked for.
    Releasing,
    /// Released, t < 0.
    Falling,
    /// Streaming the plan.
    Tracking,
    /// Streaming the target velocity.
    Target,
    /// At the end.
    Done,
    /// Given up.
    Failed,
}

/// The state to enter, if one is.
pub(super) type Next = Option<StreamerState>;
/// The state to enter, if one is, or why the streamer gives up.
pub(super) type Step = Result<Next, String>;

impl StreamerState {
    /// Whether the vehicle must stay armed and in OFFBOARD.
    pub(super) fn is_flight(self) -> bool {
        matches!(self, Self::Hanging | Self::Releasing | Self::Falling | Self::Tracking | Self::Target)
    }

    /// Whether nothing more will be sent.
    pub(super) fn is_over(self) -> bool {
        matches!(self, Self::Done | Self::Failed)
    }
}
