//! Jobs out, rows in: how a study has its flights flown.
//!
//! A study says how many jobs it has next and what each comes to, and goes on with the rows. Who flies them -
//! on how many threads, with which progress, with rows kept so that a study that was ended goes on - is its
//! host's: a study has no thread, no file and no clock. What a job comes to hangs on its number alone, so a
//! row that was kept stands for the job that was flown.

use std::ops::Range;
use std::sync::Arc;

use samara_core::assess::Outcome;
use samara_core::assess::envelope::Edge;
pub use samara_core::assess::envelope::Stopped;
use samara_core::assess::free_fall::{Descent, FoundRelease, ReleaseTrial};
use samara_core::assess::outcome::QUANTITIES;

/// Whether a study is to end now; asked between flights.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// Flies a group of jobs, of these numbers: a row for each, or none where it was stopped.
pub type Fly<'a, R> = &'a (dyn Fn(Range<u64>, Stop<'_>) -> Option<Vec<R>> + Sync);

/// Flies jobs of a set, of these numbers within it.
pub type FlySet<'a, R> = &'a (dyn Fn(usize, Range<u64>, Stop<'_>) -> Option<Vec<R>> + Sync);

/// The jobs that a study has next: `0..count`, `group` neighbours at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Round {
    /// How many jobs.
    pub count: u64,
    /// How many fly side by side, at least one.
    pub group: u64,
}

impl Round {
    /// Jobs that fly side by side in groups.
    pub fn of(count: u64, group: u64) -> Self {
        Self { count, group: group.max(1) }
    }

    /// Groups of the jobs from `first` on.
    pub fn groups(&self, first: u64) -> u64 {
        self.count.saturating_sub(first).div_ceil(self.group)
    }

    /// The jobs of the group of this number, of those from `first` on.
    pub fn group(&self, first: u64, number: u64) -> Range<u64> {
        let from = first + number * self.group;
        from..self.count.min(from + self.group)
    }
}

/// The numbers of a row.
pub type Numbers = Vec<f64>;

/// Flies a group of jobs, of these numbers: the numbers of a row for each, or none where it was stopped.
pub type FlyNumbers<'a> = &'a (dyn Fn(Range<u64>, Stop<'_>) -> Option<Vec<Numbers>> + Sync);

/// A stage of a study behind another one, which may go on for longer, as a search may.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// Name of its jobs, for people.
    pub unit: &'static str,
    /// The most jobs that it may have.
    pub jobs: u64,
    /// A line that stands for everything that its rows hang on beside the study.
    pub hangs_on: &'a str,
}

/// Wall time since a study began [s].
pub type Clock = Arc<dyn Fn() -> f64 + Send + Sync>;

/// The host of a study: it flies the jobs. A study asks for rows by `fly` and `fold`.
pub trait Jobs {
    /// Flies jobs, neighbours in groups, on any threads, and gives the numbers of each to `take`, in the
    /// order of the jobs; `take` says whether they are a row. `what` is said of them while they fly.
    ///
    /// # Errors
    /// [`Stopped`] when the study is to end.
    fn fly_numbers(
        &mut self,
        what: &str,
        round: Round,
        fly: FlyNumbers<'_>,
        take: &mut dyn FnMut(&[f64]) -> bool,
    ) -> Result<(), Stopped>;

    /// What follows is another stage of the study: rows of the one before stay where that goes on for longer,
    /// and those of another end of it are not gone on with.
    ///
    /// # Errors
    /// [`Stopped`] when the study is to end.
    fn stage(&mut self, stage: &Stage<'_>) -> Result<(), Stopped> {
        let _ = stage;
        Ok(())
    }

    /// Whether what was found up to where the study was stopped is wanted: not where others fly its jobs.
    fn wants_so_far(&self) -> bool {
        false
    }

    /// How many jobs were flown by this host, and not by an earlier run or by others.
    fn flown(&self) -> u64 {
        0
    }

    /// The clock of a host that has one.
    fn clock(&self) -> Option<Clock> {
        None
    }
}

impl dyn Jobs + '_ {
    /// Flies jobs; their rows, in the order of the jobs. `what` is said of them while they fly.
    ///
    /// # Errors
    /// [`Stopped`] when the study is to end.
    pub fn fly<R: Row>(&mut self, what: &str, round: Round, fly: Fly<'_, R>) -> Result<Vec<R>, Stopped> {
        let mut rows = Vec::new();
        self.fold(what, round, fly, |row| rows.push(row))?;
        Ok(rows)
    }

    /// Flies `count` jobs of each of some sets, all in one round; the rows of each set. What flies them is
    /// told the number of the set, and numbers within it.
    ///
    /// # Errors
    /// [`Stopped`] when the study is to end.
    pub fn fly_sets<R: Row>(
        &mut self,
        what: &str,
        (sets, count): (usize, u64),
        group: u64,
        fly: FlySet<'_, R>,
    ) -> Result<Vec<Vec<R>>, Stopped> {
        let mut rows: Vec<Vec<R>> = (0..sets).map(|_| Vec::new()).collect();
        self.fold_sets(what, (sets, count), group, fly, |set, row| {
            if let Some(rows) = rows.get_mut(set) {
                rows.push(row);
            }
        })?;
        Ok(rows)
    }

    /// Flies `count` jobs of each of some sets, all in one round, and gives each row to `take` with the
    /// number of its set, in the order of the jobs, so that none has to be kept.
    ///
    /// # Errors
    /// [`Stopped`] when the study is to end.
    pub fn fold_sets<R: Row>(
        &mut self,
        what: &str,
        (sets, count): (usize, u64),
        group: u64,
        fly: FlySet<'_, R>,
        mut take: impl FnMut(usize, R),
    ) -> Result<(), Stopped> {
        let mut taken = 0;
        let some_of_sets = |some: Range<u64>, stop: Stop<'_>| {
            let (mut flown, mut from) = (Vec::new(), some.start);
            while from < some.end {
                let set = from / count;
                let end = some.end.min((set + 1) * count);
                flown.extend(fly(set as usize, from - set * count..end - set * count, stop)?);
                from = end;
            }
            Some(flown)
        };
        self.fold(what, Round::of(sets as u64 * count, group), &some_of_sets, |row| {
            take((taken / count) as usize, row);
            taken += 1;
        })
    }

    /// Flies jobs and gives each row to `take`, in the order of the jobs, so that none has to be kept.
    ///
    /// # Errors
    /// [`Stopped`] when the study is to end.
    pub fn fold<R: Row>(
        &mut self,
        what: &str,
        round: Round,
        fly: Fly<'_, R>,
        mut take: impl FnMut(R),
    ) -> Result<(), Stopped> {
        let numbers = |some: Range<u64>, stop: Stop<'_>| {
            let rows = fly(some, stop)?;
            Some(rows.iter().map(numbers_of).collect())
        };
        self.fly_numbers(what, round, &numbers, &mut |numbers| {
            let mut numbers = numbers.iter().copied();
            let row = R::from_numbers(&mut numbers).filter(|_| numbers.next().is_none());
            row.map(&mut take).is_some()
        })
    }
}

/// The numbers of a row.
pub fn numbers_of(row: &impl Row) -> Numbers {
    let mut numbers = Vec::new();
    row.put_numbers(&mut numbers);
    numbers
}

/// Flies one group after another in the thread that asks, without an end: for tests and examples.
#[derive(Clone, Copy, Debug, Default)]
pub struct HereAndNow;

impl Jobs for HereAndNow {
    fn fly_numbers(
        &mut self,
        _: &str,
        round: Round,
        fly: FlyNumbers<'_>,
        take: &mut dyn FnMut(&[f64]) -> bool,
    ) -> Result<(), Stopped> {
        for number in 0..round.groups(0) {
            let rows = fly(round.group(0, number), &|| false).ok_or(Stopped)?;
            if !rows.iter().all(|row| take(row)) {
                return Err(Stopped);
            }
        }
        Ok(())
    }
}

/// What a job came to, as numbers: to the bit when it is read back.
pub trait Row: Sized + Send {
    /// Puts its numbers behind those of others.
    fn put_numbers(&self, numbers: &mut Vec<f64>);
    /// Takes it from the numbers that are left; `None` where they are not those of such a row.
    fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self>;
}

impl Row for f64 {
    fn put_numbers(&self, numbers: &mut Vec<f64>) {
        numbers.push(*self);
    }
    fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
        numbers.next()
    }
}

