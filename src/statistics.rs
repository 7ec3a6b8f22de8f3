//! Median, quantiles and a seeded bootstrap: how a handful of clips is summed up.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Resamples behind an interval: the ends move by less than a tenth of its width from more.
const RESAMPLES: usize = 2000;

/// The middle value (mean of the two middle ones); `None` of nothing. NaN sorts last.
pub fn median(values: Vec<f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// The value below which the part `part` in `[0, 1]` of `values` lies, linearly interpolated
/// between order statistics (Hyndman & Fan 1996, type 7); `None` of nothing.
pub fn quantile(mut values: Vec<f64>, part: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let place = part.clamp(0.0, 1.0) * values.len().checked_sub(1)? as f64;
    let (below, above) = (values[place.floor() as usize], values[place.ceil() as usize]);
    Some(below + (above - below) * place.fract())
}

/// The mean; `None` of nothing.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Mean, median and a 95 % interval of the mean (percentile bootstrap, Efron 1979), of `n` values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// How many values.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    /// Their median.
    pub median: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Summary {
    /// Sums up `values`; `None` of nothing. The resampling is seeded: equal in, equal out.
    pub fn of(values: &[f64]) -> Option<Self> {
        Self::of_groups(&values.chunks(1).collect::<Vec<_>>())
    }

    /// Sums up values that come in groups, as several measurements of one thing do: the interval is
    /// that of other groups being drawn, each with all its values. `None` of no values.
    pub fn of_groups(groups: &[&[f64]]) -> Option<Self> {
        let values = groups.concat();
        let (mean, median) = (mean(&values)?, median(values.clone())?);
        let groups = groups.iter().filter(|group| !group.is_empty());
        let sums: Vec<(f64, usize)> = groups.map(|g| (g.iter().sum(), g.len())).collect();
        let mut random = ChaCha8Rng::seed_from_u64(sums.len() as u64);
        let resampled = (0..RESAMPLES).map(|_| {
            let draws = (0..sums.len()).map(|_| sums[random.random_range(0..sums.len())]);
            let (sum, count) = draws.fold((0.0, 0), |(sum, count), (s, c)| (sum + s, count + c));
            sum / count as f64
        });
        let means: Vec<f64> = resampled.collect();
        let low = quantile(means.clone(), 0.025)?;
        let high = quantile(means, 0.975)?;
        Some(Self { n: values.len(), mean, median, low, high })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_and_nothing_has_none() {
        assert_eq!(median(vec![3.0, 1.0, 2.0, 10.0]), Some(2.5));
        assert_eq!(quantile(vec![0.0, 10.0], 0.9), Some(9.0));
        assert_eq!(median(Vec::new()), None);
        assert_eq!(Summary::of(&[]), None);
    }

    #[test]
    fn the_interval_is_that_of_a_mean() {
        let values: Vec<f64> = (0..100).map(|i| f64::from(i % 10)).collect();
        let summary = Summary::of(&values).unwrap();
        assert_eq!((summary.n, summary.mean, summary.median), (100, 4.5, 4.5));
        // Standard error 0.288: 1.96 of it either side.
        assert!((summary.high - summary.low - 2.0 * 1.96 * 0.288).abs() < 0.1, "{summary:?}");
        assert_eq!(Summary::of(&values), Some(summary));
    }

    #[test]
    fn measuring_the_same_again_narrows_no_interval() {
        let once: Vec<f64> = (0..40).map(|i| f64::from(i % 10)).collect();
        let twice: Vec<[f64; 2]> = once.iter().map(|v| [*v, *v]).collect();
        let groups: Vec<&[f64]> = twice.iter().map(|group| &group[..]).collect();
        let (summary, grouped) =
            (Summary::of(&once).unwrap(), Summary::of_groups(&groups).unwrap());
        assert_eq!(grouped, Summary { n: 80, ..summary });
        // Groups without values are as if they were not there.
        let with_empty = [&groups[..], &[&[]]].concat();
        assert_eq!(Summary::of_groups(&with_empty), Some(grouped));
        assert_eq!(Summary::of_groups(&[&[], &[]]), None);
    }
}
