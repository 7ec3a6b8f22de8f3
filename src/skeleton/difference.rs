//! How one skeleton is not another, in words: for whoever has to mend a recording.

use super::{JointId, Skeleton};

/// How two people's joints are not those of others: `giver: right_hand is missing`; none where
/// they are the same.
///
/// - `people`: each one's name, skeleton, and what it would have to be.
///
/// ```
/// use handover_mesh::{Skeleton, skeleton::joint_differences};
/// let names = ["torso", "head", "left_hand"].map(str::to_owned);
/// let short = Skeleton::from_names(names[..2].to_vec()).unwrap();
/// let usual = Skeleton::from_names(names.to_vec()).unwrap();
/// let people = [("A", &short, &usual), ("B", &usual, &usual)];
/// assert_eq!(joint_differences(people).unwrap(), "A: left_hand is missing");
/// ```
pub fn joint_differences(people: [(&str, &Skeleton, &Skeleton); 2]) -> Option<String> {
    let different = people.into_iter().filter(|(_, skeleton, usual)| skeleton != usual);
    let words = different.map(|(name, skeleton, usual)| {
        let lacks = |of: &Skeleton, other: &Skeleton| -> Vec<String> {
            other.names().iter().filter(|name| of.joint(name).is_none()).cloned().collect()
        };
        let what = [(lacks(skeleton, usual), "missing"), (lacks(usual, skeleton), "extra")];
        let what = what.into_iter().filter(|(joints, _)| !joints.is_empty());
        let what = what.map(|(joints, what)| {
            format!("{} {} {what}", joints.join(", "), if joints.len() == 1 { "is" } else { "are" })
        });
        let what: Vec<String> = what.collect();
        let place = |of: &Skeleton, rider: JointId| {
            let bone = of.bones().find(|bone| bone.child == rider);
            bone.map_or("", |bone| of.name(bone.parent)).to_owned()
        };
        let moved = skeleton.attached().zip(usual.attached());
        let mut moved = moved.map(|(a, b)| (a, place(skeleton, a), place(usual, b)));
        let moved = moved.find(|(_, here, there)| here != there);
        if let (true, Some((rider, here, there))) = (what.is_empty(), moved) {
            format!("{name}: {} rides on {here}, not on {there}", skeleton.name(rider))
        } else if what.is_empty() {
            format!("{name}: the same joints in another order, or joined by other bones")
        } else {
            format!("{name}: {}", what.join(" and "))
        }
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() { None } else { Some(words.join("; ")) }
}
