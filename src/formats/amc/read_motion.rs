//! The frames of an AMC file → a [`Motion`], or everything that is wrong with it.

use std::collections::BTreeSet;
use std::num::NonZeroU32;

use super::super::error::{ReadError, Reason, Violations, shortened};
use super::super::field;
use super::hierarchy::ROOT;
use super::lines::{AngleUnit, first_word, lines, unknown};
use super::motion::{Motion, Root};
use super::skeleton::{Asf, Bone, RootChannel};

/// No joint turns farther, in degrees or radians.
const MOST_ANGLE: f64 = 1e6;

/// What the lines before the first frame may be.
pub(in crate::formats) const SECTIONS: [&str; 3] = [":FULLY-SPECIFIED", ":DEGREES", ":RADIANS"];
const KNOWN_SECTIONS: &str = ":FULLY-SPECIFIED, :DEGREES, :RADIANS";
/// How many names that are unknown are told once only; beyond, the file is none of ours.
const MOST_REFUSED: usize = 1000;
/// How many missing bones a message names.
const MOST_NAMED: usize = 3;

/// Reads an AMC file.
pub(super) fn read(bytes: &[u8], skeleton: &Asf, rate: NonZeroU32) -> Result<Motion, ReadError> {
    if bytes.trim_ascii().is_empty() {
        return Err(ReadError::of(1, Reason::Empty));
    }
    let mut violations = Violations::default();
    let mut reader = Reader::new(skeleton, &mut violations);
    let mut last = 1;
    for (number, line) in lines(bytes) {
        last = number;
        let Ok(text) = std::str::from_utf8(line) else {
            reader.violations.add(number, Reason::NotUtf8);
            reader.damage();
            continue;
        };
        reader.line(text, number);
    }
    // Digits may be lost where the last line breaks off, and nothing else would tell.
    let is_cut = !bytes[bytes.trim_ascii_end().len()..].contains(&b'\n');
    reader.close_frame(true);
    let Reader { first_number, roots, angles, .. } = reader;
    match first_number {
        None => violations.add(last, Reason::NoFrames),
        Some(_) if is_cut => violations.add(last, Reason::LineWithoutEnd),
        Some(_) => {}
    }
    let first_number = first_number.unwrap_or(0);
    let good = violations.none();
    violations.or(good.then(|| Motion {
        skeleton: skeleton.clone(),
        rate,
        first_number,
        roots,
        angles,
    }))
}

struct Reader<'a, 'v> {
    skeleton: &'a Asf,
    violations: &'v mut Violations,
    fully_specified: bool,
    unit: Option<AngleUnit>,
    /// `None` before the first frame.
    frame: Option<Frame>,
    first_number: Option<u64>,
    /// The last frame that told each bone, the root last; frames are counted from 1.
    told_in: Vec<u64>,
    /// The values of the frame that is being read: kept only if it holds all of them, so that
    /// frames cost no memory that the file does not have.
    root: Root,
    values: Vec<f64>,
    /// How many lines a frame has.
    needed: usize,
    roots: Vec<Root>,
    angles: Vec<f64>,
    /// Unknown names complained about: once each is enough.
    refused: BTreeSet<&'a str>,
}

/// A frame that is being read.
struct Frame {
    /// Which one it is, counted from 1.
    count: u64,
    number: u64,
    line: u64,
    /// Lines of bones that it has.
    told: usize,
    /// A line was lost, which is noted; what is missing for it need not be noted again.
    damaged: bool,
}

impl<'a, 'v> Reader<'a, 'v> {
    fn new(skeleton: &'a Asf, violations: &'v mut Violations) -> Self {
        let bones = skeleton.bones();
        Self {
            skeleton,
            violations,
            fully_specified: false,
            unit: None,
            frame: None,
            first_number: None,
            told_in: vec![0; bones.len() + 1],
            root: Root::default(),
            values: vec![0.0; skeleton.channel_count()],
            needed: 1 + bones.iter().filter(|bone| !bone.dofs.is_empty()).count(),
            roots: Vec::new(),
            angles: Vec::new(),
            refused: BTreeSet::new(),
        }
    }

    fn damage(&mut self) {
        if let Some(frame) = &mut self.frame {
            frame.damaged = true;
        }
    }

    fn line(&mut self, text: &'a str, line: u64) {
        if text.starts_with(':') {
            return self.section(text, line);
        }
        let (word, rest) = first_word(text);
        let digit = |letter: char| letter.is_ascii_digit() || matches!(letter, '+' | '-' | '.');
        if rest.trim().is_empty() && word.starts_with(digit) {
            return self.start_frame(word, line);
        }
        if self.frame.is_none() {
            if self.refused.insert("") {
                let what = "the number of the first frame, before its values,".into();
                self.violations.add(line, Reason::Missing { what });
            }
            return;
        }
        self.bone(word, rest, line);
    }

    fn section(&mut self, text: &str, line: u64) {
        let known = SECTIONS.into_iter().find(|known| known.eq_ignore_ascii_case(text));
        let repeated = match known {
            Some(":FULLY-SPECIFIED") => std::mem::replace(&mut self.fully_specified, true),
            Some(":DEGREES") => self.unit.replace(AngleUnit::Degrees).is_some(),
            Some(_) => self.unit.replace(AngleUnit::Radians).is_some(),
            None => return self.violations.add(line, unknown("section", text, KNOWN_SECTIONS)),
        };
        if repeated {
            let what = if known == Some(SECTIONS[0]) { SECTIONS[0] } else { "the unit of angles" };
            self.violations.add(line, Reason::Repeated { what: what.into() });
        }
    }

