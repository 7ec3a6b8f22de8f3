//! The bytes of a file → its statements, each with the line it begins at, and their words.

use std::ops::Range;

use super::super::detect::without_mark;

/// All statements of a file that say something.
pub(super) struct Statements<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

/// A line, and those that it goes on with.
#[derive(Clone, Copy)]
pub(super) struct Statement<'a> {
    /// Where it begins, counted from 1.
    pub(super) line: u64,
    pub(super) keyword: &'a [u8],
    words: Words<'a>,
}

/// The words of a statement, each with where in the file it stands.
#[derive(Clone, Copy)]
pub(super) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
}

impl<'a> Statements<'a> {
    pub(super) fn of(bytes: &'a [u8]) -> Self {
        Self { bytes, at: bytes.len() - without_mark(bytes).len(), line: 1 }
    }

    /// Where the statement that begins here ends, and how many lines it has.
    fn end(&self) -> (usize, u64) {
        let (mut at, mut lines) = (self.at, 0);
        while at < self.bytes.len() {
            let rest = &self.bytes[at..];
            let length = rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |p| p + 1);
            (at, lines) = (at + length, lines + 1);
            let text = rest[..length].trim_ascii_end();
            // `C:\shapes\` at the end of a comment swallows no line.
            if !text.ends_with(b"\\") || has_comment(text) {
                break;
            }
        }
        (at, lines)
    }
}

/// Whether a comment begins at the start of a word.
fn has_comment(line: &[u8]) -> bool {
    let starts = |at: usize| at == 0 || line[at - 1].is_ascii_whitespace();
    (0..line.len()).any(|at| line[at] == b'#' && starts(at))
}

impl<'a> Iterator for Statements<'a> {
    type Item = Statement<'a>;

    fn next(&mut self) -> Option<Statement<'a>> {
        while self.at < self.bytes.len() {
            let (end, lines) = self.end();
            let mut words = Words { bytes: self.bytes, at: self.at, end };
            let line = self.line;
            (self.at, self.line) = (end, line + lines);
            if let Some((_, keyword)) = words.next() {
                return Some(Statement { line, keyword, words });
            }
        }
        None
    }
}

impl<'a> Statement<'a> {
    /// What follows the keyword.
    pub(super) fn words(&self) -> Words<'a> {
        self.words
    }
}

impl Words<'_> {
    /// Whether this byte is between words: a blank, or what joins two lines.
    fn is_blank(&self, at: usize) -> bool {
        match self.bytes[at] {
            b'\\' => {
                let mut rest = self.bytes[at + 1..self.end].iter();
                rest.find(|byte| !matches!(byte, b' ' | b'\t' | b'\r')).is_none_or(|b| *b == b'\n')
            }
            byte => byte.is_ascii_whitespace(),
        }
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = (Range<usize>, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let start = (self.at..self.end).find(|at| !self.is_blank(*at)).unwrap_or(self.end);
        if start == self.end || self.bytes[start] == b'#' {
            self.at = self.end;
            return None;
        }
        let end = (start..self.end).find(|at| self.is_blank(*at)).unwrap_or(self.end);
        self.at = end;
        Some((start..end, &self.bytes[start..end]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each statement as `line: keyword|word|word`.
    #[track_caller]
    fn check(text: &str, expected: &[&str]) {
        let found = Statements::of(text.as_bytes()).map(|statement| {
            let mut words = vec![String::from_utf8_lossy(statement.keyword).into_owned()];
            for (at, word) in statement.words() {
                assert_eq!(&text.as_bytes()[at], word);
                words.push(String::from_utf8_lossy(word).into_owned());
            }
            format!("{}: {}", statement.line, words.join("|"))
        });
        assert_eq!(found.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn lines_go_on_and_keep_their_numbers() {
        check("", &[]);
        check("\u{feff}v 1  2\t3\r\n\n# c\nf 1 2 3", &["1: v|1|2|3", "4: f|1|2|3"]);
        check("f 1 2\\\n3 \\\r\n 4\ng a\n", &["1: f|1|2|3|4", "4: g|a"]);
        check("f 1 \\", &["1: f|1"]);
        check("\\\nv 1", &["1: v|1"]);
        check("# C:\\shapes\\\nv 1 # x\\\nv 2", &["2: v|1", "3: v|2"]);
        check("usemtl a\\b c#d", &["1: usemtl|a\\b|c#d"]);
    }
}
