//! Where a handover is: what the owner of the gripper waits for.

use std::fmt;

use crate::config::NodeSettings;
use crate::geometry::{Point, Vector, yaw_isometry};
use crate::online::{OnlineModel, Tick};
use crate::safety::HoldReason;
use crate::skeleton::Part;
use crate::track::Who;

/// Where a handover is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum HandoverState {
    /// Nobody is there, or nobody reaches out.
    #[default]
    Idle,
    /// The hands will meet soon.
    Approach,
    /// The hands are as far apart as they were in the demonstrations when they met.
    Contact,
    /// They part.
    Retreat,
    /// Something is wrong: the robot brakes or stands.
    Hold,
}

impl HandoverState {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Idle, Self::Approach, Self::Contact, Self::Retreat, Self::Hold];

    /// The word on the topic.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Approach => "approach",
            Self::Contact => "contact",
            Self::Retreat => "retreat",
            Self::Hold => "hold",
        }
    }
}

impl fmt::Display for HandoverState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Where the robot's hand is to be, whoever is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HandTarget {
    /// `[m]` in the world.
    pub(super) place: Point,
    /// From its elbow to it, if it has one `[m]`.
    pub(super) forearm: Option<Vector>,
}

impl HandTarget {
    /// Of the hand that meets or last met somebody's; none if the skeleton has no such hand.
    pub(super) fn of(model: &OnlineModel, tick: Option<&Tick<'_>>) -> Option<Self> {
        let tick = tick?;
        let (places, side) = (tick.target?.positions(), tick.belief.hands.robot);
        let skeleton = model.library().skeleton(Who::Robot);
        let place = places[skeleton.part(Part::Hand(side))?.index()];
        let elbow = skeleton.part(Part::Elbow(side));
        Some(Self { place, forearm: elbow.map(|elbow| place - places[elbow.index()]) })
    }
}

/// The hands that will meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hands {
    /// Where the robot's is to be now `[m]`.
    pub(super) robot: Point,
    /// Where the partner's is now `[m]`.
    pub(super) partner: Point,
    /// How long until they meet `[s]`, below 0 once they have.
    pub(super) contact_in: f64,
    /// How far the gap between them is from the demonstrated one `[m]`.
    pub(super) gap_error: f64,
    /// How wide the demonstrated one is `[m]`.
    pub(super) gap: f64,
}

impl Hands {
    /// None if nobody is followed, or a skeleton has no such hand.
    pub(super) fn of(model: &OnlineModel, tick: Option<&Tick<'_>>) -> Option<Self> {
        let tick = tick?;
        let (target, partner) = (tick.target?, tick.partner?);
        let library = model.library();
        let belief = Some(tick.belief).filter(|belief| !belief.followed.is_empty())?;
        let [own, other] = [Who::Robot, Who::Partner].map(|who| library.skeleton(who));
        let hand = own.part(Part::Hand(belief.hands.robot))?;
        let partner_hand = other.part(Part::Hand(belief.hands.partner))?;
        let robot = target.positions()[hand.index()];
        let gap_in_heading = model.gap(belief.hands);
        let world_from_heading = yaw_isometry(other.heading(partner), Vector::zeros());
        let partner = partner[partner_hand.index()];
        Some(Self {
            robot,
            partner,
            contact_in: belief.contact * library.step().seconds(),
            gap_error: (robot - partner - world_from_heading * gap_in_heading).norm(),
            gap: gap_in_heading.norm(),
        })
    }

    /// Whether the object, if it is known, is where the hands are.
    fn has(&self, object: Option<Point>, distance: f64) -> bool {
        let reach = self.gap + distance;
        object.is_none_or(|place| {
            (place - self.robot).norm().min((place - self.partner).norm()) <= reach
        })
    }
}

/// How far the handover has come.
#[derive(Debug, Clone, Default)]
pub(super) struct Progress {
    /// As it was when the robot last moved as demonstrated.
    state: HandoverState,
}

impl Progress {
    /// Once there, contact ends only where the gap is this many times as far off as at its start.
    const HYSTERESIS: f64 = 1.5;
    /// Hands that part so long before they should meet were only passing `[s]`.
    const PASSING: f64 = 0.3;
    /// So long after they should have met, they part `[s]`.
    const OVER: f64 = 1.0;

    /// The state after a tick.
    pub(super) fn update(
        &mut self,
        reason: Option<HoldReason>,
        hands: Option<&Hands>,
        object: Option<Point>,
        node: &NodeSettings,
    ) -> HandoverState {
        match reason {
            None => {}
            Some(HoldReason::NoRobot | HoldReason::NoPartner) => {
                self.state = HandoverState::Idle;
                return self.state;
            }
            Some(_) => return HandoverState::Hold,
        }
        let Some(hands) = hands else {
            self.state = HandoverState::Idle;
            return self.state;
        };
        let wide = if self.state == HandoverState::Contact { Self::HYSTERESIS } else { 1.0 };
        let near = hands.gap_error <= wide * node.contact_distance
            && hands.has(object, wide * node.contact_distance);
        let soon = hands.contact_in <= node.approach;
        self.state = match self.state {
            _ if near && soon => HandoverState::Contact,
            HandoverState::Contact if hands.contact_in <= Self::PASSING => HandoverState::Retreat,
            HandoverState::Retreat if hands.contact_in <= 0.0 => HandoverState::Retreat,
            HandoverState::Approach if hands.contact_in < -Self::OVER => HandoverState::Retreat,
            HandoverState::Idle if hands.contact_in < -Self::OVER => HandoverState::Idle,
            _ if soon => HandoverState::Approach,
            _ => HandoverState::Idle,
        };
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use HandoverState::{Approach, Contact, Hold, Idle, Retreat};

    fn hands(contact_in: f64, gap_error: f64) -> Hands {
        let [robot, partner] = [Point::origin(), Point::new(0.1, 0.0, 0.0)];
        Hands { robot, partner, contact_in, gap_error, gap: 0.1 }
    }

    #[test]
    fn a_handover_goes_through_all_its_states() {
        let (mut progress, node) = (Progress::default(), NodeSettings::default());
        let mut next = |reason, contact_in, gap_error| {
            progress.update(reason, Some(&hands(contact_in, gap_error)), None, &node)
        };
        assert_eq!(next(Some(HoldReason::NoPartner), 9.0, 9.0), Idle);
        assert_eq!(next(None, 3.0, 0.6), Idle);
        assert_eq!(next(None, 1.4, 0.5), Approach);
        assert_eq!(next(Some(HoldReason::Stale), 1.3, 0.4), Hold);
        assert_eq!(next(None, 0.3, 0.2), Approach, "it goes on where it was");
        assert_eq!(next(None, 0.1, 0.079), Contact);
        assert_eq!(next(None, 0.0, 0.11), Contact, "noise does not end it");
        assert_eq!(next(None, -0.5, 0.13), Retreat);
        assert_eq!(next(None, -1.5, 0.4), Retreat);
        assert_eq!(next(None, 4.0, 0.5), Idle, "the interaction begins anew");
        assert_eq!(next(None, -2.0, 0.5), Idle, "somebody who has handed over before");
    }

    #[test]
    fn hands_without_the_object_do_not_meet() {
        let (mut progress, node) = (Progress::default(), NodeSettings::default());
        let mut next = |object: [f64; 3]| {
            let object = Some(Point::from(object));
            progress.update(None, Some(&hands(0.1, 0.01)), object, &node)
        };
        assert_eq!(next([0.0, 0.0, 0.6]), Approach);
        assert_eq!(next([0.05, 0.0, 0.1]), Contact);
    }
}
