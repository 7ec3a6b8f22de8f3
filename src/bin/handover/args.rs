//! The command line as data; parsing touches no file.

mod blend;

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use handover_mesh::forecast::ForecastMethod;
use handover_mesh::formats::UpAxis;
use handover_mesh::learn::LearnMethod;
use handover_mesh::motion::Neighbourhood;
use handover_mesh::predict::Method;

pub(crate) use blend::{Blend, Weights};

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
    /// Threads to work with, up to 1024 [default: one for each core]
    #[arg(long, global = true, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Parameter file in ROS 2 form [default: the values of config/handover.yaml]
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// One parameter over the file's, e.g. mesh.scale=10; may be repeated
    #[arg(long, global = true, value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<(String, String)>,
    /// Print one JSON object on stdout instead of text
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// No progress bar and no notes on stderr; errors stay
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
// NOTE: a variant's own words would hide those of its arguments from --help.
pub(crate) enum Command {
    Import(Import),
    Learn(Learn),
    Replay(Replay),
    Evaluate(Evaluate),
    Motion(Motion),
    Blend(Blend),
    Check(Check),
}

impl Command {
    /// Options that stand for parameters, and win over `--set`.
    pub(crate) fn parameters(&self) -> Vec<(String, String)> {
        match self {
            Self::Learn(learn) => learn.learning.parameters(),
            Self::Evaluate(evaluate) => evaluate.parameters(),
            Self::Motion(motion) => motion.parameters(),
            Self::Import(_) | Self::Replay(_) | Self::Blend(_) | Self::Check(_) => Vec::new(),
        }
    }
}

/// Turn recordings of any known format into CSV or a bag of rosbag2.
///
/// One recording (a file, or a bag's folder) becomes what OUT's ending says: .csv, .mcap (a bag in
/// one file) or .bag (a bag as a folder, metadata.yaml and one .mcap; so is any name that ends in
/// /). A folder of recordings becomes a folder of CSVs. Bad files are named and left out; of a
/// damaged bag what is whole is taken, what is lost named, and the exit code is 3. docs/bags.md says
/// which topics are people.
///
/// With --object-mesh each recording's object, one place over time, becomes the outermost points of
/// a shape, p00, p01 and so on, at most object.points of them; their mean is where the object was
/// recorded. How it was turned is not recorded: the shape's axes are the world's, its z up, in every
/// frame. Such recordings are written as CSV only. docs/object.md says what for.
#[derive(Debug, Args)]
pub(crate) struct Import {
    /// A recording, or a folder searched for recordings (.csv, .txt, .mcap, .db3, .zstd, bags)
    #[arg(value_name = "SRC")]
    pub(crate) source: PathBuf,
    /// A name ending in .csv, .mcap, .bag or /, or for a folder the folder to write to
    #[arg(value_name = "OUT")]
    pub(crate) out: PathBuf,
    /// The object's shape (.obj), of which the outermost points take its one point's place
    #[arg(long, value_name = "MESH")]
    pub(crate) object_mesh: Option<PathBuf>,
    /// The unit of --object-mesh in metres, 0.001 for millimetres
    #[arg(long, value_name = "S", default_value_t = 1.0, requires = "object_mesh",
          value_parser = scale, allow_negative_numbers = true)]
    pub(crate) object_scale: f64,
    #[command(flatten)]
    pub(crate) selection: Selection,
}

/// A finite number above 0.
fn scale(text: &str) -> Result<f64, String> {
    let scale = text.parse().ok().filter(|scale: &f64| *scale > 0.0 && scale.is_finite());
    scale.ok_or_else(|| "no finite number above 0".to_owned())
}

