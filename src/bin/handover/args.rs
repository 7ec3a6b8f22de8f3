//! The command line as data; parsing touches no file.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use handover_mesh::formats::UpAxis;

/// Learns handovers from recordings of two people, and says what recordings hold.
///
/// Exit codes: 0 done, 1 failed, 2 wrong usage, 3 done with loss (what was left out is named).
#[derive(Debug, Parser)]
#[command(name = "handover", version, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What every command takes.
#[derive(Debug, Args)]
pub(crate) struct Global {
    /// Threads to work with [default: one for each core]
    #[arg(long, global = true, value_name = "N")]
    pub(crate) jobs: Option<NonZeroUsize>,
    /// Print one JSON object on stdout instead of text
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// No progress bar and no notes on stderr; errors stay
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Turn recordings of any known format into CSV
    Import(Import),
    /// Say what files hold and what is wrong with them
    Check(Check),
}

/// Turn recordings of any known format into CSV.
///
/// A file becomes a file, a folder a folder of files. Bad files are named and left out.
#[derive(Debug, Args)]
pub(crate) struct Import {
    /// A recording, or a folder searched for recordings (.csv, .txt)
    #[arg(value_name = "SRC")]
    pub(crate) source: PathBuf,
    /// A file ending in .csv, or for a folder the folder to write to
    #[arg(value_name = "OUT")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) selection: Selection,
}

/// Say what files hold and what is wrong with them.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Recordings, or folders searched for recordings (.csv, .txt)
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) selection: Selection,
}

/// Which recordings of a folder are meant, and how they are read.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct Selection {
    /// The axis that points up in the files [default: z]
    #[arg(long, value_name = "AXIS")]
    pub(crate) up: Option<Up>,
    /// Only this class (SBU: the class's folder; else the metadata `class`)
    #[arg(long, value_name = "C")]
    pub(crate) class: Option<String>,
    /// Only paths below the folder that match; `*` matches `/` too
    #[arg(long, value_name = "GLOB")]
    pub(crate) filter: Option<glob::Pattern>,
}

/// An axis that can point up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Up {
    /// y, as cameras have it
    Y,
    /// z, as robots have it
    Z,
}

impl Selection {
    /// The axis that points up in the files.
    pub(crate) fn up_axis(&self) -> UpAxis {
        match self.up {
            Some(Up::Y) => UpAxis::Y,
            Some(Up::Z) | None => UpAxis::Z,
        }
    }
}
