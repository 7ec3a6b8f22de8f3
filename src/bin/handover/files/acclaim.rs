//! AMC files, each with the skeleton that lies beside it.

use std::fs;
use std::path::{Path, PathBuf};

use handover_mesh::formats::amc::{Asf, Motion};

use super::search::ends_in;
use super::{Fault, bytes, faults};

/// One person's motion, by the only .asf in its folder.
pub(super) fn read(path: &Path, motion: &[u8]) -> Result<Motion, Vec<Fault>> {
    let skeleton = skeleton_beside(path).map_err(|reason| vec![Fault::of_file(reason)])?;
    // Which line is at fault means nothing without the file that has it.
    let of_skeleton = |fault: Fault| {
        Fault::of_file(format!("its skeleton {}: {}", skeleton.display(), fault.text()))
    };
    let asf = bytes(&skeleton).and_then(|bytes| Asf::read(&bytes).map_err(|e| faults(&e)));
    let asf = asf.map_err(|all| all.into_iter().map(of_skeleton).collect::<Vec<_>>())?;
    Motion::read(motion, &asf).map_err(|error| faults(&error))
}

/// The only .asf in the folder of a file.
fn skeleton_beside(path: &Path) -> Result<PathBuf, String> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let folder = parent.unwrap_or(Path::new("."));
    let entries =
        fs::read_dir(folder).map_err(|error| format!("no skeleton beside it: {error}"))?;
    let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut found: Vec<PathBuf> = files.filter(|path| ends_in(path, &["asf"])).collect();
    found.sort();
    match &found[..] {
        [one] => Ok(one.clone()),
        [] => Err("no skeleton (.asf) beside it".to_owned()),
        [first, second, ..] => Err(format!(
            "which skeleton? {} and {} lie beside it",
            first.display(),
            second.display()
        )),
    }
}
