//! What decides an output: Sobol's indices of groups of independent standard-normal coordinates.
//!
//! The first-order index of a group is the share of the output's variance that would go if the group were
//! known; its total index the share that would stay if all else were known, interactions included. Two
//! samples A and B, and for each group A with that group from B (Saltelli et al. 2010,
//! <https://doi.org/10.1016/j.cpc.2009.09.018>, table 2):
//!
//! ```text
//! S_i  = mean of f(B) (f(A_B^i) - f(A)) / V        T_i = mean of (f(A) - f(A_B^i))^2 / (2 V)
//! ```
//!
//! with outputs less their mean. Intervals take the estimates as normal, with the deviation that the ratio of
//! two means has to first order. A row of which an output is no number is left out, of that output, and
//! counted: it would make all indices of the output no number. Where few rows carry most of the variance the
//! estimates hang on those and their intervals are too short: [`Sensitivity::hangs_on_few`].

use std::ops::Range;

use crate::random::{Purpose, Stream, normal_pair};

/// Points of each sample that are looked at together.
const BLOCK: usize = 64;
/// Deviations of a normal variable on either side that hold 95 % of it.
const DEVIATIONS: f64 = 1.959_963_984_540_054;

/// How indices are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SobolStudy {
    /// Points of each of the two samples.
    pub points: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// An index with the interval that holds it with 95 % confidence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Index {
    /// The estimate.
    pub value: f64,
    /// Half of the interval's width.
    pub half: f64,
}

/// Share of the rows that are few, where they carry half of the variance; of a normal output 19 % do.
const FEW: f64 = 0.01;
/// Rows that are few whatever their share.
const FEW_AT_LEAST: usize = 5;

/// What decides an output.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sensitivity {
    /// Rows that it was estimated from: points of A and of B with those between them.
    pub rows: usize,
    /// Rows that were left out, since the output is no number at one of their points.
    pub left_out: usize,
    /// Fewest rows that carry half of the variance; 0 of an output that does not vary.
    pub half_by: usize,
    /// Mean of the output.
    pub mean: f64,
    /// Standard deviation of the output.
    pub deviation: f64,
    /// First-order index of each group.
    pub first: Vec<Index>,
    /// Total index of each group.
    pub total: Vec<Index>,
}

impl Sensitivity {
    /// Whether so few rows carry half of the variance that the indices are theirs more than the output's: one
    /// of a hundred, or five.
    pub fn hangs_on_few(&self) -> bool {
        let few = (FEW * self.rows as f64) as usize;
        (1..=few.max(FEW_AT_LEAST)).contains(&self.half_by)
    }
}

/// The outputs of a point of A, of B, and of A with each group from B.
struct SobolSample<const M: usize> {
    a: [f64; M],
    b: [f64; M],
    mixed: Vec<[f64; M]>,
}

impl SobolStudy {
    /// Number of evaluations for so many groups.
    pub fn evaluations(&self, groups: usize) -> usize {
        self.points * (groups + 2)
    }

    /// Estimates the indices of groups of coordinates, each a list of ranges, for `M` outputs. An output that
    /// does not vary has indices of zero.
    ///
    /// # Errors
    /// What `outputs` ends with.
    pub fn run<E, const M: usize>(
        &self,
        dimensions: usize,
        groups: &[Vec<Range<usize>>],
        mut outputs: impl FnMut(&[Vec<f64>]) -> Result<Vec<[f64; M]>, E>,
    ) -> Result<[Sensitivity; M], E> {
        let mut rows: Vec<SobolSample<M>> = Vec::with_capacity(self.points);
        for from in (0..self.points).step_by(BLOCK) {
            let mut points = Vec::new();
            for k in from..self.points.min(from + BLOCK) {
                let [a, b] = [0, 1].map(|sample| self.point(2 * k as u64 + sample, dimensions));
                for group in groups {
                    let mut mixed = a.clone();
                    for range in group {
                        mixed[range.clone()].copy_from_slice(&b[range.clone()]);
                    }
                    points.push(mixed);
                }
                points.extend([a, b]);
            }
            let values = outputs(&points)?;
            rows.extend(values.chunks_exact(groups.len() + 2).map(|values| {
                let (mixed, ends) = values.split_at(groups.len());
                SobolSample { a: ends[0], b: ends[1], mixed: mixed.to_vec() }
            }));
        }
        Ok(std::array::from_fn(|output| sensitivity(&rows, output, groups.len())))
    }

    fn point(&self, number: u64, dimensions: usize) -> Vec<f64> {
        let mut stream = Stream::new(self.seed, Purpose::Sobol, number);
        let mut point = Vec::with_capacity(dimensions + 1);
        while point.len() < dimensions {
            point.extend(normal_pair(stream.bits()));
        }
        point.truncate(dimensions);
        point
    }
}

