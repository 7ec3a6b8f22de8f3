//! Velocities, and paths that follow them.

use std::f64::consts::TAU;

use handover_mesh::motion::{
    Dimensions, FollowSettings, MotionError, MotionModel, MotionSettings, Neighbourhood, Path,
    Rows, Stop,
};
use proptest::prelude::*;

use crate::{distance, model, walks};

const STEPS: FollowSettings = FollowSettings { steps: 50, still: 0.0, goal: None };

/// Rounds of 200 frames on a circle of this radius.
fn circle(radius: f64, frames: i32) -> Rows {
    let pose = |k| {
        let turn = f64::from(k) * TAU / 200.0;
        [radius * turn.cos(), radius * turn.sin(), 0.0]
    };
    Rows::new(3, (0..frames).flat_map(pose).collect()).unwrap()
}

fn follow(model: &MotionModel, pose: &[f64], settings: &FollowSettings) -> Path {
    let start = model.pca().project(&Rows::new(pose.len(), pose.to_vec()).unwrap());
    model.follow(start.row(0), settings)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn velocities_are_half_the_steps(
        seed in 0..10_000_u64, lengths in prop::collection::vec(1..6_usize, 1..5),
    ) {
        prop_assume!(lengths.iter().sum::<usize>() >= 4);
        let model = model(&walks(seed, &lengths), Neighbourhood::Knn, 3);
        prop_assert_eq!(model.sequences().len(), lengths.len());
        for range in model.sequences() {
            for pose in range.clone() {
                let [to, from] = match range.len() {
                    1 => [pose, pose],
                    _ if pose + 1 == range.end => [pose, pose - 1],
                    _ => [pose + 1, pose],
                };
                let [to, from] = [to, from].map(|row| model.points().row(row));
                let expected = [0, 1].map(|axis| (to[axis] - from[axis]) / 2.0);
                prop_assert_eq!(model.velocities().row(pose), expected);
            }
        }
    }

    #[test]
    fn every_step_is_the_fields_velocity(seed in 0..10_000_u64) {
        for neighbourhood in Neighbourhood::ALL {
            let model = model(&walks(seed, &[25, 20]), neighbourhood, 4);
            let path = model.follow(model.points().row(3), &STEPS);
            let mut around = model.around();
            let (mut velocity, mut outside) = ([0.0; 2], 0);
            for step in 1..path.points.len() {
                let place = path.points.row(step - 1);
                model.velocity(place, &mut around, &mut velocity);
                outside += usize::from(around.is_outside());
                let next = [place[0] + velocity[0], place[1] + velocity[1]];
                prop_assert_eq!(path.points.row(step), next);
            }
            prop_assert_eq!((path.outside, path.stop), (outside, Stop::Steps));
            prop_assert_eq!(path.points.len(), 51);
        }
    }
}

#[test]
fn a_path_on_circles_stays_between_them() {
    let data = [circle(1.0, 410), circle(1.1, 410)];
    // NOTE: steps by forward differences lead inwards by about π²/200 a round.
    for neighbourhood in Neighbourhood::ALL {
        let model = model(&data, neighbourhood, 16);
        let settings = FollowSettings { steps: 800, ..STEPS };
        let path = follow(&model, &[1.05, 0.0, 0.0], &settings);
        assert_eq!((path.stop, path.points.len()), (Stop::Steps, 801));
        let poses = model.pca().reproject(&path.points);
        let mut turned = 0.0;
        for step in 1..poses.len() {
            let [from, to] = [poses.row(step - 1), poses.row(step)];
            let radius = to[0].hypot(to[1]);
            assert!((0.9..1.2).contains(&radius), "{} {step}: {radius}", neighbourhood.name());
            turned += (from[0] * to[1] - from[1] * to[0]).atan2(from[0] * to[0] + from[1] * to[1]);
        }
        // Half steps: two rounds in 800 of them, give or take what blending costs.
        assert!((1.6..2.1).contains(&(turned / TAU)), "{}: {turned}", neighbourhood.name());
    }
}

