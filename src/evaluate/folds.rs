//! Who may learn from whom.

/// More groups than this are dealt into folds instead of being left out one by one.
const MOST_SINGLE_GROUPS: usize = 20;

/// Deals items into folds: no item may learn from an item of its own fold.
///
/// Items of equal group stay together. Up to twenty groups make a fold each; more are dealt in
/// name order into `folds` folds, one after another.
///
/// Returns the fold of each item, in the items' order.
///
/// ```
/// use handover_mesh::evaluate::folds;
/// assert_eq!(folds(&["b", "a", "b"].map(String::from), 10), [1, 0, 1]);
/// ```
pub fn folds(groups: &[String], folds: usize) -> Vec<usize> {
    let mut names: Vec<&String> = groups.iter().collect();
    names.sort();
    names.dedup();
    let count = if names.len() > MOST_SINGLE_GROUPS { folds.max(2) } else { names.len() };
    let place = |group| names.binary_search(&group).unwrap_or(0);
    groups.iter().map(|group| place(group) % count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_groups_are_dealt_and_stay_whole() {
        let groups: Vec<String> = (0..42).map(|i| format!("g{:02}", i / 2)).collect();
        let folds = folds(&groups, 10);
        assert_eq!(folds.iter().max(), Some(&9));
        assert!((0..21).all(|g| folds[2 * g] == folds[2 * g + 1] && folds[2 * g] == g % 10));
    }
}
