//! The site of a flight: gravity, air and the anchor of the local frame on a flat, non-rotating Earth or
//! Titan. Gravity and air are constant over the flight, or follow the altitude ([`Atmosphere`]); the wind is
//! uniform.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::Vector3;

use super::{Atmosphere, ModelError};
use crate::math;
use crate::real::{Mask as _, Real};
use crate::units::{DEG_PER_RAD, EARTH_RADIUS_M, RAD_PER_DEG, STANDARD_GRAVITY_M_S2};
use crate::vector::V3;

/// The site: gravity, density, wind, and the place of the local NED frame's origin on the globe.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Gravity at the anchor's altitude, along +down [m/s^2].
    pub gravity_m_s2: f64,
    /// Density of the air at the anchor's altitude [kg/m^3].
    pub density_kg_m3: f64,
    /// How gravity and density change with altitude.
    pub atmosphere: Atmosphere,
    /// Velocity of the air over the ground, NED [m/s].
    pub wind_ned_m_s: Vector3<f64>,
    /// Latitude [deg], longitude [deg] and altitude above mean sea level [m] of the local origin: the point
    /// of release.
    pub anchor: GeoPoint,
}

/// Gravity, air and wind at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient<S = f64> {
    /// Gravity, along +down [m/s^2].
    pub gravity_m_s2: S,
    /// Density of the air [kg/m^3].
    pub density_kg_m3: S,
    /// Velocity of the air over the ground, NED [m/s].
    pub wind_ned_m_s: V3<S>,
}

/// Gravity and density of a site about an altitude, for what evaluates them in each stage of an integration:
/// a polynomial of third degree over 16 m, or less where the atmosphere's formulae change. It is a function
/// of the altitude alone, wherever it was before, within 4e-14 of [`Environment::at`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalAir<S = f64>(Option<AirPiece<S>>);

/// Gravity and density between two altitudes, as polynomials of the place between them, -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AirPiece<S> {
    /// Altitudes that the atmosphere is known for [m].
    known_m: [f64; 2],
    low_m: S,
    high_m: S,
    middle_m: S,
    per_half_m: S,
    gravity_m_s2: [S; 4],
    density_kg_m3: [S; 4],
}

/// Height of a piece of the atmosphere [m].
const PIECE_M: f64 = 16.0;

impl<S: Real> LocalAir<S> {
    /// The air about places that are `down_m` below the local origin of a site.
    pub fn about(site: &Environment, down_m: S) -> Self {
        let altitude_m = down_m.of(site.anchor.altitude_m) - down_m;
        let known_m = site.atmosphere.altitudes_m();
        Self(known_m.map(|known_m| AirPiece::about(site, known_m, altitude_m)))
    }

    /// Goes to the altitudes of places that are `down_m` below the local origin.
    #[inline(always)]
    pub fn follow(&mut self, site: &Environment, down_m: S) {
        if let Some(piece) = &mut self.0 {
            let altitude_m = piece.known(down_m.of(site.anchor.altitude_m) - down_m);
            let holds = piece.holds(altitude_m);
            if !holds.all() {
                *piece = piece.moved(site, altitude_m, !holds);
            }
        }
    }

    /// Gravity and air `down_m` below the local origin, in this wind, NED [m/s].
    #[inline(always)]
    pub fn at(&self, site: &Environment, wind_ned_m_s: V3<S>, down_m: S) -> Ambient<S> {
        let Some(piece) = &self.0 else {
            let [gravity_m_s2, density_kg_m3] = [site.gravity_m_s2, site.density_kg_m3];
            let kind = down_m;
            return Ambient {
                gravity_m_s2: kind.of(gravity_m_s2),
                density_kg_m3: kind.of(density_kg_m3),
                wind_ned_m_s,
            };
        };
        let altitude_m = piece.known(down_m.of(site.anchor.altitude_m) - down_m);
        let holds = piece.holds(altitude_m);
        if holds.all() {
            piece.at(altitude_m, wind_ned_m_s)
        } else {
            piece.moved(site, altitude_m, !holds).at(altitude_m, wind_ned_m_s)
        }
    }
}

