//! How a board must be set up for hardware in the loop: looked at when it is heard, each parameter told with
//! what it is and should be. (PX4's `init.d/rcS` and `airframes/1001_rc_quad_x.hil`.)

use std::collections::BTreeMap;
use std::fmt;

use mavlink::dialects::common::{MavMessage, PARAM_VALUE_DATA};

use super::super::streamer::parameters::{Exchange, RETRY_US};
use super::super::streamer::patience::Wire;
use crate::time::TimeUs;

/// Function of the first motor among those that PX4's outputs have.
const FIRST_MOTOR: u8 = 101;

/// A parameter of the set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Parameter {
    /// SYS_HITL: sensors from the simulator, no real outputs; read at the board's start.
    Hitl,
    /// HIL_ACT_FUNC of a channel, from 1: what is sent in it. PX4 v1.14 and later.
    Output(u8),
}

impl Parameter {
    fn wanted(self) -> u8 {
        match self {
            Self::Hitl => 1,
            Self::Output(channel) => FIRST_MOTOR + channel - 1,
        }
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hitl => f.write_str("SYS_HITL"),
            Self::Output(channel) => write!(f, "HIL_ACT_FUNC{channel}"),
        }
    }
}

/// A parameter of the set-up as it is on a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checked {
    parameter: Parameter,
    /// `None`: the board has not said.
    value: Option<f64>,
}

impl Checked {
    /// Whether hardware in the loop can do with it: what is not known counts as right.
    pub fn is_fit(&self) -> bool {
        self.value.is_none_or(|value| value == f64::from(self.parameter.wanted()))
    }
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { parameter, value } = self;
        let wanted = parameter.wanted();
        match (parameter, value) {
            (_, Some(value)) if self.is_fit() => write!(f, "board: {parameter} = {value}, as it should be"),
            (Parameter::Hitl, Some(value)) => {
                let is =
                    if *value == 2.0 { "the board simulates itself" } else { "it flies by its own sensors" };
                write!(
                    f,
                    "board: {parameter} = {value}, and should be {wanted}: {is}; set it, and start the board again"
                )
            }
            (Parameter::Output(channel), Some(value)) => write!(
                f,
                "board: {parameter} = {value}, and should be {wanted}: in channel {channel} motor {channel} is expected"
            ),
            (Parameter::Hitl, None) => write!(f, "board: {parameter} is not answered; it should be {wanted}"),
            (Parameter::Output(_), None) => write!(
                f,
                "board: {parameter} is not there: a PX4 before v1.14, whose airframe's mixer file has its outputs, or one built for \
                 simulation"
            ),
        }
    }
}

/// A look at a board's set-up.
#[derive(Clone, Debug)]
pub(super) struct BoardCheck {
    parameters: Vec<Parameter>,
    exchange: Exchange,
}

impl BoardCheck {
    /// For a vehicle of so many rotors.
    pub(super) fn of(rotors: usize) -> Self {
        let outputs = (1..=rotors).filter_map(|channel| u8::try_from(channel).ok()).map(Parameter::Output);
        let parameters: Vec<_> = std::iter::once(Parameter::Hitl).chain(outputs).collect();
        let names: Vec<_> = parameters.iter().map(Parameter::to_string).collect();
        let exchange = Exchange::new(&BTreeMap::new(), names.iter().map(String::as_str));
        Self { parameters, exchange }
    }

    /// What is to be sent to the board's system now.
    pub(super) fn poll(&mut self, now: TimeUs, system_id: u8) -> Vec<MavMessage> {
        self.exchange.poll(now, RETRY_US, &Wire::default(), system_id)
    }

    pub(super) fn take(&mut self, m: &PARAM_VALUE_DATA) {
        self.exchange.take(m);
    }

    /// How the board is set up, once it has answered or will not; outputs that are all not there in one.
    pub(super) fn outcome(&self) -> Option<Vec<Checked>> {
        let values = self.exchange.is_over().then(|| self.exchange.outcome().values)?;
        let value = |parameter: Parameter| values.get(&parameter.to_string()).map(|value| value.as_f64());
        let has_outputs = self.parameters.iter().any(|p| *p != Parameter::Hitl && value(*p).is_some());
        let is_told = |p: &&Parameter| has_outputs || matches!(p, Parameter::Hitl | Parameter::Output(1));
        let told = self.parameters.iter().filter(is_told);
        Some(told.map(|p| Checked { parameter: *p, value: value(*p) }).collect())
    }
}
