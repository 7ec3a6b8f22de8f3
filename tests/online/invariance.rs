//! Where the scene stands and how often the tick comes make no difference.

use std::f64::consts::FRAC_PI_3;
use std::sync::Arc;

use handover_mesh::geometry::yaw_isometry;
use handover_mesh::online::{OnlineModel, OnlineSettings, Perception, Reference, Scene};
use handover_mesh::predict::{PredictSettings, ReferenceBlend};
use handover_mesh::track::{Followed, Who};
use handover_mesh::{Point, Stamp, Vector};
use nalgebra::UnitComplex;

use crate::handovers::{DURATION, Handover, demonstrations, model_of, pipeline};
use crate::runs::{HELD_OUT, Said, farthest, run, usual};

/// The usual model, its reference the blend of the demonstrations followed.
fn rigid() -> Arc<OnlineModel> {
    let predict = PredictSettings { blend: ReferenceBlend::Rigid, ..PredictSettings::default() };
    model_of(demonstrations(6), predict, OnlineSettings::default())
}

#[test]
fn targets_move_with_the_scene() {
    for (name, model) in [("mean", usual()), ("rigid", rigid())] {
        let off = off_elsewhere(&model);
        println!("{name}: {off:.1e} m off");
        assert!(off < 1e-6, "{name}: {off} m");
    }
}

/// How far targets are from where they were, moved along, once the scene is elsewhere `[m]`.
fn off_elsewhere(model: &Arc<OnlineModel>) -> f64 {
    let mut farthest_off = 0.0f64;
    let handover = Handover::new(HELD_OUT);
    let robot = handover.giver(0.0);
    let here = run(
        &mut pipeline(model, &robot),
        |now| Some(handover.receiver(now)),
        &robot,
        30.0,
        DURATION,
    );
    for (yaw, shift) in
        [(0.0, Vector::new(3.0, -2.0, 0.4)), (FRAC_PI_3, Vector::zeros()), (2.9, Vector::x())]
    {
        let there_from_here = yaw_isometry(yaw, shift);
        let all = |pose: Vec<Point>| -> Vec<Point> {
            pose.iter().map(|place| there_from_here * place).collect()
        };
        let there = run(
            &mut pipeline(model, &robot),
            |now| Some(all(handover.receiver(now))),
            &all(robot.clone()),
            30.0,
            DURATION,
        );
        let off = here.iter().zip(&there).map(|(here, there)| {
            assert_eq!(here.reason, there.reason);
            farthest(&all(here.places.clone()), &there.places)
        });
        farthest_off = off.fold(farthest_off, f64::max);
    }
    farthest_off
}

/// A pose of one demonstration alone is that pose, blended or not; of several the blend is near the
/// mean, the bases where they were.
#[test]
fn a_blended_reference_is_the_mean_of_one_and_near_that_of_several() {
    let (mean, rigid) = (usual(), rigid());
    let library = mean.library();
    let followed = |exemplar: usize, weight: f64, frame: f64| Followed {
        exemplar,
        weight,
        frame,
        turn: UnitComplex::new(0.3),
    };
    let base = |who: Who| library.base(who).index();
    let handover = Handover::new(HELD_OUT);
    let [robot, partner] = [handover.giver(0.0), handover.receiver(0.0)];
    let frames = mean.settings().past + 1 + mean.settings().future;
    let scene = Scene { partner: partner.repeat(frames), robot_base: robot[base(Who::Robot)] };
    let mut perception = Perception::new(&mean);
    perception.see(&mean, Stamp(0), &partner, scene.robot_base, |_| 0.0);
    let mut belief = perception.belief().clone();
    let mut fill = |followed: Vec<Followed>, model: &OnlineModel| {
        belief.followed = followed;
        let mut reference = Reference::new(model);
        reference.fill(model, &belief, &scene, false);
        reference
    };
    let one = || vec![followed(1, 1.0, 20.4)];
    let (plain, blended) = (fill(one(), &mean), fill(one(), &rigid));
    let apart =
        |a: &[Point], b: &[Point]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let off = apart(&plain.robot, &blended.robot).max(apart(&plain.partner, &blended.partner));
    // Between two frames even one demonstration is a mean of two poses.
    assert!(off < 1e-3, "{off}");
    let several = || vec![followed(0, 0.5, 10.0), followed(1, 0.3, 30.5), followed(3, 0.2, 35.0)];
    let (plain, blended) = (fill(several(), &mean), fill(several(), &rigid));
    let off = apart(&plain.robot, &blended.robot);
    assert!((1e-4..0.1).contains(&off), "{off}");
    let joints = robot.len();
    for frame in 0..frames {
        let place = |reference: &Reference| reference.robot[frame * joints + base(Who::Robot)];
        assert!((place(&plain) - place(&blended)).norm() < 1e-12);
    }
}

#[test]
fn the_rate_of_ticks_makes_little_difference() {
    let handover = Handover::new(HELD_OUT);
    let robot = handover.giver(0.0);
    // Multiples of 30 Hz, so that instants are the same; ticks between sightings see none.
    let at = |rate: usize| {
        let partner = |now| Some(handover.receiver(now));
        let said = run(&mut pipeline(&usual(), &robot), partner, &robot, rate as f64, 2.5);
        said.into_iter().step_by(rate / 30).collect::<Vec<_>>()
    };
    let [slow, medium, fast] = [30, 90, 990].map(at);
    let off = |a: &[Said], b: &[Said], from: f64| {
        let pairs = a.iter().zip(b).filter(|(a, _)| a.now >= from);
        let off = pairs.map(|(a, b)| {
            assert!((a.now - b.now).abs() < 1e-6 && a.distance == b.distance);
            farthest(&a.places, &b.places)
        });
        off.fold(0.0, f64::max)
    };
    let met = handover.contact;
    println!(
        "30 Hz is {:.3} m off 90 Hz, {:.3} from contact on; 90 Hz {:.3} m and {:.3} off 990 Hz",
        off(&slow, &medium, 0.0),
        off(&slow, &medium, met),
        off(&medium, &fast, 0.0),
        off(&medium, &fast, met),
    );
    assert!(off(&medium, &fast, 0.0) < 0.01);
    // A jump of what is believed the gate follows worse at 30 Hz.
    assert!(off(&slow, &medium, 0.0) < 0.03);
    assert!(off(&slow, &medium, met) < 0.01);
}