/// A row of one number that is exact as a double.
macro_rules! number {
    ($($number:ty),*) => {
        $(impl Row for $number {
            fn put_numbers(&self, numbers: &mut Vec<f64>) {
                numbers.push(*self as f64);
            }
            fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
                numbers.next().map(|x| x as Self)
            }
        })*
    };
}
number!(f32, u64, usize);

impl Row for bool {
    fn put_numbers(&self, numbers: &mut Vec<f64>) {
        numbers.push(f64::from(u8::from(*self)));
    }
    fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
        numbers.next().map(|x| x != 0.0)
    }
}

impl<T: Row> Row for Option<T> {
    fn put_numbers(&self, numbers: &mut Vec<f64>) {
        self.is_some().put_numbers(numbers);
        self.iter().for_each(|value| value.put_numbers(numbers));
    }
    fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
        Some(if bool::from_numbers(numbers)? { Some(T::from_numbers(numbers)?) } else { None })
    }
}

impl<T: Row> Row for Vec<T> {
    fn put_numbers(&self, numbers: &mut Vec<f64>) {
        self.len().put_numbers(numbers);
        self.iter().for_each(|value| value.put_numbers(numbers));
    }
    fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
        (0..usize::from_numbers(numbers)?).map(|_| T::from_numbers(numbers)).collect()
    }
}

