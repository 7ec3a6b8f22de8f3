//! Where words go: data to stdout, talk to stderr.

use std::io::{self, IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::Value;

use crate::args::Global;

/// Knows who is listening, and whether something was told that makes the exit code 3.
#[derive(Debug)]
pub(crate) struct Output {
    json: bool,
    quiet: bool,
    lost: AtomicBool,
}

impl Output {
    pub(crate) fn new(global: &Global) -> Self {
        Self { json: global.json, quiet: global.quiet, lost: AtomicBool::new(false) }
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

    /// Something of an input that is lost, though the rest of it is used.
    pub(crate) fn loss(&self, text: &str) {
        self.lost.store(true, Ordering::Relaxed);
        self.problem(&format!("lost: {text}"));
    }

    /// Whether something was lost.
    pub(crate) fn has_lost(&self) -> bool {
        self.lost.load(Ordering::Relaxed)
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