impl<S: Real> AirPiece<S> {
    fn about(site: &Environment, known_m: [f64; 2], altitude_m: S) -> Self {
        let nothing = [altitude_m.of(0.0); 4];
        let [low_m, high_m, middle_m, per_half_m] = nothing;
        let (gravity_m_s2, density_kg_m3) = (nothing, nothing);
        let none = Self { known_m, low_m, high_m, middle_m, per_half_m, gravity_m_s2, density_kg_m3 };
        none.moved(site, none.known(altitude_m), !altitude_m.less(low_m) | altitude_m.less(low_m))
    }

    /// The pieces about these altitudes, which the atmosphere is known for, where the mask holds.
    #[cold]
    #[inline(never)]
    fn moved(&self, site: &Environment, altitude_m: S, mask: S::Mask) -> Self {
        let before = [
            [self.low_m, self.high_m, self.middle_m, self.per_half_m],
            self.gravity_m_s2,
            self.density_kg_m3,
        ];
        let [[low_m, high_m, middle_m, per_half_m], gravity_m_s2, density_kg_m3] =
            altitude_m.constants(mask, before, &mut |altitude_m| piece_about(site, altitude_m));
        Self { low_m, high_m, middle_m, per_half_m, gravity_m_s2, density_kg_m3, ..*self }
    }

    /// The altitude [m], or the nearest one that the atmosphere is known for.
    #[inline(always)]
    fn known(&self, altitude_m: S) -> S {
        let [lowest_m, highest_m] = self.known_m;
        altitude_m.at_least(altitude_m.of(lowest_m)).at_most(altitude_m.of(highest_m))
    }

    #[inline(always)]
    fn holds(&self, altitude_m: S) -> S::Mask {
        !altitude_m.less(self.low_m) & altitude_m.less(self.high_m)
    }

    #[inline(always)]
    fn at(&self, altitude_m: S, wind_ned_m_s: V3<S>) -> Ambient<S> {
        let x = (altitude_m - self.middle_m) * self.per_half_m;
        let [g0, g1, g2, g3] = self.gravity_m_s2;
        let [d0, d1, d2, d3] = self.density_kg_m3;
        Ambient {
            gravity_m_s2: g0 + x * (g1 + x * (g2 + x * g3)),
            density_kg_m3: d0 + x * (d1 + x * (d2 + x * d3)),
            wind_ned_m_s,
        }
    }
}

/// The piece about an altitude [m] that the atmosphere is known for: its ends and middle [m], one over half
/// its height [1/m], and the coefficients of gravity [m/s^2] and density [kg/m^3].
fn piece_about(site: &Environment, altitude_m: f64) -> [[f64; 4]; 3] {
    let mut low_m = (altitude_m / PIECE_M).floor() * PIECE_M;
    let mut high_m = low_m + PIECE_M;
    for knot_m in site.atmosphere.knots_m() {
        if knot_m <= altitude_m {
            low_m = low_m.max(knot_m);
        } else {
            high_m = high_m.min(knot_m);
        }
    }
    let (middle_m, half_m) = (0.5 * (low_m + high_m), 0.5 * (high_m - low_m));
    // Through Chebyshev's four points.
    let [a2, b2] = [0.5 * (1.0 + FRAC_1_SQRT_2), 0.5 * (1.0 - FRAC_1_SQRT_2)];
    let values = [a2.sqrt(), -a2.sqrt(), b2.sqrt(), -b2.sqrt()].map(|place| {
        let there = site.in_atmosphere(middle_m + half_m * place);
        there.unwrap_or([site.gravity_m_s2, site.density_kg_m3])
    });
    let polynomial = |k: usize| {
        let [far, near] = [[values[0][k], values[1][k]], [values[2][k], values[3][k]]];
        let even = |[above, below]: [f64; 2]| 0.5 * (above + below);
        let odd = |[above, below]: [f64; 2], place2: f64| 0.5 * (above - below) / place2.sqrt();
        let square = (even(far) - even(near)) / (a2 - b2);
        let cube = (odd(far, a2) - odd(near, b2)) / (a2 - b2);
        [even(near) - square * b2, odd(near, b2) - cube * b2, square, cube]
    };
    [[low_m, high_m, middle_m, 1.0 / half_m], polynomial(0), polynomial(1)]
}

/// A point on the globe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeoPoint {
    /// Latitude [deg].
    pub latitude_deg: f64,
    /// Longitude [deg].
    pub longitude_deg: f64,
    /// Altitude above mean sea level [m].
    pub altitude_m: f64,
}

