//! One motion's time on another's: dynamic time warping.
//!
//! `D(i,j) = c(i,j) + min(D(i−1,j−1), D(i−1,j) + p, D(i,j−1) + p)` (Sakoe & Chiba 1978), with a
//! penalty `p` for standing still, and ends that may stay unmatched for a while: a demonstration
//! may have started earlier or ended later. Knows nothing of people; sees both motions whole.

/// How far a warp may go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WarpSettings {
    /// Cost, in the unit of the distances, of a step in which one of the two stands still; ≥ 0.
    pub pause_penalty: f64,
    /// The part of either end of the source, `0..0.5`, that may be left out without cost.
    pub slack: f64,
}

/// For each frame of the target motion, the place in the source motion that matches it.
#[derive(Debug, Clone, PartialEq)]
pub struct Warp {
    /// Fractional source frames, one per target frame, never falling.
    pub source: Vec<f64>,
    /// Mean distance along the path, in the unit of the distances.
    pub cost: f64,
}

/// Warps a source of `sources` frames onto a target of `targets` frames.
///
/// `distance(target, source)` is finite and ≥ 0. Where a target frame matches several source
/// frames their middle counts.
///
/// Returns `None` if either is empty.
/// # Cost
/// `O(targets · sources)` time and memory.
pub fn warp(
    targets: usize,
    sources: usize,
    settings: WarpSettings,
    distance: impl Fn(usize, usize) -> f64,
) -> Option<Warp> {
    if targets == 0 || sources == 0 {
        return None;
    }
    let slack = (settings.slack * sources as f64) as usize;
    // Total costs row by row, and the step that led to each: 0 both, 1 target alone, 2 source.
    let mut steps = vec![0u8; targets * sources];
    let mut before = vec![f64::INFINITY; sources];
    let mut row = before.clone();
    for target in 0..targets {
        for source in 0..sources {
            let here = distance(target, source);
            let (mut best, mut step) = match (target, source) {
                (0, source) if source <= slack => (0.0, 0),
                (0, _) | (_, 0) => (f64::INFINITY, 0),
                _ => (before[source - 1], 0),
            };
            if before[source] + settings.pause_penalty < best {
                (best, step) = (before[source] + settings.pause_penalty, 1);
            }
            if source > 0 && row[source - 1] + settings.pause_penalty < best {
                (best, step) = (row[source - 1] + settings.pause_penalty, 2);
            }
            row[source] = best + here;
            steps[target * sources + source] = step;
        }
        std::mem::swap(&mut before, &mut row);
    }
    // The cheapest place to end, the last one where they tie.
    let ends = (sources - 1).saturating_sub(slack)..sources;
    let end = ends.min_by(|a, b| before[*a].total_cmp(&before[*b]).then(b.cmp(a)))?;
    let (mut target, mut source, mut length) = (targets - 1, end, 1);
    let mut ranges = vec![(usize::MAX, 0); targets];
    loop {
        let range: &mut (usize, usize) = &mut ranges[target];
        *range = (range.0.min(source), range.1.max(source));
        match steps[target * sources + source] {
            0 if target == 0 => break,
            0 => (target, source) = (target - 1, source - 1),
            1 => target -= 1,
            _ => source -= 1,
        }
        length += 1;
    }
    let middle = |(first, last): &(usize, usize)| (first + last) as f64 / 2.0;
    let source = ranges.iter().map(middle).collect();
    Some(Warp { source, cost: before[end] / f64::from(length) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: WarpSettings = WarpSettings { pause_penalty: 0.01, slack: 0.0 };

    fn curve(t: f64) -> f64 {
        (3.0 * t).sin() + t
    }

    fn warped(targets: &[f64], sources: &[f64], settings: WarpSettings) -> Warp {
        warp(targets.len(), sources.len(), settings, |i, j| (targets[i] - sources[j]).abs())
            .unwrap()
    }

    #[test]
    fn a_motion_matches_itself_frame_by_frame() {
        let motion: Vec<f64> = (0..50).map(|k| curve(f64::from(k) / 20.0)).collect();
        let warp = warped(&motion, &motion, SETTINGS);
        assert_eq!(warp.cost, 0.0);
        assert_eq!(warp.source, (0..50).map(f64::from).collect::<Vec<_>>());
    }

    #[test]
    fn half_the_tempo_is_found() {
        let slow: Vec<f64> = (0..101).map(|k| curve(f64::from(k) / 40.0)).collect();
        let fast: Vec<f64> = (0..51).map(|k| curve(f64::from(k) / 20.0)).collect();
        for (k, source) in warped(&fast, &slow, SETTINGS).source.iter().enumerate() {
            assert!((source - 2.0 * k as f64).abs() <= 2.0, "{k}: {source}");
        }
        let back = warped(&slow, &fast, SETTINGS);
        assert!(back.source.windows(2).all(|w| w[0] <= w[1]), "never runs back");
    }

    #[test]
    fn slack_leaves_out_a_late_start() {
        let whole: Vec<f64> = (0..100).map(|k| curve(f64::from(k) / 30.0)).collect();
        let part = &whole[15..90];
        let settings = WarpSettings { slack: 0.2, ..SETTINGS };
        let warp = warped(part, &whole, settings);
        assert_eq!((warp.source[0], warp.source[74], warp.cost), (15.0, 89.0, 0.0));
        assert_eq!(warp.source.len(), part.len());
    }

    #[test]
    fn nothing_matches_nothing() {
        assert_eq!(warp(0, 3, SETTINGS, |_, _| 0.0), None);
        assert_eq!(warp(3, 0, SETTINGS, |_, _| 0.0), None);
    }
}
