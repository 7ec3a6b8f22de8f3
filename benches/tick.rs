//! One tick, from sighting to target: p50, p99 and maximum over made-up handovers, by transform and
//! by how many demonstrations there are; its parts apart; and a minute at 1 kHz.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]
#![allow(clippy::print_stdout, reason = "criterion's means hide the slowest tick")]
#![allow(clippy::disallowed_methods, reason = "the clock is what a bench is for")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use handover_mesh::filter::{Filter, Sighting};
use handover_mesh::forecast::Moment;
use handover_mesh::online::{
    OnlineModel, OnlineSettings, Perception, Reference, TickInput, Window,
};
use handover_mesh::retarget::Transform;
use handover_mesh::safety::{PartnerBody, Proposal, SafetyGate};
use handover_mesh::track::{Tracker, Who};
use handover_mesh::{Frame, Point, Skeleton, Stamp};

#[allow(dead_code, reason = "shared with tests that use other parts")]
#[path = "../tests/common/handovers.rs"]
mod handovers;
use handovers::{DURATION, FRAME, Handover, demonstrations, lengths, model, pipeline};

/// Handovers that nothing is learned from.
const SEEN: u64 = 20;
const PASSES: usize = 10;
const TRANSFORMS: [(&str, Transform); 3] = [
    ("none", Transform::None),
    ("local_global", Transform::LocalGlobal),
    ("implicit", Transform::Implicit),
];

fn main() {
    // `cargo bench` passes `--bench`; a name picks what is run.
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let is_wanted =
        |name: &str| wanted.is_empty() || wanted.iter().any(|part| name.contains(part.as_str()));
    for count in [5, 40] {
        for (name, transform) in TRANSFORMS {
            let names = ["tick", "parts", "minute"]
                .map(|kind| format!("{kind}/{name}, {count} demonstrations"));
            if !names.iter().any(|name| is_wanted(name)) {
                continue;
            }
            let model = model(demonstrations(count), transform, OnlineSettings::default());
            let [tick, part, minutes] = &names;
            if is_wanted(tick) {
                print_times(tick, &recorded(&model));
            }
            if is_wanted(part) {
                for (name, times) in parts(&model) {
                    print_times(&format!("{part}/{name}"), &[times]);
                }
            }
            if is_wanted(minutes) {
                minute(minutes, &model);
            }
        }
    }
}

/// Prints the times of all passes, and those of each tick's quickest pass: what it takes where
/// nobody else wants the core.
fn print_times(name: &str, passes: &[Vec<Duration>]) {
    let summary = |mut times: Vec<Duration>| {
        times.sort_unstable();
        let last = times.len() - 1;
        let [p50, p99, max] =
            [last / 2, last * 99 / 100, last].map(|at| times[at].as_secs_f64() * 1e6);
        format!("p50 {p50:7.1} µs   p99 {p99:7.1} µs   max {max:8.1} µs")
    };
    println!("{name:<52} {}", summary(passes.concat()));
    if passes.len() > 1 {
        let quickest = |at: usize| passes.iter().map(|pass| pass[at]).min();
        let quickest = (0..passes[0].len()).filter_map(quickest).collect();
        println!("{:>52} {}", "quickest of the passes", summary(quickest));
    }
}

/// Frames of a handover and the receiver's joints there.
fn frames(handover: &Handover) -> impl Iterator<Item = (Stamp, Vec<Point>)> {
    let count = (DURATION * 1e9) as i64 / FRAME;
    (0..count).map(|k| Stamp(k * FRAME)).map(|stamp| (stamp, handover.receiver(stamp.seconds())))
}

/// Every tick of each pass over the handovers at 30 Hz.
fn recorded(model: &Arc<OnlineModel>) -> Vec<Vec<Duration>> {
    let mut passes = vec![Vec::new(); PASSES];
    for seed in 0..SEEN {
        let handover = Handover::new(100 + seed);
        let robot = handover.giver(0.0);
        let mut pipeline = pipeline(model, &robot);
        for times in &mut passes {
            pipeline.reset();
            for (now, positions) in frames(&handover) {
                let positions = &positions;
                let sighting = Sighting { stamp: now, body: None, positions, confidences: &[] };
                let input = TickInput { now, sighting: Some(sighting), robot: Some(&robot) };
                let begun = Instant::now();
                black_box(pipeline.tick(black_box(&input)));
                times.push(begun.elapsed());
            }
        }
    }
    passes
}

