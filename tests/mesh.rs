//! Topologies: from tetrahedra where there are any, with the bones always.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::sync::Arc;

use handover_mesh::mesh::{Edge, InitialEdges, Kernel, MeshError, Pair, Topology};
use handover_mesh::{Point, Role, Skeleton};

fn pair() -> Arc<Pair> {
    Arc::new(Pair::new([Skeleton::nite(), Skeleton::nite()]))
}

/// Thirty points in general position, the second person's far from the first's.
fn positions() -> Vec<Point> {
    let apart = |i: usize| if i < 15 { 0.0 } else { 3.0 };
    (0..30)
        .map(|i| (i as f64, apart(i)))
        .map(|(i, apart)| Point::new((1.3 * i).sin() + apart, (2.1 * i).cos(), (0.7 * i).sin()))
        .collect()
}

#[test]
fn tetrahedra_of_both_join_the_people_and_those_of_each_do_not() {
    let pair = pair();
    let initial = |edges| Topology::initial(pair.clone(), &positions(), edges).unwrap();
    let (each, both) = (initial(InitialEdges::EachPerson), initial(InitialEdges::BothPeople));
    let between = |topology: &Topology| {
        topology.edges().iter().filter(|edge| edge.is_interperson(&pair)).count()
    };
    assert_eq!(between(&each), 0);
    assert!(between(&both) > 5, "{}", between(&both));
    for topology in [&each, &both] {
        for [parent, child] in pair.bones() {
            assert!(topology.edges().contains(&Edge::new(child, parent)), "bones are edges");
        }
        assert!(topology.edges().len() > 28 + 20, "and there are others");
        assert!(topology.edges().is_sorted(), "in order");
        // Each edge is known to both of its ends.
        for (at, edge) in topology.edges().iter().enumerate() {
            let [a, b] = edge.ends().map(|vertex| vertex.index());
            assert!(topology.neighbours(a).any(|n| n == (b, at)));
            assert!(topology.neighbours(b).any(|n| n == (a, at)));
        }
    }
}

#[test]
fn flat_people_keep_their_bones() {
    let flat: Vec<Point> = positions().iter().map(|p| Point::new(p.x, 0.0, p.z)).collect();
    for edges in [InitialEdges::EachPerson, InitialEdges::BothPeople] {
        let topology = Topology::initial(pair(), &flat, edges).unwrap();
        assert_eq!(topology.edges().len(), 28);
    }
    let same = vec![Point::new(1.0, 2.0, 3.0); 30];
    assert_eq!(
        Topology::initial(pair(), &same, InitialEdges::BothPeople).unwrap().edges().len(),
        28
    );
}

#[test]
fn what_is_no_topology_is_refused() {
    let pair = pair();
    let initial = |positions: &[Point]| {
        Topology::initial(pair.clone(), positions, InitialEdges::BothPeople).unwrap_err()
    };
    let error = initial(&positions()[..29]);
    assert_eq!(error, MeshError::Shape { got: 29, frames: 1, vertices: 30 });
    let mut lost = positions();
    lost[3].y = f64::NAN;
    assert!(matches!(initial(&lost), MeshError::Delaunay(_)));
    let hand = pair.vertices(Role::Second).nth(8).unwrap();
    let error = Topology::new(pair.clone(), [Edge::new(hand, hand)]).unwrap_err();
    assert_eq!(error, MeshError::Edge { a: 23, b: 23, vertices: 30 });
}

#[test]
fn an_edge_named_twice_counts_once() {
    let pair = pair();
    let hand = |role| pair.vertices(role).nth(8).unwrap();
    let (a, b) = (hand(Role::First), hand(Role::Second));
    let bones = Topology::new(pair.clone(), []).unwrap();
    let joined = bones.with([Edge::new(a, b), Edge::new(b, a)]).unwrap();
    assert_eq!(joined.edges().len(), bones.edges().len() + 1);
}

#[test]
fn the_kernel_falls_with_distance_and_is_bounded_near_zero() {
    let kernel = Kernel::InverseDistance { scale: 3.0, power: 2.0, reference: 0.1, minimum: 0.05 };
    assert!((kernel.weight(0.1) - 3.0).abs() < 1e-12, "its scale at the reference distance");
    assert!((kernel.weight(0.2) - 0.75).abs() < 1e-12);
    assert_eq!(kernel.weight(0.0), kernel.weight(0.05));
    assert_eq!(Kernel::Uniform.weight(7.0), 1.0);
}
