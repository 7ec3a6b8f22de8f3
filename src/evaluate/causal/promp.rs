//! Interaction movement primitives conditioned on the past: `r = r̄ + Σ_d s_d (r_d − r̄)`,
//! `(G + λI) s = g`, where `G` and `g` sum, over all that has been seen, the products of the
//! demonstrations' partners with each other and with the observed one (Maeda et al. 2014, in the
//! dual form; time by the tracker in place of basis functions).

use nalgebra::{DMatrix, DVector};

use crate::geometry::{Point, Vector};
use crate::online::{OnlineModel, Perception};
use crate::track::Who;

/// What has been seen so far, as products.
pub(super) struct Promp {
    gram: DMatrix<f64>,
    seen: DVector<f64>,
}

impl Promp {
    pub(super) fn new(model: &OnlineModel) -> Self {
        let count = model.library().exemplars().len();
        Self { gram: DMatrix::zeros(count, count), seen: DVector::zeros(count) }
    }

    /// Takes in one more frame, and says where the robot's joints are.
    ///
    /// - `partner`: the partner's joints `[m]`.
    /// - `base`: the robot's base `[m]`.
    /// - `pose`: overwritten.
    pub(super) fn predict(
        &mut self,
        model: &OnlineModel,
        perception: &Perception,
        partner: &[Point],
        base: Point,
        pose: &mut [Point],
    ) {
        let partner_base = partner[model.library().base(Who::Partner).index()];
        // What rides on the partner's joints tells nothing.
        let own = model.library().skeleton(Who::Partner).own();
        let columns = demonstrated(model, perception, Who::Partner, own);
        let mean = columns.column_mean();
        let observed = partner[..own].iter().flat_map(|place| {
            let from_base = place - partner_base;
            [from_base.x, from_base.y, from_base.z]
        });
        let news = DVector::from_iterator(mean.len(), observed) - &mean;
        let off = apart(columns, &mean);
        self.gram += off.tr_mul(&off);
        self.seen += off.tr_mul(&news);
        let count = self.seen.len();
        let noise = model.predict_settings().promp_noise * self.gram.trace().max(1e-12);
        let shares = (&self.gram + DMatrix::identity(count, count) * noise)
            .cholesky()
            .map_or_else(|| DVector::zeros(count), |factor| factor.solve(&self.seen));
        let joints = model.library().skeleton(Who::Robot).len();
        let robot = demonstrated(model, perception, Who::Robot, joints);
        let mean = robot.column_mean();
        let place = &mean + apart(robot, &mean) * shares;
        for (place, from_base) in pose.iter_mut().zip(place.as_slice().chunks_exact(3)) {
            *place = base + Vector::from_column_slice(from_base);
        }
        pose[model.library().base(Who::Robot).index()] = base;
    }
}

fn apart(mut columns: DMatrix<f64>, mean: &DVector<f64>) -> DMatrix<f64> {
    columns.column_iter_mut().for_each(|mut column| column -= mean);
    columns
}

/// The first joints from the base where every demonstration is believed to be: a column each.
fn demonstrated(
    model: &OnlineModel,
    perception: &Perception,
    who: Who,
    joints: usize,
) -> DMatrix<f64> {
    let library = model.library();
    let mut columns = DMatrix::zeros(3 * joints, library.exemplars().len());
    for (followed, mut column) in perception.everywhere().zip(columns.column_iter_mut()) {
        for joint in library.skeleton(who).joints().take(joints) {
            let from_base = library.from_base(followed.exemplar, who, followed.frame, joint);
            column.fixed_rows_mut::<3>(3 * joint.index()).copy_from(&followed.turned(from_base));
        }
    }
    columns
}