impl GeoPoint {
    /// The point at `p_ned` [m] from this one: an equirectangular chart on a sphere of Earth's mean radius,
    /// good to millimetres over the kilometre of a drop. (Ground stations draw every site on Earth's map.)
    pub fn moved(&self, p_ned: &Vector3<f64>) -> Self {
        let cos_lat = math::cos(self.latitude_deg * RAD_PER_DEG);
        Self {
            latitude_deg: self.latitude_deg + p_ned.x / EARTH_RADIUS_M * DEG_PER_RAD,
            longitude_deg: self.longitude_deg + p_ned.y / (EARTH_RADIUS_M * cos_lat) * DEG_PER_RAD,
            altitude_m: self.altitude_m - p_ned.z,
        }
    }
}

/// Gravities [m/s^2] that differ by no more than this part are the same: files and missions round.
const SAME_GRAVITY: f64 = 1e-3;
/// Gravity on Earth differs from the standard's by less than this [m/s^2].
const EARTH_GRAVITY_SPREAD_M_S2: f64 = 0.05;

/// Whether two gravities [m/s^2] are the same, but for rounding.
pub fn same_gravity(a_m_s2: f64, b_m_s2: f64) -> bool {
    (a_m_s2 / b_m_s2 - 1.0).abs() < SAME_GRAVITY
}

impl Environment {
    /// Checks the numbers of a site: gravity [m/s^2], density [kg/m^3], wind NED [m/s] and the origin of the
    /// local frame.
    ///
    /// # Errors
    /// [`ModelError`] when gravity or density is not positive, or a number is out of range.
    pub fn new(
        gravity_m_s2: f64,
        density_kg_m3: f64,
        wind_ned_m_s: Vector3<f64>,
        anchor: GeoPoint,
    ) -> Result<Self, ModelError> {
        super::check_positive("gravity", gravity_m_s2)?;
        super::check_positive("density", density_kg_m3)?;
        let steady = wind_ned_m_s.iter().all(|w| w.is_finite());
        super::check(steady, "wind", "finite", wind_ned_m_s.norm())?;
        let latitude_deg = anchor.latitude_deg;
        let expected = "between -90 and 90 deg, poles excluded";
        super::check(latitude_deg.abs() < 90.0, "latitude", expected, latitude_deg)?;
        Ok(Self { gravity_m_s2, density_kg_m3, atmosphere: Atmosphere::Constant, wind_ned_m_s, anchor })
    }

    /// The site with the air and gravity of an atmosphere, those of its anchor's altitude from now on.
    ///
    /// # Errors
    /// [`ModelError`] when the atmosphere is not known at that altitude.
    pub fn within(self, atmosphere: Atmosphere) -> Result<Self, ModelError> {
        let (Some(air), Some([low, high])) =
            (atmosphere.at(self.anchor.altitude_m), atmosphere.altitudes_m())
        else {
            return Ok(Self { atmosphere, ..self });
        };
        let altitude_m = self.anchor.altitude_m;
        let expected = "where the atmosphere is known: us1976 from -5 to 86 km, titan from 0 to 10 km";
        super::check((low..=high).contains(&altitude_m), "altitude", expected, altitude_m)?;
        let (gravity_m_s2, density_kg_m3) = (air.gravity_m_s2, air.density_kg_m3);
        Ok(Self { gravity_m_s2, density_kg_m3, atmosphere, ..self })
    }

    /// The site with gravity and density as they are at its anchor's altitude, at every altitude.
    pub fn uniform(self) -> Self {
        Self { atmosphere: Atmosphere::Constant, ..self }
    }

    /// The site as it is at the altitude of `p_ned` [m], if that makes a difference: gravity and density in
    /// proportion to the atmosphere's at that altitude and at the anchor's.
    #[inline(always)]
    pub fn at(&self, p_ned: &Vector3<f64>) -> Option<Self> {
        if self.atmosphere == Atmosphere::Constant {
            return None;
        }
        let [gravity_m_s2, density_kg_m3] = self.in_atmosphere(self.anchor.altitude_m - p_ned.z)?;
        Some(Self { gravity_m_s2, density_kg_m3, ..self.clone() })
    }

