//! The baseline `ridge`: the robot's pose as a linear function of the partner's, frame by frame.

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::demonstration::{Demonstration, Observation};
use crate::geometry::{Isometry, Point, Vector, yaw_isometry};
use crate::linear;

/// `y = mean + (x − mean) B`: `x` the partner's joints from the robot's base, `y` the robot's.
#[derive(Debug, Clone)]
pub(super) struct Ridge {
    input_mean: Vec<f64>,
    input_scale: Vec<f64>,
    output_mean: Vec<f64>,
    coefficients: DMatrix<f64>,
}

/// Which way the partner is, seen from the robot over the whole clip: the clip's own x axis.
fn clip_from_world(observation: &Observation) -> Isometry {
    axis((0..observation.len()).map(|frame| towards_partner(observation, frame)).sum())
}

fn towards_partner(observation: &Observation, frame: usize) -> Vector {
    observation.partner_place(frame) - observation.base[frame]
}

/// Turns what is seen along `towards` to the x axis.
fn axis(towards: Vector) -> Isometry {
    yaw_isometry(-towards.y.atan2(towards.x), Vector::zeros())
}

fn flatten<'a>(
    points: impl IntoIterator<Item = &'a Point>,
    from: Point,
    turn: &Isometry,
) -> Vec<f64> {
    points.into_iter().map(|p| turn * (p - from)).flat_map(|p| [p.x, p.y, p.z]).collect()
}

fn input(observation: &Observation, frame: usize, clip_from_world: &Isometry) -> Vec<f64> {
    let own = observation.partner.skeleton().own();
    let positions = &observation.partner.frames()[frame].positions[..own];
    flatten(positions, observation.base[frame], clip_from_world)
}

impl Ridge {
    pub(super) fn fit(demonstrations: &[Arc<Demonstration>], penalty: f64) -> Self {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for demonstration in demonstrations {
            let observation = demonstration.observation();
            let turn = clip_from_world(&observation);
            x.extend((0..observation.len()).map(|frame| input(&observation, frame, &turn)));
            let robot = demonstration.robot().frames().iter().zip(&observation.base);
            y.extend(robot.map(|(frame, base)| flatten(&frame.positions, *base, &turn)));
        }
        let matrix = |rows: &[Vec<f64>]| {
            let columns = rows.first().map_or(0, Vec::len);
            DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j])
        };
        let (mut x, mut y) = (matrix(&x), matrix(&y));
        let input_mean: Vec<f64> = x.column_iter().map(|column| column.mean()).collect();
        let output_mean: Vec<f64> = y.column_iter().map(|column| column.mean()).collect();
        let input_scale: Vec<f64> =
            x.column_iter().map(|column| column.variance().sqrt().max(1e-6)).collect();
        for (j, mut column) in x.column_iter_mut().enumerate() {
            column.apply(|value| *value = (*value - input_mean[j]) / input_scale[j]);
        }
        for (j, mut column) in y.column_iter_mut().enumerate() {
            column.add_scalar_mut(-output_mean[j]);
        }
        let coefficients = linear::ridge(&x, &y, penalty * x.nrows() as f64);
        Self { input_mean, input_scale, output_mean, coefficients }
    }

    pub(super) fn predict(&self, observation: &Observation) -> Vec<Point> {
        let turn = clip_from_world(observation);
        self.predict_by(observation, |_| turn)
    }

    /// The same where at each frame only the past is known.
    pub(super) fn predict_causally(&self, observation: &Observation) -> Vec<Point> {
        let mut towards = Vector::zeros();
        self.predict_by(observation, |frame| {
            towards += towards_partner(observation, frame);
            axis(towards)
        })
    }

    fn predict_by(
        &self,
        observation: &Observation,
        mut clip_from_world: impl FnMut(usize) -> Isometry,
    ) -> Vec<Point> {
        let mut predicted = Vec::new();
        for (frame, base) in observation.base.iter().enumerate() {
            let turn = clip_from_world(frame);
            let (input, world_from_clip) = (input(observation, frame, &turn), turn.inverse());
            let standard: Vec<f64> = input
                .iter()
                .zip(self.input_mean.iter().zip(&self.input_scale))
                .map(|(value, (mean, scale))| (value - mean) / scale)
                .collect();
            let change = DMatrix::from_row_slice(1, standard.len(), &standard) * &self.coefficients;
            let pose: Vec<f64> =
                self.output_mean.iter().zip(change.iter()).map(|(mean, d)| mean + d).collect();
            let joints = pose.chunks_exact(3).map(|p| Vector::new(p[0], p[1], p[2]));
            let first = predicted.len();
            predicted.extend(joints.map(|p| base + world_from_clip * p));
            // The base is known; the regression need not hit it.
            predicted[first + observation.robot_base.index()] = *base;
        }
        predicted
    }
}
