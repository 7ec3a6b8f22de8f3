//! Where words go: data to stdout, talk to stderr.

use std::io::{self, IsTerminal as _, Write as _};

use serde_json::Value;

use crate::args::Global;

/// Knows who is listening.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Output {
    json: bool,
    quiet: bool,
}

impl Output {
    pub(crate) fn new(global: &Global) -> Self {
        Self { json: global.json, quiet: global.quiet }
    }

    /// The command's result on stdout: `value` for programs, else `text` for people.
    pub(crate) fn result(
        &self,
        text: impl FnOnce() -> String,
        value: impl FnOnce() -> Value,
    ) -> io::Result<()> {
        let mut stdout = io::stdout().lock();
        if self.json {
            writeln!(stdout, "{}", value())?;
        } else {
            stdout.write_all(text().as_bytes())?;
        }
        stdout.flush()
    }

    /// Something worth knowing, unless nobody wants to.
    pub(crate) fn note(&self, text: &str) {
        if !self.quiet {
            self.problem(text);
        }
    }

    /// Something wrong.
    pub(crate) fn problem(&self, text: &str) {
        // Where stderr is closed there is nobody left to tell.
        let _ = writeln!(io::stderr(), "{text}");
    }

    /// Whether a progress bar has somebody to look at it.
    pub(crate) fn shows_progress(&self) -> bool {
        !self.quiet && io::stderr().is_terminal()
    }
}

/// `1 clip`, `2 clips`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {what}{plural}")
}

/// Whether stdout's reader has gone away.
pub(crate) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.chain().find_map(|cause| cause.downcast_ref::<io::Error>());
    io.is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
