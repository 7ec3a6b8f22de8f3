//! Tracks of a bag → which two of them are the people.

use super::super::error::Reason;
use super::collect::{Collected, Kind, Track};

/// What the partner of a robot is called in a bag that was recorded live.
pub const PARTNER: &str = "partner";
/// What the robot is called there.
pub const ROBOT: &str = "robot";
/// Of custom data: the names of the two, the first one first; a JSON list.
pub(super) const PEOPLE: &str = "handover_mesh.people";

/// Somebody and the track they are seen in.
pub(super) struct Candidate {
    pub(super) name: String,
    pub(super) track: Track,
}

/// The two that are meant, in order.
///
/// # Errors
/// [`Reason::WhichPeople`] if there are fewer or more.
pub(super) fn two(collected: &mut Collected) -> Result<[Candidate; 2], Reason> {
    let robots = [Kind::Targets, Kind::Robot].map(|kind| collected.tracks(kind));
    let robots = robots.into_iter().find(|tracks| !tracks.is_empty()).unwrap_or_default();
    let seen = [Kind::Skeleton, Kind::Markers, Kind::Transforms];
    // The same people by another road are not other people.
    let people = seen.map(|kind| collected.tracks(kind));
    let people = people.into_iter().find(|tracks| !tracks.is_empty()).unwrap_or_default();
    let has_robot = !robots.is_empty();
    let alone = people.len() == 1;
    let name = |track: &Track| match (track.id, parent(&track.topic)) {
        _ if has_robot && alone => PARTNER.to_owned(),
        (Some(id), _) => format!("body_{id}"),
        (None, Some(parent)) => parent.to_owned(),
        (None, None) => PARTNER.to_owned(),
    };
    let people = people.into_iter().map(|track| Candidate { name: name(&track), track });
    let robots = robots.into_iter().map(|track| Candidate { name: ROBOT.to_owned(), track });
    let found: Vec<Candidate> = people.chain(robots).collect();
    <[Candidate; 2]>::try_from(found).map(|two| in_order(two, collected)).map_err(|found| {
        let named = found.iter().map(|Candidate { name, track }| {
            let (topic, count) = (super::shortened(&track.topic), track.seen.len());
            format!("{} in {topic}, {count} times", super::shortened(name))
        });
        Reason::WhichPeople { found: named.take(10).collect(), topics: collected.listed() }
    })
}

/// As whoever wrote the bag had them, where that is known.
fn in_order(two: [Candidate; 2], collected: &Collected) -> [Candidate; 2] {
    let names = collected.custom_data.get(PEOPLE);
    let names: Option<Vec<String>> = names.and_then(|names| serde_json::from_str(names).ok());
    let [first, second] = two;
    if names.is_some_and(|names| names.len() == 2 && names[0] == second.name) {
        [second, first]
    } else {
        [first, second]
    }
}

/// The part of a topic's name before the last: whose it is.
pub(super) fn parent(topic: &str) -> Option<&str> {
    let (rest, _) = topic.rsplit_once('/')?;
    rest.rsplit('/').next().filter(|parent| !parent.is_empty())
}
