//! The most likely failure: of standard-normal points that fail, the one nearest to the origin.
//!
//! Lines from the origin through failures that were met, and through their mean, are followed to where they
//! begin to fail. From the nearest such place the direction is turned towards the gradient of the score
//! there, which at the nearest failure it has (Hasofer and Lind 1974; Rackwitz and Fiessler 1978), or spans
//! that matter least there are left out, whichever comes nearer. A span of coordinates counts as one: white
//! noise of a while that acts alike.

use std::ops::Range;

/// Failures of each population from which lines are followed, the nearest.
const TRIED: usize = 4;
/// Places along a line that are looked at, at once.
const LOOKS: usize = 16;
/// Times that the stretch between the last place that holds and the first that fails is looked at again.
const CLOSER: usize = 2;
/// Most turns of the direction.
const TURNS: usize = 12;
/// Shares by which a direction is turned to the gradient.
const SHARES: [f64; 5] = [1.0, 0.6, 0.3, 0.1, 0.03];
/// Shares of the squared distance that spans which matter least are left out for.
const LEFT_OUT: [f64; 6] = [0.1, 0.25, 0.5, 0.75, 0.9, 0.97];
/// A turn that comes nearer by less than this share is the last.
const GAIN: f64 = 0.002;
/// Step of the differences, in standard deviations.
const STEP: f64 = 0.1;

/// Most points that are scored on the way from the failures of so many populations to the most likely one,
/// over so many spans.
pub(super) fn points_most(populations: usize, spans: usize) -> usize {
    let line = (LOOKS + 1) * (CLOSER + 1);
    // As they are and in spans.
    let first = 2 * populations * (TRIED + 1) * line;
    first + TURNS * (spans + (SHARES.len() + LEFT_OUT.len()) * line)
}

/// A failing point that is likelier than all others known.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// The coordinates.
    pub point: Vec<f64>,
    /// The score there, at or above the bound.
    pub score: f64,
    /// Distance from the origin, in standard deviations.
    pub distance: f64,
}

/// Goes from the failures that each population met to the most likely one; `None` without any.
///
/// # Errors
/// What `score` ends with.
pub(super) fn nearest<E>(
    failures: &[Vec<Vec<f64>>],
    spans: &[Range<usize>],
    bound: f64,
    score: &mut impl FnMut(&[Vec<f64>]) -> Result<Vec<f64>, E>,
) -> Result<Option<Nearest>, E> {
    let mut directions: Vec<Vec<f64>> = Vec::new();
    for failures in failures {
        let mut sorted: Vec<&Vec<f64>> = failures.iter().collect();
        sorted.sort_by(|a, b| norm(a).total_cmp(&norm(b)));
        directions.extend(sorted.iter().take(TRIED).map(|point| (*point).clone()));
        directions.extend(mean(failures));
    }
    let farthest = directions.iter().map(|point| norm(point)).fold(0.0, f64::max);
    let whole: Vec<Vec<f64>> = directions.iter().map(|direction| in_spans(direction, spans)).collect();
    directions.extend(whole);
    let mut rays = Rays { bound, score };
    let Some(mut best) = rays.first_failing(&directions, farthest)? else { return Ok(None) };
    for _ in 0..TURNS {
        if best.distance == 0.0 {
            break;
        }
        let gradient = rays.gradient(&best, spans)?;
        let turned = SHARES.iter().map(|share| turned(&best.point, &gradient, *share));
        let order = least_first(&best.point, &gradient, spans);
        let thinned = LEFT_OUT.iter().map(|share| without_least(&best.point, spans, &order, *share));
        let directions: Vec<Vec<f64>> = turned.chain(thinned).collect();
        let Some(found) = rays.first_failing(&directions, best.distance)? else { break };
        let gain = 1.0 - found.distance / best.distance;
        if gain > 0.0 {
            best = found;
        }
        if gain < GAIN {
            break;
        }
    }
    Ok(Some(best))
}

