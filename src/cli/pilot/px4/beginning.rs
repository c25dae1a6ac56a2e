//! What PX4's start-up script is told of the vehicle, and how.

use samara::control::px4::versions::ToldBy;

/// What PX4's start-up script is told before it starts anything.
#[derive(Clone, Debug)]
pub struct Beginning {
    /// The mixer of the vehicle, of a PX4 that has mixers as files.
    pub mixer: Option<&'static str>,
    /// Parameters that are read once, at the start; those that this PX4 does not have, it leaves out.
    pub parameters: Vec<(&'static str, f64)>,
    /// How it is told the parameters.
    pub by: ToldBy,
}

impl Beginning {
    /// Lines of the script, if there are any.
    pub(super) fn script(&self) -> Option<String> {
        let told = self.parameters.iter().filter(|_| self.by == ToldBy::Script);
        let mixer = self.mixer.map(|mixer| format!("set MIXER {mixer}\n"));
        let parameters = told.map(|(name, value)| format!("param set {name} {value}\n"));
        let lines: String = mixer.into_iter().chain(parameters).collect();
        (!lines.is_empty()).then(|| format!("#!/bin/sh\n# Read by PX4's start-up script.\n{lines}"))
    }

    /// Variables of its environment, and their values.
    pub(super) fn environment(&self) -> impl Iterator<Item = (String, String)> + '_ {
        let told = self.parameters.iter().filter(|_| self.by == ToldBy::Environment);
        told.map(|(name, value)| (format!("{}{name}", ToldBy::VARIABLE), value.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_go_one_way_alone() {
        let told = |by| {
            let beginning = Beginning { mixer: None, parameters: vec![("EKF2_DELAY_MAX", 450.0)], by };
            (beginning.script(), beginning.environment().collect::<Vec<_>>())
        };
        let (script, variables) = told(ToldBy::Script);
        assert!(script.unwrap().ends_with("param set EKF2_DELAY_MAX 450\n") && variables.is_empty());
        let variable = ("PX4_PARAM_EKF2_DELAY_MAX".to_owned(), "450".to_owned());
        assert_eq!(told(ToldBy::Environment), (None, vec![variable]));
    }
}