fn sensitivity<const M: usize>(rows: &[SobolSample<M>], output: usize, groups: usize) -> Sensitivity {
    let values = |row: &SobolSample<M>| {
        let mixed: Vec<f64> = row.mixed.iter().map(|mixed| mixed[output]).collect();
        let whole = [row.a[output], row.b[output]].iter().chain(&mixed).all(|x| x.is_finite());
        whole.then_some((row.a[output], row.b[output], mixed))
    };
    let kept: Vec<(f64, f64, Vec<f64>)> = rows.iter().filter_map(values).collect();
    let n = kept.len() as f64;
    let mean = kept.iter().map(|(a, b, _)| 0.5 * (a + b)).sum::<f64>() / n;
    let square = |(a, b, _): &(f64, f64, Vec<f64>)| 0.5 * ((a - mean) * (a - mean) + (b - mean) * (b - mean));
    let squares: Vec<f64> = kept.iter().map(square).collect();
    let variance = squares.iter().sum::<f64>() / n;
    let index = |terms: Vec<f64>| {
        if !(variance > 0.0) {
            return Index::default();
        }
        let value = terms.iter().sum::<f64>() / n / variance;
        let off = |(term, square): (&f64, &f64)| (term - value * square) / variance;
        let spread = terms.iter().zip(&squares).map(off).map(|x| x * x).sum::<f64>() / n;
        Index { value, half: DEVIATIONS * (spread / n).sqrt() }
    };
    let of = |term: fn([f64; 3]) -> f64, group: usize| {
        index(kept.iter().map(|(a, b, mixed)| term([a - mean, b - mean, mixed[group] - mean])).collect())
    };
    Sensitivity {
        rows: kept.len(),
        left_out: rows.len() - kept.len(),
        half_by: half_by(&squares),
        mean,
        deviation: variance.sqrt(),
        first: (0..groups).map(|group| of(|[a, b, mixed]| b * (mixed - a), group)).collect(),
        total: (0..groups).map(|group| of(|[a, _, mixed]| 0.5 * (a - mixed) * (a - mixed), group)).collect(),
    }
}

