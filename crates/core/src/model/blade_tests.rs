//! The lander's blades, for tests.

use std::sync::LazyLock;

use super::blade_element::{Airfoil, BladeStation, Blades};
use super::coefficient_table::CoefficientTable;

/// Profile of the blades of `titan_bemt.json`.
pub(crate) const PROFILE: Airfoil = Airfoil {
    lift_slope: 5.7,
    zero_lift_rad: 0.0,
    stall_lift: [-1.2, 1.2],
    drag_min: 0.01287,
    lift_at_drag_min: 0.0,
    drag_rise: 0.01,
    drag_across: 1.8,
};

/// Four blades without twist from a tenth of the radius on, solidity 0.1.
pub(crate) fn blades(pitch_rad: f64, tip_loss: f64) -> Blades {
    let station = |radius_share| BladeStation { radius_share, chord_share: 0.0872665, pitch_rad };
    Blades::new(0.65, 4, &[station(0.1), station(1.0)], PROFILE, tip_loss).unwrap()
}

/// The blades of `titan_bemt.json`.
pub(crate) fn lander() -> Blades {
    blades(0.180706, 0.97)
}

/// The table of blades that turn forwards.
pub(crate) fn table_of(blades: &Blades) -> CoefficientTable {
    let cells = CoefficientTable::grid().map(|place| {
        let cell = CoefficientTable::cell(blades, place);
        [cell.thrust, cell.in_plane, cell.torque]
    });
    CoefficientTable::new(blades.radius_m(), cells.collect()).unwrap()
}

/// The table of [`lander`], solved once for all tests.
pub(crate) static LANDER: LazyLock<CoefficientTable> = LazyLock::new(|| table_of(&lander()));
