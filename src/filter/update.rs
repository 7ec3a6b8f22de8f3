//! The filter itself: what each stage says of a sighting, put together.

use std::sync::Arc;

use super::body::Body;
use super::bones::Bones;
use super::clock::{Admission, Clock, Receipt};
use super::history::History;
use super::identity::{self, Identity, Whereabouts};
use super::swap::{Labels, Swap};
use super::tracks::Tracks;
use super::{Doubt, FilterSettings, Partner, Sighting, is_usable, seconds_since};
use crate::geometry::Point;
use crate::skeleton::{JointId, Skeleton};
use crate::time::Stamp;

/// One person's sightings → that person now: see the [module](super).
///
/// ```
/// use handover_mesh::filter::{Doubt, Filter, FilterSettings, Sighting};
/// use handover_mesh::{Point, Skeleton, Stamp};
/// let skeleton = Skeleton::nite();
/// let mut filter = Filter::new(skeleton.clone(), skeleton.root(), FilterSettings::default());
/// assert_eq!(filter.partner().unwrap_err(), Doubt::Nobody);
/// let positions: Vec<Point> = (0..15).map(|j| Point::new(0.0, 0.0, 0.1 * f64::from(j))).collect();
/// let sighting =
///     Sighting { stamp: Stamp(0), body: None, positions: &positions, confidences: &[] };
/// let partner = filter.update(Some(&sighting), Stamp(5_000_000)).unwrap();
/// assert!(partner.is_new() && partner.is_tracked(skeleton.root()));
/// // Nothing more comes.
/// assert!(matches!(filter.update(None, Stamp(400_000_000)), Err(Doubt::Stale(_))));
/// ```
#[derive(Debug, Clone)]
pub struct Filter {
    pub(super) settings: FilterSettings,
    pub(super) body: Body,
    pub(super) tracks: Tracks,
    pub(super) history: History,
    bones: Bones,
    clock: Clock,
    identity: Identity,
    swap: Swap,
    /// When this person was first seen, and when last seen well enough to be told from others.
    known: Option<[Stamp; 2]>,
    /// The sensor's number of this person.
    number: Option<u32>,
    /// When the last sighting was taken, and when the last one was not, and why.
    taken: Option<Receipt>,
    refused: Option<(Doubt, Receipt)>,
    /// This person is yet to be announced.
    is_unannounced: bool,
    doubt: Option<Doubt>,
    ignored: Option<Doubt>,
    pub(super) is_fresh: bool,
    pub(super) is_new: bool,
    pub(super) is_swapped: bool,
    /// Joints of the sighting that can be used, and where they are expected: scratch.
    seen: Box<[Option<Point>]>,
    expected: Box<[Option<Point>]>,
}

impl Filter {
    /// A filter that has seen nobody yet; the last call that allocates.
    ///
    /// - `base`: the joint without which the person is not known (the root, mostly).
    ///
    /// # Panics
    /// If `settings` are out of their bounds ([`FilterSettings::check`] says so before) or `base`
    /// is no joint of the skeleton: the caller's bugs.
    pub fn new(skeleton: Arc<Skeleton>, base: JointId, settings: FilterSettings) -> Self {
        if let Err(error) = settings.check() {
            panic!("{error}");
        }
        let joints = skeleton.len();
        assert!(base.index() < joints, "the base is a joint of the skeleton");
        Self {
            settings,
            body: Body::new(&skeleton, base),
            tracks: Tracks::new(joints),
            history: History::new(joints),
            bones: Bones::new(joints),
            clock: Clock::default(),
            identity: Identity::new(joints),
            swap: Swap::default(),
            known: None,
            number: None,
            taken: None,
            refused: None,
            is_unannounced: false,
            doubt: Some(Doubt::Nobody),
            ignored: None,
            is_fresh: false,
            is_new: false,
            is_swapped: false,
            seen: vec![None; joints].into(),
            expected: vec![None; joints].into(),
        }
    }

