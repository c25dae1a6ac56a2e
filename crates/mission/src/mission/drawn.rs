//! How far what a mission draws is off its nominal release.

use super::Mission;
use samara_core::units::DEG_PER_RAD;

/// Standard deviations that what a mission draws reaches.
const SIGMAS: f64 = 3.0;

impl Mission {
    /// How far what the mission draws is off the nominal release, in the order of the axes of an envelope
    /// ([`samara_core::assess::envelope::EnvelopeAxis::ALL`]) and in their units: three standard deviations
    /// of the swing's largest pitch and pitch rate and of what the cut gives, of the random wind of whole
    /// drops; the turbulence that the mission names, as it is. 0: it draws none.
    pub fn drawn_off(&self) -> [f64; 6] {
        let random = &self.study.monte_carlo;
        let cut = &random.tip_off_sigma;
        let swing_rad_s = random.amplitude_sigma_rad * random.omega_rad_s;
        let turbulence = self.site.wind.turbulence.as_ref();
        [
            SIGMAS * random.amplitude_sigma_rad * DEG_PER_RAD,
            SIGMAS * (swing_rad_s.powi(2) + cut.omega_body.y.powi(2)).sqrt() * DEG_PER_RAD,
            SIGMAS * cut.v_body.z,
            0.0,
            SIGMAS * random.wind_sigma_m_s,
            turbulence.map_or(0.0, |turbulence| turbulence.sigma_m_s.into_iter().fold(0.0, f64::max)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::units::RAD_PER_DEG;

    /// By hand, for the x500: swing of 3.1 deg, 3.1316 rad/s; the mission's own turbulence as it is.
    #[test]
    fn closed_form_three_sigma_of_what_is_drawn() {
        let mut mission = Mission::shipped("x500_drop").unwrap();
        let random = &mut mission.study.monte_carlo;
        (random.amplitude_sigma_rad, random.omega_rad_s) = (3.0 * RAD_PER_DEG, 2.0);
        (random.wind_sigma_m_s, random.tip_off_sigma.omega_body.y) = (1.5, 2.5 * RAD_PER_DEG);
        random.tip_off_sigma.v_body.z = 0.1;
        mission.site.wind.turbulence = None;
        let near = |found: [f64; 6], expected: [f64; 6]| {
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12)
        };
        // 3 sqrt(6^2 + 2.5^2) = 3 * 6.5.
        assert!(near(mission.drawn_off(), [9.0, 19.5, 0.3, 0.0, 4.5, 0.0]), "{:?}", mission.drawn_off());
        let real = Mission::shipped("x500_drop").unwrap();
        let sigma_m_s = real.site.wind.turbulence.as_ref().unwrap().sigma_m_s;
        assert_eq!(real.drawn_off()[5], sigma_m_s.into_iter().fold(0.0, f64::max));
    }
}
