//! Why the robot is not moving as proposed.

use std::fmt;

/// Why the robot brakes or stands. Most reasons are the caller's; the gate adds its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum HoldReason {
    /// Where the robot is has not been said, or not again since a reset.
    NoRobot,
    /// Nobody has been seen.
    NoPartner,
    /// The partner has not been seen for a while.
    Stale,
    /// The partner has not been known for so long that the robot resumes gently.
    Stopped,
    /// Too little of the partner is seen, or where they stand is not a finite place.
    Lost,
    /// The partner moved farther than a person can.
    Jump,
    /// Someone else is seen in the partner's place.
    Exchanged,
    /// What the partner does was not demonstrated.
    OffDemonstration,
    /// There is no finite pose to follow.
    Unsolved,
    /// Someone called it off.
    Cancelled,
    /// The partner is, or would be, too near.
    Separation,
    /// A joint is, or would be, outside the workspace.
    Workspace,
    /// No way towards the proposal is within speed, acceleration and jerk.
    Limits,
    /// Time did not go on since the last tick, or the clock was set.
    Clock,
}

impl HoldReason {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::NoRobot,
        Self::NoPartner,
        Self::Stale,
        Self::Stopped,
        Self::Lost,
        Self::Jump,
        Self::Exchanged,
        Self::OffDemonstration,
        Self::Unsolved,
        Self::Cancelled,
        Self::Separation,
        Self::Workspace,
        Self::Limits,
        Self::Clock,
    ];

    /// The name in messages and traces.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoRobot => "no_robot",
            Self::NoPartner => "no_partner",
            Self::Stale => "stale",
            Self::Stopped => "stopped",
            Self::Lost => "lost",
            Self::Jump => "jump",
            Self::Exchanged => "exchanged",
            Self::OffDemonstration => "off_demonstration",
            Self::Unsolved => "unsolved",
            Self::Cancelled => "cancelled",
            Self::Separation => "separation",
            Self::Workspace => "workspace",
            Self::Limits => "limits",
            Self::Clock => "clock",
        }
    }
}

impl fmt::Display for HoldReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
