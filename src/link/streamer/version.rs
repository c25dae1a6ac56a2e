//! The vehicle's software, by AUTOPILOT_VERSION.

use std::fmt;

/// A version as PX4 tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AutopilotVersion {
    /// `flight_sw_version`: major, minor, patch, kind of release, a byte each.
    pub software: u32,
    /// The last four bytes of `flight_custom_version`: the first eight digits of PX4's git hash.
    pub git: u32,
}

/// As `git describe` would say it: `v1.12.0 2c8a3b1f`.
impl fmt::Display for AutopilotVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [major, minor, patch, kind] = self.software.to_be_bytes();
        // FIRMWARE_VERSION_TYPE.
        let kind = match kind {
            255 => "",
            192..255 => "-rc",
            128..192 => "-beta",
            64..128 => "-alpha",
            _ => "-dev",
        };
        write!(f, "v{major}.{minor}.{patch}{kind} {:08x}", self.git)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PX4's `px4_firmware_version()` for the tags v1.12.0 and v1.14.0-beta1.
    #[test]
    fn versions_are_told_as_tags_are() {
        let said = |software, git| AutopilotVersion { software, git }.to_string();
        assert_eq!(said(0x010C_00FF, 0x0A1B_2C3D), "v1.12.0 0a1b2c3d");
        assert_eq!(said(0x010E_0080, 0), "v1.14.0-beta 00000000");
        assert_eq!(said(0x010D_0300, 1), "v1.13.3-dev 00000001");
    }
}