#[test]
fn a_path_ends_at_its_goal_where_it_stands_or_when_told() {
    let model = model(&[circle(1.0, 410), circle(1.1, 410)], Neighbourhood::KDelaunay, 4);
    let goal = model.points().row(20).to_vec();
    let at_goal = FollowSettings { steps: 500, still: 0.0, goal: Some((goal.clone(), 0.15)) };
    let path = model.follow(model.points().row(0), &at_goal);
    assert_eq!(path.stop, Stop::Goal);
    let last = path.points.len() - 1;
    assert!(last < 60 && distance(path.points.row(last), &goal) <= 0.15);
    assert!((0..last).all(|step| distance(path.points.row(step), &goal) > 0.15));
    // There already; and there with the last step allowed.
    let path_there = model.follow(&goal, &at_goal);
    assert_eq!((path_there.points.len(), path_there.stop), (1, Stop::Goal));
    let just = FollowSettings { steps: last, ..at_goal.clone() };
    assert_eq!(model.follow(model.points().row(0), &just), path);
    let short = FollowSettings { steps: last - 1, ..at_goal };
    assert_eq!(model.follow(model.points().row(0), &short).stop, Stop::Steps);

    let none = FollowSettings { steps: 0, ..STEPS };
    assert_eq!(model.follow(&goal, &none).points.values(), goal);
    let slow = FollowSettings { still: 1.0, ..STEPS };
    let path = model.follow(&goal, &slow);
    assert_eq!((path.points.len(), path.stop), (1, Stop::Still));
    let path = model.follow(&[f64::NAN, 0.0], &STEPS);
    assert_eq!((path.points.len(), path.stop), (1, Stop::Still));
}

#[test]
fn a_path_out_of_the_hull_goes_on_by_the_nearest_and_says_so() {
    let line = |k: i32| [f64::from(k), 0.3 * f64::from(k % 3)];
    let line = Rows::new(2, (0..30).flat_map(line).collect()).unwrap();
    for neighbourhood in Neighbourhood::ALL {
        let model = model(std::slice::from_ref(&line), neighbourhood, 3);
        let path = follow(&model, &[25.0, 0.3], &FollowSettings { steps: 80, ..STEPS });
        let last = model.pca().reproject(&path.points);
        assert!(last.row(path.points.len() - 1)[0] > 31.0, "{}", neighbourhood.name());
        assert_eq!(path.stop, Stop::Steps);
        let counted = (20..80).contains(&path.outside);
        assert_eq!(counted, neighbourhood.has_simplices(), "{}", path.outside);
    }
}

#[test]
fn lone_poses_move_nothing() {
    let alone: Vec<Rows> =
        walks(8, &[5]).remove(0).iter().map(|p| Rows::new(4, p.to_vec()).unwrap()).collect();
    for neighbourhood in Neighbourhood::ALL {
        let model = model(&alone, neighbourhood, 2);
        assert_eq!(model.sequences().len(), 5);
        assert!(model.velocities().values().iter().all(|v| *v == 0.0));
        assert_eq!(model.follow(&[0.0, 0.0], &STEPS).stop, Stop::Still);
        assert_eq!((model.graph().edge_count(), model.graph().components().len()), (0, 5));
    }
    // Two frames and a lone one between their neighbours.
    let mixed = [&alone[..3], &walks(9, &[2])].concat();
    let model = model(&mixed, Neighbourhood::Delaunay, 2);
    assert_eq!(model.velocities().row(3), model.velocities().row(4), "one step, told twice");
    assert_ne!(model.velocities().row(3), [0.0, 0.0]);
}

#[test]
fn what_makes_no_model_is_named() {
    let fit = |sequences: &[Rows]| MotionModel::fit(sequences, MotionSettings::default());
    let empty = Rows::new(4, vec![]).unwrap();
    for none in [vec![], vec![empty.clone(), empty.clone()]] {
        assert_eq!(fit(&none).unwrap_err(), MotionError::NoPoses);
    }
    let other = [walks(1, &[9]).remove(0), circle(1.0, 9)];
    let error = MotionError::Channels { sequence: 1, expected: 4, got: 3 };
    assert_eq!(fit(&other).unwrap_err(), error);
    let walk = walks(1, &[9]).remove(0);
    let with_empty = fit(&[empty.clone(), walk.clone(), empty]).unwrap();
    assert_eq!(with_empty.sequences(), std::slice::from_ref(&(0..9)));
    let six = MotionSettings { dimensions: Dimensions::Share(1.0), ..MotionSettings::default() };
    let wide = crate::random(3, 30, 6);
    let error = MotionModel::fit(&[wide], six).unwrap_err();
    assert_eq!(error, MotionError::Dimensions { dimensions: 6 });
}

#[test]
#[should_panic(expected = "dimension")]
fn a_goal_of_other_dimensions_is_the_callers_bug() {
    let goal = FollowSettings { goal: Some((vec![0.0], 0.1)), ..STEPS };
    model(&walks(1, &[9]), Neighbourhood::Knn, 3).follow(&[0.0, 0.0], &goal);
}

#[test]
#[should_panic(expected = "dimension")]
fn a_velocity_of_other_dimensions_is_the_callers_bug() {
    let model = model(&walks(1, &[9]), Neighbourhood::Knn, 3);
    model.velocity(&[0.0, 0.0], &mut model.around(), &mut [0.0; 3]);
}
