//! A handover at random: the mix of people and habits that a set of recordings is made of.

use std::f64::consts::TAU;

use handover_mesh::{Role, Side, Vector};
use rand::Rng;
use rand_distr::{Distribution, Normal};

use super::config::{Approach, PersonConfig, SceneConfig, Timing};
use super::play::Scene;
use crate::body::Body;

/// The most people lean ahead for a handover before they would rather step nearer, `[rad]`.
const MOST_LEAN: f64 = 0.45;

/// Draws the parameters of one handover.
///
/// Statures 1.50 to 1.95 m; distances 0.9 to 1.3 m, nearer for short people; objects of 10 to
/// 15 cm; right hand to right hand in 3 of 4 scenes, else left or mixed; tempo 0.75 to 1.35;
/// one person walks up in 1 of 4. People lean as far as the meeting point asks for (up to a
/// bound). The line between them lies roughly along world x, [2.2 m, 2.8 m] ahead (along y) of
/// the origin, where a sensor at the origin sees both from the side.
///
/// Every draw is within [`SceneConfig::check`]'s ranges.
pub fn draw(random: &mut impl Rng) -> SceneConfig {
    let hands = match random.random_range(0..100) {
        0..75 => [Side::Right, Side::Right],
        75..85 => [Side::Left, Side::Left],
        85..93 => [Side::Right, Side::Left],
        _ => [Side::Left, Side::Right],
    };
    let [giver, receiver] = hands.map(|hand| person(hand, random));
    let arms = [&giver, &receiver].map(|person| Body::of_stature(person.stature).arm());
    let distance = (arms[0] + arms[1]) * random.random_range(0.70..0.92);
    let shift = [0.04, 0.05, 0.05].map(|spread| normal(random, 0.0, spread, 0.12));
    let walker = random.random_range(0..8);
    let approach = (walker < 2).then(|| {
        let role = if walker == 0 { Role::First } else { Role::Second };
        let distance = random.random_range(0.35..0.8);
        // A first and a last half step, and the way at an indoor pace between them.
        let duration = 1.2 + distance / random.random_range(0.5..0.7);
        Approach { role, distance, duration }
    });
    let config = SceneConfig {
        giver,
        receiver,
        distance: distance.clamp(0.9, 1.3),
        gap: random.random_range(0.10..0.15),
        suit_receiver: random.random_range(0.2..0.8),
        meeting_shift: Vector::from(shift),
        timing: timing(random),
        approach,
        step_in: None,
        centre: [normal(random, 0.0, 0.1, 0.3), random.random_range(2.2..2.8)],
        heading: normal(random, 0.0, 0.12, 0.4),
    };
    lean_to_reach(config)
}

/// A normal draw, cut at `most` either side of the mean.
fn normal(random: &mut impl Rng, mean: f64, spread: f64, most: f64) -> f64 {
    // A finite spread ≥ 0 always makes a distribution; the mean is what zero spread would give.
    let drawn = Normal::new(mean, spread).map_or(mean, |normal| normal.sample(random));
    drawn.clamp(mean - most, mean + most)
}

fn person(hand: Side, random: &mut impl Rng) -> PersonConfig {
    PersonConfig {
        stature: normal(random, 1.72, 0.11, 0.22).clamp(1.50, 1.95),
        hand,
        facing: normal(random, 0.0, 0.12, 0.35),
        lean: normal(random, 0.10, 0.04, 0.09),
        twist: normal(random, 0.18, 0.07, 0.17),
        swivel: normal(random, 0.40, 0.15, 0.4),
        carry: random.random_range(0.3..0.9),
        arc: normal(random, 0.01, 0.015, 0.04),
        sway: random.random_range(0.002..0.008),
        swing: random.random_range(0.01..0.05),
        phase: random.random_range(0.0..TAU),
    }
}

fn timing(random: &mut impl Rng) -> Timing {
    Timing {
        lead_in: random.random_range(0.5..1.2),
        giver_reach: random.random_range(0.9..1.3),
        reaction: random.random_range(0.2..0.6),
        receiver_reach: random.random_range(0.8..1.2),
        hold: random.random_range(0.2..0.5),
        release: random.random_range(-0.1..0.2),
        retreat: random.random_range(0.8..1.2),
        lead_out: random.random_range(0.4..0.8),
        tempo: random.random_range(0.75..1.35),
    }
}

/// Lets whoever falls short lean farther, in small steps.
fn lean_to_reach(mut config: SceneConfig) -> SceneConfig {
    // The meeting point moves with the shoulders, so each step is looked at anew.
    for _ in 0..20 {
        let Ok(scene) = Scene::new(config.clone()) else { break };
        // All through the time a hand is out, since its owner sways.
        let moments = scene.moments();
        let short = |role: Role| {
            let ([_, arrival], [leave, _]) =
                (moments.reach[role as usize], moments.retreat[role as usize]);
            let instants = (0..=8).map(|k| arrival + (leave - arrival) * f64::from(k) / 8.0);
            instants.into_iter().any(|now| scene.pose(role, now).shortfall > 0.0)
        };
        let [giver, receiver] = [Role::First, Role::Second].map(short);
        if !giver && !receiver {
            break;
        }
        for (person, short) in [(&mut config.giver, giver), (&mut config.receiver, receiver)] {
            if short {
                person.lean = (person.lean + 0.03).min(MOST_LEAN);
            }
        }
    }
    config
}
