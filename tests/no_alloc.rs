//! Once a workspace is made, assembling, factoring, solving, asking a motion model, forecasting and
//! whole ticks allocate nothing.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[allow(dead_code, reason = "shared with tests and benches that use other parts")]
#[path = "common/handovers.rs"]
mod handovers;

use std::collections::BTreeSet;
use std::sync::Arc;

use handover_mesh::blend::{BlendSettings, Blender, Energy, Triangles};
use handover_mesh::filter::Sighting;
use handover_mesh::forecast::{ForecastMethod, ForecastSettings, Forecaster, Moment};
use handover_mesh::mesh::{EdgeWeights, InitialEdges, InteractionMesh, Kernel, Pair, Topology};
use handover_mesh::motion::{MotionModel, MotionSettings, Neighbourhood, Rows};
use handover_mesh::online::{OnlineSettings, TickInput};
use handover_mesh::predict::{PredictSettings, ReferenceBlend};
use handover_mesh::retarget::{Constraint, RetargetSettings, Retargeter, Start, Transform};
use handover_mesh::{Frame, Point, Sequence, Side, Skeleton, Stamp};

#[test]
fn solves_allocate_nothing() {
    let skeleton = Skeleton::nite();
    let pair = Arc::new(Pair::new([skeleton.clone(), skeleton]));
    let positions: Vec<Point> = (0..18 * 30)
        .map(f64::from)
        .map(|i| Point::new(i.sin(), (1.7 * i).cos(), (0.3 * i).sin()))
        .collect();
    let topology = Arc::new(
        Topology::initial(pair.clone(), &positions[..30], InitialEdges::BothPeople).unwrap(),
    );
    let weights = EdgeWeights::by_kernel(&topology, &positions, Kernel::Uniform, 1.0);
    let mesh = InteractionMesh::new(topology.clone(), positions.clone(), weights).unwrap();
    let constraints: Vec<Constraint> = (0..positions.len())
        .map(|v| if v % 30 < 15 || v % 30 == 17 { Constraint::Fixed } else { Constraint::Free })
        .collect();
    let lengths = vec![0.3; pair.bones().count()];
    for transform in [Transform::None, Transform::Implicit, Transform::LocalGlobal] {
        let settings =
            RetargetSettings { transform, start: Start::Aligned, ..RetargetSettings::default() };
        let retargeter = Retargeter::new(topology.clone(), &constraints, settings).unwrap();
        let mut workspace = retargeter.workspace();
        let mut solved = positions.clone();
        let allocations = allocation_counter::measure(|| {
            retargeter.assemble(&mesh, &mut workspace).unwrap();
            retargeter.factor(&mut workspace).unwrap();
            retargeter.solve(&mesh, &positions, &lengths, &mut workspace, &mut solved).unwrap();
        });
        assert_eq!(allocations.count_total, 0, "{transform:?}: {allocations:?}");
    }
    // The counter does count.
    assert!(allocation_counter::measure(|| drop(positions.clone())).count_total > 0);
}

#[test]
fn blends_allocate_nothing() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let reference = corners.map(Point::from);
    let shape = reference.map(|place| Point::new(place.y, -1.5 * place.x, place.z));
    let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let triangles = Triangles::new(4, triangles).unwrap();
    for energy in Energy::ALL {
        let settings = BlendSettings { energy, ..BlendSettings::default() };
        let blender = Blender::of_triangles(&triangles, &[&reference, &shape], settings).unwrap();
        let (mut workspace, mut out) = (blender.workspace(), reference);
        let allocations = allocation_counter::measure(|| {
            blender.blend(&[0.3], &mut workspace, &mut out);
        });
        assert_eq!(allocations.count_total, 0, "{energy:?}: {allocations:?}");
    }
}

#[test]
fn field_queries_allocate_nothing() {
    let pose = |k: i32| [1.0, 2.0, 3.0].map(|turn| (0.1 * turn * f64::from(k)).sin());
    // Some poses twice, so that places have more poses than corners.
    let poses: Vec<f64> = (0..200).chain(50..80).flat_map(pose).collect();
    for neighbourhood in Neighbourhood::ALL {
        let settings = MotionSettings { neighbourhood, ..MotionSettings::default() };
        let sequence = Rows::new(3, poses.clone()).unwrap();
        let model = MotionModel::fit(&[sequence], settings).unwrap();
        let mut around = model.around();
        let (mut point, mut velocity, mut pose) = ([0.0; 2], [0.0; 2], [0.0; 3]);
        let allocations = allocation_counter::measure(|| {
            for row in poses.chunks_exact(3) {
                model.pca().project_pose(row, &mut point);
                // On a pose, beside it, and outside the hull.
                for stretch in [1.0, 1.01, 5.0] {
                    let place = point.map(|value| stretch * value);
                    model.find(&place, &mut around);
                    model.velocity(&place, &mut around, &mut velocity);
                    model.pca().reproject_point(&velocity, &mut pose);
                }
            }
        });
        assert_eq!(allocations.count_total, 0, "{}: {allocations:?}", neighbourhood.name());
    }
}

