//! PX4's own description of its parameters: type, default, unit, range, decimals. The table is
//! `parameters.csv`; a `#` in a name stands for a rotor's number, 0 to 11. `release` is `current`
//! (the main branch), `v1.16` (known up to that release at least, no longer in the main branch), `v1.12`
//! (known there, later renamed or dropped, or not looked up later) or `older` (known to older releases only).

/// The table `parameters.csv`.
const TABLE: &str = include_str!("parameters.csv");

/// Type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 32-bit integer.
    Int,
    /// Single precision.
    Float,
}

/// One parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name; `#` stands for a rotor's number.
    pub name: &'static str,
    /// Type of the value.
    pub kind: Kind,
    /// Value unless it is set.
    pub default: f32,
    /// Unit as PX4 writes it; empty for none.
    pub unit: &'static str,
    /// Least value; `None`: unlimited.
    pub min: Option<f32>,
    /// Greatest value; `None`: unlimited.
    pub max: Option<f32>,
    /// Number of decimals that a ground station shows.
    pub decimals: Option<usize>,
    /// Releases that have the parameter: `current`, `v1.16`, `v1.12` or `older`.
    pub release: &'static str,
    /// Description in a few words; may be empty.
    pub description: &'static str,
}

impl Parameter {
    /// Whether a value lies in the stated range, ends included.
    pub fn contains(&self, value: f64) -> bool {
        self.min.is_none_or(|min| f64::from(min) <= value)
            && self.max.is_none_or(|max| value <= f64::from(max))
    }

    /// The range in words: `0.01 to 0.6`, `at least 0`.
    pub fn range(&self) -> String {
        match (self.min, self.max) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            (Some(min), None) => format!("at least {min}"),
            (None, Some(max)) => format!("at most {max}"),
            (None, None) => "any".to_owned(),
        }
    }
}

/// PX4's parameters by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    by_name: std::collections::BTreeMap<&'static str, Parameter>,
}

impl Metadata {
    /// The table of PX4's parameters that comes with samara.
    pub fn px4() -> Self {
        Self { by_name: TABLE.lines().skip(1).filter_map(parameter).map(|p| (p.name, p)).collect() }
    }

    /// The description of a parameter, also of a rotor's; `None` when it is not in the table.
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        self.by_name.get(name).or_else(|| {
            let digits: String =
                name.chars().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
            let rotor: u8 = digits.parse().ok().filter(|i| *i < 12)?;
            (rotor.to_string() == digits)
                .then(|| self.by_name.get(name.replacen(&digits, "#", 1).as_str()))?
        })
    }

    /// All parameters in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = &Parameter> {
        self.by_name.values()
    }
}

fn parameter(line: &'static str) -> Option<Parameter> {
    let mut fields = line.splitn(9, ',');
    let mut next = || fields.next();
    let optional =
        |text: &'static str| if text.is_empty() { Some(None) } else { text.parse().ok().map(Some) };
    Some(Parameter {
        name: next()?,
        kind: match next()? {
            "INT32" => Kind::Int,
            "FLOAT" => Kind::Float,
            _ => return None,
        },
        default: next()?.parse().ok()?,
        unit: next()?,
        min: optional(next()?)?,
        max: optional(next()?)?,
        decimals: optional(next()?)?.map(|d: f32| d as usize),
        release: next()?,
        description: next()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_the_table_is_understood() {
        let metadata = Metadata::px4();
        assert_eq!(metadata.iter().count(), TABLE.lines().count() - 1);
        for p in metadata.iter() {
            assert!(["current", "v1.16", "v1.12", "older"].contains(&p.release), "{p:?}");
            assert!(p.contains(f64::from(p.default)), "{p:?}");
        }
        assert!(TABLE.lines().is_sorted_by(|a, b| a.starts_with("name,") || a < b));
    }

    /// PX4 v1.16.0's sources have them (`multicopter_position_control_params.c` and its neighbours).
    #[test]
    fn reference_what_v1_16_knows_is_not_older() {
        for name in [
            "MC_AIRMODE",
            "MPC_HOLD_DZ",
            "MPC_LAND_RC_HELP",
            "MPC_USE_HTE",
            "MPC_XY_MAN_EXPO",
            "MPC_YAW_EXPO",
            "MPC_Z_MAN_EXPO",
        ] {
            assert!(Metadata::px4().iter().any(|p| p.name == name && p.release == "v1.16"), "{name}");
        }
    }

    #[test]
    fn reference_rows() {
        let metadata = Metadata::px4();
        let p = metadata.get("MC_PITCHRATE_P").unwrap();
        assert_eq!(
            (p.kind, p.default, p.min, p.max, p.decimals),
            (Kind::Float, 0.15, Some(0.01), Some(0.6), Some(3))
        );
        assert_eq!(p.range(), "0.01 to 0.6");
        assert!(p.contains(f64::from(0.6f32)) && !p.contains(0.61) && !p.contains(f64::NAN));
        assert_eq!(metadata.get("MC_PR_INT_LIM").unwrap().range(), "at least 0");
        for rotor in ["CA_ROTOR0_KM", "CA_ROTOR11_KM"] {
            assert_eq!(metadata.get(rotor).unwrap().max, Some(1.0));
        }
        for unknown in ["CA_ROTOR12_KM", "CA_ROTOR00_KM", "CA_ROTOR_KM", "", "CA_ROTOR999999_KM", "#"] {
            assert_eq!(metadata.get(unknown), None, "{unknown}");
        }
    }
}
