//! Services on the graph: requests taken and answered by whatever spins the node.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use futures::{FutureExt, Stream, StreamExt};
use r2r::{Node, QosProfile, ServiceRequest, WrappedServiceTypeSupport};

use super::shell::now;

/// For so long an answer is tried: whoever asks can be heard before hearing, by half a second on a
/// busy machine.
const PATIENCE: Duration = Duration::from_secs(3);
/// A try that fails takes 100 ms of the middleware's waiting, in which nothing else is heard; for so
/// long then nobody else is answered, so that what the node hears is never later by more than one.
const BETWEEN_TRIES: Duration = Duration::from_millis(250);
/// More answers do not wait: the oldest gives way.
const MOST_WAITING: usize = 32;

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
    since: Instant,
    tries: u32,
}

impl Answers {
    /// Tells those that are waiting, at most one of which is not heard.
    pub(super) fn tell(&self) {
        self.tell_at(now());
    }

    fn tell_at(&self, now: Instant) {
        let waiting = &mut *self.0.borrow_mut();
        while waiting.failed.is_none_or(|failed| now - failed >= BETWEEN_TRIES) {
            // Whoever hears is not kept waiting by whoever does not.
            let next = waiting.answers.iter().enumerate().min_by_key(|(_, answer)| answer.tries);
            let Some((next, _)) = next else { return };
            let mut answer = waiting.answers.remove(next);
            answer.tries += 1;
            match (answer.tell)() {
                Ok(()) => {}
                Err(r2r::Error::RCL_RET_TIMEOUT) if now - answer.since < PATIENCE => {
                    waiting.failed = Some(now);
                    waiting.answers.push(answer);
                }
                Err(error) => {
                    waiting.failed = Some(now);
                    answer.give_up(&error);
                }
            }
        }
    }

    fn add(&self, answer: Answer) {
        let waiting = &mut *self.0.borrow_mut();
        if waiting.answers.len() == MOST_WAITING {
            let oldest = waiting.answers.iter().enumerate().min_by_key(|(_, answer)| answer.since);
            if let Some((oldest, _)) = oldest {
                waiting.answers.remove(oldest).give_up(&"too many are waiting");
            }
        }
        waiting.answers.push(answer);
    }

    /// Whether some are waiting.
    pub(super) fn are_waiting(&self) -> bool {
        !self.0.borrow().answers.is_empty()
    }
}

impl Answer {
    fn give_up(self, why: &dyn std::fmt::Display) {
        let Self { logger, service, .. } = self;
        r2r::log_warn!(&logger, "{service}: whoever asked is not answered: {why}");
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
        self.answers.add(Answer { service, logger, tell, since: now(), tries: 0 });
        self.answers.tell();
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// Adds an answer that is heard at the try of this number, counted in `tries`.
    fn add(answers: &Answers, since: Instant, heard_at: u32, tries: &Rc<Cell<u32>>) {
        let counted = tries.clone();
        let tell = Box::new(move || {
            counted.set(counted.get() + 1);
            if counted.get() < heard_at { Err(r2r::Error::RCL_RET_TIMEOUT) } else { Ok(()) }
        });
        let (service, logger) = ("~/asked".to_owned(), "test".to_owned());
        answers.add(Answer { service, logger, tell, since, tries: 0 });
    }

    #[test]
    fn who_does_not_hear_is_told_again_and_holds_up_nobody() {
        let (answers, begin) = (Answers::default(), now());
        let [deaf, late, here]: [Rc<Cell<u32>>; 3] = Default::default();
        let tried = || [deaf.get(), late.get(), here.get()];
        add(&answers, begin, 3, &deaf);
        answers.tell_at(begin);
        answers.tell_at(begin);
        assert_eq!(tried(), [1, 0, 0], "not again at once");
        add(&answers, begin, 2, &late);
        add(&answers, begin, 1, &here);
        answers.tell_at(begin + BETWEEN_TRIES / 2);
        assert_eq!(tried(), [1, 0, 0], "one try in a while costs 100 ms");
        answers.tell_at(begin + BETWEEN_TRIES);
        assert_eq!(tried(), [1, 1, 0], "whoever was not told comes first");
        answers.tell_at(begin + 2 * BETWEEN_TRIES);
        assert_eq!(tried(), [2, 1, 1]);
        assert!(answers.are_waiting());
        answers.tell_at(begin + 3 * BETWEEN_TRIES);
        assert_eq!(tried(), [3, 2, 1]);
        assert!(!answers.are_waiting());
    }

    #[test]
    fn who_never_hears_is_given_up_and_many_are_not_kept() {
        let (answers, begin, gone) = (Answers::default(), now(), Rc::default());
        add(&answers, begin, u32::MAX, &gone);
        for k in 0..40 {
            answers.tell_at(begin + k * PATIENCE / 20);
        }
        assert!(!answers.are_waiting() && gone.get() > 5);
        for _ in 0..1000 {
            add(&answers, begin, u32::MAX, &gone);
        }
        assert_eq!(answers.0.borrow().answers.len(), MOST_WAITING);
    }
}
