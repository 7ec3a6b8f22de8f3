//! Who moves the robot: a tick in, a target out.

use handover_mesh::filter::Sighting;
use handover_mesh::online::{Pipeline, TickInput};
use handover_mesh::safety::{HoldReason, Target};
use handover_mesh::{Point, Stamp};

/// What a controller says in a tick.
#[derive(Debug, Clone, Copy)]
pub struct Reply<'a> {
    /// Where the joints are to be: `[m]` in the world; none: nothing is published.
    pub target: Option<&'a [Point]>,
    /// Why they do not move as demonstrated; none: they do.
    pub reason: Option<HoldReason>,
}

/// Moves the robot by what it is told of the partner.
pub trait Controller {
    /// One tick.
    ///
    /// - `sighting`: the newest message since the last tick, if one arrived.
    /// - `robot`: where the robot's joints are, `[m]` in the world.
    fn tick(&mut self, now: Stamp, sighting: Option<Sighting<'_>>, robot: &[Point]) -> Reply<'_>;
}

impl Controller for Pipeline {
    fn tick(&mut self, now: Stamp, sighting: Option<Sighting<'_>>, robot: &[Point]) -> Reply<'_> {
        let tick = Self::tick(self, &TickInput { now, sighting, robot: Some(robot) });
        Reply { target: tick.target.map(Target::positions), reason: tick.reason }
    }
}
