//! What a replay knows before it sees the recording: a model, or demonstrations and the edges
//! learned from them.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, bail};
use handover_mesh::Config;
use handover_mesh::demonstration::Demonstration;
use handover_mesh::evaluate::UnknownJoint;
use handover_mesh::learn::{Lessons, Search};
use handover_mesh::predict::{LearnedEdges, Method, Predictor};

use crate::args::{Global, Replay, Selection};
use crate::demonstrations::{self, Loaded};
use crate::output::Output;
use crate::{UsageError, configuration, files, learn};

/// What a replay knows before it sees the recording.
pub(super) struct Known {
    demonstrations: Vec<Arc<Demonstration>>,
    pub(super) role: String,
    pub(super) config: Config,
    /// A model's; of demonstrations they are learned first.
    edges: Option<LearnedEdges>,
    pub(super) left_out: usize,
}

impl Known {
    /// Reads the model or the demonstrations.
    ///
    /// - `config`: of demonstrations.
    pub(super) fn read(
        replay: &Replay,
        global: &Global,
        config: &Config,
        output: &Output,
    ) -> anyhow::Result<Self> {
        if files::is_model(&replay.source) {
            Self::by_model(replay, global)
        } else {
            Self::by_demonstrations(replay, config, output)
        }
    }

    fn by_demonstrations(
        replay: &Replay,
        config: &Config,
        output: &Output,
    ) -> anyhow::Result<Self> {
        // Who learns from the answer need not find it.
        let others =
            Selection { except: Some(replay.recording.clone()), ..replay.selection.clone() };
        let (paths, role) = (std::slice::from_ref(&replay.source), replay.role.as_deref());
        let loaded = demonstrations::load(paths, role, &others, config, output)?;
        let Loaded { demonstrations, role, left_out, .. } = loaded;
        Ok(Self { demonstrations, role, config: config.clone(), edges: None, left_out })
    }

    fn by_model(replay: &Replay, global: &Global) -> anyhow::Result<Self> {
        let path = &replay.source;
        let shown = path.display();
        files::about(path)?;
        let model = files::read_model(path).map_err(|faults| {
            let faults: Vec<String> = faults.iter().map(files::Fault::text).collect();
            anyhow::anyhow!("{shown}: {}", faults.join("\n"))
        })?;
        let role = model.people()[model.robot_role() as usize];
        if let Some(other) = replay.role.as_deref().filter(|other| *other != role) {
            bail!(UsageError(format!("{shown}: the model's robot is {role}, not {other}")));
        }
        Ok(Self {
            demonstrations: model.demonstrations().to_vec(),
            role: role.to_owned(),
            config: configuration::over(model.config(), path, global)?,
            edges: Some(model.edges().clone()),
            left_out: 0,
        })
    }

    /// What the two people are called, in order.
    pub(super) fn people(&self) -> [String; 2] {
        let recording = self.demonstrations.first().map(|known| known.recording());
        recording
            .map(|recording| recording.people().each_ref().map(|person| person.name.clone()))
            .unwrap_or_default()
    }

    /// Leaves out what is the recording itself: the same scene under another path.
    ///
    /// # Errors
    /// If nothing is left.
    pub(super) fn without(
        &mut self,
        truth: &Demonstration,
        recording: &Path,
        output: &Output,
    ) -> anyhow::Result<()> {
        let (scene, people) = (truth.recording().scene(), truth.recording().people());
        let is_model = self.edges.is_some();
        self.demonstrations.retain(|demonstration| {
            let recording = demonstration.recording();
            let other = recording.scene() != scene && recording.people() != people;
            if !other && is_model {
                let name = recording.name();
                output
                    .note(&format!("left out: the model's {name}; its edges know it all the same"));
            }
            other
        });
        if self.demonstrations.is_empty() {
            bail!(
                "a recording does not learn from itself, and there is no other than {}",
                recording.display()
            );
        }
        Ok(())
    }

    /// Fits, and learns the edges where a method has some that are not known.
    pub(super) fn predictor(&self, method: Method, output: &Output) -> anyhow::Result<Predictor> {
        let groups = demonstrations::groups(&self.demonstrations, None)?;
        let predictor = Predictor::fit(self.demonstrations.clone(), self.config.predict.clone());
        let predictor = predictor.context("cannot learn")?;
        let edges = match &self.edges {
            Some(edges) => edges.clone(),
            None if method != Method::Mesh => return Ok(predictor),
            None => {
                let count = groups.len();
                output.note(&format!(
                    "learning the edges between the people from {count} recordings"
                ));
                self.learn(&predictor, &groups, output).context(
                    "cannot learn the edges between the people (hint: --method none has none)",
                )?
            }
        };
        Ok(predictor.with_edges(edges))
    }

    fn learn(
        &self,
        predictor: &Predictor,
        groups: &[String],
        output: &Output,
    ) -> anyhow::Result<LearnedEdges> {
        let skeleton = predictor.demonstrations()[0].robot().skeleton();
        let ignored = UnknownJoint::find(skeleton, &self.config.ignored_joints)?;
        let settings = &self.config.learn;
        let lessons = Lessons::of(predictor, groups, &ignored, settings)?;
        let mut search = Search::new(lessons, settings.clone())?;
        let mut steps = Vec::new();
        while let Some(step) = learn::step(&mut search, &steps, output)? {
            steps.push(step);
        }
        Ok(search.edges()?)
    }
}
