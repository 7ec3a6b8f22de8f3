//! A [`Player`] on topics, its settings as the node's parameters; the simulator's one place that
//! knows `r2r`.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::process::ExitCode;
use std::sync::PoisonError;
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow, bail};
use handover_mesh::formats::bag::{self, Files};
use handover_mesh::formats::{self, Format, UpAxis};
use handover_mesh::parameters::{ParameterValue, Refusals};
use handover_mesh::ros::context::{ArgumentsError, context};
use handover_mesh::ros::parameters::{ParameterServer, ParameterServerError};
use handover_mesh::ros::shell::{RosClock, Stop, line};
use handover_mesh::{Recording, Span, Stamp};
use handover_sim::broadcast::{
    BroadcastError, Outgoing, Player, Reliability, Settings, Source, Topic, follow_ups, parameters,
};
use r2r::{Clock, ClockType, Node, PublisherUntyped, QosProfile};

use crate::complain;

/// The node's name, if nothing else is said.
const NAME: &str = "handover_sim";
/// How long it may wait for something to do: as long as it takes to notice that it is to end.
const LONGEST_WAIT: Duration = Duration::from_millis(10);
/// The same while others live by its `/clock`: no tick of theirs is to come later.
const LONGEST_WAIT_WITH_CLOCK: Duration = Duration::from_millis(2);
/// Waits are not shorter: asking the middleware takes about as long.
const SHORTEST_WAIT: Duration = Duration::from_micros(100);
/// How long the last messages have to reach whoever listens, before the node ends by itself.
const FAREWELL: Span = Span(500_000_000);
/// Listeners may take as long to come; after that the log says that they are waited for.
const LISTENERS_MAY_TAKE: Span = Span(5_000_000_000);
/// And says so again, as often.
const BETWEEN_WORDS: Span = Span(10_000_000_000);

/// Runs the node until a signal ends it, or it ends by itself because it was told to.
///
/// Exit codes: 0 ended as asked, 1 failed, 2 started with parameters that cannot be meant.
pub(crate) fn run() -> ExitCode {
    match play() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => complain(&format!("{error:#}"), if is_usage(&error) { 2 } else { 1 }),
    }
}

/// Whether the parameters are at fault.
fn is_usage(error: &anyhow::Error) -> bool {
    let refused = error.downcast_ref::<ParameterServerError>();
    matches!(refused, Some(ParameterServerError::Refused(_)))
        || error.is::<ArgumentsError>()
        || error.is::<BroadcastError>()
        || error.is::<Unreadable>()
}

/// What should be played cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("recording: {0:#}")]
struct Unreadable(anyhow::Error);

fn play() -> Result<()> {
    let stop = Stop::on_signals()?;
    let mut node = Node::create(context()?, NAME, "")?;
    // Dropped before the node, whatever happens: what it offers is the node's.
    let mut broadcast = Broadcast::new(&mut node)?;
    broadcast.spin(&mut node, &stop)
}

/// The node's parts; the graph's node itself is the caller's, and outlives them.
struct Broadcast {
    server: ParameterServer,
    player: Player,
    /// Whether whoever has to listen does.
    is_begun: bool,
    /// When the log says, for the next time, who is waited for; of the steady clock.
    next_word: Option<Stamp>,
    /// Whether the log has been told that all has been played.
    is_over: bool,
    /// When the node ends by itself, once that is to be; of the steady clock.
    end: Option<Stamp>,
    publishers: Vec<(Topic, PublisherUntyped)>,
    ros_clock: RosClock,
    steady_clock: Clock,
}

impl Broadcast {
    fn new(node: &mut Node) -> Result<Self> {
        let kind = started_kind(node);
        let mut server = ParameterServer::new(node, parameters(&kind))?;
        let more = follow_ups(server.table(), &[]);
        put_all(&mut server, node, more)?;
        let settings = Settings::of(server.table());
        let source = source(&settings)?;
        let what = match &source {
            Source::Recording(recording) => recording.name().to_owned(),
            Source::Scene(_) => format!("what seed {} makes up", settings.seed),
        };
        let player = Player::new(source, settings)?;
        let [robot, partner] = player.names();
        let plays = format!("plays {what}: the partner is {partner}, the robot {robot}");
        r2r::log_info!(node.logger(), "{}", line(plays));
        Ok(Self {
            publishers: publishers(node, player.settings())?,
            ros_clock: server.clock(),
            steady_clock: Clock::create(ClockType::SteadyTime)?,
            server,
            player,
            is_begun: false,
            next_word: None,
            is_over: false,
            end: None,
        })
    }

