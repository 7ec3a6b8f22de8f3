//! Configuring: a model's file and what the node was given → what ticks, in a thread of its own, so
//! that the node answers meanwhile.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, anyhow, bail};

use super::lifecycle::Asker;
use super::shell::now;
use crate::config::given::Given;
use crate::config::{Change, Config, NodeSettings};
use crate::live::Live;
use crate::model::Model;
use crate::online::OnlineModel;
use crate::parameters::ParameterTable;
use crate::predict::Predictor;

/// What configuring leaves.
pub(super) struct Loaded {
    pub(super) model: Arc<OnlineModel>,
    pub(super) node: NodeSettings,
    /// All parameters as they are now.
    pub(super) config: Config,
    /// What was given and counts for nothing.
    pub(super) differing: Vec<Change>,
    /// What was loaded, in words.
    pub(super) about: String,
}

/// A model on its way.
pub(super) struct Loading {
    began: Instant,
    least: Duration,
    thread: JoinHandle<Result<Loaded>>,
    /// Who wants to know; nobody if the node configures itself.
    pub(super) asker: Option<Asker>,
}

impl Loading {
    /// Sets out.
    ///
    /// - `table`: the parameters as they are.
    /// - `least`: how long it takes at least.
    pub(super) fn begin(
        given: Given,
        table: ParameterTable,
        asker: Option<Asker>,
        least: Duration,
    ) -> Self {
        Self { began: now(), least, thread: thread::spawn(move || load(&given, &table)), asker }
    }

    pub(super) fn is_done(&self) -> bool {
        self.thread.is_finished() && self.began.elapsed() >= self.least
    }

    /// What has come of it, and who wants to know.
    pub(super) fn end(self) -> (Result<Loaded>, Option<Asker>) {
        let loaded = self.thread.join();
        let loaded =
            loaded.unwrap_or_else(|_| Err(anyhow!("loading has ended by a bug: see above")));
        (loaded, self.asker)
    }
}

/// Reads the model, and lays what was given over its parameters.
fn load(given: &Given, table: &ParameterTable) -> Result<Loaded> {
    let node = given.node(table)?;
    if node.model.is_empty() {
        bail!("node.model is not set (hint: -p node.model:=MODEL.safetensors)");
    }
    let path = Path::new(&node.model);
    let shown = path.display();
    let bytes = fs::read(path).with_context(|| format!("node.model: {shown}"))?;
    let model = Model::from_bytes(&bytes).map_err(|error| anyhow!("{shown}: {error}"))?;
    let role = model.people()[model.robot_role() as usize];
    if !node.role.is_empty() && node.role != role {
        bail!("node.role is {}, but the robot of {shown} is {role}", node.role);
    }
    let at = || shown.to_string();
    let (config, differing) = given.over(model.config(), table)?;
    let predictor = Predictor::fit(model.demonstrations().to_vec(), config.predict.clone());
    let predictor = predictor.with_context(at)?.with_edges(model.edges().clone());
    let online = OnlineModel::new(&predictor, config.online.clone());
    let online = Arc::new(online.with_context(at)?);
    // What cannot be ticked with is said now, not when the node is made active.
    Live::new(online.clone(), node.clone()).with_context(at)?;
    let count = model.demonstrations().len();
    let about = format!("{shown}: the robot is {role}, {count} demonstrations");
    Ok(Loaded { model: online, node, config, differing, about })
}
