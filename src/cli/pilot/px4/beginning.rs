//! What PX4's start-up script is told of the vehicle.

/// What PX4's start-up script is told before it starts anything.
#[derive(Clone, Debug, Default)]
pub struct Beginning {
    /// The mixer of the vehicle, of a PX4 that has mixers as files.
    pub mixer: Option<&'static str>,
    /// Parameters that are read once, at the start; those that this PX4 does not have, it leaves out.
    pub parameters: Vec<(&'static str, f64)>,
}

impl Beginning {
    /// Lines of the script, if there are any.
    pub(super) fn script(&self) -> Option<String> {
        let mixer = self.mixer.map(|mixer| format!("set MIXER {mixer}\n"));
        let parameters = self.parameters.iter().map(|(name, value)| format!("param set {name} {value}\n"));
        let lines: String = mixer.into_iter().chain(parameters).collect();
        (!lines.is_empty()).then(|| format!("#!/bin/sh\n# Read by PX4's start-up script.\n{lines}"))
    }
}
