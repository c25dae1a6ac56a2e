//! Arrangements of rotors, in PX4's order.

use samara_core::model::RotationSense;

/// Arrangement of the rotors, on a circle about the centre of mass, in PX4's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// Four rotors, two of them ahead.
    QuadX,
    /// Four rotors, one of them ahead.
    QuadPlus,
    /// Six rotors, two of them ahead.
    HexaX,
    /// Six rotors, one of them ahead.
    HexaPlus,
    /// Eight rotors, two of them ahead.
    OctoX,
    /// Eight rotors, one of them ahead.
    OctoPlus,
    /// Three arms, one of them behind, with a coaxial pair each.
    Y6,
    /// Four arms, two of them ahead, with a coaxial pair each.
    X8,
}

/// Where the rotor of a frame sits on its arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnArm {
    /// Alone.
    Alone,
    /// Above the other one of a coaxial pair.
    Upper,
    /// Below the other one of a coaxial pair.
    Lower,
}

/// A rotor of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRotor {
    /// Bearing of the arm, clockwise from the front [deg].
    pub bearing_deg: f64,
    /// Place on the arm.
    pub on_arm: OnArm,
    /// Sense of rotation, seen from above.
    pub spin: RotationSense,
}

impl Frame {
    /// Every frame there is.
    pub const ALL: [Self; 8] = [
        Self::QuadX,
        Self::QuadPlus,
        Self::HexaX,
        Self::HexaPlus,
        Self::OctoX,
        Self::OctoPlus,
        Self::Y6,
        Self::X8,
    ];

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::QuadX => "quad-x",
            Self::QuadPlus => "quad-plus",
            Self::HexaX => "hexa-x",
            Self::HexaPlus => "hexa-plus",
            Self::OctoX => "octo-x",
            Self::OctoPlus => "octo-plus",
            Self::Y6 => "y6",
            Self::X8 => "x8",
        }
    }

    /// Whether each arm has a coaxial pair.
    pub fn is_coaxial(self) -> bool {
        matches!(self, Self::Y6 | Self::X8)
    }

    /// The rotors in PX4's order (its airframe reference, <https://docs.px4.io/main/en/airframes/>; coaxial
    /// ones: airframes 11001 and 12001).
    pub fn rotors(self) -> Vec<FrameRotor> {
        use OnArm::{Alone, Lower, Upper};
        use RotationSense::{Ccw, Cw};
        let places: &[(f64, OnArm, RotationSense)] = match self {
            Self::QuadX => {
                &[(45.0, Alone, Ccw), (-135.0, Alone, Ccw), (-45.0, Alone, Cw), (135.0, Alone, Cw)]
            }
            Self::QuadPlus => {
                &[(90.0, Alone, Ccw), (-90.0, Alone, Ccw), (0.0, Alone, Cw), (180.0, Alone, Cw)]
            }
            Self::HexaX => &[
                (90.0, Alone, Cw),
                (-90.0, Alone, Ccw),
                (-30.0, Alone, Cw),
                (150.0, Alone, Ccw),
                (30.0, Alone, Ccw),
                (-150.0, Alone, Cw),
            ],
            Self::HexaPlus => &[
                (0.0, Alone, Cw),
                (180.0, Alone, Ccw),
                (-120.0, Alone, Cw),
                (60.0, Alone, Ccw),
                (-60.0, Alone, Ccw),
                (120.0, Alone, Cw),
            ],
            Self::OctoX => &[
                (22.5, Alone, Cw),
                (-157.5, Alone, Cw),
                (67.5, Alone, Ccw),
                (157.5, Alone, Ccw),
                (-22.5, Alone, Ccw),
                (-112.5, Alone, Ccw),
                (-67.5, Alone, Cw),
                (112.5, Alone, Cw),
            ],
            Self::OctoPlus => &[
                (0.0, Alone, Cw),
                (180.0, Alone, Cw),
                (45.0, Alone, Ccw),
                (135.0, Alone, Ccw),
                (-45.0, Alone, Ccw),
                (-135.0, Alone, Ccw),
                (-90.0, Alone, Cw),
                (90.0, Alone, Cw),
            ],
            Self::Y6 => &[
                (60.0, Upper, Cw),
                (60.0, Lower, Ccw),
                (180.0, Upper, Cw),
                (180.0, Lower, Ccw),
                (-60.0, Upper, Cw),
                (-60.0, Lower, Ccw),
            ],
            Self::X8 => &[
                (45.0, Upper, Ccw),
                (-45.0, Upper, Cw),
                (-135.0, Upper, Ccw),
                (135.0, Upper, Cw),
                (-45.0, Lower, Ccw),
                (45.0, Lower, Cw),
                (135.0, Lower, Ccw),
                (-135.0, Lower, Cw),
            ],
        };
        places.iter().map(|&(bearing_deg, on_arm, spin)| FrameRotor { bearing_deg, on_arm, spin }).collect()
    }
}
