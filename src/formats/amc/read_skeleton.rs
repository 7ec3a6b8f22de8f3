//! The sections of an ASF file → an [`Asf`], or everything that is wrong with it.

use std::collections::{BTreeMap, BTreeSet};

use super::super::error::{ReadError, Reason, Violations, shortened};
use super::super::field;
use super::hierarchy::{self, Link, ROOT};
use super::lines::{AngleUnit, first_word, lines, numbers, one_word, unknown};
use super::read_bone::BoneDraft;
use super::read_root::RootDraft;
use super::skeleton::{Asf, Bone, BoneId};

/// The sections of an ASF file; what the first three say is free.
pub(in crate::formats) const SECTIONS: [&str; 7] =
    [":version", ":name", ":documentation", ":units", ":root", ":bonedata", ":hierarchy"];
const KNOWN_SECTIONS: &str =
    ":version, :name, :documentation, :units, :root, :bonedata, :hierarchy";
const NEEDED: [&str; 4] = [":units", ":root", ":bonedata", ":hierarchy"];
/// CMU's units of length are inches, scaled.
const METRES_PER_INCH: f64 = 0.0254;

/// What a key says: not given, given but wrong (which is noted), or its value.
pub(super) type Slot<T> = Option<Option<T>>;

/// Notes a key that is given twice; the first value stays.
pub(super) fn put<T>(
    slot: &mut Slot<T>,
    value: Option<T>,
    key: &str,
    line: u64,
    violations: &mut Violations,
) {
    if slot.is_some() {
        violations.add(line, Reason::Repeated { what: format!("'{key}'") });
    }
    slot.get_or_insert(value);
}

/// What a key must say, unless it is wrong, or not there, which is noted.
pub(super) fn take<T>(
    slot: Slot<T>,
    key: impl FnOnce() -> String,
    line: u64,
    violations: &mut Violations,
) -> Option<T> {
    if slot.is_none() {
        violations.add(line, Reason::Missing { what: key() });
    }
    slot.flatten()
}

/// Reads an ASF file.
pub(super) fn read(bytes: &[u8]) -> Result<Asf, ReadError> {
    let mut violations = Violations::default();
    if bytes.trim_ascii().is_empty() {
        return Err(ReadError::of(1, Reason::Empty));
    }
    let mut reader = Reader::default();
    for (number, line) in lines(bytes) {
        let Ok(text) = std::str::from_utf8(line) else {
            violations.add(number, Reason::NotUtf8);
            continue;
        };
        reader.line(text, number, &mut violations);
        if reader.bones.len() > Asf::MOST_BONES || reader.links.len() > 2 * Asf::MOST_BONES {
            violations.add(number, Reason::TooManyBones { most: Asf::MOST_BONES });
            return violations.or(None);
        }
    }
    let skeleton = reader.finish(&mut violations);
    violations.or(skeleton)
}

#[derive(Default)]
struct Reader<'a> {
    /// The sections so far, each with its line.
    sections: BTreeMap<&'static str, u64>,
    /// `None` before the first, and in one that is unknown: its lines say nothing.
    section: Option<&'static str>,
    name: Option<String>,
    length: Slot<f64>,
    mass: Slot<f64>,
    angle: Slot<AngleUnit>,
    root: RootDraft,
    bones: Vec<BoneDraft<'a>>,
    /// Where the `begin` is that has no `end` yet.
    open: Option<u64>,
    links: Vec<Link<'a>>,
}

impl<'a> Reader<'a> {
    fn line(&mut self, text: &'a str, line: u64, violations: &mut Violations) {
        if text.starts_with(':') {
            return self.start_section(text, line, violations);
        }
        let (word, rest) = first_word(text);
        match self.section {
            Some(":units") => self.unit(word, rest, line, violations),
            Some(":root") => self.root.line(word, rest, line, violations),
            Some(":bonedata") => self.bone(word, text, line, violations),
            Some(":hierarchy") => self.link(word, rest, line, violations),
            None if self.sections.is_empty() => {
                violations.add(line, unknown("section", text, KNOWN_SECTIONS));
                // Once is enough: whatever stands before the first section belongs to none.
                self.sections.insert("", line);
            }
            _ => {}
        }
    }

    fn start_section(&mut self, text: &'a str, line: u64, violations: &mut Violations) {
        self.close(violations);
        let (word, rest) = first_word(text);
        self.section = SECTIONS.into_iter().find(|known| known.eq_ignore_ascii_case(word));
        let Some(section) = self.section else {
            self.sections.entry("").or_insert(line);
            return violations.add(line, unknown("section", word, KNOWN_SECTIONS));
        };
        if self.sections.insert(section, line).is_some() {
            violations.add(line, Reason::Repeated { what: format!("section '{section}'") });
        }
        if section == ":name" {
            self.name = Some(rest.trim().to_owned());
        }
    }

