//! Who hangs from whom → every bone once, each after the one that it hangs from.

use std::collections::{BTreeMap, VecDeque};

use super::super::error::{Reason, Violations, shortened};
use super::skeleton::BoneId;

/// How the file names what bones hang from.
pub(super) const ROOT: &str = "root";

/// A line's word: `child` hangs from `parent`.
pub(super) struct Link<'a> {
    pub(super) line: u64,
    pub(super) parent: &'a str,
    pub(super) child: &'a str,
}

/// A tree: every bone's parent, and an order from the root outwards.
pub(super) struct Tree {
    /// `None` is the root.
    pub(super) parents: Vec<Option<BoneId>>,
    pub(super) outwards: Box<[BoneId]>,
}

/// The tree of these links, unless something is wrong, which is noted.
///
/// - `names`, `starts`: the bones and the lines that they start at, in the file's order.
pub(super) fn tree(
    links: &[Link],
    by_name: &BTreeMap<String, BoneId>,
    names: &[&str],
    starts: &[u64],
    violations: &mut Violations,
) -> Option<Tree> {
    let places = places(links, by_name, names.len(), violations);
    for (at, place) in places.iter().enumerate() {
        // A bone given twice, which is noted, has its place by its name.
        let is_known = by_name.get(names[at]).is_some_and(|bone| bone.index() == at);
        if place.is_none() && is_known {
            let what = format!("the place of bone '{}' in the hierarchy", shortened(names[at]));
            violations.add(starts[at], Reason::Missing { what });
        }
    }
    let outwards = outwards(&places);
    if outwards.len() < places.len() {
        note_cycles(&places, names, starts, violations);
        return None;
    }
    Some(Tree { parents: places.into_iter().flatten().collect(), outwards })
}

/// What each bone hangs from: `None` if it hangs nowhere, `Some(None)` if from the root.
type Place = Option<Option<BoneId>>;

fn places(
    links: &[Link],
    by_name: &BTreeMap<String, BoneId>,
    count: usize,
    violations: &mut Violations,
) -> Vec<Place> {
    let mut places = vec![None; count];
    let mut parent_before = "";
    for link in links {
        let parent = (link.parent != ROOT).then(|| by_name.get(link.parent).copied());
        // Once for all the bones that a line hangs from it.
        if parent == Some(None) && parent_before != link.parent {
            violations.add(link.line, Reason::NotInSkeleton { bone: shortened(link.parent) });
        }
        parent_before = link.parent;
        let Some(child) = by_name.get(link.child) else {
            let bone = shortened(link.child);
            violations.add(link.line, Reason::NotInSkeleton { bone });
            continue;
        };
        let place: &mut Place = &mut places[child.index()];
        if place.is_some() {
            let what = format!("the place of bone '{}' in the hierarchy", shortened(link.child));
            violations.add(link.line, Reason::Repeated { what });
        }
        // Where the parent is not known, which is noted, the child need not be named as well.
        *place = place.or(Some(parent.flatten()));
    }
    places
}

/// Those that the root leads to, each after its parent.
fn outwards(places: &[Place]) -> Box<[BoneId]> {
    let mut children = vec![Vec::new(); places.len()];
    let mut next = VecDeque::new();
    // There are never more bones than a `u16` counts.
    for (bone, place) in (0..).map(BoneId).zip(places) {
        match place {
            Some(Some(parent)) => children[parent.index()].push(bone),
            Some(None) => next.push_back(bone),
            None => {}
        }
    }
    let mut found = Vec::with_capacity(places.len());
    while let Some(bone) = next.pop_front() {
        found.push(bone);
        next.extend(&children[bone.index()]);
    }
    found.into()
}

/// Notes each ring of bones once, at the first of them.
fn note_cycles(places: &[Place], names: &[&str], starts: &[u64], violations: &mut Violations) {
    let mut told = vec![false; places.len()];
    for start in 0..places.len() {
        let parent = |at: usize| places[at].flatten().map(BoneId::index);
        let mut path = vec![start];
        // A way that is longer than there are bones runs around a ring elsewhere.
        while let Some(next) = parent(path[path.len() - 1]).filter(|_| path.len() <= places.len()) {
            if next == start {
                if !path.iter().any(|at| told[*at]) {
                    let bone = shortened(names[start]);
                    violations.add(starts[start], Reason::HangsFromItself { bone });
                }
                path.iter().for_each(|at| told[*at] = true);
                break;
            }
            path.push(next);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bones `a` to `e`, the first starting at line 1; links as `parent child`, from line 11.
    #[track_caller]
    fn check(links: &[&str], expected: Result<(&[Option<u16>], &[u16]), &str>) {
        let names = ["a", "b", "c", "d", "e"];
        let by_name = (0..).map(BoneId).zip(names).map(|(bone, name)| (name.into(), bone));
        let links = (11..).zip(links).map(|(line, link)| {
            let (parent, child) = link.split_once(' ').unwrap();
            Link { line, parent, child }
        });
        let links: Vec<Link> = links.collect();
        let mut violations = Violations::default();
        let found = tree(&links, &by_name.collect(), &names, &[1, 2, 3, 4, 5], &mut violations);
        match (violations.or(found).map_err(|error| error.to_string()), expected) {
            (Ok(tree), Ok((parents, outwards))) => {
                let numbers: Vec<_> = tree.parents.iter().map(|p| p.map(|bone| bone.0)).collect();
                assert_eq!(numbers, parents);
                assert_eq!(tree.outwards.iter().map(|bone| bone.0).collect::<Vec<_>>(), outwards);
            }
            (Err(found), Err(expected)) => assert_eq!(found, expected),
            (found, _) => panic!("{:?}", found.err()),
        }
    }

    #[test]
    fn bones_come_after_those_they_hang_from() {
        let links = ["c a", "root c", "a b", "root e", "b d"];
        check(&links, Ok((&[Some(2), Some(0), None, Some(1), None], &[2, 4, 0, 1, 3])));
    }

    #[test]
    fn rings_are_named_once() {
        let links = ["root a", "c b", "b c", "c d", "e e"];
        let expected = "line 2: bone 'b' hangs from itself\nline 5: bone 'e' hangs from itself";
        check(&links, Err(expected));
    }

    #[test]
    fn strangers_and_bones_twice_or_nowhere_are_named_together() {
        let links = ["root a", "x b", "b c", "root c", "root y"];
        let expected = "line 4: the place of bone 'd' in the hierarchy is missing\n\
            line 5: the place of bone 'e' in the hierarchy is missing\n\
            line 12: bone 'x' is not in the skeleton\n\
            line 14: the place of bone 'c' in the hierarchy appears twice\n\
            line 15: bone 'y' is not in the skeleton";
        check(&links, Err(expected));
    }
}
