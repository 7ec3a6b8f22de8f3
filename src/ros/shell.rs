//! What every node needs: a context, an end, a clock, bytes out.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use anyhow::{Context as _, Result};
use futures::{FutureExt as _, Stream, StreamExt as _};
use r2r::{Node, PublisherUntyped, QosProfile};

use crate::messages::{Clock, Message, decode, encode};
use crate::time::Stamp;

/// Set by SIGINT, SIGTERM and SIGHUP: whoever spins ends then, and the node is dropped in order, so
/// that the middleware leaves nothing behind.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Takes over the signals; once in a process.
    ///
    /// # Errors
    /// If somebody else has them.
    pub fn on_signals() -> Result<Self> {
        let stop = Self::default();
        let flag = stop.clone();
        ctrlc::set_handler(move || flag.set()).context("signals")?;
        Ok(stop)
    }

    /// Asks for the end.
    pub fn set(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Whether the end is asked for.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// The moment, for what waits and for how long something took: not for stamps.
pub(super) fn now() -> Instant {
    #[expect(clippy::disallowed_methods, reason = "a shell: peers and people need time")]
    Instant::now()
}

/// A line for the log that holds words of strangers: with a NUL in it there would be no log.
pub fn line(text: impl std::fmt::Display) -> String {
    text.to_string().replace('\0', "\u{fffd}")
}

/// A node's clock: that of `/clock` if its time is simulated, else the system's.
#[derive(Debug, Clone)]
pub struct RosClock(Option<Arc<AtomicI64>>);

impl RosClock {
    /// Now; 0 before simulated time has begun.
    pub fn now(&self) -> Stamp {
        if let Some(simulated) = &self.0 {
            return Stamp(simulated.load(Ordering::Acquire));
        }
        #[expect(clippy::disallowed_methods, reason = "a shell: ROS time is the system's")]
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Stamp(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
    }
}

/// What a node's clock goes by.
pub struct TimeSource {
    clock: RosClock,
    messages: Option<Messages<Clock>>,
}

impl TimeSource {
    /// - `is_simulated`: whether time is that of `/clock`.
    ///
    /// # Errors
    /// If `/clock` cannot be subscribed to.
    pub fn new(node: &mut Node, is_simulated: bool) -> Result<Self> {
        if !is_simulated {
            return Ok(Self { clock: RosClock(None), messages: None });
        }
        // As rclcpp hears it.
        let quality = QosProfile::default().keep_last(1).best_effort();
        let messages = Messages::new(node, "/clock", quality)?;
        let clock = RosClock(Some(Arc::default()));
        Ok(Self { clock, messages: Some(messages) })
    }

    /// The clock.
    pub fn clock(&self) -> RosClock {
        self.clock.clone()
    }

    /// Hears what time it is; says whether that has changed.
    pub fn hear(&mut self) -> bool {
        let (Some(messages), Some(time)) = (&mut self.messages, &self.clock.0) else {
            return false;
        };
        let before = time.load(Ordering::Acquire);
        messages.each(&mut |_, _| {}, |message, _| {
            time.store(message.clock.stamp().0, Ordering::Release);
        });
        time.load(Ordering::Acquire) != before
    }
}

/// A topic's messages.
pub(super) struct Messages<M> {
    pub(super) topic: &'static str,
    bytes: Box<dyn Stream<Item = Vec<u8>> + Unpin>,
    message: PhantomData<fn() -> M>,
}

/// Hears of a topic and what is wrong with its message.
pub(super) type Complain<'a> = dyn FnMut(&'static str, &dyn std::fmt::Display) + 'a;

impl<M: Message> Messages<M> {
    pub(super) fn new(node: &mut Node, topic: &'static str, quality: QosProfile) -> Result<Self> {
        let bytes = node.subscribe_raw(topic, M::TYPE, quality);
        let bytes = bytes.with_context(|| format!("{topic} ({})", M::TYPE))?;
        Ok(Self { topic, bytes: Box::new(bytes), message: PhantomData })
    }

    /// Every message that has come in; bytes that are none are complained about.
    pub(super) fn each(
        &mut self,
        complain: &mut Complain<'_>,
        mut take: impl FnMut(M, &mut Complain<'_>),
    ) {
        while let Some(bytes) = self.bytes.next().now_or_never().flatten() {
            match decode(&bytes) {
                Ok(message) => take(message, complain),
                Err(error) => complain(self.topic, &error),
            }
        }
    }
}

/// A publisher of one of our messages.
#[derive(Debug, Clone)]
pub struct Publisher<M> {
    untyped: PublisherUntyped,
    message: PhantomData<fn(&M)>,
}

impl<M: Message> Publisher<M> {
    /// # Errors
    /// If the topic's name is none, or the message's type was not installed where this was built.
    pub fn new(node: &mut Node, topic: &str, quality: QosProfile) -> Result<Self> {
        let untyped = node.create_publisher_untyped(topic, M::TYPE, quality);
        let untyped = untyped.with_context(|| format!("{topic} ({})", M::TYPE))?;
        Ok(Self { untyped, message: PhantomData })
    }

    /// Sends a message.
    ///
    /// # Errors
    /// If the middleware does not take it.
    pub fn publish(&self, message: &M) -> Result<()> {
        Ok(self.untyped.publish_raw(&encode(message))?)
    }
}
