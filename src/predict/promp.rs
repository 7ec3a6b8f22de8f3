//! The baseline `promp`: interaction probabilistic movement primitives (Maeda et al. 2014).
//!
//! Each demonstration, on the observation's time, becomes weights of Gaussian bases for all
//! coordinates of both people; over the demonstrations these are Gaussian, and the robot's are
//! conditioned on the partner's: `w_r = μ_r + Σ_rp (Σ_pp + λI)⁻¹ (w_p − μ_p)`, here in the dual
//! form, a system of as many unknowns as demonstrations.

use nalgebra::{DMatrix, DVector};

use super::PredictSettings;
use super::aligned::Alignment;
use crate::demonstration::Observation;
use crate::geometry::{Point, Vector};
use crate::linear;

pub(super) fn predict(
    observation: &Observation,
    alignment: &Alignment,
    settings: &PredictSettings,
) -> Vec<Point> {
    let frames = observation.len();
    let bases = settings.promp_bases;
    let phi = DMatrix::from_fn(frames, bases, |k, b| {
        let phase = k as f64 / (frames - 1).max(1) as f64;
        let centre = b as f64 / (bases - 1) as f64;
        (-0.5 * ((phase - centre) * bases as f64).powi(2)).exp()
    });
    // Coordinates from each person's own base: the places are known.
    let flatten = |points: &[Point], counted: usize, place: &dyn Fn(usize) -> Point| {
        let joints = points.len() / frames;
        DMatrix::from_fn(frames, 3 * counted, |k, c| {
            points[k * joints + c / 3][c % 3] - place(k)[c % 3]
        })
    };
    let (own, robot_joints) =
        (observation.partner.skeleton().own(), observation.robot_skeleton.len());
    let partner_place = |k: usize| observation.partner_place(k);
    let robot_place = |k: usize| observation.base[k];
    let weights = |positions: DMatrix<f64>| {
        let weights = linear::ridge(&phi, &positions, 1e-6);
        DVector::from_column_slice(weights.as_slice())
    };
    let people: Vec<[DVector<f64>; 2]> = alignment
        .all
        .iter()
        .map(|demonstration| {
            let partner = flatten(&demonstration.partner, own, &partner_place);
            let robot = flatten(&demonstration.robot, robot_joints, &robot_place);
            [weights(partner), weights(robot)]
        })
        .collect();
    let count = people.len() as f64;
    let mean = |person: usize| people.iter().map(|p| &p[person]).sum::<DVector<f64>>() / count;
    let (partner_mean, robot_mean) = (mean(0), mean(1));
    let off: Vec<DVector<f64>> = people.iter().map(|p| &p[0] - &partner_mean).collect();
    let observed: Vec<Point> =
        observation.partner.frames().iter().flat_map(|f| f.positions.iter().copied()).collect();
    let news = weights(flatten(&observed, own, &partner_place)) - &partner_mean;
    // Gram matrix of the demonstrations; the noise is a share of their mean variance.
    let gram = DMatrix::from_fn(off.len(), off.len(), |i, j| off[i].dot(&off[j]));
    let noise = settings.promp_noise * gram.trace().max(1e-12);
    let seen = DVector::from_iterator(off.len(), off.iter().map(|o| o.dot(&news)));
    let shares = (gram + DMatrix::identity(off.len(), off.len()) * noise)
        .cholesky()
        .map_or_else(|| DVector::zeros(off.len()), |factor| factor.solve(&seen));
    let mut robot = robot_mean.clone();
    for (share, person) in shares.iter().zip(&people) {
        robot += (&person[1] - &robot_mean) * *share;
    }
    let coordinates = robot_joints * 3;
    let path = &phi * DMatrix::from_column_slice(bases, coordinates, robot.as_slice());
    let mut predicted = Vec::with_capacity(frames * coordinates / 3);
    for k in 0..frames {
        let base = observation.base[k];
        for joint in 0..coordinates / 3 {
            let from_base = Vector::from_fn(|axis, _| path[(k, 3 * joint + axis)]);
            predicted.push(base + from_base);
        }
        predicted[k * coordinates / 3 + observation.robot_base.index()] = base;
    }
    predicted
}
