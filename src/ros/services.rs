//! One service on the graph: requests taken and answered by whatever spins the node.

use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use futures::{FutureExt, Stream, StreamExt};
use r2r::{Node, QosProfile, ServiceRequest, WrappedServiceTypeSupport};

/// How often an answer is tried, and how long after each other: whoever asks can be heard before he
/// hears, by half a second on a busy machine. A try that fails takes 100 ms of the middleware's
/// waiting, so what the node hears is never later by more than one.
const TRIES: u32 = 12;
const BETWEEN_TRIES: Duration = Duration::from_millis(150);

/// Requests to one service, taken without waiting.
pub(super) struct Requests<T: WrappedServiceTypeSupport> {
    name: String,
    logger: String,
    stream: Box<dyn Stream<Item = ServiceRequest<T>> + Send + Unpin>,
    unheard: Vec<Unheard<T>>,
}

/// An answer to somebody who does not hear the service yet, or has gone.
struct Unheard<T: WrappedServiceTypeSupport> {
    request: ServiceRequest<T>,
    answer: T::Response,
    tries_left: u32,
    last_try: Option<Instant>,
}

impl<T: WrappedServiceTypeSupport + 'static> Requests<T> {
    /// Offers the service.
    ///
    /// # Errors
    /// If it cannot be.
    pub(super) fn new(node: &mut Node, name: &str) -> Result<Self> {
        let stream = node.create_service::<T>(name, QosProfile::parameters());
        Ok(Self {
            name: name.to_owned(),
            logger: node.logger().to_owned(),
            stream: Box::new(stream.with_context(|| name.to_owned())?),
            unheard: Vec::new(),
        })
    }

    /// The next request that has come in. Whoever has not heard an answer yet is told first.
    pub(super) fn next(&mut self) -> Option<ServiceRequest<T>> {
        let is_due = |unheard: &Unheard<T>| {
            unheard.last_try.is_none_or(|tried| tried.elapsed() >= BETWEEN_TRIES)
        };
        if let Some(due) = self.unheard.iter().position(is_due) {
            let unheard = self.unheard.swap_remove(due);
            self.tell(unheard);
        }
        self.stream.next().now_or_never().flatten()
    }

    /// Answers one; whoever does not hear yet is told later, by [`Self::next`].
    pub(super) fn answer(&mut self, request: ServiceRequest<T>, answer: T::Response) {
        self.tell(Unheard { request, answer, tries_left: TRIES, last_try: None });
    }

    fn tell(&mut self, mut unheard: Unheard<T>) {
        let told = unheard.request.clone().respond(unheard.answer.clone());
        unheard.tries_left -= 1;
        match told {
            Ok(()) => {}
            Err(r2r::Error::RCL_RET_TIMEOUT) if unheard.tries_left > 0 => {
                #[expect(clippy::disallowed_methods, reason = "a shell: a peer needs time")]
                let now = Instant::now();
                unheard.last_try = Some(now);
                self.unheard.push(unheard);
            }
            Err(error) => {
                r2r::log_warn!(
                    &self.logger,
                    "{}: whoever asked is not answered: {error}",
                    self.name
                );
            }
        }
    }
}