/// Learn a model: which edges between the people a movement needs.
///
/// Some demonstrations are retargeted from others, whose right answer is known; edges are added or
/// taken away, each time the one that brings the robot's joints nearest to it, until none does.
/// Others are held out and only say how well the edges serve them. The model holds the
/// demonstrations, the edges and all parameters; the order of the files and the number of threads
/// change no byte of it.
///
/// With --log each step is written down as soon as it is taken; a run that was broken off goes on
/// with --resume, and ends as if it had not been.
#[derive(Debug, Args)]
pub(crate) struct Learn {
    /// Demonstrations, or folders searched for demonstrations (.csv, .txt, .mcap, .db3, .zstd, bags)
    #[arg(value_name = "DEMO", required = true)]
    pub(crate) demonstrations: Vec<PathBuf>,
    /// Write the model here (.safetensors)
    #[arg(long, short, value_name = "MODEL")]
    pub(crate) out: PathBuf,
    /// The person the robot stands in for [default: giver, else B]
    #[arg(long, value_name = "R")]
    pub(crate) role: Option<String>,
    #[command(flatten)]
    pub(crate) learning: Learning,
    /// Clips with this metadata in common never learn from each other, e.g. pair
    #[arg(long, value_name = "KEY")]
    pub(crate) group: Option<String>,
    /// Write each step down as a line of JSON as soon as it is taken; a new file
    #[arg(long, value_name = "STEPS")]
    pub(crate) log: Option<PathBuf>,
    /// Go on from the steps of --log, which must be of the same recordings and parameters
    #[arg(long, requires = "log")]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) selection: Selection,
}

/// Put a recording to the robot, tick by tick.
///
/// At each frame the partner is sighted as recorded, by the recorded clock, and the robot is moved
/// as it would be live: filter, tracker, mesh, safety gate. It sees the partner's past and where
/// its own base is; what the person in its role really did is only what the result is measured
/// against. --method none is the same without edges between the people; the other methods know the
/// past alone as well, but have no tick. With --whole a method sees the partner's whole motion.
///
/// Of a bag that was recorded live the robot plays its role again, from where it was then.
///
/// A recording that lies among the demonstrations is left out of them. A model brings its edges,
/// parameters and role along, and takes parameters of the sections tick, filter, track, window and
/// safety over its own; without one, the edges of `mesh` are learned first.
///
/// A trace (-o TRACE.jsonl) has a line for each tick, at least one a frame; docs/trace.md says what
/// every key in it is, and what the reasons are to hold. In it `robot` is no measurement but the
/// first recorded pose, shifted to where the base was recorded.
#[derive(Debug, Args)]
pub(crate) struct Replay {
    /// A model (.safetensors), a demonstration, or a folder searched for demonstrations
    #[arg(value_name = "MODEL")]
    pub(crate) source: PathBuf,
    /// The recording to replay
    #[arg(value_name = "RECORDING")]
    pub(crate) recording: PathBuf,
    /// Write the recording with the robot's joints in its role's place (.csv, .mcap), or what every
    /// tick was given and said (.jsonl; beside it .ticks.csv, how long each took)
    #[arg(long, short, value_name = "TRACE")]
    pub(crate) out: Option<PathBuf>,
    /// The person the robot stands in for [default: the model's; else giver, else B]
    #[arg(long, value_name = "R")]
    pub(crate) role: Option<String>,
    /// How the robot's joints are found; mesh and none by the tick
    #[arg(long, value_name = "METHOD", default_value = "mesh", value_parser = method_parser())]
    pub(crate) method: String,
    /// Let the method see the partner's whole motion, not the past alone
    #[arg(long)]
    pub(crate) whole: bool,
    #[command(flatten)]
    pub(crate) selection: Selection,
}