    /// Gravity [m/s^2] and density [kg/m^3] at an altitude [m], where the atmosphere has them.
    fn in_atmosphere(&self, altitude_m: f64) -> Option<[f64; 2]> {
        let (here, there) = (self.atmosphere.at(self.anchor.altitude_m)?, self.atmosphere.at(altitude_m)?);
        Some([
            self.gravity_m_s2 * (there.gravity_m_s2 / here.gravity_m_s2),
            self.density_kg_m3 * (there.density_kg_m3 / here.density_kg_m3),
        ])
    }

    /// Gravity, air and wind at the anchor's altitude.
    #[inline(always)]
    pub fn ambient(&self) -> Ambient {
        let Self { gravity_m_s2, density_kg_m3, wind_ned_m_s, .. } = *self;
        Ambient { gravity_m_s2, density_kg_m3, wind_ned_m_s: wind_ned_m_s.into() }
    }

    /// Gravity, air and wind at `p_ned` [m].
    pub fn ambient_at(&self, p_ned: &Vector3<f64>) -> Ambient {
        self.at(p_ned).map_or(self.ambient(), |there| there.ambient())
    }

    /// Whether the gravity is one that occurs on Earth.
    pub fn has_earths_gravity(&self) -> bool {
        (self.gravity_m_s2 - STANDARD_GRAVITY_M_S2).abs() <= EARTH_GRAVITY_SPREAD_M_S2
    }

    /// Gravity as an acceleration in NED [m/s^2].
    pub fn gravity_ned(&self) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, self.gravity_m_s2)
    }

    /// Velocity over ground of what hangs in this air without power, NED [m/s]: the wind's horizontal part.
    /// (A rate of descent is given over ground, so a vertical wind is in it.)
    pub fn drift_ned_m_s(&self) -> Vector3<f64> {
        Vector3::new(self.wind_ned_m_s.x, self.wind_ned_m_s.y, 0.0)
    }

    /// The point of the globe at `p_ned` [m] from the anchor: [`GeoPoint::moved`].
    pub fn geo_point(&self, p_ned: &Vector3<f64>) -> GeoPoint {
        self.anchor.moved(p_ned)
    }

    /// The local position [m] of a point of the globe: the inverse of [`Environment::geo_point`].
    pub fn local_ned(&self, point: &GeoPoint) -> Vector3<f64> {
        let cos_lat = math::cos(self.anchor.latitude_deg * RAD_PER_DEG);
        Vector3::new(
            (point.latitude_deg - self.anchor.latitude_deg) * RAD_PER_DEG * EARTH_RADIUS_M,
            (point.longitude_deg - self.anchor.longitude_deg) * RAD_PER_DEG * EARTH_RADIUS_M * cos_lat,
            self.anchor.altitude_m - point.altitude_m,
        )
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The air of a piece is the atmosphere's, also beyond its ends, and does not depend on where the
        /// piece was before.
        #[test]
        fn prop_local_air_is_the_atmosphere_s(
            titan: bool, anchor_m in 0.0f64..9_000.0, down_m in -78_000.0f64..11_000.0,
            moved_m in -99.0f64..99.0,
        ) {
            let atmosphere = if titan { Atmosphere::Titan } else { Atmosphere::Us1976 };
            let anchor = GeoPoint { altitude_m: anchor_m, ..GeoPoint::default() };
            let site = Environment::new(9.8, 1.2, Vector3::zeros(), anchor).unwrap();
            let site = site.within(atmosphere).unwrap();
            let place = Vector3::new(0.0, 0.0, down_m);
            let calm = V3::zero(0.0);
            let found = LocalAir::about(&site, down_m).at(&site, calm, down_m);
            let wanted = site.at(&place).unwrap();
            for (found, wanted) in [
                (found.gravity_m_s2, wanted.gravity_m_s2), (found.density_kg_m3, wanted.density_kg_m3),
            ] {
                prop_assert!((found / wanted - 1.0).abs() < 4e-14, "{found} {wanted}");
            }
            let before = LocalAir::about(&site, down_m + moved_m);
            let mut following = before;
            following.follow(&site, down_m);
            prop_assert_eq!(before.at(&site, calm, down_m), found);
            prop_assert_eq!(following.at(&site, calm, down_m), found);
        }
    }
}
