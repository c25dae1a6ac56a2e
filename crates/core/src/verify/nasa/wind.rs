//! NASA's check cases with drag over the turning Earth: 6 in still air, 7 in a steady wind, 8 in a wind that
//! grows with altitude.
//!
//! The drag is [`BodyAero`]'s, whose side area is its drag area, as a sphere has it; the wind of case 8 is a
//! [`WindProfile`]: the code that flies. Motion stays over the equator, where with longitude the directions
//! east and down turn: `v_e v_d/r` and `v_e^2/r` are added to Coriolis' acceleration.

use nalgebra::Vector3;

use super::super::motion::{Load, advance, level};
use super::super::{Check, CheckGroup};
use super::data::rows_of;
use super::{ALTITUDE_FT, Brick, DT_S, Earth};
use crate::frames::rotate_body_from_ned;
use crate::model::rigid_body::{BodyState, MassProperties};
use crate::model::wind::WindProfile;
use crate::model::{BodyAero, ModelError};
use crate::units::M_PER_FT;

/// The published states, a line each: case, time, altitude, speeds east and down.
const PUBLISHED: &str = include_str!("wind_cases.csv");

/// A state in the units of the report.
#[derive(Clone, Copy, Debug)]
struct PublishedWind {
    t_s: f64,
    altitude_ft: f64,
    speed_east_ft_s: f64,
    speed_down_ft_s: f64,
}

/// The published states of a case.
fn published(case: u8) -> Vec<PublishedWind> {
    let row = |[t_s, altitude_ft, speed_east_ft_s, speed_down_ft_s]: [f64; 4]| PublishedWind {
        t_s,
        altitude_ft,
        speed_east_ft_s,
        speed_down_ft_s,
    };
    rows_of(PUBLISHED, case).map(row).collect()
}

/// Wind towards the east at 0 and at 30 000 ft [ft/s]: cases 6, 7 and 8.
pub const WINDS_FT_S: [(u8, [f64; 2]); 3] = [(6, [0.0, 0.0]), (7, [20.0, 20.0]), (8, [-20.0, 70.0])];

/// A sphere, its air and its Earth.
struct Falling {
    earth: Earth,
    mass: MassProperties,
    aero: BodyAero,
    wind: WindProfile,
}

impl Falling {
    fn altitude_m(state: &BodyState) -> f64 {
        ALTITUDE_FT * M_PER_FT - state.p_ned.z
    }

    fn load(&self, state: &BodyState) -> Load {
        let (altitude_m, v) = (Self::altitude_m(state), state.v_ned);
        let through_air = rotate_body_from_ned(state.q_ned_from_body, v - self.wind.at(altitude_m));
        let aero = self.aero.load(through_air.into(), Earth::density_kg_m3(altitude_m));
        let turn = v.y / (self.earth.radius_m + altitude_m);
        let apparent = self.earth.coriolis_ned(&v) + Vector3::new(0.0, turn * v.z, -turn * v.y);
        let apparent_body = rotate_body_from_ned(state.q_ned_from_body, apparent * self.mass.mass_kg);
        Load {
            gravity_m_s2: self.earth.apparent_gravity_m_s2(altitude_m),
            force_body: Vector3::from(aero.force_body) + apparent_body,
            moment_body: aero.moment_body.into(),
        }
    }
}

/// Cases 6, 7 and 8: a sphere falls through the air of a turning Earth in winds `[at 0, at 30 000 ft]`
/// towards the east [ft/s].
///
/// # Errors
/// [`ModelError`] when the sphere is impossible.
pub fn cases_6_to_8(
    earth: &Earth,
    sphere: &Brick,
    winds_ft_s: &[(u8, [f64; 2]); 3],
) -> Result<CheckGroup, ModelError> {
    let turn = [-180.0f64, -90.0, 0.0, 90.0, 180.0].map(f64::to_radians);
    let area_m2 = sphere.area_ft2 * M_PER_FT * M_PER_FT * sphere.c_drag;
    let aero = BodyAero::new(area_m2, 1.0, &turn, &[1.0; 5], &[0.0; 5], &[0.0; 5])?;
    let aero = aero.with_side_area(area_m2)?;
    let mut checks = Vec::new();
    for (case, [at_0, at_30_000]) in winds_ft_s {
        let east = |speed_ft_s: f64| Vector3::new(0.0, speed_ft_s * M_PER_FT, 0.0);
        let wind = vec![(0.0, east(*at_0)), (ALTITUDE_FT * M_PER_FT, east(*at_30_000))];
        let wind = WindProfile::new(wind)?;
        let falling = Falling { earth: *earth, mass: sphere.mass()?, aero: aero.clone(), wind };
        let nasa = published(*case);
        let mut state = level(Vector3::zeros(), Vector3::zeros());
        let mut steps = 0u32;
        let mut ours = Vec::new();
        for row in &nasa {
            while f64::from(steps) * DT_S < row.t_s - 0.5 * DT_S {
                state = advance(&falling.mass, &state, DT_S, |x| falling.load(x));
                steps += 1;
            }
            ours.push(state);
        }
        let pairs = || ours.iter().zip(&nasa);
        let altitude = pairs().map(|(x, row)| (Falling::altitude_m(x) / M_PER_FT, row.altitude_ft));
        let down = pairs().map(|(x, row)| (x.v_ned.z / M_PER_FT, row.speed_down_ft_s));
        let sideways = pairs().map(|(x, row)| (x.v_ned.y / M_PER_FT, row.speed_east_ft_s));
        checks.extend([
            Check::worst(format!("case {case}: altitude"), "ft", altitude, 2e-4),
            Check::worst(format!("case {case}: vertical speed"), "ft/s", down, 5e-5),
            Check::worst(format!("case {case}: speed east"), "ft/s", sideways, 2e-6),
        ]);
    }
    Ok(CheckGroup {
        title: "NASA cases 6, 7, 8: falling sphere, still air, steady wind, wind shear",
        source: "NASA/TM-2015-218675, atmospheric cases 6, 7 and 8, simulation 4; worst of 0, 5, .. 30 s",
        checks,
    })
}