fn norm(point: &[f64]) -> f64 {
    point.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn mean(points: &[Vec<f64>]) -> Option<Vec<f64>> {
    let mut mean = points.first()?.clone();
    for point in &points[1..] {
        mean.iter_mut().zip(point).for_each(|(sum, x)| *sum += x);
    }
    Some(mean)
}

/// The part of a direction that moves whole spans.
fn in_spans(direction: &[f64], spans: &[Range<usize>]) -> Vec<f64> {
    let mut whole = vec![0.0; direction.len()];
    for span in spans {
        let mean = direction[span.clone()].iter().sum::<f64>() / span.len().max(1) as f64;
        whole[span.clone()].fill(mean);
    }
    whole
}

/// The direction of a point, turned by a share to that of the gradient.
fn turned(point: &[f64], gradient: &[f64], share: f64) -> Vec<f64> {
    let (long, steep) = (norm(point), norm(gradient));
    if !(long > 0.0 && steep > 0.0) {
        return point.to_vec();
    }
    let turn = |(x, g): (&f64, &f64)| (1.0 - share) * x / long + share * g / steep;
    point.iter().zip(gradient).map(turn).collect()
}

/// Blocks by how much they do to the score, either way, for their squared length, the least first.
fn least_first(point: &[f64], gradient: &[f64], spans: &[Range<usize>]) -> Vec<usize> {
    let worth = |span: &Range<usize>| {
        let (x, g) = (&point[span.clone()], &gradient[span.clone()]);
        let gain: f64 = x.iter().zip(g).map(|(x, g)| x * g).sum();
        gain.abs() / x.iter().map(|x| x * x).sum::<f64>().max(f64::MIN_POSITIVE)
    };
    let mut order: Vec<(usize, f64)> = spans.iter().map(worth).enumerate().collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    order.into_iter().map(|(span, _)| span).collect()
}

/// A point without the first spans of an order, as many as make up a share of its squared distance at most.
fn without_least(point: &[f64], spans: &[Range<usize>], order: &[usize], share: f64) -> Vec<f64> {
    let mut thinned = point.to_vec();
    let mut left = share * norm(point).powi(2);
    for span in order.iter().map(|span| &spans[*span]) {
        left -= norm(&point[span.clone()]).powi(2);
        if left < 0.0 {
            break;
        }
        thinned[span.clone()].fill(0.0);
    }
    thinned
}

/// Lines from the origin, of which points are scored.
struct Rays<'a, S> {
    bound: f64,
    score: &'a mut S,
}

impl<S> Rays<'_, S> {
    /// Where the first of these lines to fail does so, up to a distance; `None` where none does.
    fn first_failing<E>(&mut self, directions: &[Vec<f64>], farthest: f64) -> Result<Option<Nearest>, E>
    where
        S: FnMut(&[Vec<f64>]) -> Result<Vec<f64>, E>,
    {
        let mut best: Option<Nearest> = None;
        for direction in directions {
            let long = norm(direction);
            if !(long > 0.0) {
                continue;
            }
            // Beyond the best nothing is of interest.
            let mut high = best.as_ref().map_or(farthest, |best| best.distance);
            let mut low = 0.0;
            for _ in 0..=CLOSER {
                let place = |k: usize| low + (high - low) * k as f64 / LOOKS as f64;
                let at = |distance: f64| direction.iter().map(|x| x * distance / long).collect::<Vec<f64>>();
                let first = if low == 0.0 { 0 } else { 1 };
                let places: Vec<f64> = (first..=LOOKS).map(place).collect();
                let points: Vec<Vec<f64>> = places.iter().map(|distance| at(*distance)).collect();
                let scores = (self.score)(&points)?;
                let Some(failing) = scores.iter().position(|score| *score >= self.bound) else { break };
                let (distance, score) = (places[failing], scores[failing]);
                if best.as_ref().is_none_or(|best| distance < best.distance) {
                    best = Some(Nearest { point: points[failing].clone(), score, distance });
                }
                if failing == 0 && low == 0.0 {
                    break;
                }
                (low, high) = (failing.checked_sub(1).map_or(low, |before| places[before]), distance);
            }
        }
        Ok(best)
    }

    /// The gradient of the score at a point, along whole spans.
    fn gradient<E>(&mut self, at: &Nearest, spans: &[Range<usize>]) -> Result<Vec<f64>, E>
    where
        S: FnMut(&[Vec<f64>]) -> Result<Vec<f64>, E>,
    {
        let moved = |span: &Range<usize>| {
            let mut point = at.point.clone();
            let each = STEP / (span.len().max(1) as f64).sqrt();
            point[span.clone()].iter_mut().for_each(|x| *x += each);
            point
        };
        let points: Vec<Vec<f64>> = spans.iter().map(moved).collect();
        let scores = (self.score)(&points)?;
        let mut gradient = vec![0.0; at.point.len()];
        for (span, score) in spans.iter().zip(scores) {
            let slope = (score - at.score) / STEP;
            let each = if slope.is_finite() { slope / (span.len().max(1) as f64).sqrt() } else { 0.0 };
            gradient[span.clone()].fill(each);
        }
        Ok(gradient)
    }
}
