//! Services on the graph: requests taken and answered by whatever spins the node.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use futures::{FutureExt, Stream, StreamExt};
use r2r::{Node, QosProfile, ServiceRequest, WrappedServiceTypeSupport};

/// How often an answer is tried, and how long after each other: whoever asks can be heard before
/// hearing, by half a second on a busy machine.
const TRIES: u32 = 12;
/// A try that fails takes 100 ms of the middleware's waiting, in which nothing else is heard; for so
/// long then nobody else is answered, so that what the node hears is never later by more than one.
const BETWEEN_TRIES: Duration = Duration::from_millis(150);

/// Answers of all of a node's services: those that nobody heard yet are told again.
#[derive(Clone, Default)]
pub(super) struct Answers(Rc<RefCell<Waiting>>);

#[derive(Default)]
struct Waiting {
    answers: Vec<Answer>,
    failed: Option<Instant>,
}

/// One of them.
struct Answer {
    service: String,
    logger: String,
    tell: Box<dyn Fn() -> r2r::Result<()>>,
    tries: u32,
}

impl Answers {
    /// Tells those that are waiting, at most one of which is not heard.
    pub(super) fn tell(&self) {
        let waiting = &mut *self.0.borrow_mut();
        while waiting.failed.is_none_or(|failed| failed.elapsed() >= BETWEEN_TRIES) {
            // Whoever hears is not kept waiting by whoever does not.
            let next = waiting.answers.iter().enumerate().min_by_key(|(_, answer)| answer.tries);
            let Some((next, _)) = next else { return };
            let mut answer = waiting.answers.remove(next);
            answer.tries += 1;
            match (answer.tell)() {
                Ok(()) => {}
                Err(r2r::Error::RCL_RET_TIMEOUT) => {
                    #[expect(clippy::disallowed_methods, reason = "a shell: a peer needs time")]
                    let now = Instant::now();
                    waiting.failed = Some(now);
                    if answer.tries < TRIES {
                        waiting.answers.push(answer);
                    } else {
                        let Answer { logger, service, .. } = answer;
                        r2r::log_warn!(
                            &logger,
                            "{service}: whoever asked has not heard the answer"
                        );
                    }
                }
                Err(error) => {
                    let Answer { logger, service, .. } = answer;
                    r2r::log_warn!(&logger, "{service}: whoever asked is not answered: {error}");
                }
            }
        }
    }

    /// Whether some are waiting.
    pub(super) fn are_waiting(&self) -> bool {
        !self.0.borrow().answers.is_empty()
    }
}

/// Requests to one service, taken without waiting.
pub(super) struct Requests<T: WrappedServiceTypeSupport> {
    name: String,
    logger: String,
    stream: Box<dyn Stream<Item = ServiceRequest<T>> + Send + Unpin>,
    answers: Answers,
}

impl<T: WrappedServiceTypeSupport + 'static> Requests<T> {
    /// Offers the service.
    ///
    /// # Errors
    /// If it cannot be.
    pub(super) fn new(node: &mut Node, name: &str, answers: &Answers) -> Result<Self> {
        let stream = node.create_service::<T>(name, QosProfile::parameters());
        Ok(Self {
            name: name.to_owned(),
            logger: node.logger().to_owned(),
            stream: Box::new(stream.with_context(|| name.to_owned())?),
            answers: answers.clone(),
        })
    }

    /// The next request that has come in.
    pub(super) fn next(&mut self) -> Option<ServiceRequest<T>> {
        self.stream.next().now_or_never().flatten()
    }

    /// Answers one, now or when [`Answers::tell`] is called next.
    pub(super) fn answer(&self, request: ServiceRequest<T>, answer: T::Response) {
        let tell = Box::new(move || request.clone().respond(answer.clone()));
        let (service, logger) = (self.name.clone(), self.logger.clone());
        self.answers.0.borrow_mut().answers.push(Answer { service, logger, tell, tries: 0 });
        self.answers.tell();
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::thread::sleep;

    use super::*;

    /// Adds an answer that is heard at the try of this number, counted in `tries`.
    fn add(answers: &Answers, heard_at: u32, tries: &Rc<Cell<u32>>) {
        let counted = tries.clone();
        let tell = Box::new(move || {
            counted.set(counted.get() + 1);
            if counted.get() < heard_at { Err(r2r::Error::RCL_RET_TIMEOUT) } else { Ok(()) }
        });
        let (service, logger) = ("~/asked".to_owned(), "test".to_owned());
        answers.0.borrow_mut().answers.push(Answer { service, logger, tell, tries: 0 });
    }

    #[test]
    fn who_does_not_hear_is_told_again_and_holds_up_nobody() {
        let answers = Answers::default();
        let [deaf, late, here] = [(); 3].map(|()| Rc::default());
        add(&answers, 3, &deaf);
        answers.tell();
        answers.tell();
        assert_eq!(deaf.get(), 1, "not again at once");
        add(&answers, 2, &late);
        add(&answers, 1, &here);
        answers.tell();
        assert_eq!((late.get(), here.get()), (0, 0), "one try in a while costs 100 ms");
        sleep(BETWEEN_TRIES);
        answers.tell();
        assert_eq!((deaf.get(), late.get(), here.get()), (1, 1, 0), "whoever was not told first");
        sleep(BETWEEN_TRIES);
        answers.tell();
        assert_eq!((deaf.get(), late.get(), here.get()), (2, 1, 1));
        sleep(BETWEEN_TRIES);
        answers.tell();
        assert_eq!((deaf.get(), late.get(), here.get()), (3, 2, 1));
        assert!(!answers.are_waiting());
    }

    #[test]
    fn who_never_hears_is_given_up() {
        let (answers, gone) = (Answers::default(), Rc::default());
        add(&answers, u32::MAX, &gone);
        for _ in 0..TRIES + 3 {
            answers.tell();
            sleep(BETWEEN_TRIES);
        }
        assert_eq!(gone.get(), TRIES);
        assert!(!answers.are_waiting());
    }
}