    /// Takes what came in since the last call, if anything.
    ///
    /// A single sighting that is not taken because of its stamp leaves the person as known as
    /// before: see [`Self::ignored`]. Nothing is allocated.
    ///
    /// - `now`: the receipt; staleness counts from it. It may run back.
    ///
    /// # Errors
    /// [`Doubt`]: why the person is not known now. Whoever is doubted is not shown, even where
    /// something is known of them.
    ///
    /// # Panics
    /// If the sighting has another number of joints than the skeleton, or of confidences than none
    /// or that: the caller's bug. No value in it panics.
    pub fn update(
        &mut self,
        sighting: Option<&Sighting<'_>>,
        now: Stamp,
    ) -> Result<Partner<'_>, Doubt> {
        (self.is_fresh, self.is_new, self.ignored) = (false, false, None);
        if let Some(sighting) = sighting {
            let (joints, confidences) = (sighting.positions.len(), sighting.confidences.len());
            assert_eq!(joints, self.body.len(), "joints of the sighting and the skeleton");
            assert!(confidences == 0 || confidences == joints, "a confidence for every joint");
            match self.take(sighting, now) {
                Ok(()) => {
                    self.taken = Some(Receipt::new(now));
                    self.refused = None;
                    self.is_fresh = true;
                }
                Err(doubt) => {
                    self.ignored = Some(doubt);
                    // A wrong stamp does not make somebody else the person again.
                    let before = self.refused.filter(|_| self.identity.is_doubted());
                    let is_of_stamp = matches!(doubt, Doubt::OutOfOrder | Doubt::FarFromNow(_));
                    let doubt = before.filter(|_| is_of_stamp).map_or(doubt, |(kept, _)| kept);
                    self.refused = Some((doubt, Receipt::new(now)));
                }
            }
        }
        self.doubt = self.doubt_at(now);
        if self.doubt.is_none() {
            self.is_new = std::mem::take(&mut self.is_unannounced);
        }
        self.partner()
    }

    /// The person as after the last update.
    ///
    /// # Errors
    /// As [`Self::update`] said.
    pub fn partner(&self) -> Result<Partner<'_>, Doubt> {
        match self.doubt {
            None => Ok(Partner { filter: self }),
            Some(doubt) => Err(doubt),
        }
    }

    /// Why the last update's sighting was not taken, if there was one and it was not.
    pub fn ignored(&self) -> Option<Doubt> {
        self.ignored
    }

    /// Forgets everything: as new.
    pub fn reset(&mut self) {
        self.start_anew();
        self.clock = Clock::default();
        (self.taken, self.refused, self.ignored) = (None, None, None);
        self.doubt = Some(Doubt::Nobody);
        (self.is_fresh, self.is_new, self.is_unannounced) = (false, false, false);
    }

    /// Forgets the person: whoever is taken next is new.
    fn start_anew(&mut self) {
        self.tracks.forget();
        self.history.forget();
        self.bones.forget();
        self.identity.forget();
        self.swap = Swap::default();
        self.known = None;
        self.number = None;
        self.is_swapped = false;
        self.is_unannounced = true;
    }

    /// Takes a sighting, or says why not.
    fn take(&mut self, sighting: &Sighting<'_>, now: Stamp) -> Result<(), Doubt> {
        let stamp = sighting.stamp;
        match self.clock.admit(stamp, now, &self.settings) {
            Admission::Take => {}
            Admission::Restart => self.start_anew(),
            Admission::Ignore(doubt) => return Err(doubt),
        }
        let usable = self.gather(sighting);
        let is_clear = usable >= identity::ENOUGH;
        let unknown_for = self.known.map_or(0.0, |[_, last]| seconds_since(stamp, last));
        // Whoever was watched elsewhere meanwhile has to settle first.
        if is_clear && unknown_for > self.settings.forget && !self.identity.is_doubted() {
            self.start_anew();
        }
        if self.known.is_some() {
            self.recognise(sighting)?;
        } else {
            self.start_anew();
        }
        self.identity.forget();
        self.number = sighting.body.or(self.number);
        let [first, last] = self.known.unwrap_or([stamp; 2]);
        self.known = Some([first, if is_clear { stamp } else { last }]);
        self.bones.look(&self.body, &self.seen, stamp, &self.settings);
        self.tracks.take(&self.body, &self.seen, stamp, &mut self.bones, &self.settings);
        if self.was_all_seen() {
            self.history.push(stamp, self.tracks.places.iter().copied());
        }
        Ok(())
    }

    /// Fills `seen`; returns how many joints that are no leg's can be used.
    fn gather(&mut self, sighting: &Sighting<'_>) -> usize {
        let mut usable = 0;
        for (joint, place) in sighting.positions.iter().enumerate() {
            // A confidence that is no number is none.
            let is_sure =
                sighting.confidences.get(joint).is_none_or(|c| *c >= self.settings.confidence);
            self.seen[joint] = (is_sure && is_usable(place)).then_some(*place);
            usable += usize::from(self.seen[joint].is_some() && !self.body.joints[joint].is_leg);
        }
        usable
    }

    /// Mends the labels of a sighting of the known person; begins anew where it is believed to be
    /// someone else's, or refuses it.
    fn recognise(&mut self, sighting: &Sighting<'_>) -> Result<(), Doubt> {
        let Self { body, tracks, settings, seen, expected, .. } = self;
        let stamp = sighting.stamp;
        for (joint, expected) in expected.iter_mut().enumerate() {
            *expected = tracks
                .absence(joint, stamp)
                .map(|_| tracks.carried(body, joint, stamp, settings.bridge, settings));
        }
        // After a while nobody knows which way a person turned.
        let is_recent = seconds_since(stamp, tracks.stamp()) <= settings.bridge;
        let found = if is_recent { Swap::find(body, expected, seen) } else { [false; 2] };
        let exchange = |seen: &mut [Option<Point>]| {
            (0..2).filter(|group| found[*group]).for_each(|g| Swap::exchange(body, g, seen));
        };
        exchange(seen);
        let absence = |joint| tracks.absence(joint, stamp).unwrap_or(0.0);
        let whereabouts = self.identity.whereabouts(body, expected, seen, absence, settings);
        match whereabouts {
            Whereabouts::Unclear if self.identity.is_doubted() => {
                return Err(self.refused.map_or(Doubt::Jump, |(doubt, _)| doubt));
            }
            Whereabouts::Here | Whereabouts::Unclear => {}
            Whereabouts::Elsewhere => {
                exchange(seen);
                let numbers = [self.number, sighting.body];
                return match self.identity.watch(body, seen, stamp, numbers, settings) {
                    Some(doubt) => Err(doubt),
                    None => {
                        self.start_anew();
                        Ok(())
                    }
                };
            }
        }
        self.settle_sides(found, stamp);
        Ok(())
    }

    /// Keeps labels exchanged, or gives up doing so: the sides in question are as new.
    fn settle_sides(&mut self, found: [bool; 2], stamp: Stamp) {
        let started = self.known.map_or(stamp, |[first, _]| first);
        let labels = self.swap.judge(found, stamp, started, &self.settings);
        self.is_swapped = labels.contains(&Labels::Exchanged);
        for (group, _) in labels.iter().enumerate().filter(|(_, l)| **l == Labels::Believed) {
            Swap::exchange(&self.body, group, &mut self.seen);
            for &joint in self.body.pairs[group].iter().flatten() {
                self.tracks.forget_joint(joint);
                self.bones.forget_joint(&self.body, joint);
            }
            self.history.forget();
            self.is_unannounced = true;
        }
    }

    /// Why the person is not known at `now`.
    fn doubt_at(&mut self, now: Stamp) -> Option<Doubt> {
        let stale = self.settings.stale;
        let refused = self.refused.as_mut();
        let refused =
            refused.and_then(|(doubt, at)| (at.age(now).seconds() <= stale).then_some(*doubt));
        let Some(taken) = &mut self.taken else { return Some(refused.unwrap_or(Doubt::Nobody)) };
        let age = taken.age(now);
        if age.seconds() > stale {
            return Some(refused.unwrap_or(Doubt::Stale(age)));
        }
        // Someone else was seen last: not even the newest sighting taken is of use.
        if let Some((doubt, _)) = self.refused.filter(|_| self.identity.is_doubted()) {
            return Some(doubt);
        }
        (!self.is_whole()).then_some(Doubt::Lost)
    }

    /// Whether enough of the person was seen lately: the base, most of the trunk, and all but the
    /// legs at some time.
    fn is_whole(&self) -> bool {
        let stamp = self.tracks.stamp();
        let is_held = |joint| {
            self.tracks.absence(joint, stamp).is_some_and(|absence| absence <= self.settings.bridge)
        };
        let trunk = || (0..self.body.len()).filter(|joint| self.body.joints[*joint].is_trunk);
        let held = trunk().filter(|joint| is_held(*joint)).count();
        self.was_all_seen() && is_held(self.body.base) && 2 * held > trunk().count()
    }

    /// Whether every joint that is no leg's was seen at some time: before that some places are
    /// nobody's.
    fn was_all_seen(&self) -> bool {
        let stamp = self.tracks.stamp();
        let is_needed = |joint: &usize| !self.body.joints[*joint].is_leg;
        let mut needed = (0..self.body.len()).filter(is_needed);
        needed.all(|joint| self.tracks.absence(joint, stamp).is_some())
    }
}