/// Measure all methods against what people did.
///
/// leave_one_out: each clip is predicted from the others; with more than twenty clips (or groups)
/// they are dealt into folds.
///
/// displaced: the same with the partner moved up, left, right or nearer by 0.1 or 0.2 m, and apart
/// from that with the robot 0.8 or 1.2 times as large. What a person would have done there is not
/// known, so only the gap to the partner's hand, bones and jerk are measured.
///
/// thesis: the first recording is retargeted to each of all, by an interaction mesh that was trained
/// on one of them: a row a training, a column a target, in metres over all joints and frames.
///
/// forecast: where the partner's active hand (wrist) and all joints are 100 to 500 ms later, said
/// from the past alone by what was learned from other clips.
#[derive(Debug, Args)]
pub(crate) struct Evaluate {
    /// Recordings, or folders searched for recordings (.csv, .txt, .mcap, .db3, .zstd, bags)
    #[arg(value_name = "DEMO", required = true)]
    pub(crate) demonstrations: Vec<PathBuf>,
    /// Who learns from whom, and what is measured
    #[arg(long, value_enum)]
    pub(crate) protocol: Protocol,
    /// The person the robot stands in for [default: giver, else B]
    #[arg(long, value_name = "R")]
    pub(crate) role: Option<String>,
    /// Clips with this metadata in common never learn from each other, e.g. pair
    #[arg(long, value_name = "KEY")]
    pub(crate) group: Option<String>,
    /// Let methods know the past alone, tick by tick (leave_one_out and displaced)
    #[arg(long)]
    pub(crate) causal: bool,
    /// The methods to compare, separated by commas [default: all of the protocol's]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = any_method_parser())]
    pub(crate) methods: Vec<String>,
    /// Folds where there are more than twenty clips or groups [default: evaluate.folds]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub(crate) folds: Option<u32>,
    /// Write the JSON object to a file too (.json)
    #[arg(long, short, value_name = "OUT")]
    pub(crate) out: Option<PathBuf>,
    /// Draw the distances over the steps of learning (.svg; thesis only)
    #[arg(long, value_name = "OUT")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) learning: Learning,
    #[command(flatten)]
    pub(crate) selection: Selection,
}

impl Evaluate {
    /// The parameters that the options stand for.
    fn parameters(&self) -> Vec<(String, String)> {
        let folds = self.folds.map(|folds| ("evaluate.folds".to_owned(), folds.to_string()));
        self.learning.parameters().into_iter().chain(folds).collect()
    }
}

/// How the edges between the people are learned.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct Learning {
    /// How edges are searched for [default: learn.method, which is grow]
    #[arg(long, value_name = "METHOD",
          value_parser = PossibleValuesParser::new(LearnMethod::ALL.map(LearnMethod::name)))]
    pub(crate) method: Option<String>,
    /// How an edge's weight follows from its length [default: mesh.kernel, which is
    /// inverse_distance]
    #[arg(long, value_name = "KERNEL", value_parser = ["uniform", "inverse_distance"])]
    pub(crate) kernel: Option<String>,
}

impl Learning {
    /// The parameters that the options stand for.
    fn parameters(&self) -> Vec<(String, String)> {
        let options = [("learn.method", &self.method), ("mesh.kernel", &self.kernel)];
        let given = options.into_iter().filter_map(|(key, value)| Some((key, value.clone()?)));
        given.map(|(key, value)| (key.to_owned(), value)).collect()
    }
}

/// How clips are dealt and measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Protocol {
    /// Each clip predicted from the others
    #[value(name = "leave_one_out")]
    LeaveOneOut,
    /// The same with the partner elsewhere, or the robot of another size
    #[value(name = "displaced")]
    Displaced,
    /// The first recording retargeted to each of all, by meshes trained on one of them
    #[value(name = "thesis")]
    Thesis,
    /// The partner's joints some tenths of a second ahead, each clip from the others
    #[value(name = "forecast")]
    Forecast,
}