    fn unit(&mut self, word: &str, rest: &str, line: u64, violations: &mut Violations) {
        let positive = |key: &'static str, violations: &mut Violations| {
            let [value] = numbers(rest, [key], line, violations)?;
            if value > 0.0 {
                return Some(value);
            }
            let (field, bound) = (key.into(), "above 0");
            violations.add(line, Reason::OutOfBounds { field, value, bound });
            None
        };
        match word {
            "length" => {
                let value = positive("length", violations);
                put(&mut self.length, value, word, line, violations);
            }
            "mass" => {
                let value = positive("mass", violations);
                put(&mut self.mass, value, word, line, violations);
            }
            "angle" => {
                let unit = one_word(rest, line, violations).and_then(|unit| match unit {
                    "deg" => Some(AngleUnit::Degrees),
                    "rad" => Some(AngleUnit::Radians),
                    _ => {
                        violations.add(line, unknown("angle", unit, "deg, rad"));
                        None
                    }
                });
                put(&mut self.angle, unit, word, line, violations);
            }
            _ => violations.add(line, unknown("unit", word, "mass, length, angle")),
        }
    }

    fn bone(&mut self, word: &str, text: &'a str, line: u64, violations: &mut Violations) {
        match (word, self.open) {
            ("begin", _) => {
                self.close(violations);
                self.open = Some(line);
                self.bones.push(BoneDraft::new(line));
            }
            ("end", Some(_)) => self.open = None,
            (_, Some(_)) => {
                if let Some(bone) = self.bones.last_mut() {
                    bone.line(text, line, violations);
                }
            }
            _ => violations.add(line, unknown("word outside 'begin' and 'end'", word, "begin")),
        }
    }

    fn link(&mut self, word: &'a str, rest: &'a str, line: u64, violations: &mut Violations) {
        match (word, self.open) {
            ("begin", None) => self.open = Some(line),
            ("end", Some(_)) => self.open = None,
            (_, Some(_)) => {
                let children = rest.split_ascii_whitespace();
                let links = children.map(|child| Link { line, parent: word, child });
                // One more than may be, for the caller to see that there are too many.
                let room = (2 * Asf::MOST_BONES + 1).saturating_sub(self.links.len());
                self.links.extend(links.take(room));
            }
            _ => violations.add(line, unknown("word outside 'begin' and 'end'", word, "begin")),
        }
    }

    /// Notes a `begin` whose `end` did not come.
    fn close(&mut self, violations: &mut Violations) {
        if let Some(line) = self.open.take() {
            violations.add(line, Reason::Missing { what: "the 'end' of this 'begin'".into() });
        }
    }

    fn finish(mut self, violations: &mut Violations) -> Option<Asf> {
        self.close(violations);
        let at = |section: &'static str| self.sections.get(section).copied();
        for section in NEEDED.into_iter().filter(|section| at(section).is_none()) {
            violations.add(1, Reason::Missing { what: format!("section '{section}'") });
        }
        // What a section that is missing does not say need not be named as well.
        let line = |section| at(section).unwrap_or(0);
        let (units, root, bonedata) = (line(":units"), line(":root"), line(":bonedata"));
        let length = needed(self.length, "'length'", units, violations);
        let angle = needed(self.angle, "'angle'", units, violations);
        if self.bones.is_empty() && bonedata > 0 {
            violations.add(bonedata, Reason::Missing { what: "a bone".into() });
        }
        let by_name = by_name(&self.bones, violations);
        let names: Vec<&str> = self.bones.iter().map(|bone| bone.label()).collect();
        let starts: Vec<u64> = self.bones.iter().map(|bone| bone.start).collect();
        let tree = self
            .sections
            .contains_key(":hierarchy")
            .then(|| hierarchy::tree(&self.links, &by_name, &names, &starts, violations));
        // Without units the rest of a bone is looked at all the same.
        let scale = length.map_or(1.0, |length| METRES_PER_INCH / length);
        let unit = angle.unwrap_or(AngleUnit::Degrees);
        if let Err(reason) = field::within_reach(scale, || "length".into()) {
            violations.add(units, reason);
            return None;
        }
        let mut bones: Vec<Bone> = Vec::new();
        let mut channels = 0;
        for draft in self.bones {
            if let Some(bone) = draft.finish(scale, unit, channels, violations) {
                channels += bone.dofs.len();
                bones.push(bone);
            }
        }
        let root = self.root.finish(root, scale, unit, violations);
        let (root, tree) = (root?, tree??);
        if !violations.none() {
            return None;
        }
        for (bone, parent) in bones.iter_mut().zip(tree.parents) {
            bone.parent = parent;
        }
        Some(Asf {
            name: self.name,
            metres_per_unit: scale,
            mass: self.mass.flatten(),
            root,
            bones: bones.into(),
            by_name,
            outwards: tree.outwards,
        })
    }
}

/// What a key of a section must say; a section that is not there has line 0 and says nothing.
pub(super) fn needed<T>(
    slot: Slot<T>,
    key: &str,
    section: u64,
    violations: &mut Violations,
) -> Option<T> {
    if section == 0 {
        return None;
    }
    take(slot, || key.into(), section, violations)
}

/// Every name's bone; a name or an id given twice is noted.
fn by_name(bones: &[BoneDraft], violations: &mut Violations) -> BTreeMap<String, BoneId> {
    let mut found = BTreeMap::new();
    let mut ids = BTreeSet::new();
    // There are never more bones than a `u16` counts.
    for (at, bone) in (0..).map(BoneId).zip(bones) {
        if let Some(name) = bone.name.flatten() {
            let repeated = name == ROOT || found.contains_key(name);
            if repeated {
                let what = format!("bone '{}'", shortened(name));
                violations.add(bone.start, Reason::Repeated { what });
            } else {
                found.insert(name.to_owned(), at);
            }
        }
        if let Some(id) = bone.id.flatten().filter(|id| !ids.insert(*id)) {
            violations.add(bone.start, Reason::Repeated { what: format!("bone id {id}") });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_every_section() {
        assert_eq!(KNOWN_SECTIONS, SECTIONS.join(", "));
    }
}
