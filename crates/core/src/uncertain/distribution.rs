//! How a quantity is distributed.

use std::sync::Arc;

use crate::math;
use crate::random::Stream;

/// The distribution of a number.
#[derive(Clone, Debug, PartialEq)]
pub enum Distribution {
    /// Uniform between two numbers, the first at most the second.
    Uniform([f64; 2]),
    /// Normal.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation; not negative.
        sigma: f64,
    },
    /// Normal, and never outside two numbers: what is outside is drawn again.
    TruncatedNormal {
        /// Mean before it is cut.
        mean: f64,
        /// Standard deviation before it is cut; positive.
        sigma: f64,
        /// The least and the greatest number.
        range: [f64; 2],
    },
    /// By a table of probabilities, which ascend from 0 to 1, and the numbers that are not exceeded with
    /// them, which do not descend; uniform between two rows.
    Table(Arc<[[f64; 2]]>),
}

/// A distribution of which nothing can be drawn, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnfitDistribution {
    /// A number is none, or is infinite.
    #[error("expected finite numbers")]
    NotFinite,
    /// The second end of a range is below the first one.
    #[error("expected the least number first, then the greatest")]
    Descending,
    /// A standard deviation is negative, or zero where something is cut off.
    #[error("expected a standard deviation above 0")]
    Sigma,
    /// Next to nothing of a normal distribution is within the range.
    #[error("expected a range within eight standard deviations of the mean")]
    Outside,
    /// A table's rows do not ascend, or do not go from 0 to 1.
    #[error(
        "expected rows of a probability and a number: probabilities that ascend from 0 to 1, and numbers that do not descend"
    )]
    Table,
}

/// Deviations of a normal distribution beyond which nothing is drawn: a stream has 53 bits.
const NORMAL_ENDS: f64 = 8.6;
/// Deviations from the mean at which a range must begin.
const CUT_WITHIN: f64 = 8.0;
/// Deviations of a normal distribution at which it is taken to end where one end is asked for.
const END: f64 = 2.0;

impl Distribution {
    /// The distribution, if something can be drawn of it.
    ///
    /// # Errors
    /// [`UnfitDistribution`] says why nothing can.
    pub fn checked(self) -> Result<Self, UnfitDistribution> {
        match &self {
            Self::Uniform(range) => ascending(*range)?,
            Self::Normal { mean, sigma } => {
                finite(&[*mean, *sigma])?;
                if *sigma < 0.0 {
                    return Err(UnfitDistribution::Sigma);
                }
            }
            Self::TruncatedNormal { mean, sigma, range } => {
                finite(&[*mean, *sigma])?;
                ascending(*range)?;
                if *sigma <= 0.0 {
                    return Err(UnfitDistribution::Sigma);
                }
                let [least, most] = range.map(|end| (end - mean) / sigma);
                if least > CUT_WITHIN || most < -CUT_WITHIN {
                    return Err(UnfitDistribution::Outside);
                }
            }
            Self::Table(rows) => {
                rows.iter().try_for_each(|row| finite(row))?;
                let from_0_to_1 = rows.first().is_some_and(|[p, _]| *p == 0.0)
                    && rows.last().is_some_and(|[p, _]| *p == 1.0);
                let ascend = rows.windows(2).all(|two| two[0][0] < two[1][0] && two[0][1] <= two[1][1]);
                if !(from_0_to_1 && ascend) {
                    return Err(UnfitDistribution::Table);
                }
            }
        }
        Ok(self)
    }

    /// The number at a standard-normal coordinate: a greater one has a greater coordinate.
    pub fn at(&self, z: f64) -> f64 {
        match self {
            Self::Uniform([least, most]) => 0.5 * (least + most) + 0.5 * (most - least) * either_way(z),
            Self::Normal { mean, sigma } => mean + sigma * z,
            Self::TruncatedNormal { mean, sigma, range } => cut(*mean, *sigma, *range, below(z)),
            Self::Table(rows) => of_table(rows, below(z)),
        }
    }

    /// The number of a draw.
    pub fn draw(&self, stream: &mut Stream) -> f64 {
        match self {
            Self::Uniform([least, most]) => stream.between(*least, *most),
            Self::Normal { mean, sigma } => mean + sigma * stream.normal(),
            Self::TruncatedNormal { mean, sigma, range } => cut(*mean, *sigma, *range, stream.uniform()),
            Self::Table(rows) => of_table(rows, stream.uniform()),
        }
    }

