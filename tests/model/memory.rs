//! Whatever the bytes, reading them neither panics nor costs more memory than
//! `Model::from_bytes` says.

use handover_mesh::model::Model;
use handover_mesh::predict::LearnedEdges;
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::files::{File, put_together};
use super::parts::{edges_between, motion, parts, person, right_hands, skeleton, source};

/// The most memory that reading took at a time.
fn peak(bytes: &[u8]) -> usize {
    let used = allocation_counter::measure(|| drop(Model::from_bytes(bytes)));
    used.bytes_max as usize
}

/// Reads, and holds the documented bound.
#[track_caller]
fn check_bound(what: &str, bytes: &[u8]) {
    let (length, rest) = bytes.split_first_chunk().unwrap();
    let header = (u64::from_le_bytes(*length) as usize).min(rest.len());
    let most = 64 * header + 2 * (rest.len() - header) + (8 << 20);
    let peak = peak(bytes);
    assert!(peak <= most, "{what}: {peak} bytes for a header of {header} in {}", bytes.len());
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = parts().model().unwrap().to_bytes();
    for length in 0..bytes.len() {
        assert!(Model::from_bytes(&bytes[..length]).is_err(), "{length} bytes");
    }
    assert!(Model::from_bytes(&[&bytes[..], &[0]].concat()).is_err());
}

#[test]
fn ten_thousand_flips_never_panic_nor_fill_the_memory() {
    let good = parts().model().unwrap().to_bytes();
    let header = good.len() - File::of(&good).data.len();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut refused = 0;
    for round in 0..10_000 {
        let mut bytes = good.clone();
        for _ in 0..=round % 3 {
            // The header is the smaller part of the file, and the one that can do harm.
            let end = if rng.random() { bytes.len() } else { header };
            let at = rng.random_range(0..end);
            bytes[at] = if rng.random() { bytes[at] ^ (1 << (round % 8)) } else { rng.random() };
        }
        let used = allocation_counter::measure(|| match Model::from_bytes(&bytes) {
            // What was read can be written and read again.
            Ok(model) if round % 10 == 0 => drop(Model::from_bytes(&model.to_bytes()).unwrap()),
            Ok(_) => {}
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
        });
        let most = 64 * bytes.len();
        assert!(used.bytes_max as usize <= most, "round {round}: {used:?}");
    }
    assert!((1000..10_000).contains(&refused), "{refused} refused");
}

#[test]
fn claimed_sizes_fill_no_memory() {
    let of = |header: &str| put_together(header.as_bytes(), &[]);
    // A megabyte of what costs most where it is kept as values.
    let filled = |before: &str, each: &str, after: &str| {
        of(&format!("{before}{}{after}", each.repeat((1 << 20) / each.len())))
    };
    check_bound("ones", &filled("{\"a\":[1", ",1", "]}"));
    check_bound("lists", &filled("{\"a\":[[]", ",[]", "]}"));
    check_bound("maps", &filled("{\"a\":[{}", ",{}", "]}"));
    check_bound("the same key", &filled("{\"a\":0", ",\"a\":0", "}"));
    let shape = "{\"a\":{\"dtype\":\"F64\",\"data_offsets\":[0,0],\"shape\":[1";
    check_bound("shape", &filled(shape, ",1", "]}}"));
    let empty = "{\"dtype\":\"U8\",\"shape\":[0],\"data_offsets\":[0,0]}";
    let keys: String = (0..20_000).map(|k| format!(",\"{k:x}\":{empty}")).collect();
    check_bound("tensors", &of(&format!("{{\"__metadata__\":{{}}{keys}}}")));
    let claims =
        "{\"a\":{\"dtype\":\"U8\",\"shape\":[9000000000],\"data_offsets\":[0,9000000000]}}";
    assert!(peak(&of(claims)) < 64 << 10);
    let mut long = of("{}");
    long[..8].copy_from_slice(&(Model::MOST_HEADER as u64).to_le_bytes());
    assert!(peak(&long) < 4 << 10);
}

#[test]
fn no_text_beside_the_tensors_fills_the_memory() {
    let good = File::of(&parts().model().unwrap().to_bytes());
    // The first `"key":` and the bracket behind it, and then many of `each`.
    let filled = |key: &str, each: &str, size: usize| {
        let mut file = good.clone();
        let many = each.repeat(size / each.len());
        let text = file.model().to_string();
        assert!(text.contains(key), "{text}");
        file.header["__metadata__"]["model"] =
            text.replacen(key, &(key.to_owned() + &many), 1).into();
        file.bytes()
    };
    let size = 1 << 20;
    check_bound("joints", &filled("\"joints\":[", "\"\",", size));
    check_bound("bones", &filled("\"bones\":[", "[0,0],", size));
    let demonstration = "{\"frames\":0,\"metadata\":{},\"name\":\"\",\"sha256\":\"\"},";
    check_bound("demonstrations", &filled("\"demonstrations\":[", demonstration, size));
    check_bound("name", &filled("\"name\":\"", "\\u0000", size));
    check_bound("key", &filled("\"metadata\":{\"", "\\u0000", size));
    check_bound("config", &filled("\"evaluate.ignored_joints\":[", "1,", size));
    check_bound("deep", &filled("\"evaluate.ignored_joints\":[", "[", size));
    check_bound("deep config", &filled("\"evaluate.ignored_joints\":[", "[", 50_000));
    check_bound("values", &filled("\"evaluate.ignored_joints\":[", "1,", 60_000));
    check_bound("roles", &filled("\"role\":\"", "x", size));
}

#[test]
fn good_models_cost_little_more_than_their_numbers() {
    let model = |frames: usize, which: usize, count: usize, phases: Option<usize>| {
        let people =
            || ["giver", "receiver"].map(|n| person(n, motion(skeleton(which), frames, 0.0)));
        let mut parts = parts();
        parts.sources = (0..count).map(|_| source("x", people())).collect();
        parts.edges = match phases {
            Some(phases) => edges_between(&[(8, 23), (0, 23)], phases),
            None => LearnedEdges::none(right_hands()),
        };
        parts.model().unwrap().to_bytes()
    };
    check_bound("small", &model(3, 0, 1, None));
    check_bound("demonstrations", &model(1, 2, 2000, None));
    for (what, bytes) in
        [("frames", model(20_000, 2, 1, None)), ("phases", model(1, 0, 1, Some(100_000)))]
    {
        check_bound(what, &bytes);
        let peak = peak(&bytes);
        assert!(peak < 2 * bytes.len() + (64 << 10), "{what}: {peak} for {}", bytes.len());
    }
}
