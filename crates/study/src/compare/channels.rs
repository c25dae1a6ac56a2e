//! Quantities over time: a flight's beside what was predicted of it.

use samara_report::columns::fixed;
use samara_report::document::Grid;
use samara_report::json::{finite, result_objects};

/// A quantity over time: how far a prediction is from the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Name; it ends in its unit.
    pub name: &'static str,
    /// Root of the mean square of the flight's about its mean.
    pub rms_flight: f64,
    /// Mean of the prediction less the flight.
    pub bias: f64,
    /// Root of the mean square of the prediction less the flight.
    pub rms_error: f64,
    /// Correlation of both; `None` where one of them stays what it is.
    pub correlation: Option<f64>,
}

impl Channel {
    /// A channel of the flight's values, each with the prediction's.
    pub fn of(name: &'static str, values: impl Iterator<Item = [f64; 2]> + Clone) -> Self {
        let n = values.clone().count() as f64;
        let mean = |of: &dyn Fn([f64; 2]) -> f64| values.clone().map(of).sum::<f64>() / n;
        let [of_a, of_b] = [mean(&|[a, _]| a), mean(&|[_, b]| b)];
        let aa = mean(&|[a, _]| (a - of_a) * (a - of_a));
        let bb = mean(&|[_, b]| (b - of_b) * (b - of_b));
        let ab = mean(&|[a, b]| (a - of_a) * (b - of_b));
        let rms_error = mean(&|[a, b]| (b - a) * (b - a)).sqrt();
        let correlation = (aa > 1e-12 && bb > 1e-12).then(|| ab / (aa * bb).sqrt());
        Self { name, rms_flight: aa.sqrt(), bias: of_b - of_a, rms_error, correlation }
    }

    /// A table of channels.
    pub fn grid(title: &str, channels: &[Self]) -> Grid {
        let mut grid = Grid::new(title, ["", "rms of the flight", "bias", "rms of the error", "correlation"]);
        for channel in channels {
            let correlation = channel.correlation.map_or("-".to_owned(), |rho| fixed(rho, 3));
            let [flight, bias, error] =
                [channel.rms_flight, channel.bias, channel.rms_error].map(|x| fixed(x, 3));
            grid.row(channel.name, [flight, bias, error, correlation]);
        }
        grid
    }
}

result_objects! {
    /// A quantity over time: a flight's beside what was predicted of it.
    ChannelObject(channel: &Channel) {
        /// Name, with its unit.
        name: String = channel.name.to_owned(),
        /// Root of the mean square of the flight's about its mean; null where nothing was compared.
        rms_flight: Option<f64> = finite(channel.rms_flight),
        /// Mean of the prediction less the flight; null where nothing was compared.
        bias: Option<f64> = finite(channel.bias),
        /// Root of the mean square of the prediction less the flight; null where nothing was compared.
        rms_error: Option<f64> = finite(channel.rms_error),
        /// Correlation of both; null where one of them stays what it is.
        correlation: Option<f64> = channel.correlation,
    }
}