    /// The least number that is ever drawn and the greatest.
    pub fn support(&self) -> [f64; 2] {
        match self {
            Self::Uniform(range) | Self::TruncatedNormal { range, .. } => *range,
            Self::Normal { mean, sigma } => [mean - NORMAL_ENDS * sigma, mean + NORMAL_ENDS * sigma],
            Self::Table(rows) => [rows[0][1], rows[rows.len() - 1][1]],
        }
    }

    /// Numbers that stand for both ends where one quantity is tried at a time: those of a uniform one, two
    /// standard deviations of a normal one, 2.3 and 97.7 % of any other.
    pub fn ends(&self) -> [f64; 2] {
        match self {
            Self::Uniform(range) => *range,
            _ => [self.at(-END), self.at(END)],
        }
    }

    /// Mean and standard deviation: closed forms, of one that is cut by 4096 quantiles.
    pub fn mean_and_sigma(&self) -> (f64, f64) {
        match self {
            Self::Uniform([least, most]) => (0.5 * (least + most), (most - least) / 12f64.sqrt()),
            Self::Normal { mean, sigma } => (*mean, *sigma),
            Self::TruncatedNormal { mean, sigma, range } => {
                let n = 4096;
                let all = (0..n).map(|i| cut(*mean, *sigma, *range, (f64::from(i) + 0.5) / f64::from(n)));
                let (sum, squares) = all.fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
                let mean = sum / f64::from(n);
                (mean, (squares / f64::from(n) - mean * mean).max(0.0).sqrt())
            }
            Self::Table(rows) => {
                let (mut mean, mut square) = (0.0, 0.0);
                for two in rows.windows(2) {
                    let ([p0, a], [p1, b]) = (two[0], two[1]);
                    mean += (p1 - p0) * 0.5 * (a + b);
                    square += (p1 - p0) * (a * a + a * b + b * b) / 3.0;
                }
                (mean, (square - mean * mean).max(0.0).sqrt())
            }
        }
    }

    /// The distribution in words, without a unit: "normal, 0.02 about 0".
    pub fn words(&self) -> String {
        // What was identified has more digits than anyone reads.
        let four = |x: &f64| format!("{x:.3e}").parse().unwrap_or(*x);
        match self {
            Self::Uniform(range) => {
                let [least, most] = range.each_ref().map(four);
                format!("uniform from {least} to {most}")
            }
            Self::Normal { mean, sigma } => format!("normal, {} about {}", four(sigma), four(mean)),
            Self::TruncatedNormal { mean, sigma, range } => {
                let [least, most] = range.each_ref().map(four);
                format!("normal, {} about {}, cut at {least} and {most}", four(sigma), four(mean))
            }
            Self::Table(rows) => {
                let [least, most] = self.support().each_ref().map(four);
                format!("by a table of {} rows from {least} to {most}", rows.len())
            }
        }
    }
}

fn finite(numbers: &[f64]) -> Result<(), UnfitDistribution> {
    if numbers.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(UnfitDistribution::NotFinite) }
}

fn ascending(range: [f64; 2]) -> Result<(), UnfitDistribution> {
    finite(&range)?;
    if range[0] <= range[1] { Ok(()) } else { Err(UnfitDistribution::Descending) }
}

/// `2 Phi(z) - 1`: uniform in (-1, 1) for a standard-normal z.
pub(crate) fn either_way(z: f64) -> f64 {
    1.0 - math::erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

/// The number of a normal distribution that is cut that is not exceeded with the probability `p`.
fn cut(mean: f64, sigma: f64, range: [f64; 2], p: f64) -> f64 {
    let [from, to] = range.map(|end| (end - mean) / sigma);
    (mean + sigma * truncated(p, from, to)).clamp(range[0], range[1])
}

/// The number of a table, of two rows or more, that is not exceeded with the probability `p`.
fn of_table(rows: &[[f64; 2]], p: f64) -> f64 {
    let after = rows.partition_point(|[at, _]| *at <= p).clamp(1, rows.len() - 1);
    let ([p0, x0], [p1, x1]) = (rows[after - 1], rows[after]);
    x0 + (x1 - x0) * ((p - p0) / (p1 - p0)).clamp(0.0, 1.0)
}

/// The probability that a standard-normal number is below z.
fn below(z: f64) -> f64 {
    0.5 * math::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Steps of a bisection that leaves nothing between two numbers.
const HALVINGS: usize = 64;

/// The number between `from` and `to` below which a standard-normal one that is cut there is with the
/// probability `p`. Of a range above the mean its mirror image is taken, whose probabilities have digits.
fn truncated(p: f64, from: f64, to: f64) -> f64 {
    if from > 0.0 {
        return -truncated(1.0 - p, -to, -from);
    }
    let wanted = below(from) + p * (below(to) - below(from));
    let (mut low, mut high) = (from, to);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if below(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