    fn spin(&mut self, node: &mut Node, stop: &Stop) -> Result<()> {
        let has_clock = self.player.settings().has_clock;
        let longest = if has_clock { LONGEST_WAIT_WITH_CLOCK } else { LONGEST_WAIT };
        while !stop.is_set() {
            let steady = self.steady()?;
            let now = if has_clock { steady } else { self.ros_clock.now() };
            if !self.is_begun {
                self.await_listeners(node, steady);
            }
            if !self.is_begun {
                if let Some(message) = self.player.stand_by(now) {
                    self.send(&message)?;
                }
            // Before simulated time of somebody else has begun there is none.
            } else if has_clock || now > Stamp(0) {
                for message in self.player.advance(now) {
                    self.send(&message)?;
                }
            }
            if self.player.is_over() != self.is_over {
                self.is_over = self.player.is_over();
                if self.is_over {
                    r2r::log_info!(node.logger(), "all has been played");
                }
            }
            // Meanwhile it answers, time goes on, and whoever wants more gets it.
            let ends = self.is_over && self.player.settings().exits_at_end;
            self.end = ends.then(|| self.end.unwrap_or(steady + FAREWELL));
            if self.end.is_some_and(|end| end <= steady) {
                break;
            }
            let wait = self.player.wait().map_or(longest, |wait| {
                Duration::from_nanos(u64::try_from(wait.0).unwrap_or_default())
            });
            node.spin_once(wait.clamp(SHORTEST_WAIT, longest));
            self.serve(node)?;
        }
        Ok(())
    }

    /// Begins once one of the partner's topics has as many listeners as there have to be. They are
    /// not added up: somebody may listen to several. `/tf`, to which everybody listens, counts only
    /// where the partner is sent on no other.
    ///
    /// - `now`: of the steady clock; where they take long to come, the log says so now and then.
    fn await_listeners(&mut self, node: &Node, now: Stamp) {
        let wanted = self.player.settings().listeners;
        let partner = self.publishers.iter().filter(|(topic, _)| Topic::PARTNER.contains(topic));
        let is_only_there = !partner.clone().any(|(topic, _)| *topic != Topic::Transforms);
        let partner = partner.filter(|(topic, _)| is_only_there || *topic != Topic::Transforms);
        let there: Vec<(Topic, usize)> = partner
            .map(|(topic, publisher)| {
                (*topic, publisher.get_inter_process_subscription_count().unwrap_or_default())
            })
            .collect();
        // Where the partner is not sent at all, nobody can listen.
        self.is_begun = there.is_empty() || there.iter().any(|(_, count)| *count >= wanted);
        let next = *self.next_word.get_or_insert(now + LISTENERS_MAY_TAKE);
        if !self.is_begun && next <= now {
            self.next_word = Some(now + BETWEEN_WORDS);
            let there =
                there.iter().map(|(topic, count)| format!("{} ({count} there)", topic.name()));
            let there = there.collect::<Vec<_>>().join(" or ");
            let hint = "(hint: whoever looks elsewhere needs skeleton:=false, tf or markers)";
            r2r::log_info!(node.logger(), "waits for {wanted} listeners of {there} {hint}");
        }
    }

    fn steady(&mut self) -> Result<Stamp> {
        let now = self.steady_clock.get_now()?;
        Ok(Stamp(i64::try_from(now.as_nanos()).unwrap_or(i64::MAX)))
    }

    fn send(&self, message: &Outgoing) -> Result<()> {
        let topic = message.topic();
        match self.publishers.iter().find(|(known, _)| *known == topic) {
            Some((_, publisher)) => publisher.publish_raw(&message.bytes()).context(topic.name()),
            None => Ok(()),
        }
    }

