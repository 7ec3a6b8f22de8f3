//! Once a workspace is made, assembling, factoring, solving, asking a motion model and forecasting
//! allocate nothing.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::sync::Arc;

use handover_mesh::forecast::{ForecastMethod, ForecastSettings, Forecaster, Moment};
use handover_mesh::mesh::{EdgeWeights, InitialEdges, InteractionMesh, Kernel, Pair, Topology};
use handover_mesh::motion::{MotionModel, MotionSettings, Neighbourhood, Rows};
use handover_mesh::retarget::{Constraint, RetargetSettings, Retargeter, Start, Transform};
use handover_mesh::{Frame, Point, Sequence, Skeleton, Stamp};

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
