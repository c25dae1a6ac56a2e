//! Outcomes of flights from t = 0 that are flown many at once: each the same as [`FlightWatch`] makes of the
//! flight alone, whose peaks are looked for eight side by side where they fly so.

use std::ops::ControlFlow;

#[cfg(target_arch = "x86_64")]
use super::beside::{Beside, Look};
use super::outcome::Outcome;
use super::safety::FlightWatch;
use crate::sim::{Sample, Watch};

/// Outcomes of flights, by their number from 0.
#[derive(Debug)]
pub(crate) struct Outcomes<'a> {
    watches: Vec<FlightWatch<'a>>,
    #[cfg(target_arch = "x86_64")]
    beside: Option<Box<Beside>>,
}

impl<'a> Outcomes<'a> {
    /// Outcomes by these watches, of one scenario, which have not seen anything.
    pub(crate) fn by(watches: Vec<FlightWatch<'a>>) -> Self {
        Self {
            watches,
            #[cfg(target_arch = "x86_64")]
            beside: None,
        }
    }

    /// The outcomes.
    pub(crate) fn finish(mut self) -> Vec<Outcome> {
        self.leave();
        self.watches.iter().map(FlightWatch::outcome).collect()
    }

    /// Tells each watch what has been seen side by side.
    fn leave(&mut self) {
        #[cfg(target_arch = "x86_64")]
        if let Some(beside) = self.beside.take() {
            for (i, watch) in self.watches[beside.flights()].iter_mut().enumerate() {
                watch.seen = beside.seen(i);
                watch.plan_end_p_ned = beside.kept_p_ned(i).unwrap_or(watch.plan_end_p_ned);
            }
        }
    }
}

impl Watch for Outcomes<'_> {
    fn take(&mut self, flight: usize, sample: &Sample) -> ControlFlow<()> {
        self.leave();
        self.watches[flight].observe(sample);
        ControlFlow::Continue(())
    }

    #[cfg(target_arch = "x86_64")]
    fn take_abreast(&mut self, first: usize, count: usize, samples: &crate::sim::watch::Samples<'_>) -> bool {
        if self.beside.as_ref().is_none_or(|beside| !beside.is_of(first, count)) {
            self.leave();
            let seen = self.watches[first..first + count].iter().map(|watch| &watch.seen);
            self.beside = Some(Box::new(Beside::begin(first, seen, samples.a_ned.x)));
        }
        let watch = &self.watches[first];
        let look = Look {
            limits: &watch.scenario.limits.safety,
            v_cmd_ned: watch.scenario.target_v_ned,
            within_m_s: watch.scenario.limits.steady_within_m_s,
            steady_at_s: Some(samples.t_s),
            plan_v_ned: None,
            keeps_place: samples.t_s <= watch.plan_end_s,
        };
        if let Some(beside) = &mut self.beside {
            beside.see(samples, &look);
        }
        true
    }
}