impl<T: Row, const N: usize> Row for [T; N] {
    fn put_numbers(&self, numbers: &mut Vec<f64>) {
        self.iter().for_each(|value| value.put_numbers(numbers));
    }
    fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
        let values: Option<Vec<T>> = (0..N).map(|_| T::from_numbers(numbers)).collect();
        values?.try_into().ok()
    }
}

impl<A: Row, B: Row> Row for (A, B) {
    fn put_numbers(&self, numbers: &mut Vec<f64>) {
        self.0.put_numbers(numbers);
        self.1.put_numbers(numbers);
    }
    fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
        Some((A::from_numbers(numbers)?, B::from_numbers(numbers)?))
    }
}

impl Row for Outcome {
    fn put_numbers(&self, numbers: &mut Vec<f64>) {
        QUANTITIES.iter().for_each(|quantity| quantity.of(self).put_numbers(numbers));
    }
    fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
        let mut outcome = Self::default();
        for quantity in &QUANTITIES {
            quantity.put(&mut outcome, Option::<f64>::from_numbers(numbers)?);
        }
        Some(outcome)
    }
}

/// A row of a struct's fields, in this order.
macro_rules! row_of {
    ($name:ty { $($field:ident),* }) => {
        impl $crate::jobs::Row for $name {
            fn put_numbers(&self, numbers: &mut Vec<f64>) {
                $(self.$field.put_numbers(numbers);)*
            }
            fn from_numbers(numbers: &mut dyn Iterator<Item = f64>) -> Option<Self> {
                Some(Self { $($field: $crate::jobs::Row::from_numbers(numbers)?),* })
            }
        }
    };
}
pub(crate) use row_of;

row_of!(Edge { limit, safe, beyond, tried, holds });
row_of!(FoundRelease { after_s, dated_late_s });
row_of!(ReleaseTrial { trial, swing_rad, tumble_rad_s, wind_m_s, autopilot, companion, rules_s });
row_of!(Descent { trial, alarms, slack_alarms, slack_spells, slack_s, least_m_s2, rules });

#[cfg(test)]
mod tests {
    use super::*;

    /// What is put is taken, to the bit, and numbers that are too few are no row.
    #[test]
    fn prop_rows_are_read_back_to_the_bit() {
        let edge =
            Edge { limit: 0.7, safe: 0.1 + 0.2, beyond: None, tried: vec![1e-300, f64::MAX], holds: true };
        let numbers = numbers_of(&edge);
        assert_eq!(Edge::from_numbers(&mut numbers.iter().copied()), Some(edge));
        for cut in 0..numbers.len() {
            assert_eq!(Edge::from_numbers(&mut numbers[..cut].iter().copied()), None, "{cut}");
        }
        let descent = Descent {
            trial: 7,
            least_m_s2: f64::INFINITY,
            rules: vec![[1, 2], [3, 4]],
            ..Descent::default()
        };
        assert_eq!(Descent::from_numbers(&mut numbers_of(&descent).into_iter()), Some(descent));
        let mut outcome =
            Outcome { steady_after_s: Some(1.0 / 3.0), impact_speed_m_s: Some(-0.0), ..Outcome::lost() };
        outcome.j_tpf = f64::INFINITY;
        let read = Outcome::from_numbers(&mut numbers_of(&outcome).into_iter()).unwrap();
        assert_eq!(numbers_of(&read), numbers_of(&outcome));
        assert_eq!(
            (read.j_tpf, read.impact_speed_m_s.unwrap().to_bits()),
            (f64::INFINITY, (-0.0f64).to_bits())
        );
    }

    #[test]
    fn here_and_now_flies_every_job_once_in_order() {
        let fly: Fly<'_, u64> = &|jobs, _| Some(jobs.collect());
        let here: &mut dyn Jobs = &mut HereAndNow;
        assert_eq!(here.fly("jobs", Round::of(7, 3), fly).unwrap(), (0..7).collect::<Vec<_>>());
        let ended: Fly<'_, u64> = &|jobs, _| (jobs.start < 3).then(|| jobs.collect());
        assert!(here.fly("jobs", Round::of(7, 3), ended).is_err());
    }
}