    fn start_frame(&mut self, word: &str, line: u64) {
        self.close_frame(false);
        let before = self.frame.take();
        if before.is_none() {
            self.check_header(line);
        }
        let next = before.as_ref().map_or(0, |frame| frame.number.saturating_add(1));
        let number = field::frame_number(word, || "frame".into());
        let number = number.map_err(|reason| self.violations.add(line, reason)).ok();
        if let (Some(frame), Some(before)) = (number, before.as_ref().map(|frame| frame.number)) {
            if frame <= before {
                self.violations.add(line, Reason::FrameOrder { frame, before });
            } else if frame > next {
                self.violations.add(line, Reason::FrameGap { frame, before });
            }
        }
        let number = number.unwrap_or(next);
        self.first_number.get_or_insert(number);
        let count = before.map_or(1, |frame| frame.count + 1);
        self.frame = Some(Frame { count, number, line, told: 0, damaged: false });
    }

    /// Notes what should have come before the first frame.
    fn check_header(&mut self, line: u64) {
        let unit = (self.unit.is_some(), "':DEGREES' or ':RADIANS', before the first frame,");
        let full = (self.fully_specified, "':FULLY-SPECIFIED', before the first frame,");
        for (_, what) in [full, unit].into_iter().filter(|(given, _)| !given) {
            self.violations.add(line, Reason::Missing { what: what.into() });
        }
    }

    fn bone(&mut self, name: &'a str, rest: &str, line: u64) {
        let skeleton = self.skeleton;
        let bone = skeleton.bone(name);
        if bone.is_none() && name != ROOT {
            let is_new = self.refused.len() > MOST_REFUSED || self.refused.insert(name);
            if is_new {
                let reason = Reason::NotInSkeleton { bone: shortened(name) };
                self.violations.add(line, reason);
            }
            return;
        }
        let Some(frame) = &mut self.frame else { return };
        let place = bone.map_or(skeleton.bones().len(), |bone| bone.index());
        if std::mem::replace(&mut self.told_in[place], frame.count) == frame.count {
            let what = format!("frame {}: '{}'", frame.number, shortened(name));
            return self.violations.add(line, Reason::Repeated { what });
        }
        let bone = bone.map(|bone| &skeleton[bone]);
        let expected = bone.map_or(6, |bone| bone.dofs.len());
        // A bone that cannot turn may be named or not.
        frame.told += usize::from(expected > 0);
        let words = rest.split_ascii_whitespace();
        let got = words.clone().count();
        if got != expected {
            let of = shortened(name);
            self.violations.add(line, Reason::ValueCount { of, expected, got });
            return self.damage();
        }
        for (at, word) in words.enumerate() {
            let found = match bone {
                Some(bone) => self.set_angle(bone, at, word),
                None => self.set_root(at, word),
            };
            if let Err(reason) = found {
                self.violations.add(line, reason);
                self.damage();
            }
        }
    }

    fn set_angle(&mut self, bone: &Bone, at: usize, word: &str) -> Result<(), Reason> {
        let axis = bone.dofs[at].axis.letter();
        let name = || format!("{}.r{axis}", bone.name);
        let angle = field::number(word, name)?;
        if angle.abs() > MOST_ANGLE {
            let bound = "an angle of at most a million";
            return Err(Reason::OutOfBounds { field: name(), value: angle, bound });
        }
        self.values[bone.first_channel + at] = self.radians(angle);
        Ok(())
    }

    fn set_root(&mut self, at: usize, word: &str) -> Result<(), Reason> {
        match self.skeleton.root.order[at] {
            RootChannel::Translation(axis) => {
                let name = || format!("{ROOT}.t{}", axis.letter());
                let metres = field::number(word, name)? * self.skeleton.metres_per_unit;
                self.root.translation[axis.index()] = field::within_reach(metres, name)?;
            }
            RootChannel::Rotation(axis) => {
                let angle = field::number(word, || format!("{ROOT}.r{}", axis.letter()))?;
                self.root.rotation[axis.index()] = self.radians(angle);
            }
        }
        Ok(())
    }

    /// Where the unit is missing, which is noted, any will do.
    fn radians(&self, angle: f64) -> f64 {
        self.unit.unwrap_or(AngleUnit::Degrees).to_radians(angle)
    }

    /// Keeps the frame's values if all are there; notes what is missing otherwise.
    fn close_frame(&mut self, at_end: bool) {
        let Some(frame) = &self.frame else { return };
        if frame.damaged {
            return;
        }
        if frame.told == self.needed {
            self.roots.push(self.root);
            self.angles.extend(&self.values);
            return;
        }
        let bones = self.skeleton.bones().iter();
        let needed = bones.map(|bone| (bone.name.as_str(), !bone.dofs.is_empty()));
        let needed = needed.chain([(ROOT, true)]).zip(&self.told_in);
        let missing = needed.filter(|((_, needed), told)| *needed && **told != frame.count);
        let names = missing.map(|((name, _), _)| shortened(name)).take(MOST_NAMED);
        let bones: Vec<String> = names.collect();
        let more = self.needed - frame.told - bones.len();
        let reason = Reason::MissingBones { frame: frame.number, bones, more, at_end };
        self.violations.add(frame.line, reason);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_every_section() {
        assert_eq!(KNOWN_SECTIONS, SECTIONS.join(", "));
    }
}
