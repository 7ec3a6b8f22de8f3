//! Which of the bodies seen is the partner.

use crate::bodies::Body;
use crate::config::NodeSettings;
use crate::geometry::{Isometry, Point};
use crate::time::Stamp;

/// Whom the robot keeps to.
#[derive(Debug, Clone, Default)]
pub(super) struct Choice {
    /// The tracker's number of the partner (of trackers that number nobody, none), and when they
    /// were seen last.
    current: Option<(Option<u32>, Stamp)>,
}

impl Choice {
    /// The number of the partner, if there is one.
    pub(super) fn current(&self) -> Option<Option<u32>> {
        self.current.map(|(id, _)| id)
    }

    /// The partner's newest body, if it is among those given.
    ///
    /// Whoever is the partner stays it until not [confirmed](Self::confirm) for `forget` seconds, or
    /// until the clock is set back; then it is whoever is nearest to the robot's base along the
    /// floor, within the start zone.
    ///
    /// - `bodies`: with `world_from_body`, the newest last.
    /// - `base`: the joint that a body's place is known by; without it, it is the joints' mean.
    pub(super) fn choose<'a>(
        &mut self,
        now: Stamp,
        bodies: &[(&'a Body, Isometry)],
        base: &str,
        robot: Option<Point>,
        node: &NodeSettings,
        forget: f64,
    ) -> Option<(&'a Body, Isometry)> {
        if let Some(wanted) = node.partner {
            self.current = Some((Some(wanted), now)).filter(|_| {
                bodies.iter().any(|(body, _)| body.id == Some(wanted))
                    || self.current().flatten() == Some(wanted)
            });
            return bodies.iter().rev().find(|(body, _)| body.id == Some(wanted)).copied();
        }
        let age = |seen: Stamp| (now - seen).seconds();
        if self.current.is_some_and(|(_, seen)| !(0.0..=forget).contains(&age(seen))) {
            self.current = None;
        }
        if self.current.is_none() {
            let robot = robot?;
            let away = |(body, world_from_body): &(&Body, Isometry)| {
                let place = world_from_body * place(body, base)?;
                let distance = (place - robot).xy().norm();
                (distance <= node.start_zone).then_some((distance, body.id))
            };
            let nearest = bodies.iter().filter_map(away).min_by(|a, b| a.0.total_cmp(&b.0));
            self.current = nearest.map(|(_, id)| (id, now));
        }
        let (id, _) = self.current?;
        bodies.iter().rev().find(|(body, _)| body.id == id).copied()
    }

    /// What was seen of the partner was taken.
    pub(super) fn confirm(&mut self, now: Stamp) {
        if let Some((_, seen)) = &mut self.current {
            *seen = now;
        }
    }
}

/// Where a body is, in its own frame.
fn place(body: &Body, base: &str) -> Option<Point> {
    if let Some(place) = body.place(base) {
        return Some(place);
    }
    let count = body.joints.len();
    let sum = body.joints.iter().map(|(_, place)| place.coords).reduce(|a, b| a + b)?;
    Some(Point::from(sum / count as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(id: u32, x: f64) -> Body {
        let joints = vec![("torso".to_owned(), Point::new(x, 0.0, 1.0))];
        Body { stamp: Stamp(1), frame: String::new(), id: Some(id), joints }
    }

    #[test]
    fn the_nearest_in_the_zone_is_kept_until_forgotten() {
        let (mut choice, node) = (Choice::default(), NodeSettings::default());
        let mut chosen = |seconds: f64, bodies: &[Body]| {
            let bodies: Vec<_> = bodies.iter().map(|b| (b, Isometry::identity())).collect();
            let now = Stamp::from_seconds(seconds).unwrap();
            let robot = Some(Point::new(0.0, 0.0, 1.0));
            let chosen =
                choice.choose(now, &bodies, "torso", robot, &node, 2.0).map(|(body, _)| body.id);
            if chosen.is_some() {
                choice.confirm(now);
            }
            chosen
        };
        assert_eq!(chosen(0.0, &[body(7, 9.0)]), None, "out of the zone");
        assert_eq!(chosen(0.1, &[body(7, 3.0), body(2, -2.0)]), Some(Some(2)));
        assert_eq!(chosen(0.2, &[body(7, 0.5), body(2, 8.0)]), Some(Some(2)), "kept");
        assert_eq!(chosen(2.1, &[body(7, 0.5)]), None, "not yet forgotten");
        assert_eq!(chosen(2.3, &[body(7, 0.5)]), Some(Some(7)));
        assert_eq!(chosen(2.4, &[]), None);
        // A clock that is set back begins anew.
        assert_eq!(chosen(0.5, &[body(3, 1.0)]), Some(Some(3)));
    }

    #[test]
    fn whoever_is_never_taken_is_forgotten() {
        let (mut choice, node) = (Choice::default(), NodeSettings::default());
        let (ghost, person) = (body(1, 0.5), body(2, 1.0));
        let mut chosen = |seconds: f64, body: &Body| {
            let now = Stamp::from_seconds(seconds).unwrap();
            let bodies = [(body, Isometry::identity())];
            let robot = Some(Point::new(0.0, 0.0, 1.0));
            choice.choose(now, &bodies, "torso", robot, &node, 2.0).map(|(body, _)| body.id)
        };
        assert_eq!(chosen(0.0, &ghost), Some(Some(1)));
        assert_eq!(chosen(1.0, &person), None);
        assert_eq!(chosen(2.1, &person), Some(Some(2)));
    }

    #[test]
    fn whoever_is_named_is_the_partner_wherever_they_stand() {
        let node = NodeSettings { partner: Some(4), ..NodeSettings::default() };
        let mut choice = Choice::default();
        let (near, far) = (body(1, 0.5), body(4, 50.0));
        let bodies = [(&near, Isometry::identity()), (&far, Isometry::identity())];
        let chosen = choice.choose(Stamp(5), &bodies, "torso", None, &node, 2.0);
        assert_eq!(chosen.map(|(body, _)| body.id), Some(Some(4)));
        assert_eq!(choice.choose(Stamp(5), &bodies[..1], "torso", None, &node, 2.0), None);
        assert_eq!(choice.current(), Some(Some(4)));
    }
}
