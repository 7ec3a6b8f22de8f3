//! The sensor's messages, one after another as they arrive.

use handover_mesh::{Point, Stamp};

/// One skeleton message.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// When it was captured, from the trial's start.
    pub stamp: Stamp,
    /// When it arrives.
    pub received: Stamp,
    /// The sensor's number of whoever it saw.
    pub body: u32,
    /// What is said to be the partner: `[m]` in the world, NaN where untracked.
    pub positions: Vec<Point>,
    /// Somebody else in the sensor's view, who may be taken for the partner `[m]`.
    pub(super) bystander: Vec<Point>,
}

/// Hands out messages by the time of their receipt.
#[derive(Debug, Clone)]
pub struct Feed<'a> {
    messages: &'a [Message],
    next: usize,
}

impl<'a> Feed<'a> {
    pub(super) fn new(messages: &'a [Message]) -> Self {
        Self { messages, next: 0 }
    }

    /// The newest message received since the last call, up to `now`; those before it are lost, as
    /// to a node that keeps the last one.
    pub fn receive(&mut self, now: Stamp) -> Option<&'a Message> {
        let since = &self.messages[self.next..];
        let arrived = since.partition_point(|message| message.received <= now);
        self.next += arrived;
        since[..arrived].last()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_has_arrived_is_handed_out_and_once() {
        let message = |at: i64| Message {
            stamp: Stamp(at),
            received: Stamp(at + 30),
            body: 1,
            positions: Vec::new(),
            bystander: Vec::new(),
        };
        let messages = [0, 33, 66].map(message);
        let mut feed = Feed::new(&messages);
        let mut stamp = |now: i64| feed.receive(Stamp(now)).map(|message| message.stamp.0);
        assert_eq!([29, 30, 31].map(&mut stamp), [None, Some(0), None]);
        assert_eq!([100, 200].map(&mut stamp), [Some(66), None]);
    }
}