    /// Answers whoever asks for parameters, and plays on with those that have changed.
    fn serve(&mut self, node: &Node) -> Result<()> {
        self.server.hear_time();
        // Whatever may be set at all may be set at any time.
        self.server.serve(node, |_, _| Ok(()));
        // What was set to what it was changes nothing here.
        self.server.take_set_names();
        let changes = self.server.take_changes();
        if changes.is_empty() {
            return Ok(());
        }
        for (name, value) in &changes {
            r2r::log_info!(node.logger(), "{name} is now {value}");
        }
        let more = follow_ups(self.server.table(), &changes);
        put_all(&mut self.server, node, more)?;
        Ok(self.player.change(&Settings::of(self.server.table()))?)
    }
}

fn put_all(
    server: &mut ParameterServer,
    node: &Node,
    values: Vec<(String, ParameterValue)>,
) -> Result<(), Refusals> {
    values.into_iter().try_for_each(|(name, value)| server.put(node, &name, value))
}

/// The kind of sensor that the node was started with: its figures are the others' defaults.
fn started_kind(node: &Node) -> String {
    let given = node.params.lock().unwrap_or_else(PoisonError::into_inner);
    match given.get("sensor.kind").map(|parameter| &parameter.value) {
        Some(r2r::ParameterValue::String(kind)) => kind.clone(),
        _ => String::new(),
    }
}

fn source(settings: &Settings) -> Result<Source> {
    let Some(path) = &settings.recording else { return Ok(Source::generated(settings.seed)?) };
    let recording = read(Path::new(path), settings.up).map_err(Unreadable)?;
    Ok(Source::Recording(Box::new(recording)))
}

/// The one place that knows how what is played is stored: a file of any format there is, or a bag's
/// folder.
fn read(path: &Path, up: UpAxis) -> Result<Recording> {
    let at = || path.display().to_string();
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let files = if path.is_dir() {
        let metadata = match File::open(path.join(bag::METADATA_FILE)) {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                bail!("{} is a folder, and no bag: name a file in it", at())
            }
            opened => formats::bytes(opened.with_context(at)?).with_context(at)?,
        };
        let metadata = String::from_utf8_lossy(&metadata).into_owned();
        Files::of_folder(metadata, |name| open_plain(&path.join(name))).with_context(at)?
    } else {
        let bytes = formats::bytes(File::open(path).with_context(at)?).with_context(at)?;
        let format = formats::detect(&bytes).map_err(|error| anyhow!("{}: {error}", at()))?;
        if !matches!(format, Format::Mcap | Format::Sqlite) {
            return formats::read(&bytes, &name, up).map_err(|error| anyhow!("{}: {error}", at()));
        }
        Files::of_file(at(), bytes)
    };
    let read = files.read(&name, up).with_context(at)?;
    for lost in &read.losses {
        r2r::log_warn!(NAME, "{}", line(format_args!("{}: lost: {lost}", at())));
    }
    for note in &read.notes {
        r2r::log_info!(NAME, "{}", line(format_args!("{}: {note}", at())));
    }
    Ok(read.recording)
}

/// Who opens a pipe waits for whoever writes into it.
fn open_plain(path: &Path) -> io::Result<File> {
    if fs::metadata(path)?.is_file() { File::open(path) } else { Err(ErrorKind::NotFound.into()) }
}

fn publishers(node: &mut Node, settings: &Settings) -> Result<Vec<(Topic, PublisherUntyped)>> {
    let mut publishers = Vec::new();
    for topic in Topic::ALL.into_iter().filter(|topic| settings.sends(*topic)) {
        let (name, type_name) = (topic.name(), topic.type_name());
        let created = node.create_publisher_untyped(name, type_name, quality(topic.reliability()));
        match created {
            Ok(publisher) => publishers.push((topic, publisher)),
            // Not every ROS 2 that this can be built with has them.
            Err(_) if topic == Topic::Transforms => {
                r2r::log_warn!(node.logger(), "no {name}: {type_name} was not there to build with");
            }
            Err(error) => return Err(error).with_context(|| format!("{name} ({type_name})")),
        }
    }
    Ok(publishers)
}

fn quality(reliability: Reliability) -> QosProfile {
    match reliability {
        Reliability::Sensor => QosProfile::sensor_data(),
        Reliability::Reliable(kept) => QosProfile::default().reliable().keep_last(kept),
        Reliability::Kept => QosProfile::default().reliable().keep_last(1).transient_local(),
    }
}
