//! What a tick costs.

use handover_mesh::safety::{HoldReason, Proposal, SafetySettings};
use handover_mesh::{Span, Vector};

use crate::scene::{STEP, gate, partner, reach, seconds, standing, window};

#[test]
fn the_gate_allocates_nothing() {
    let mut gate = gate(SafetySettings::default());
    let pose = reach(Vector::new(0.2, 0.08, 0.45), 0.5, 0.8);
    let reversed: Vec<_> = standing().iter().map(|p| standing()[2] - (p - standing()[2])).collect();
    let mut later = standing();
    for tick in 0..300 {
        let now = f64::from(tick) / 100.0;
        let poses = if tick < 200 { window(&pose, now) } else { reversed.clone() };
        // They come into the way.
        let person = partner(1.5 - 0.5 * now, 0.0);
        let proposal = if (150..160).contains(&tick) {
            Proposal::Hold(HoldReason::Stale)
        } else {
            Proposal::Move { poses: &poses, step: STEP }
        };
        let allocations = allocation_counter::measure(|| {
            let target = gate.admit(proposal, Some(&person), seconds(now)).unwrap();
            target.positions_at(Span(50_000_000), &mut later);
        });
        assert_eq!(allocations.count_total, 0, "tick {tick}");
    }
}