#[test]
fn forecasts_allocate_nothing() {
    let skeleton = Skeleton::nite();
    let motion = |seed: f64| {
        let frame = |k: i64| {
            let time = k as f64 / 30.0;
            let place =
                |j: f64| Point::new((seed + time * j).sin(), (j * j + seed).cos(), time + j);
            let positions = (0..15).map(|j| place(0.3 * f64::from(j))).collect();
            Frame { stamp: Stamp(k * 33_333_333), positions }
        };
        Sequence::new(skeleton.clone(), (0..60).map(frame).collect()).unwrap()
    };
    let (one, other, seen) = (motion(0.0), motion(0.4), motion(0.7));
    for simplex_dimensions in [2, 3, 4] {
        let settings = ForecastSettings { simplex_dimensions, ..ForecastSettings::default() };
        let root = skeleton.root();
        let forecaster = Forecaster::fit(&[(&one, 0), (&other, 1)], root, settings).unwrap();
        let mut moment = Moment::new(&skeleton, root);
        let mut workspace = forecaster.workspace();
        for now in [1, 2, 30, 60] {
            let allocations = allocation_counter::measure(|| {
                moment.observe(&skeleton, &seen.frames()[..now], forecaster.velocity_window());
                for method in ForecastMethod::ALL {
                    forecaster.forecast(method, &moment, &mut workspace);
                }
            });
            assert_eq!(allocations.count_total, 0, "{simplex_dimensions}, {now}: {allocations:?}");
        }
    }
}

/// Ticks at 100 Hz, sightings at 30 Hz; in every four seconds another handover, with the hands of
/// another side, half a second without the partner, joints that are lost, and one that is called
/// off.
#[test]
fn ticks_allocate_nothing() {
    const TICK: i64 = 10_000_000;
    let demonstrations = handovers::demonstrations(6);
    let mut ticks = 0;
    use ReferenceBlend::{Mean, Rigid};
    for (transform, blend, count) in [
        (Transform::None, Mean, 4_500),
        (Transform::None, Rigid, 1_500),
        (Transform::LocalGlobal, Mean, 2_500),
        (Transform::Implicit, Mean, 1_500),
    ] {
        let retarget = RetargetSettings { transform, ..RetargetSettings::default() };
        let predict = PredictSettings { retarget, blend, ..PredictSettings::default() };
        let settings = OnlineSettings::default();
        let model = handovers::model_of(demonstrations.clone(), predict, settings);
        let robot = handovers::Handover::new(100).giver(0.0);
        let mut pipeline = handovers::pipeline(&model, &robot);
        let (mut hands, mut reasons) = (BTreeSet::new(), BTreeSet::new());
        let (mut solved, mut frame) = (0, -1);
        for tick in 0..count {
            let now = tick * TICK;
            let (seconds, cycle) = (now as f64 / 1e9 % 4.0, now / 4_000_000_000);
            let handover = handovers::Handover::new(100 + cycle as u64);
            let side = if cycle % 2 == 0 { Side::Right } else { Side::Left };
            let mut places = handover.with_hands(side, side).receiver(seconds);
            if (0.8..1.0).contains(&seconds) {
                places[4..9].fill(Point::new(f64::NAN, f64::NAN, f64::NAN));
            }
            let is_seen = frame != now / handovers::FRAME && !(2.5..3.0).contains(&seconds);
            frame = now / handovers::FRAME;
            let stamp = Stamp(frame * handovers::FRAME);
            let sighting =
                Sighting { stamp, body: Some(1), positions: &places, confidences: &[0.9; 15] };
            let input = TickInput {
                now: Stamp(now),
                sighting: is_seen.then_some(sighting),
                robot: Some(&robot),
            };
            let mut said = (model.library().exemplars()[0].hands, None, false);
            let allocations = allocation_counter::measure(|| {
                if cycle % 2 == 1 && (3.0..3.01).contains(&seconds) {
                    pipeline.cancel();
                }
                if cycle % 2 == 1 && (3.5..3.51).contains(&seconds) {
                    pipeline.reset();
                }
                let tick = pipeline.tick(&input);
                said = (tick.belief.hands, tick.reason, tick.solved.is_some());
            });
            assert_eq!(allocations.count_total, 0, "{transform:?}, tick {tick}: {allocations:?}");
            hands.insert(said.0);
            reasons.insert(said.1);
            solved += i64::from(said.2);
            ticks += 1;
        }
        println!("{transform:?}, {blend:?}: {solved} solved of {count}, {hands:?}, {reasons:?}");
        assert!(solved > count / 2 && hands.len() > 1 && reasons.len() > 2);
    }
    assert_eq!(ticks, 10_000);
}
