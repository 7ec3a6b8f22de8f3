//! Real recordings: nobody is doubted, and what is shown is near the recording smoothed with
//! knowledge of what comes later.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use handover_mesh::filter::{Filter, FilterSettings, Sighting};
use handover_mesh::formats::{self, UpAxis};
use handover_mesh::{Part, Point, Recording, Role, Sequence, Side, Skeleton, Span, Stamp};

/// The development recordings, which are no part of this package.
fn folder(below: &str) -> Option<PathBuf> {
    let shared = std::env::var_os("HANDOVER_DATA").map(PathBuf::from);
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = shared.unwrap_or_else(beside).join(below);
    if !folder.is_dir() {
        eprintln!("SKIPPED: no recordings at {}", folder.display());
        return None;
    }
    Some(folder)
}

fn read(path: &Path) -> Recording {
    let bytes = std::fs::read(path).unwrap();
    let name = path.file_stem().unwrap().to_str().unwrap();
    formats::read(&bytes, name, UpAxis::Z).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn sbu(class: &str) -> Option<Vec<Recording>> {
    let mut paths = Vec::new();
    for pair in std::fs::read_dir(folder("sbu/raw")?).unwrap() {
        let Ok(takes) = std::fs::read_dir(pair.unwrap().path().join(class)) else { continue };
        paths.extend(takes.map(|take| take.unwrap().path().join("skeleton_pos.txt")));
    }
    paths.sort();
    Some(paths.iter().map(|path| read(path)).collect())
}

fn dyn_handover() -> Option<Vec<Recording>> {
    let files = std::fs::read_dir(folder("dyn_handover/csv15")?).unwrap();
    let mut paths: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    Some(paths.iter().map(|path| read(path)).collect())
}

fn new_filter(skeleton: &Arc<Skeleton>) -> Filter {
    Filter::new(skeleton.clone(), skeleton.root(), FilterSettings::default())
}

#[derive(Debug, Default)]
struct Figures {
    people: usize,
    frames: usize,
    doubted: usize,
    swapped: usize,
    /// Of the joints that are no leg's.
    untracked: usize,
    joints: usize,
    /// Squares of distances from the smoothed recording, of the hands: raw, filtered.
    squares: [f64; 2],
    hands: usize,
    /// Sum over the hands of how far along its way the filtered one is behind `[m]`, and of the
    /// ways' speeds `[m/s]`: their quotient is a lag.
    behind: [f64; 2],
}

impl Figures {
    fn add(&mut self, motion: &Sequence) {
        let skeleton = motion.skeleton();
        let smooth = motion.smoothed(0.05);
        let mut filter = new_filter(skeleton);
        let hands = Side::BOTH.map(|side| skeleton.part(Part::Hand(side)).unwrap());
        let is_leg = |part| matches!(part, Some(Part::Hip(_) | Part::Knee(_) | Part::Foot(_)));
        self.people += 1;
        for (k, frame) in motion.frames().iter().enumerate() {
            let sighting = Sighting {
                stamp: frame.stamp,
                body: None,
                positions: &frame.positions,
                confidences: &[],
            };
            self.frames += 1;
            let Ok(partner) = filter.update(Some(&sighting), frame.stamp) else {
                self.doubted += 1;
                continue;
            };
            self.swapped += usize::from(partner.swapped());
            for joint in skeleton.joints().filter(|j| !is_leg(skeleton.part_of(*j))) {
                self.joints += 1;
                self.untracked += usize::from(!partner.is_tracked(joint));
            }
            if k < 3 || k + 1 >= motion.len() {
                continue;
            }
            for hand in hands {
                let truth = smooth.position(k, hand);
                let shown = partner.positions()[hand.index()];
                self.squares[0] += (frame.positions[hand.index()] - truth).norm_squared();
                self.squares[1] += (shown - truth).norm_squared();
                self.hands += 1;
                let way = smooth.position(k + 1, hand) - smooth.position(k - 1, hand);
                let span = (smooth.frames()[k + 1].stamp - smooth.frames()[k - 1].stamp).seconds();
                let velocity = way / span;
                self.behind[0] += (truth - shown).dot(&velocity);
                self.behind[1] += velocity.norm_squared();
            }
        }
    }

    fn of(recordings: &[Recording], name: &str) -> Self {
        let mut figures = Self::default();
        for recording in recordings {
            for role in [Role::First, Role::Second] {
                figures.add(&recording.person(role).motion);
            }
        }
        let [raw, shown] = figures.squares.map(|sum| 100.0 * (sum / figures.hands as f64).sqrt());
        println!(
            "{name}: {} people, {} frames, {} doubted, {} swapped; {:.2} % of upper joints untracked; \
             hands from the smoothed recording: raw {raw:.2} cm, filtered {shown:.2} cm, lag {:.0} ms",
            figures.people,
            figures.frames,
            figures.doubted,
            figures.swapped,
            100.0 * figures.untracked as f64 / figures.joints as f64,
            1e3 * figures.behind[0] / figures.behind[1],
        );
        figures
    }
}

/// How far off hands are `[m]`, root mean square, 0.1 s after the newest sighting, and when both
/// were hidden for the last 0.2 s.
fn carried(recordings: &[Recording]) -> [f64; 2] {
    let (mut squares, mut counts) = ([0.0; 2], [0.0; 2]);
    for recording in recordings {
        for role in [Role::First, Role::Second] {
            let motion = &recording.person(role).motion;
            let skeleton = motion.skeleton();
            let smooth = motion.smoothed(0.05);
            let hands = Side::BOTH.map(|side| skeleton.part(Part::Hand(side)).unwrap());
            let mut filter = new_filter(skeleton);
            let mut hiding: Option<(Filter, Stamp)> = None;
            for (k, frame) in motion.frames().iter().enumerate() {
                let stamp = frame.stamp;
                let mut positions = frame.positions.to_vec();
                let send = |filter: &mut Filter, positions: &[Point]| {
                    let sighting = Sighting { stamp, body: None, positions, confidences: &[] };
                    let partner = filter.update(Some(&sighting), stamp).ok()?;
                    let ahead = stamp + Span::from_seconds(0.1).unwrap();
                    let mut out = positions.to_vec();
                    partner.at(ahead, &mut out);
                    Some((hands.map(|hand| partner.positions()[hand.index()]), out))
                };
                let found = send(&mut filter, &positions);
                let last = motion.frames()[motion.len() - 1].stamp;
                let ahead = stamp + Span::from_seconds(0.1).unwrap();
                if let (Some((_, out)), true) = (&found, k > 5 && ahead <= last) {
                    let truth = smooth.resampled(&[ahead]).unwrap();
                    for hand in hands {
                        squares[0] += (out[hand.index()] - truth.position(0, hand)).norm_squared();
                        counts[0] += 1.0;
                    }
                }
                hands.iter().for_each(|hand| positions[hand.index()].x = f64::NAN);
                if let Some((hidden, since)) = &mut hiding {
                    let found = send(hidden, &positions);
                    if (stamp - *since).seconds() > 0.19 {
                        for (hand, place) in
                            hands.iter().zip(found.map(|f| f.0).into_iter().flatten())
                        {
                            squares[1] += (place - smooth.position(k, *hand)).norm_squared();
                            counts[1] += 1.0;
                        }
                        hiding = None;
                    }
                } else if k > 5 {
                    hiding = Some((filter.clone(), stamp));
                }
            }
        }
    }
    [0, 1].map(|which| (squares[which] / counts[which]).sqrt())
}

#[test]
fn hidden_hands_and_hands_to_come_are_near() {
    for (name, recordings) in [("SBU 07", sbu("07")), ("dynamic handovers", dyn_handover())] {
        let Some(recordings) = recordings else { continue };
        let [ahead, hidden] = carried(&recordings);
        println!(
            "{name}: hands 0.1 s ahead {:.1} cm off, hidden for 0.2 s {:.1} cm",
            1e2 * ahead,
            1e2 * hidden
        );
        assert!(ahead < 0.08 && hidden < 0.1, "{name}: {ahead} m, {hidden} m");
    }
}

#[test]
fn recordings_that_the_settings_were_chosen_on() {
    for class in ["04", "05", "08"] {
        let Some(recordings) = sbu(class) else { return };
        Figures::of(&recordings, &format!("SBU {class}"));
    }
}

#[test]
fn real_people_are_not_doubted() {
    if let Some(recordings) = dyn_handover() {
        let figures = Figures::of(&recordings, "dynamic handovers");
        assert_eq!((figures.doubted, figures.swapped), (0, 0));
        assert!(figures.squares[1] < 1.5_f64.powi(2) * 1e-4 * figures.hands as f64);
        assert!(figures.behind[0].abs() < 0.01 * figures.behind[1]);
    }
    if let Some(recordings) = sbu("07") {
        let figures = Figures::of(&recordings, "SBU 07");
        assert!(figures.doubted * 100 <= figures.frames, "{figures:?}");
    }
}

/// At every frame, apart: arms under each other's labels, and the other person in this one's place.
/// How often each was noticed at once and of how many times, and how often there was nothing to
/// notice but something was noticed.
fn troubled(recordings: &[Recording]) -> [[usize; 2]; 3] {
    let [mut swapped, mut exchanged, mut false_alarms] = [[0, 0]; 3];
    for recording in recordings {
        for role in [Role::First, Role::Second] {
            let motion = &recording.person(role).motion;
            let other = &recording.person(role.partner()).motion;
            let skeleton = motion.skeleton();
            let mut filter = new_filter(skeleton);
            for (k, frame) in motion.frames().iter().enumerate() {
                let send = |filter: &mut Filter, positions: &[Point]| {
                    let sighting =
                        Sighting { stamp: frame.stamp, body: None, positions, confidences: &[] };
                    filter.update(Some(&sighting), frame.stamp).map(|partner| partner.swapped())
                };
                if k > 5 {
                    let mut mislabelled = frame.positions.to_vec();
                    let arms = Side::BOTH.map(|side| skeleton.arm(side).unwrap());
                    for (left, right) in arms[0].iter().zip(arms[1]) {
                        mislabelled.swap(left.index(), right.index());
                    }
                    swapped[0] += usize::from(send(&mut filter.clone(), &mislabelled) == Ok(true));
                    swapped[1] += 1;
                    let someone = &other.frames()[k].positions;
                    exchanged[0] += usize::from(send(&mut filter.clone(), someone).is_err());
                    exchanged[1] += 1;
                }
                let found = send(&mut filter, &frame.positions);
                false_alarms[0] += usize::from(found != Ok(false));
                false_alarms[1] += 1;
            }
        }
    }
    [swapped, exchanged, false_alarms]
}

#[test]
fn real_arms_that_are_exchanged_and_real_people_are_noticed() {
    for (name, recordings) in [("SBU 07", sbu("07")), ("dynamic handovers", dyn_handover())] {
        let Some(recordings) = recordings else { continue };
        let [swapped, exchanged, alarms] = troubled(&recordings);
        println!(
            "{name}: exchanged arms mended {swapped:?}, exchanged people doubted {exchanged:?}, \
             false alarms {alarms:?}"
        );
        for [noticed, all] in [swapped, exchanged] {
            assert!(noticed * 100 >= all * 99, "{name}: {noticed} of {all}");
        }
    }
}
