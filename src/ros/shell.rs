//! What every node needs: a context, an end, a clock, bytes out.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context as _, Result};
use r2r::{Clock, Node, PublisherUntyped, QosProfile};

use crate::messages::{Message, encode};
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

/// A node's clock: that of `/clock` if its time is simulated, else the system's.
#[derive(Clone)]
pub struct RosClock(Arc<Mutex<Clock>>);

impl RosClock {
    /// The clock of a node.
    pub fn of(node: &Node) -> Self {
        Self(node.get_ros_clock())
    }

    /// Now; 0 before simulated time has begun.
    pub fn now(&self) -> Stamp {
        // A poisoned clock is as good: nothing is left half done in it.
        let mut clock = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let since = clock.get_now().unwrap_or_default();
        Stamp(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
    }
}

/// A publisher of one of our messages.
#[derive(Debug, Clone)]
pub struct Publisher<M> {
    untyped: PublisherUntyped,
    message: std::marker::PhantomData<fn(&M)>,
}

impl<M: Message> Publisher<M> {
    /// # Errors
    /// If the topic's name is none, or the message's type was not installed where this was built.
    pub fn new(node: &mut Node, topic: &str, quality: QosProfile) -> Result<Self> {
        let untyped = node.create_publisher_untyped(topic, M::TYPE, quality);
        let untyped = untyped.with_context(|| format!("{topic} ({})", M::TYPE))?;
        Ok(Self { untyped, message: std::marker::PhantomData })
    }

    /// Sends a message.
    ///
    /// # Errors
    /// If the middleware does not take it.
    pub fn publish(&self, message: &M) -> Result<()> {
        Ok(self.untyped.publish_raw(&encode(message))?)
    }
}