/// How many of the greatest of these make up half of their sum; 0 where all are zero.
fn half_by(squares: &[f64]) -> usize {
    let mut greatest = squares.to_vec();
    greatest.sort_by(|a, b| b.total_cmp(a));
    let half = 0.5 * squares.iter().sum::<f64>();
    let mut sum = 0.0;
    let short = |square: &f64| {
        let short = sum < half;
        sum += square;
        short
    };
    greatest.into_iter().filter(|square| *square > 0.0).take_while(short).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    /// Uniform in 0..1 for a standard-normal z.
    fn uniform(z: f64) -> f64 {
        0.5 * math::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
    }

    fn one(range: Range<usize>) -> Vec<Range<usize>> {
        std::iter::once(range).collect()
    }

    fn study(dimensions: usize, f: fn(&[f64]) -> f64) -> Sensitivity {
        let groups: Vec<Vec<Range<usize>>> = (0..dimensions).map(|k| one(k..k + 1)).collect();
        let study = SobolStudy { points: 20_000, seed: 4 };
        let outputs = |points: &[Vec<f64>]| Ok::<_, ()>(points.iter().map(|z| [f(z)]).collect());
        let [found] = study.run(dimensions, &groups, outputs).unwrap();
        found
    }

    fn holds(name: &str, found: &[Index], exact: &[f64]) {
        for (found, exact) in found.iter().zip(exact) {
            // Twice the interval of 95 %: one in ten thousand lies outside.
            assert!((found.value - exact).abs() <= 2.0 * found.half + 1e-12, "{name}: {found:?}, {exact}");
            assert!(found.half < 0.03, "{name}: {found:?}");
        }
    }

    /// Ishigami and Homma (1990): `sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1`, x uniform in -pi..pi. Its variance
    /// is a^2/8 + b pi^4/5 + b^2 pi^8/18 + 1/2.
    #[test]
    fn closed_form_ishigami() {
        let pi = std::f64::consts::PI;
        let found = study(3, |z| {
            let x: Vec<f64> = z.iter().map(|z| std::f64::consts::PI * (2.0 * uniform(*z) - 1.0)).collect();
            let (s1, s2) = (math::sin(x[0]), math::sin(x[1]));
            s1 + 7.0 * s2 * s2 + 0.1 * x[2].powi(4) * s1
        });
        let (a, b) = (7.0f64, 0.1f64);
        let v1 = 0.5 * (1.0 + b * pi.powi(4) / 5.0).powi(2);
        let (v2, v13) = (a * a / 8.0, b * b * pi.powi(8) * 8.0 / 225.0);
        let v = v1 + v2 + v13;
        assert!((found.mean - 3.5).abs() < 0.1 && (found.deviation / v.sqrt() - 1.0).abs() < 0.02);
        holds("first", &found.first, &[v1 / v, v2 / v, 0.0]);
        holds("total", &found.total, &[(v1 + v13) / v, v2 / v, v13 / v]);
    }

    /// Sobol's g function with a = 0, 1, 4.5, 9, 99: `prod (|4 x - 2| + a)/(1 + a)`, x uniform in 0..1.
    /// `V_i = 1/(3 (1 + a_i)^2)`, and the variance is `prod (1 + V_i) - 1`.
    #[test]
    fn closed_form_sobols_g_function() {
        const A: [f64; 5] = [0.0, 1.0, 4.5, 9.0, 99.0];
        let found = study(5, |z| {
            z.iter().zip(A).map(|(z, a)| ((4.0 * uniform(*z) - 2.0).abs() + a) / (1.0 + a)).product()
        });
        let parts = A.map(|a| 1.0 / (3.0 * (1.0 + a) * (1.0 + a)));
        let product: f64 = parts.iter().map(|v| 1.0 + v).product();
        let v = product - 1.0;
        holds("first", &found.first, &parts.map(|part| part / v));
        holds("total", &found.total, &parts.map(|part| part * product / (1.0 + part) / v));
    }

    /// A group counts as one; what an output does not know has no index, nor has one that does not vary.
    #[test]
    fn closed_form_groups_of_a_sum() {
        let study = SobolStudy { points: 4000, seed: 1 };
        let groups = [vec![0..1, 2..4], one(1..2), one(4..5)];
        let outputs = |points: &[Vec<f64>]| {
            Ok::<_, ()>(points.iter().map(|z| [z[0] + z[1] + z[2] + z[3], 7.0]).collect())
        };
        let [sum, still] = study.run(5, &groups, outputs).unwrap();
        for found in [&sum.first, &sum.total] {
            holds("sum", &found[2..], &[0.0]);
            assert!(
                (found[0].value - 0.75).abs() < 0.05 && (found[1].value - 0.25).abs() < 0.05,
                "{found:?}"
            );
        }
        assert_eq!((still.deviation, still.total[0]), (0.0, Index::default()));
    }

    /// A point in a thousand has an output of 100, all others that of a normal sum: five sixths of the
    /// variance are a few rows', which is said. Of the sum alone `P(chi^2 > x)` with two degrees of freedom
    /// has half by 18.7 % of the rows.
    #[test]
    fn closed_form_a_few_rows_that_carry_the_variance_are_marked() {
        let study = SobolStudy { points: 4000, seed: 2 };
        let outputs = |points: &[Vec<f64>]| {
            let far = |z: &[f64]| if z[0] > 3.09 { 100.0 } else { z[0] + z[1] };
            Ok::<_, ()>(points.iter().map(|z| [z[0] + z[1], far(z)]).collect())
        };
        let [sum, rare] = study.run(2, &[one(0..1), one(1..2)], outputs).unwrap();
        assert!((sum.half_by as f64 / 4000.0 - 0.187).abs() < 0.01 && !sum.hangs_on_few(), "{}", sum.half_by);
        assert!(rare.hangs_on_few() && rare.half_by > 0, "{}", rare.half_by);
        assert_eq!((half_by(&[3.0, 0.0, 5.0, 2.0]), half_by(&[0.0; 4]), half_by(&[])), (1, 0, 0));
    }

    /// Where an output is no number its row is left out and counted; the others' indices stay those of the
    /// sum, a half each.
    #[test]
    fn closed_form_rows_without_a_number_are_left_out() {
        let study = SobolStudy { points: 4000, seed: 3 };
        let outputs = |points: &[Vec<f64>]| {
            let lost = |z: &[f64]| if z[2] > 2.5 { f64::NAN } else { z[0] + z[1] };
            Ok::<_, ()>(points.iter().map(|z| [lost(z)]).collect())
        };
        let groups = [one(0..1), one(1..2), one(2..3)];
        let [found] = study.run(3, &groups, outputs).unwrap();
        assert!(found.left_out > 20 && found.left_out + found.rows == 4000, "{}", found.left_out);
        holds("sum", &found.total, &[0.5, 0.5, 0.0]);
        let [nothing] = study.run(3, &groups, |points| Ok::<_, ()>(vec![[f64::NAN]; points.len()])).unwrap();
        assert!(nothing.rows == 0 && nothing.mean.is_nan() && nothing.total[0] == Index::default());
    }
}
