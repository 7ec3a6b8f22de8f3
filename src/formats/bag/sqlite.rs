//! SQLite3 bags → their topics and messages, one after another, and what of them is lost.
//!
//! Tables `topics(id, name, type, serialization_format)` and `messages(topic_id, timestamp, data)`,
//! read in the order in which rows were written. The bytes are nobody's we know: nothing but plain
//! tables is asked, and no more than the file can hold is taken.

use std::collections::BTreeMap;
use std::io::Read as _;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, MAIN_DB};

use super::losses::{Loss, Losses};
use super::{Event, packed};
use crate::time::Stamp;

const MAGIC: &[u8] = b"SQLite format 3\0";
/// Of a database: page size, versions, page count.
const HEAD: usize = 100;

/// Whether the bytes begin as SQLite's do.
pub(super) fn is_sqlite(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Walks through the file.
pub(super) fn walk(
    file: &str,
    bytes: &[u8],
    budget: &mut u64,
    losses: &mut Losses,
    each: &mut dyn FnMut(Event<'_>),
) {
    let (mut messages, mut unknown) = (0, BTreeMap::new());
    let cut = cut_behind(bytes);
    let read = open(bytes).and_then(|database| {
        let topics = topics(&database, each)?;
        rows(&database, bytes.len(), &topics, budget, &mut unknown, &mut |event| {
            messages += 1;
            each(event);
        })?;
        metadata(&database, each);
        Ok(())
    });
    for (topic, messages) in unknown {
        losses.add(Loss::Topic { file: file.to_owned(), topic, messages });
    }
    let reason = match (read, cut) {
        (Ok(()), None) => return,
        (Ok(()), Some(cut)) => cut,
        (Err(Fault::Database(error)), None) => super::shortened(&error.to_string()),
        (Err(Fault::Database(error)), Some(cut)) => {
            format!("{cut}: {}", super::shortened(&error.to_string()))
        }
        (Err(Fault::Other(reason)), _) => reason,
    };
    losses.add(Loss::Rows { file: file.to_owned(), reason, messages });
}

enum Fault {
    Database(rusqlite::Error),
    Other(String),
}

impl From<rusqlite::Error> for Fault {
    fn from(error: rusqlite::Error) -> Self {
        Self::Database(error)
    }
}

/// The size of a page, if the header has one.
fn page_size(bytes: &[u8]) -> Option<usize> {
    let size = u16::from_be_bytes([*bytes.get(16)?, *bytes.get(17)?]);
    let size = if size == 1 { 1 << 16 } else { usize::from(size) };
    (size >= 512 && size.is_power_of_two()).then_some(size)
}

/// Says so if the file is shorter than its header claims.
fn cut_behind(bytes: &[u8]) -> Option<String> {
    let pages = u32::from_be_bytes(*bytes.get(28..)?.first_chunk()?) as usize;
    let claimed = pages.checked_mul(page_size(bytes)?)?;
    (claimed > bytes.len()).then(|| format!("cut off: {} of {claimed} bytes", bytes.len()))
}

/// The database in memory, to be read only.
fn open(bytes: &[u8]) -> Result<Connection, Fault> {
    let page = page_size(bytes).filter(|page| bytes.len() >= HEAD.max(*page));
    let page = page.ok_or_else(|| Fault::Other("its header is damaged".to_owned()))?;
    // SQLite refuses a database with fewer pages than it claims; the whole ones serve us.
    let bytes = &bytes[..bytes.len() / page * page];
    let (head, rest) = bytes.split_at(HEAD);
    let mut head = head.to_vec();
    let pages = u32::try_from(bytes.len() / page).unwrap_or(u32::MAX);
    head[28..32].copy_from_slice(&pages.to_be_bytes());
    // One that was written with a log beside it cannot be opened from memory; what is in the log
    // is not in these bytes either way.
    head[18..20].copy_from_slice(&[1, 1]);
    let mut database = Connection::open_in_memory()?;
    database.deserialize_read_exact(MAIN_DB, head.chain(rest), bytes.len(), true)?;
    database.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON;")?;
    Ok(database)
}

/// Refuses what is asked of if it is no plain table: a view may compute for ever.
fn check_plain(database: &Connection, table: &str) -> Result<(), Fault> {
    let query = "SELECT type, sql FROM sqlite_master WHERE name = ?1";
    let [kind, sql] = database.query_row(query, [table], |row| {
        Ok([row.get::<_, String>(0)?, row.get::<_, String>(1)?])
    })?;
    let sql = sql.to_uppercase();
    if kind != "table" || !sql.starts_with("CREATE TABLE") || sql.contains(" AS") {
        return Err(Fault::Other(format!("'{table}' is no plain table")));
    }
    Ok(())
}

/// Name, type and encoding of each topic, by its number.
type Topics = BTreeMap<i64, [String; 3]>;

fn topics(database: &Connection, each: &mut dyn FnMut(Event<'_>)) -> Result<Topics, Fault> {
    check_plain(database, "topics")?;
    let query = "SELECT id, name, type, serialization_format FROM topics ORDER BY id";
    let mut query = database.prepare(query)?;
    let mut rows = query.query([])?;
    let mut topics = Topics::new();
    while let Some(row) = rows.next()? {
        let topic: [String; 3] = [row.get(1)?, row.get(2)?, row.get(3)?];
        each(Event::Topic { name: &topic[0], type_name: &topic[1] });
        topics.insert(row.get(0)?, topic);
    }
    Ok(topics)
}

/// - `unknown`: how many rows are of topics that nobody defined.
fn rows(
    database: &Connection,
    length: usize,
    topics: &Topics,
    budget: &mut u64,
    unknown: &mut BTreeMap<i64, u64>,
    each: &mut dyn FnMut(Event<'_>),
) -> Result<(), Fault> {
    check_plain(database, "messages")?;
    let query = "SELECT topic_id, timestamp, data FROM messages ORDER BY rowid";
    let mut query = database.prepare(query)?;
    let mut rows = query.query([])?;
    // What a damaged file claims twice is not taken for ever.
    let mut left = length;
    while let Some(row) = rows.next()? {
        let ValueRef::Blob(data) = row.get_ref(2)? else {
            return Err(Fault::Other("a message is no blob".to_owned()));
        };
        left = left
            .checked_sub(data.len().max(1))
            .ok_or_else(|| Fault::Other("more in it than it can hold".to_owned()))?;
        let number = row.get(0)?;
        let Some([topic, type_name, encoding]) = topics.get(&number) else {
            *unknown.entry(number).or_default() += 1;
            continue;
        };
        let time = Stamp(row.get(1)?);
        let unpacked;
        let mut data = data;
        if packed::is_zstd(data) {
            unpacked = packed::zstd(data, (*budget).min(super::mcap::LARGEST_CHUNK));
            if let Some(fault) = unpacked.fault {
                return Err(Fault::Other(fault));
            }
            *budget -= unpacked.bytes.len() as u64;
            data = &unpacked.bytes;
        }
        each(Event::Message { topic, type_name, encoding, time, data });
    }
    Ok(())
}

/// What is known of the bag, in newer files; nothing is lost without it.
fn metadata(database: &Connection, each: &mut dyn FnMut(Event<'_>)) {
    if check_plain(database, "metadata").is_err() {
        return;
    }
    let query = "SELECT metadata FROM metadata ORDER BY id DESC LIMIT 1";
    if let Ok(text) = database.query_row(query, [], |row| row.get::<_, String>(0)) {
        each(Event::Metadata(&text));
    }
}