/// Measure how well made-up motions resemble true ones.
///
/// Poses without their root are projected into a latent space of few dimensions, where neighbours'
/// velocities make a field. Each fold's sequences are left out; from the first pose of such a
/// sequence the field of the others is followed for as many steps as it has, and the path compared
/// with the true one: error A is how far apart they run, error F how near the path comes to the
/// true end. Medians over the sequences, beside the paper's (Gauch & Peters, Table II).
///
/// Of a recording of two people the motion is the partner's. An AMC file takes the only .asf beside
/// it, and 120 frames a second. Sequences of another rate than most, or of other joints, are left
/// out: a field counts time in frames.
#[derive(Debug, Args)]
pub(crate) struct Motion {
    /// Motions (.amc), recordings (.csv, .txt, .mcap, .db3, .zstd, bags), or folders searched for
    /// them
    #[arg(value_name = "SEQUENCE", required = true)]
    pub(crate) sequences: Vec<PathBuf>,
    /// Latent dimensions [default: motion.dimensions, which is 2]
    #[arg(long, value_name = "D", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) dims: Option<u16>,
    /// The share of the variance that the latent dimensions are to explain, in place of their number
    #[arg(long, value_name = "SHARE", conflicts_with = "dims", value_parser = share)]
    pub(crate) variance: Option<f64>,
    /// Whose velocities make the field at a place
    #[arg(long, value_name = "N", default_value = "all", value_parser = neighbourhood_parser())]
    pub(crate) neighbourhood: String,
    /// Into how many folds the sequences are dealt
    #[arg(long, value_name = "N", default_value_t = 4,
          value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub(crate) folds: u32,
    /// The person the robot stands in for, so that the other is its partner [default: giver, else
    /// B]
    #[arg(long, value_name = "R")]
    pub(crate) role: Option<String>,
    /// Write the JSON object to a file too (.json)
    #[arg(long, short, value_name = "OUT")]
    pub(crate) out: Option<PathBuf>,
    /// Draw the first two latent dimensions: poses, true and made-up paths (.svg)
    #[arg(long, value_name = "OUT")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) selection: Selection,
}

impl Motion {
    /// The parameters that the options stand for.
    fn parameters(&self) -> Vec<(String, String)> {
        let dims = self.dims.map(|dims| ("motion.dimensions".to_owned(), dims.to_string()));
        dims.into_iter().collect()
    }

    /// The columns asked for.
    pub(crate) fn neighbourhoods(&self) -> Vec<Neighbourhood> {
        let wanted =
            |n: &Neighbourhood| self.neighbourhood == "all" || self.neighbourhood == n.name();
        Neighbourhood::ALL.into_iter().filter(wanted).collect()
    }
}

fn neighbourhood_parser() -> PossibleValuesParser {
    PossibleValuesParser::new(
        Neighbourhood::ALL.map(Neighbourhood::name).into_iter().chain(["all"]),
    )
}

/// A share above 0 and not above 1.
fn share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if share > 0.0 && share <= 1.0 { Ok(share) } else { Err("not above 0 and up to 1".to_owned()) }
}

/// Accepts the methods' names.
fn method_parser() -> PossibleValuesParser {
    PossibleValuesParser::new(Method::ALL.map(Method::name))
}

/// Accepts the names of methods of any protocol, each once.
fn any_method_parser() -> PossibleValuesParser {
    let mut names = Method::ALL.map(Method::name).to_vec();
    let forecasts = ForecastMethod::ALL.map(ForecastMethod::name);
    names.extend(
        forecasts.into_iter().filter(|name| !Method::ALL.iter().any(|m| m.name() == *name)),
    );
    PossibleValuesParser::new(names)
}

/// `key=value`.
fn setting(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("expected KEY=VALUE")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// Say what files hold and what is wrong with them.
///
/// Of a parameter file: what differs from the defaults, or all that is wrong. Of a model: what it
/// was learned from and how, its edges and its parameters.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Recordings, folders searched for recordings (.csv, .txt, .mcap, .db3, .zstd, bags), parameter
    /// files (.yaml, .yml), or models (.safetensors)
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
    /// A file to leave out, whatever the folders hold: chosen by commands, not by users.
    #[arg(skip)]
    pub(crate) except: Option<PathBuf>,
    /// Whether recordings too short to be an interaction serve too: chosen by commands, as well.
    #[arg(skip)]
    pub(crate) any_length: bool,
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
