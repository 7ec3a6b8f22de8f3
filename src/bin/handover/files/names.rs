//! A file's place in its folders → the clip's name and what the place tells about it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// SBU's one file name: the folders above it are pair, class and take.
const SBU_FILE: &str = "skeleton_pos.txt";

/// Where a file lies: its folders, outermost first, and its name without ending.
#[derive(Debug)]
pub(crate) struct Place {
    folders: Vec<String>,
    stem: String,
    file: String,
    in_sbu_tree: bool,
}

impl Place {
    pub(super) fn of(path: &Path) -> Self {
        // An argument may be a folder inside the tree: what is above it counts too.
        let whole = std::path::absolute(path).unwrap_or_else(|_| path.into());
        let text = |part: &std::ffi::OsStr| part.to_string_lossy().into_owned();
        let mut folders: Vec<String> =
            whole.parent().into_iter().flat_map(|parent| parent.iter().map(text)).collect();
        // The root is no name.
        folders.retain(|folder| !folder.starts_with(std::path::MAIN_SEPARATOR));
        let is_sbu = whole.file_name().is_some_and(|name| name == SBU_FILE);
        let pair = folders.len().checked_sub(3).map(|at| folders[at].as_str());
        let in_sbu_tree = is_sbu && pair.and_then(two_people).is_some();
        let stem = whole.file_stem().map(text).unwrap_or_default();
        let file = whole.file_name().map(text).unwrap_or_default();
        Self { folders, stem, file, in_sbu_tree }
    }

    /// The class, where the folders tell it.
    pub(super) fn class(&self) -> Option<&str> {
        self.sbu().map(|[_, class, _]| class.as_str())
    }

    fn sbu(&self) -> Option<&[String; 3]> {
        self.folders.last_chunk().filter(|_| self.in_sbu_tree)
    }

    /// What the folders tell: `class`, `pair` (whoever is first), `ordered_pair` and `take`.
    pub(super) fn metadata(&self) -> BTreeMap<String, String> {
        let Some([ordered_pair, class, take]) = self.sbu() else { return BTreeMap::new() };
        let (first, second) = two_people(ordered_pair).unwrap_or((ordered_pair, ""));
        let swapped = (second.len(), second) < (first.len(), first);
        let pair = if swapped { format!("{second}{first}") } else { ordered_pair.clone() };
        let known =
            [("class", class), ("pair", &pair), ("ordered_pair", ordered_pair), ("take", take)];
        known.into_iter().map(|(key, value)| (key.into(), value.clone())).collect()
    }

    /// `pair/class/take`, or the file's stem; with `more` of the folders above it.
    pub(super) fn name(&self, more: usize) -> String {
        let stem = if self.in_sbu_tree { None } else { Some(self.stem.as_str()) };
        let least = if self.in_sbu_tree { 3 } else { 0 };
        let from = self.folders.len().saturating_sub(least + more);
        let parts = self.folders[from..].iter().map(String::as_str).chain(stem);
        parts.collect::<Vec<_>>().join("/")
    }
}

/// `s01s02` → (`s01`, `s02`).
fn two_people(pair: &str) -> Option<(&str, &str)> {
    let at = pair.rfind('s').filter(|at| *at > 0)?;
    let is_one = |name: &str| {
        let digits = name.strip_prefix('s').unwrap_or("");
        !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
    };
    let (first, second) = pair.split_at(at);
    (is_one(first) && is_one(second)).then_some((first, second))
}

/// Each place's shortest name that no other has: folders are put before it where they must.
pub(super) fn distinct_names(mut places: Vec<Place>) -> Vec<String> {
    // `a.csv` beside `a.txt`: no folder tells them apart.
    let mut stems = BTreeMap::new();
    for place in &places {
        *stems.entry((place.folders.clone(), place.stem.clone())).or_insert(0) += 1;
    }
    for place in &mut places {
        let key = (place.folders.clone(), place.stem.clone());
        if stems.get(&key).is_some_and(|count| *count > 1) {
            place.stem.clone_from(&place.file);
        }
    }
    let mut more = vec![0; places.len()];
    let deepest = places.iter().map(|place| place.folders.len()).max().unwrap_or(0);
    let mut names = Vec::new();
    for _ in 0..=deepest + 1 {
        names = places.iter().zip(&more).map(|(place, more)| place.name(*more)).collect();
        let mut seen = BTreeSet::new();
        let twice: BTreeSet<&String> = names.iter().filter(|name| !seen.insert(*name)).collect();
        if twice.is_empty() {
            break;
        }
        for (name, more) in names.iter().zip(&mut more) {
            *more += usize::from(twice.contains(name));
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(path: &str) -> Place {
        Place::of(Path::new(path))
    }

    #[test]
    fn sbu_folders_name_the_clip() {
        let clip = place("/data/raw/s05s02/07/001/skeleton_pos.txt");
        assert_eq!((clip.name(0).as_str(), clip.class()), ("s05s02/07/001", Some("07")));
        let metadata = clip.metadata();
        let of = |key: &str| metadata[key].as_str();
        assert_eq!((of("pair"), of("ordered_pair"), of("take")), ("s02s05", "s05s02", "001"));
        assert_eq!(place("/data/mine/07/001/skeleton_pos.txt").name(0), "skeleton_pos");
        assert_eq!(place("/skeleton_pos.txt").metadata().len(), 0);
    }

    #[test]
    fn equal_names_take_their_folders_along() {
        let names = |paths: &[&str]| distinct_names(paths.iter().map(|path| place(path)).collect());
        assert_eq!(names(&["/d/x/a.csv", "/d/y/a.csv", "/d/y/b.csv"]), ["x/a", "y/a", "b"]);
        assert_eq!(names(&["/1/x/a.csv", "/2/x/a.csv"]), ["1/x/a", "2/x/a"]);
        assert_eq!(names(&["/d/a.csv", "/d/a.txt", "/d/b.txt"]), ["a.csv", "a.txt", "b"]);
    }
}