/// What ticks are made of, each part on what the part before made.
fn parts(model: &Arc<OnlineModel>) -> [(&'static str, Vec<Duration>); 7] {
    let names = ["filter", "track + forecast", "track", "look", "reference", "solve", "gate"];
    let mut times = names.map(|name| (name, Vec::new()));
    let library = model.library();
    let (skeleton, settings) = (Skeleton::nite(), model.settings());
    let [robot_base, partner_base] = [Who::Robot, Who::Partner].map(|who| library.base(who));
    for seed in 0..SEEN {
        let handover = Handover::new(100 + seed);
        let robot = handover.giver(0.0);
        let base = robot[robot_base.index()];
        let mut filter = Filter::new(skeleton.clone(), partner_base, settings.filter.clone());
        let mut perception = Perception::new(model);
        let (mut tracker, mut moment) =
            (Tracker::new(library), Moment::new(&skeleton, partner_base));
        let mut reference = Reference::new(model);
        let mut window = Window::new(model, &lengths(&robot), true).unwrap();
        let safety = settings.safety.clone();
        let mut gate =
            SafetyGate::new(skeleton.clone(), robot_base, &lengths(&robot), safety).unwrap();
        gate.start(&robot, Stamp(0));
        let mut past: Vec<Frame> = Vec::new();
        for (now, positions) in frames(&handover) {
            let positions = &positions;
            let sighting = Sighting { stamp: now, body: None, positions, confidences: &[] };
            let begun = Instant::now();
            let Ok(partner) = filter.update(Some(&sighting), now) else { continue };
            times[0].1.push(begun.elapsed());

            let begun = Instant::now();
            perception.see(model, partner.stamp(), partner.positions(), base, |_| 0.0);
            times[1].1.push(begun.elapsed());

            past.push(Frame { stamp: now, positions: partner.positions().into() });
            moment.observe(&skeleton, &past, settings.track.velocity_window);
            let begun = Instant::now();
            tracker.observe(library, &moment, base, now);
            times[2].1.push(begun.elapsed());

            let begun = Instant::now();
            perception.look(model, now, base, |stamp, places| partner.at(stamp, places));
            times[3].1.push(begun.elapsed());

            let (belief, scene) = (perception.belief(), perception.scene());
            let begun = Instant::now();
            reference.fill(model, belief, scene, true);
            times[4].1.push(begun.elapsed());

            let begun = Instant::now();
            window.solve(model, belief, scene, &reference).unwrap();
            times[5].1.push(begun.elapsed());

            let [head, neck, torso] = [0, 1, 2].map(|joint| Some(positions[joint]));
            let proposal = Proposal::Move { poses: window.poses(), step: library.step() };
            let begun = Instant::now();
            black_box(gate.admit(proposal, Some(&PartnerBody { head, neck, torso }), now));
            times[6].1.push(begun.elapsed());
        }
    }
    times
}

/// A minute of ticks at 1 kHz and sightings at 30 Hz, one right after the other; how many took
/// longer than there is time.
fn minute(name: &str, model: &Arc<OnlineModel>) {
    const TICK: i64 = 1_000_000;
    let mut times = Vec::new();
    let handover = Handover::new(100);
    let robot = handover.giver(0.0);
    let mut pipeline = pipeline(model, &robot);
    let mut last = -1;
    for tick in 0..60_000 {
        let frame = tick * TICK / FRAME;
        let stamp = Stamp(frame * FRAME);
        // One handover after another.
        let positions = handover.receiver(stamp.seconds() % DURATION);
        let sighting = Sighting { stamp, body: None, positions: &positions, confidences: &[] };
        let sighting = (frame > last).then_some(sighting);
        last = frame;
        let input = TickInput { now: Stamp(tick * TICK), sighting, robot: Some(&robot) };
        let begun = Instant::now();
        black_box(pipeline.tick(black_box(&input)));
        times.push(begun.elapsed());
    }
    let longer = |limit: u64| times.iter().filter(|t| **t > Duration::from_millis(limit)).count();
    println!("{name:<50} longer than 1 ms: {}, than 2 ms: {}", longer(1), longer(2));
    print_times(name, &[times]);
}
