//! A table of bad inputs: files, keys, values, flags, folders. Each is refused with exit code 2, nothing on
//! stdout but the mission's name, and a message that says where it is, what was expected and, of what is
//! misspelt, what was probably meant.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};

use super::{code, stderr};

fn samara_in(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).current_dir(folder).args(args).output().unwrap()
}

/// A change of a shipped file: the text that is replaced (once), what by, the path in the document where the
/// fault is reported, and words of the message. The line is the first one that the change touches, plus the
/// given number.
type Edit = (&'static str, &'static str, &'static str, isize, &'static str, &'static [&'static str]);

const MISSION: &str = "mission/x500_drop.json";
const LANDERS: &str = "mission/titan_paper.json";
const VEHICLE: &str = "params/vehicles/x500.json";
const BALLOON: &str = "mission/balloon_drop.json";
const HEXA: &str = "params/vehicles/hexa_4kg5.json";
const LANDER: &str = "params/vehicles/titan.json";
const TABLE: &str = "params/vehicles/titan_rotor.csv";
const GAINS: &str = "params/gains/x500.json";

const EDITS: &[Edit] = &[
    // Keys: misspelt, without unit, of another place, missing, twice.
    (
        MISSION,
        "\"hang_s\"",
        "\"hang_sec\"",
        0,
        "release.hang_sec: ",
        &["did you mean `hang_s`?", "expected one of"],
    ),
    (MISSION, "\"gravity_m_s2\"", "\"gravity\"", 0, "site.gravity: ", &["did you mean `gravity_m_s2`?"]),
    (
        MISSION,
        "\"density_kg_m3\"",
        "\"densty_kg_m3\"",
        0,
        "site.densty_kg_m3: ",
        &["did you mean `density_kg_m3`?"],
    ),
    (MISSION, "\"nodes\"", "\"node\"", 0, "plan.node: ", &["did you mean `nodes`?"]),
    (MISSION, "\"horizon_s\"", "\"horizon_ms\"", 0, "plan.horizon_ms: ", &["did you mean `horizon_s`?"]),
    (MISSION, "\"limits\"", "\"Limits\"", 0, "Limits: ", &["did you mean `limits`?"]),
    (MISSION, "\"seed\"", "\"sede\"", 0, "sede: ", &["did you mean `seed`?"]),
    (MISSION, "\"monte_carlo\"", "\"monte-carlo\"", 0, "monte-carlo: ", &["did you mean `monte_carlo`?"]),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"colour\": 2,",
        0,
        "colour: ",
        &["unknown field `colour`", "expected one of"],
    ),
    (MISSION, "\"seed\": 1,", "\"seed\": 1, \"seed\": 1,", 0, "seed: ", &["duplicate field `seed`"]),
    (MISSION, "  \"seed\": 1,\n", "", 0, "", &["missing field `seed`"]),
    (VEHICLE, "\"mass_kg\"", "\"mass\"", 0, "mass: ", &["did you mean `mass_kg`?"]),
    (
        VEHICLE,
        "\"inertia_kg_m2\"",
        "\"inertia_kgm2\"",
        0,
        "inertia_kgm2: ",
        &["did you mean `inertia_kg_m2`?"],
    ),
    (VEHICLE, "\"spin_from_above\"", "\"spin\"", 0, "rotors[0].spin: ", &["did you mean `spin_from_above`?"]),
    (VEHICLE, "\"tau_up_s\"", "\"tau_up\"", 0, "motor.first_order.tau_up: ", &["did you mean `tau_up_s`?"]),
    (HEXA, "\"blade_element\"", "\"blade_elemnt\"", -1, "rotor: ", &["did you mean `blade_element`?"]),
    (VEHICLE, "\"c_drag\"", "\"cdrag\"", 0, "body_aero.cdrag: ", &["did you mean `c_drag`?"]),
    (GAINS, "\"k_pr_per_s\"", "\"k_pr\"", 0, "k_pr: ", &["did you mean `k_pr_per_s`?"]),
    (GAINS, "\"k_iq_per_s2\"", "\"k_iq_per_s\"", 0, "k_iq_per_s: ", &["did you mean `k_iq_per_s2`?"]),
    // Wind.
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"gust\": [] },",
        0,
        "wind.gust: ",
        &["did you mean `gusts`?"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"gusts\": [{ \"shape\": \"ramp\", \"start_s\": 0, \"length_s\": 1, \"peak_ned_m_s\": [0, 0, 1] }] },",
        0,
        "wind.gusts[0].shape: ",
        &["unknown variant `ramp`", "rise"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"gusts\": [{ \"shape\": \"rise\", \"start_s\": 0, \"peak_ned_m_s\": [0, 0, 1] }] },",
        0,
        "wind.gusts[0]: ",
        &["expected one of `length_s` and `length_m`, found neither"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"gusts\": [{ \"shape\": \"rise\", \"start_s\": 0, \"length_s\": 1, \"length_m\": 1, \"peak_ned_m_s\": [0, 0, 1] }] },",
        0,
        "wind.gusts[0]: ",
        &["found both"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"by_altitude\": [{ \"altitude_m\": 9, \"wind_ned_m_s\": [0, 0, 0] }, { \"altitude_m\": 9, \"wind_ned_m_s\": [0, 0, 0] }] },",
        0,
        "wind.by_altitude[1].altitude_m: ",
        &["must increase, but 9 follows 9"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"turbulence\": { \"form\": \"karman\", \"sigma_m_s\": [1, 1, 1], \"scale_m\": [9, 9, 9] } },",
        0,
        "wind.turbulence.form: ",
        &["unknown variant `karman`", "dryden"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"turbulence\": { \"form\": \"dryden\", \"sigma_m_s\": [1, -1, 1], \"scale_m\": [9, 9, 9] } },",
        0,
        "wind.turbulence.sigma_m_s[1]: ",
        &["-1"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"turbulence\": { \"form\": \"dryden\", \"sigma_m_s\": [1, 1, 1], \"scale_m\": \"large\" } },",
        0,
        "wind.turbulence.scale_m: ",
        &["three positive lengths"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"wind\": { \"turbulence\": { \"form\": \"dryden\", \"sigma_m_s\": [1, 1, 1], \"scale_m\": \"low_altitude\" } },",
        0,
        "wind.turbulence.scale_m: ",
        &["without a site.ground_altitude_m"],
    ),
    // Battery.
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [{ \"charge_percent\": 0, \"voltage_v\": 14 }], \"internal_resistance_om\": 0.02 } },",
        0,
        "battery.electric.internal_resistance_om: ",
        &["did you mean `internal_resistance_ohm`?"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [], \"internal_resistance_ohm\": 0.02, \"esc_efficiency\": 0.95, \"motor\": { \"efficiency\": 0.8, \"nominal_v\": 14.8, \"throttle\": \"speed\" } } },",
        0,
        "battery.electric.open_circuit: ",
        &["expected at least one entry, found none"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [{ \"charge_percent\": 0, \"voltage_v\": 14 }, { \"charge_percent\": 0, \"voltage_v\": 14 }], \"internal_resistance_ohm\": 0.02, \"esc_efficiency\": 0.95, \"motor\": { \"efficiency\": 0.8, \"nominal_v\": 14.8, \"throttle\": \"speed\" } } },",
        0,
        "battery.electric.open_circuit[1].charge_percent: ",
        &["the charges must increase, but 0 follows 0"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [{ \"charge_percent\": 0, \"voltage_v\": 14 }, { \"charge_percent\": 50, \"voltage_v\": 13 }], \"internal_resistance_ohm\": 0.02, \"esc_efficiency\": 0.95, \"motor\": { \"efficiency\": 0.8, \"nominal_v\": 14.8, \"throttle\": \"speed\" } } },",
        0,
        "battery.electric.open_circuit[1].voltage_v: ",
        &["must not fall", "13 V follows 14 V"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [{ \"charge_percent\": 0, \"voltage_v\": 14 }], \"internal_resistance_ohm\": 0.02, \"esc_efficiency\": 0.95 } },",
        0,
        "battery.electric: ",
        &["missing field `motor`", "first_order"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [{ \"charge_percent\": 0, \"voltage_v\": 14 }], \"internal_resistance_ohm\": 0.02, \"esc_efficiency\": 1.5, \"motor\": { \"efficiency\": 0.8, \"nominal_v\": 14.8, \"throttle\": \"speed\" } } },",
        0,
        "battery.electric.esc_efficiency: ",
        &["greater than 0 and at most 1"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [{ \"charge_percent\": 0, \"voltage_v\": 14 }], \"internal_resistance_ohm\": -1, \"esc_efficiency\": 0.9, \"motor\": { \"efficiency\": 0.8, \"nominal_v\": 14.8, \"throttle\": \"speed\" } } },",
        0,
        "battery.electric.internal_resistance_ohm: ",
        &["from 0 to 1000"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [{ \"charge_percent\": 0, \"voltage_v\": 14 }], \"internal_resistance_ohm\": 0, \"esc_efficiency\": 0.9, \"motor\": { \"efficiency\": 0.8, \"nominal_v\": 14.8, \"throttle\": \"duty\" } } },",
        0,
        "battery.electric.motor.throttle: ",
        &["did you mean `duty_cycle`?"],
    ),
    (
        LANDERS,
        "\"seed\": 1,",
        "\"seed\": 1, \"battery\": { \"capacity_wh\": 74, \"charge_percent\": 100, \"electric\": { \"open_circuit\": [{ \"charge_percent\": 0, \"voltage_v\": 14 }], \"internal_resistance_ohm\": 0.02, \"esc_efficiency\": 0.95, \"motor\": { \"efficiency\": 0.8, \"nominal_v\": 14.8, \"throttle\": \"speed\" } } },",
        0,
        "battery.electric.motor: ",
        &["expected nothing", "esc_dc"],
    ),
    // Faults.
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"lists\": [] },",
        0,
        "faults.lists: ",
        &["did you mean `list`?"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": { \"motor_of\": { \"rotor\": 1 } }, \"at_s\": 1 }] },",
        0,
        "faults.list[0].fault: ",
        &["did you mean `motor_off`?"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": { \"motor_off\": { \"rotor\": 5 } }, \"at_s\": 1 }] },",
        0,
        "faults.list[0].fault: ",
        &["expected a rotor from 1 to 4", "found 5"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": { \"motor_slow\": { \"rotor\": 1, \"lag_s\": 0 } }, \"at_s\": 1 }] },",
        0,
        "faults.list[0].fault.motor_slow.lag_s: ",
        &["greater than 0"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": { \"gyro_drift\": { \"rate\": [0, 0, 0] } }, \"at_s\": 1 }] },",
        0,
        "faults.list[0].fault.gyro_drift.rate: ",
        &["rate_rad_s2"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": { \"gyro_wrong\": {} }, \"at_s\": 1 }] },",
        0,
        "faults.list[0].fault: ",
        &["expected an offset, a scale or both, found neither"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": \"gyro_off\", \"at_s\": 14.5 }] },",
        0,
        "faults.list[0].at_s: ",
        &["expected less than 14.5 s", "found 14.5 s"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": \"gyro_off\", \"at_s\": 2, \"until_s\": 2 }] },",
        0,
        "faults.list[0].until_s: ",
        &["expected more than 2 s", "found 2 s"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": \"gyro_off\", \"at_s\": -99, \"until_s\": -20 }] },",
        0,
        "faults.list[0].until_s: ",
        &["expected more than -15.5 s"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": \"gyro_off\" }] },",
        0,
        "faults.list[0]: ",
        &["missing field `at_s`"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"faults\": { \"list\": [{ \"fault\": { \"riser_hung_up\": { \"attachment_body_m\": [0.2, 0, 0] } }, \"at_s\": -1 }] },",
        0,
        "faults.list[0].fault: ",
        &["expected a parachute.canopy that pulls with riser_hung_up"],
    ),
    // Canopy and riser.
    (
        MISSION,
        "\"parachute\": {",
        "\"parachute\": { \"canopy\": { \"mass_kg\": 0.1, \"drag_area_m2\": 1.3, \"apparent_mass_factor\": 1 }, ",
        0,
        "parachute.canopy: ",
        &["expected a riser (parachute.riser)"],
    ),
    (
        MISSION,
        "\"parachute\": {",
        "\"parachute\": { \"riser\": { \"length_m\": 3, \"stiffness_n_m\": 1000, \"damping_n_s_m\": 5, \"attachment_body_m\": [0, 0, -0.2] },",
        0,
        "parachute.riser: ",
        &["expected a canopy (parachute.canopy)"],
    ),
    (
        MISSION,
        "\"parachute\": {",
        "\"parachute\": { \"canopy\": { \"mass_kg\": 0.1, \"drag_area_m2\": -1, \"apparent_mass_factor\": 1 }, \"riser\": { \"length_m\": 3, \"stiffness_n_m\": 1000, \"damping_n_s_m\": 5, \"attachment_body_m\": [0, 0, -0.2] },",
        0,
        "parachute.canopy.drag_area_m2: ",
        &["-1"],
    ),
    (
        MISSION,
        "\"parachute\": {",
        "\"parachute\": { \"canopy\": { \"mass_kg\": 0.1, \"drag_area_m2\": 1.3, \"apparent_mass_factor\": 1, \"opening_descent_m_s\": 9 }, \"riser\": { \"length_m\": 3, \"stiffness_n_m\": 1000, \"damping_n_s_m\": 5, \"attachment_body_m\": [0, 0, -0.2] },",
        0,
        "parachute.canopy.opening_descent_m_s: ",
        &["expected an opening_s"],
    ),
    (
        MISSION,
        "\"parachute\": {",
        "\"parachute\": { \"canopy\": { \"mass_kg\": 0.1, \"drag_area_m2\": 1.3, \"apparent_mass_factor\": 1 }, \"riser\": { \"length_m\": 3, \"stiffness_n_m\": 1000, \"damping_n_s_m\": 5, \"attachment_body_m\": [0, 0, 0.2] },",
        0,
        "parachute.riser.attachment_body_m: ",
        &["above the centre of mass"],
    ),
    (
        MISSION,
        "\"parachute\": {",
        "\"parachute\": { \"canopy\": { \"mass_kg\": 0.1, \"drag_area_m2\": 1.3, \"apparent_mass_factor\": 1 }, \"riser\": { \"length_m\": 3, \"stiffness_n_m\": 1e9, \"damping_n_s_m\": 5, \"attachment_body_m\": [0, 0, -0.2] },",
        0,
        "parachute.riser.stiffness_n_m: ",
        &["no more than 5000 1/s"],
    ),
    (
        MISSION,
        "\"parachute\": {",
        "\"parachute\": { \"canopy\": { \"mass_kg\": 0.1, \"drag_area_m2\": 0.0001, \"apparent_mass_factor\": 1 }, \"riser\": { \"length_m\": 3, \"stiffness_n_m\": 1000, \"damping_n_s_m\": 5, \"attachment_body_m\": [0, 0, -0.2] },",
        0,
        "parachute.canopy.drag_area_m2: ",
        &["must fall faster than its canopy"],
    ),
    (
        MISSION,
        "\"parachute\": {",
        "\"parachute\": { \"canopy\": { \"mass_kg\": 0.1, \"drag_area_m2\": 1.3, \"apparent_mass_factor\": 1, \"opening_s\": 1 }, \"riser\": { \"length_m\": 3, \"stiffness_n_m\": 1000, \"damping_n_s_m\": 5, \"attachment_body_m\": [0, 0, -0.2] },",
        6,
        "release.hook_s: ",
        &["expected none with a canopy that opens"],
    ),
    (
        MISSION,
        "\"hook_s\": 8,",
        "\"tip_off\": { \"rate_deg_s\": [0, 9, 0] },",
        0,
        "release.tip_off.rate_deg_s: ",
        &["unknown field `rate_deg_s`", "`rate_body_deg_s`"],
    ),
    (
        MISSION,
        "\"monte_carlo\": {",
        "\"monte_carlo\": { \"tip_off\": { \"rate_sigma_deg_s\": [0, -9, 0] },",
        0,
        "monte_carlo.tip_off.rate_sigma_deg_s[1]: ",
        &["-9"],
    ),
    // Choices.
    (
        MISSION,
        "\"trigger\": \"command\"",
        "\"trigger\": \"comand\"",
        0,
        "release.trigger: ",
        &["did you mean `command`?"],
    ),
    (
        MISSION,
        "\"initial\": \"release\"",
        "\"initial\": \"realease\"",
        0,
        "plan.initial: ",
        &["did you mean `release`?"],
    ),
    (
        MISSION,
        "\"start\": \"release\"",
        "\"start\": \"air\"",
        0,
        "release.start: ",
        &["expected one of `release`, `t0`, `ground`"],
    ),
    (
        VEHICLE,
        "\"spin_from_above\": \"ccw\"",
        "\"spin_from_above\": \"CW\"",
        0,
        "rotors[0].spin_from_above: ",
        &["did you mean `cw`?"],
    ),
    (
        MISSION,
        "\"field\": \"world_magnetic_model\"",
        "\"field\": \"wmm\"",
        0,
        "sensors.magnetometer.field: ",
        &["expected `dipole` or"],
    ),
    // Kinds of values.
    (
        MISSION,
        "\"seed\": 1",
        "\"seed\": \"1\"",
        0,
        "seed: ",
        &["invalid type: string \"1\"", "a whole number from 0"],
    ),
    (MISSION, "\"seed\": 1", "\"seed\": 1.5", 0, "seed: ", &["a whole number from 0"]),
    (MISSION, "\"seed\": 1", "\"seed\": -1", 0, "seed: ", &["a whole number from 0"]),
    (MISSION, "\"seed\": 1", "\"seed\": null", 0, "seed: ", &["invalid type: null", "a whole number"]),
    (MISSION, "\"seed\": 1", "\"seed\": true", 0, "seed: ", &["invalid type: boolean", "a whole number"]),
    (MISSION, "\"nodes\": 38", "\"nodes\": [38]", 0, "plan.nodes: ", &["a whole number from 3 to 10000"]),
    (MISSION, "\"horizon_s\": 5.0", "\"horizon_s\": {}", 0, "plan.horizon_s: ", &["a time greater than 0"]),
    (MISSION, "[2, 0, 1]", "[2, 0]", 0, "target_v_ned_m_s: ", &["a list of exactly 3 entries"]),
    (MISSION, "[2, 0, 1]", "[2, 0, 1, 0]", 0, "target_v_ned_m_s: ", &["a list of exactly 3 entries"]),
    (MISSION, "[2, 0, 1]", "\"2 0 1\"", 0, "target_v_ned_m_s: ", &["a list of exactly 3 entries"]),
    (
        VEHICLE,
        "\"reaction_torque\": true",
        "\"reaction_torque\": 1",
        0,
        "effects.reaction_torque: ",
        &["a boolean"],
    ),
    (VEHICLE, "\"name\": \"x500\"", "\"name\": 500", 0, "name: ", &["1 to 64 letters"]),
    (MISSION, "\"name\": \"x500_drop\"", "\"name\": \"../x500\"", 0, "name: ", &["1 to 64 letters, digits"]),
    (MISSION, "\"name\": \"x500_drop\"", "\"name\": \"\"", 0, "name: ", &["1 to 64 letters, digits"]),
    // Numbers that are none, or out of their range.
    (
        MISSION,
        "\"gravity_m_s2\": 9.80665",
        "\"gravity_m_s2\": NaN",
        0,
        "site.gravity_m_s2: ",
        &["NaN and infinity are not numbers here"],
    ),
    (
        MISSION,
        "\"gravity_m_s2\": 9.80665",
        "\"gravity_m_s2\": Infinity",
        0,
        "site.gravity_m_s2: ",
        &["NaN and infinity are not numbers"],
    ),
    (
        MISSION,
        "\"gravity_m_s2\": 9.80665",
        "\"gravity_m_s2\": -Infinity",
        0,
        "site.gravity_m_s2: ",
        &["NaN and infinity are not"],
    ),
    (
        MISSION,
        "\"gravity_m_s2\": 9.80665",
        "\"gravity_m_s2\": 1e400",
        0,
        "site.gravity_m_s2: ",
        &["number out of range", "a finite number"],
    ),
    (
        MISSION,
        "\"gravity_m_s2\": 9.80665",
        "\"gravity_m_s2\": 0",
        0,
        "site.gravity_m_s2: ",
        &["greater than 0 and at most 100"],
    ),
    (
        MISSION,
        "\"density_kg_m3\": 1.225",
        "\"density_kg_m3\": -1.2",
        0,
        "site.density_kg_m3: ",
        &["greater than 0 and at most 1000"],
    ),
    (
        MISSION,
        "\"latitude_deg\": 47.397742",
        "\"latitude_deg\": 95",
        0,
        "site.latitude_deg: ",
        &["between -90 and 90 deg"],
    ),
    (
        MISSION,
        "\"longitude_deg\": 8.545594",
        "\"longitude_deg\": 200",
        0,
        "site.longitude_deg: ",
        &["from -180 to 180 deg"],
    ),
    (MISSION, "\"nodes\": 38", "\"nodes\": 2", 0, "plan.nodes: ", &["from 3 to 10000"]),
    (MISSION, "\"nodes\": 38", "\"nodes\": 100000", 0, "plan.nodes: ", &["from 3 to 10000"]),
    (MISSION, "\"duration_s\": 30", "\"duration_s\": 1e6", 0, "duration_s: ", &["at most 900 s"]),
    (
        MISSION,
        "\"tilt_limit_deg\": 20",
        "\"tilt_limit_deg\": 90",
        0,
        "control.tilt_limit_deg: ",
        &["between 0 and 90 deg"],
    ),
    (MISSION, "\"pitch_deg\": 45.0", "\"pitch_deg\": 0", 0, "limits.pitch_deg: ", &["greater than 0"]),
    (MISSION, "\"trials\": 100", "\"trials\": 1", 0, "monte_carlo.trials: ", &["from 2 to"]),
    (MISSION, "\"rate_hz\": 10,", "\"rate_hz\": 100,", 0, "sensors.gps.rate_hz: ", &["from 5 to 20"]),
    (VEHICLE, "\"mass_kg\": 2.064", "\"mass_kg\": 0", 0, "mass_kg: ", &["greater than 0"]),
    (VEHICLE, "\"mass_kg\": 2.064", "\"mass_kg\": 1e9", 0, "mass_kg: ", &["at most 100000"]),
    (
        VEHICLE,
        "\"tau_up_s\": 0.0125",
        "\"tau_up_s\": 0",
        0,
        "motor.first_order.tau_up_s: ",
        &["a time from 0.0005 to 100 s"],
    ),
    (
        VEHICLE,
        "\"omega_max_rad_s\": 714.3286",
        "\"omega_max_rad_s\": 0",
        0,
        "motor.first_order.omega_max_rad_s: ",
        &["greater than 0"],
    ),
    (GAINS, "\"k_pr_per_s\": 1.0", "\"k_pr_per_s\": -1.0", 0, "k_pr_per_s: ", &["from 0 to 1000000"]),
    // Numbers that do not fit each other.
    (MISSION, "\"duration_s\": 30", "\"duration_s\": 15", 0, "duration_s: ", &["expected more than 15.5 s"]),
    (MISSION, "\"hook_s\": 8", "\"hook_s\": 20", 0, "release.hook_s: ", &["expected less than 15 s"]),
    (
        MISSION,
        "\"hook_s\": 8,",
        "\"hook_s\": 8, \"free_fall\": { \"time_s\": 0.5 },",
        0,
        "release.free_fall.time_s: ",
        &["expected less than 0.5 s, the fall (parachute.delay_s)", "found 0.5 s"],
    ),
    (
        MISSION,
        "\"hook_s\": 8,",
        "\"hook_s\": 8, \"free_fall\": { \"level_share\": 0.05 },",
        0,
        "release.free_fall.level_share: ",
        &["share of gravity that the air carries right after the release", "found 0.05"],
    ),
    (
        MISSION,
        "\"hook_s\": 8,",
        "\"hook_s\": 8, \"free_fall\": { \"level_share\": 2 },",
        0,
        "release.free_fall.level_share: ",
        &["expected a number greater than 0 and at most 1"],
    ),
    (
        MISSION,
        "\"hook_s\": 8,",
        "\"hook_s\": 8, \"free_fall\": { \"level\": 0.3 },",
        0,
        "release.free_fall.level: ",
        &["did you mean `level_share`?"],
    ),
    (
        MISSION,
        "\"name\": \"case_3\"",
        "\"name\": \"case_2\"",
        0,
        "tuning.cases[3].name: ",
        &["expected a name of its own"],
    ),
    (
        MISSION,
        "\"cost_input_reference\": \"trim\"",
        "\"cost_input_reference\": \"trim\", \"terminal_tolerance_m_s\": 1e-9",
        0,
        "plan.terminal_tolerance_m_s: ",
        &["at least 1e-7 m/s"],
    ),
    (
        MISSION,
        "\"trigger\": \"command\"",
        "\"trigger\": { \"altitude\": { \"altitude_m\": 5000 } }",
        0,
        "release.trigger.altitude.altitude_m: ",
        &["expected less than"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"px4_clock\": \"fast\",",
        0,
        "px4_clock: ",
        &["expected `real` or `froude`"],
    ),
    (VEHICLE, "0.043875328]", "0.1]", 0, "inertia_kg_m2: ", &["triangle inequality"]),
    (
        VEHICLE,
        "\"axis_body\": [0, 0, -1]",
        "\"axis_body\": [0, 0, -0.5]",
        0,
        "rotors[0].axis_body: ",
        &["a vector of length 1, found length 0.5"],
    ),
    (
        VEHICLE,
        "\"axis_body\": [0, 0, -1]",
        "\"axis_body\": [0, 0, 0]",
        0,
        "rotors[0].axis_body: ",
        &["a vector of length 1"],
    ),
    (
        VEHICLE,
        "-180.0, -170.0, -160.0",
        "-180.0, -170.0, -175.0",
        0,
        "body_aero.alpha_deg[2]: ",
        &["the angles must increase"],
    ),
    (
        VEHICLE,
        "\"reference_area_m2\": 0.1,",
        "\"drag_area_m2\": 0.1, \"reference_area_m2\": 0.1,",
        0,
        "body_aero.drag_area_m2: ",
        &["`drag_area_m2` alone"],
    ),
    (
        VEHICLE,
        "    \"reference_span_m\": 0.4,\n",
        "",
        0,
        "body_aero: ",
        &["missing field `reference_span_m`"],
    ),
    (
        LANDER,
        "\"current_min_a\": 0",
        "\"current_min_a\": 1000",
        0,
        "motor.esc_dc.current_min_a: ",
        &["expected at most current_max_a"],
    ),
    // The vortex ring.
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"vortex_ring\": { \"thrust_rms_share\": 20, \"frequency_hz\": 5 },",
        0,
        "vortex_ring.thrust_rms_share: ",
        &["greater than 0 and at most 1"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"vortex_ring\": { \"thrust_rms_share\": 0.2, \"frequency_hz\": 0 },",
        0,
        "vortex_ring.frequency_hz: ",
        &["greater than 0 and at most 1000"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"vortex_ring\": { \"thrust_rms_share\": 0.2 },",
        0,
        "vortex_ring: ",
        &["missing field `frequency_hz`"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"vortex_ring\": { \"thrust_rms\": 0.2, \"frequency_hz\": 5 },",
        0,
        "vortex_ring.thrust_rms: ",
        &["did you mean `thrust_rms_share`?"],
    ),
    (
        LANDERS,
        "\"seed\": 1,",
        "\"seed\": 1, \"vortex_ring\": { \"thrust_rms_share\": 0.2, \"frequency_hz\": 5 },",
        0,
        "vortex_ring: ",
        &["expected a vehicle whose blades are known (rotor.blade_element)"],
    ),
    // What a plan is asked for.
    (
        MISSION,
        "\"cost_input_reference\"",
        "\"peak\": { \"weight\": 0 }, \"cost_input_reference\"",
        0,
        "plan.peak.weight: ",
        &["greater than 0"],
    ),
    (
        MISSION,
        "\"cost_input_reference\"",
        "\"motion\": { \"pitch\": 20 }, \"cost_input_reference\"",
        0,
        "plan.motion.pitch: ",
        &["did you mean `pitch_deg`?"],
    ),
    (
        MISSION,
        "\"cost_input_reference\"",
        "\"motion\": { \"v_down_m_s\": [3, 1] }, \"cost_input_reference\"",
        0,
        "plan.motion.v_down_m_s: ",
        &["expected [least, greatest]", "found [3, 1]"],
    ),
    (
        MISSION,
        "\"cost_input_reference\"",
        "\"free_horizon\": { \"least_s\": 20, \"greatest_s\": 30 }, \"cost_input_reference\"",
        0,
        "plan.free_horizon: ",
        &["expected least_s < horizon_s < greatest_s"],
    ),
    (
        LANDERS,
        "\"cost_input_reference\"",
        "\"avoid_vortex_ring\": {}, \"cost_input_reference\"",
        0,
        "plan.avoid_vortex_ring: ",
        &["expected only for a vehicle with known blades"],
    ),
    // Renewed plans.
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"replan\": { \"latency\": 0.02 },",
        0,
        "replan.latency: ",
        &["did you mean `latency_s`?"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"replan\": { \"latency_s\": 0 },",
        0,
        "replan.latency_s: ",
        &["a time greater than 0"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"replan\": { \"iterations\": 0 },",
        0,
        "replan.iterations: ",
        &["a whole number from 1 to 1000"],
    ),
    (
        MISSION,
        "\"seed\": 1,",
        "\"seed\": 1, \"replan\": { \"until_s\": -1 },",
        0,
        "replan.until_s: ",
        &["a time greater than 0"],
    ),
    // The design.
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"drawn\": 20 },",
        0,
        "design.drawn: ",
        &["did you mean `draws`?"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"draws\": 0 },",
        0,
        "design.draws: ",
        &["a whole number from 1 to 100000"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"quantile\": 0.2 },",
        0,
        "design.quantile: ",
        &["expected 0.5 to 1, found 0.2"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"objective\": \"worst\", \"quantile\": 0.9 },",
        0,
        "design.quantile: ",
        &["expected no quantile with the objective"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"turbulence\": { \"sigma_m_s\": -1, \"scale_m\": 100 } },",
        0,
        "design.turbulence.sigma_m_s: ",
        &["a number from 0 to 100"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"bounds\": { \"tilt_deg\": 0 } },",
        0,
        "design.bounds.tilt_deg: ",
        &["greater than 0 and at most 180"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"search\": { \"vertical_weight\": [10, 1] } },",
        0,
        "design.search.vertical_weight: ",
        &["expected the least number first, found 10 before 1"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"search\": { \"nodes\": [] } },",
        0,
        "design.search.nodes: ",
        &["expected at least one, found none"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"search\": { \"feed_forward\": [] } },",
        0,
        "design.search.feed_forward: ",
        &["expected at least one, found none"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"search\": { \"pitch_deg\": [null, 0] } },",
        0,
        "design.search.pitch_deg[1]: ",
        &["expected a number greater than 0"],
    ),
    (
        BALLOON,
        "\"seed\": 1,",
        "\"seed\": 1, \"design\": { \"search\": { \"input_references\": [\"trimmed\"] } },",
        0,
        "design.search.input_references[0]: ",
        &["unknown variant `trimmed`", "expected `zero` or `trim`"],
    ),
    // Two models where one belongs; JSON that is none.
    (
        HEXA,
        "\"rotor\": {\n    \"blade_element\": {",
        "\"rotor\": {\n    \"table\": { \"file\": \"a\", \"density_kg_m3\": 1 },\n    \"blade_element\": {",
        0,
        "rotor: ",
        &["expected a single one of the alternatives"],
    ),
    (
        VEHICLE,
        "\"motor\": {\n",
        "\"motor\": { \"ideal\": 1,\n",
        0,
        "motor",
        &["expected `esc_dc` or `first_order`"],
    ),
    (MISSION, "\"seed\": 1,", "\"seed\": 1, // the first\n", 0, "", &["JSON has no comments"]),
    (MISSION, "\"seed\": 1,", "\"seed\": 1, # the first\n", 0, "", &["JSON has no comments"]),
    (MISSION, "\"seed\": 1,", "'seed': 1,", 0, "", &["double quotes"]),
    (MISSION, "\"seed\": 1,", "seed: 1,", 0, "", &["double quotes"]),
    (
        MISSION,
        "\"length_m\": 1.0,\n    \"wind_sigma_m_s\": 1.5\n",
        "\"length_m\": 1.0,\n",
        0,
        "monte_carlo: ",
        &["trailing comma"],
    ),
    (MISSION, "\"seed\": 1,", "\"seed\": 1", 1, "", &["expected `,` or `}`"]),
    (MISSION, "\"seed\": 1,", "\"seed\": 01,", 0, "seed: ", &["invalid number"]),
    (MISSION, "\"seed\": 1,", "\"seed\": .5,", 0, "seed: ", &["expected value"]),
    (MISSION, "\"name\": \"x500_drop\"", "\"name\": \"x500_drop", 1, "name: ", &["control character"]),
    (MISSION, "\"seed\": 1,", "\"seed\" = 1,", 0, "", &["expected `:`"]),
    (GAINS, "\"k_pr_per_s\": 1.0", "\"k_pr_per_s\": 1,0", 0, "", &["double quotes"]),
    // The rotors' start.
    (
        LANDER,
        "  \"motor\": {",
        "  \"rotor_start\": { \"before\": \"free\", \"friction_nm\": 0 },\n  \"motor\": {",
        0,
        "rotor_start: ",
        &["expected a rotor of `blade_element`"],
    ),
    (
        VEHICLE,
        "  \"motor\": {",
        "  \"rotor_start\": { \"before\": \"fre\", \"friction_nm\": 0 },\n  \"motor\": {",
        0,
        "rotor_start.before: ",
        &["did you mean `free`?"],
    ),
    (
        VEHICLE,
        "  \"motor\": {",
        "  \"rotor_start\": { \"before\": \"free\", \"friction_nm\": -1 },\n  \"motor\": {",
        0,
        "rotor_start.friction_nm: ",
        &["expected a number from 0"],
    ),
    (
        VEHICLE,
        "  \"motor\": {",
        "  \"rotor_start\": { \"before\": \"free\", \"friction_nm\": 0, \"esc\": { \"tries\": 0 } },\n  \"motor\": {",
        0,
        "rotor_start.esc.tries: ",
        &["a whole number from 1 to 10000"],
    ),
    (
        VEHICLE,
        "  \"motor\": {",
        "  \"rotor_start\": { \"before\": \"free\", \"friction_nm\": 0, \"esc\": { \"try_s\": 0 } },\n  \"motor\": {",
        0,
        "rotor_start.esc.try_s: ",
        &["a time greater than 0"],
    ),
    // The rotor table.
    (TABLE, "omega_rad_s,", "omega_rpm,", 0, "", &["expected the header `omega_rad_s,"]),
    (
        TABLE,
        "0.0,0.0,-165.0,0.0,0.0",
        "0.0;0.0;-165.0;0.0;0.0",
        0,
        "",
        &["expected 5 numbers separated by commas"],
    ),
    (TABLE, "0.0,0.0,-165.0,0.0,0.0", "0.0,0.0,-165.0,x,0.0", 0, "", &["thrust_n: expected a finite"]),
    (TABLE, "0.0,0.0,-165.0,0.0,0.0\n", "", 24, "", &["the grid must be full"]),
];

/// The mission that is checked for a fault in a file.
fn mission_of(file: &str) -> &'static str {
    match file {
        LANDER | LANDERS | TABLE => "titan_paper",
        BALLOON | HEXA => "balloon_drop",
        _ => "x500_drop",
    }
}

#[test]
fn faults_in_files_are_told_with_file_line_and_path() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(code(&samara_in(folder.path(), &["init", "."])), 0);
    // A mission that has none of the sections that faults are put into.
    let calm = fs::read_to_string("tests/calm_x500.json").unwrap().replace("x500_calm", "x500_drop");
    fs::write(folder.path().join(MISSION), calm).unwrap();
    let mut faults = Vec::new();
    for (file, from, to, lines, path, words) in EDITS {
        let place = folder.path().join(file);
        let text = fs::read_to_string(&place).unwrap();
        let at = text.find(from).unwrap_or_else(|| panic!("{file} has no {from}"));
        fs::write(&place, text.replacen(from, to, 1)).unwrap();
        let output = samara_in(folder.path(), &["check", mission_of(file)]);
        let said = stderr(&output);
        // The first character that differs.
        let same = from.bytes().zip(to.bytes()).take_while(|(a, b)| a == b).count();
        let line = text[..at + same].matches('\n').count().saturating_add_signed(1 + lines);
        let name = file.rsplit('/').next().unwrap();
        let wanted = format!("{name}:{line}:");
        let place_and_path = said.split_once(&wanted).and_then(|(_, rest)| rest.split_once(": "));
        let path_is_right = place_and_path.is_some_and(|(_, rest)| rest.starts_with(path));
        // A missing key is reported where its object begins.
        let missing = said.contains("missing field");
        let right = code(&output) == 2
            && said.starts_with("samara: ")
            && said.lines().count() == 1
            && !said.contains("?: ")
            && (path_is_right || missing && said.contains(name))
            && words.iter().all(|word| said.contains(word));
        if !right {
            faults.push(format!("{file}, {from:?} -> {to:?}: wanted {wanted}..: {path}{words:?}\n  {said}"));
        }
        fs::write(&place, text).unwrap();
    }
    assert!(EDITS.len() > 85, "{}", EDITS.len());
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), EDITS.len(), faults.join("\n"));
}

/// Command lines, and what the message says.
const LINES: &[(&str, &[&str])] = &[
    // Names and paths.
    ("drop titan_dorp", &["no mission file of the name `titan_dorp`", "did you mean `titan_drop`?"]),
    ("plan X500-drop", &["did you mean `x500_drop`?"]),
    ("check nothing_like_it", &["expected one of ", "titan_drop, titan_no_wire"]),
    (
        "drop here/x500_drop.json",
        &["cannot read mission file here/x500_drop.json", "the built-in mission of that name is `x500_drop`"],
    ),
    ("drop params", &["there is a ./params here"]),
    ("drop empty", &["there is a ./empty.json here"]),
    ("drop mission/", &["cannot read mission file", "directory"]),
    ("drop params/vehicles/x500.json", &["x500.json:5:3: mass_kg: unknown field `mass_kg`"]),
    ("drop params/gains/x500.json", &["x500.json:5:3: k_pq_per_s: unknown field"]),
    ("plan empty.json", &["empty.json:1:1: the file is empty; a JSON object is expected"]),
    ("plan cut.json", &["cut.json:", "EOF while parsing"]),
    ("plan list.json", &["list.json:1:1: invalid type: a list, expected an object"]),
    ("plan twice.json", &["twice.json:", "text after the end"]),
    ("plan latin1.json", &["latin1.json", "is not UTF-8"]),
    ("plan text.json", &["text.json:1:1: expected value"]),
    ("drop --gains near-hover", &["did you mean `near_hover`?"]),
    (
        "drop --gains nobody",
        &["no gains file of the name `nobody`", "expected one of ", "ideal_rms, near_hover"],
    ),
    ("drop --gains mission/x500_drop.json", &["unknown field `vehicle`"]),
    ("drop --gains none.json", &["cannot read gains file none.json"]),
    ("drop --params none.params", &["cannot read parameter file none.params"]),
    ("drop --trajectory none.csv", &["cannot read trajectory file none.csv"]),
    ("drop --trajectory params/vehicles/titan_rotor.csv", &["titan_rotor.csv:"]),
    ("drop --case case_9", &["no release case `case_9`", "expected one of case_0"]),
    ("sim --sign-key none.key", &["none.key: no key to sign with"]),
    ("sim --sign-key text.json", &["text.json: no key to sign with", "(mode 0644): `chmod 600` is expected"]),
    ("sim --sign-key long.key", &["long.key: no key to sign with", "longer than 4096 bytes"]),
    ("sim --sign-key cut.key", &["cut.key: no key to sign with", "63 hexadecimal digits: a key has 64"]),
    ("sim --sign-key empty.key", &["empty.key: no key to sign with", "the key is empty"]),
    ("autopilot --sign-key stamped.key", &["stamped.key.1-1.stamps", "line 2: `hear 1`", "`latest STAMP`"]),
    (
        "autopilot --sign-key ahead.key",
        &["ahead.key.1-1.stamps", "this machine's clock is ", " s behind the last stamp"],
    ),
    ("tune --start nobody", &["no gains file of the name `nobody`"]),
    ("new mission a --vehicle x50 --planet earth --altitude 0", &["did you mean `x500`?"]),
    // Flags.
    ("drp", &["unrecognized subcommand 'drp'", "drop"]),
    ("drop --gain ours", &["unexpected argument '--gain'", "--gains"]),
    ("drop --seed -1", &["a whole number from 0"]),
    ("drop --seed x", &["a whole number from 0"]),
    ("drop --speed 0", &["a factor from 0.001 to 10000, or `max`"]),
    ("sim --wait-for godot", &["`companion`, or `companion=` and seconds from 0.1 to 86400"]),
    ("sim --wait-for companion=0", &["`companion`, or `companion=` and seconds from 0.1 to 86400"]),
    ("drop --speed fast", &["a factor from 0.001 to 10000, or `max`"]),
    ("drop --instance 10", &["0", "9"]),
    ("drop --autopilot px5", &["`reference`, `px4-model`, or `px4=`"]),
    ("drop x500_drop --autopilot px4-model=1.13", &["v1.12, v1.14, v1.16, v1.17, v1.18"]),
    ("tune x500_drop --for px4 --px4-version new", &["v1.12, v1.14, v1.16, v1.17, v1.18"]),
    ("tune --px4-version v1.16", &["--px4-version", "--for px4 is expected with it"]),
    ("drop x500_drop --autopilot px4=nowhere", &["nowhere: there is no such folder"]),
    ("drop x500_drop --autopilot px4=mission", &["mission: no `bin/px4` in it"]),
    ("drop --cpu many", &["`auto`, `any` or the number of a processor"]),
    ("drop --estimator lpe", &["truth", "ekf"]),
    ("drop --cases --case case_0", &["cannot be used with"]),
    ("drop --gains ours --params a.params", &["cannot be used with"]),
    ("plan --nodes 2", &["a whole number from 3 to"]),
    ("plan --nodes 1.5", &["a whole number from 3 to"]),
    ("plan --tolerance 0", &["a number from 1e-12 to 0.01 is expected"]),
    ("assess --trials 1", &["a whole number from 2"]),
    ("assess --trials 0", &["a whole number from 2"]),
    ("assess --threads 0", &["a whole number from 1 to 256"]),
    ("assess --threads 1000", &["a whole number from 1 to 256"]),
    ("tune --threads 1000", &["a whole number from 1 to 256"]),
    ("assess --autopilot reference --replan --feed-forward", &["cannot be used with"]),
    ("assess --envelope=pitch:roll", &["pairs of different quantities such as pitch:wind", "turbulence_m_s"]),
    ("assess --envelope=wind", &["pairs of different quantities", "found `wind`"]),
    ("assess --envelope=wind:wind_m_s", &["pairs of different quantities"]),
    ("assess --envelope --rays 6", &["a multiple of 4 from 4 to 64"]),
    ("assess --envelope --trials 5", &["cannot be used with"]),
    ("assess --rays 8", &["--envelope"]),
    ("assess titan_paper --free-fall", &["free-fall: parachute.canopy and parachute.riser are expected"]),
    ("assess x500_ground --free-fall", &["free-fall is about drops, and this mission begins on the ground"]),
    ("assess titan_no_wire --free-fall=0", &["1"]),
    ("assess titan_no_wire --free-fall --bound 2", &["cannot be used with"]),
    ("assess x500_ground --envelope", &["envelope is about drops, and this mission begins on the ground"]),
    ("assess x500_ground --rare 1e-3", &["rare is about drops, and this mission begins on the ground"]),
    ("assess --rare 2", &["a probability from 1e-12 to 0.1", "such as 1e-6"]),
    ("assess --rare 1e-3 --trials 5", &["cannot be used with"]),
    ("assess --rare 1e-3 --autopilot reference", &["cannot be used with"]),
    ("assess --rare 1e-3 --per-level 7", &["a whole number from 800 to 100000"]),
    ("assess --unknowns", &["--rare"]),
    // Where what is needed cannot be used with what was typed, the parser does not miss it.
    ("assess --trials 600 --unknowns", &["--unknowns: --rare is expected with it"]),
    ("assess --sobol --per-level 900", &["--per-level: --rare is expected with it"]),
    ("assess --only 3 --rays 8", &["--rays: --envelope is expected with it"]),
    ("assess --rare 1e-3 --feed-forward", &["--feed-forward: --autopilot is expected with it"]),
    ("assess --autopilot reference --repeat 3", &["--repeat: --only K is expected with it"]),
    ("assess --paper --instance 3", &["--instance: --autopilot is expected with it"]),
    ("card --chosen-among 0", &["a whole number from 1"]),
    ("assess x500_ground --sobol", &["sobol is about drops, and this mission begins on the ground"]),
    ("assess --sobol=7", &["a whole number from 64 to 1000000"]),
    ("assess --sobol --rare 1e-3", &["cannot be used with"]),
    ("study", &["Usage: samara study <COMMAND>"]),
    ("study rare --least 2", &["a probability from 1e-12 to 0.1"]),
    ("study envelope --pairs wind", &["pairs of different quantities", "found `wind`"]),
    ("study sobol x500_drop --only 3", &["--only: an index is of all flights together"]),
    ("study sobol x500_ground", &["sobol is about drops, and this mission begins on the ground"]),
    ("study rare --only a.json --resume", &["cannot be used with"]),
    ("study effects --trials 100001 x500_drop", &["a whole number from 2 to 100000 is expected"]),
    ("assess --only nowhere.json", &["cannot read failure of --rare nowhere.json"]),
    ("assess --bound -1", &["a number above 0, up to 1e6"]),
    ("assess --only 1 --resume", &["cannot be used with"]),
    ("assess --resume --out nowhere", &["nowhere", "no campaign to go on with", "without --resume"]),
    ("tune --resume --out nowhere", &["tune_rows.csv", "nothing to go on with"]),
    ("tune --draws 5", &["--draws: --robust is expected with it"]),
    ("design --set vehicle.mass_kg=2", &["--set", "a key of the mission is expected"]),
    ("study design x500_drop --only 3", &["--only: a design is judged by all its flights"]),
    ("tune --method simplex", &["pso-cma", "near-hover"]),
    ("tune --particles 1", &["a whole number from 4"]),
    ("tune --name a/b", &["letters, digits, _ and -"]),
    ("tune --swing 1,x", &["a positive number"]),
    ("params export --for ardupilot", &["samara", "px4", "px4-froude"]),
    ("params check none.params", &["cannot read parameter file none.params"]),
    ("params check file", &["file: there is no parameter in it"]),
    ("new vehicle a --mass 0 --frame quad-x", &["a positive number"]),
    ("new vehicle a --mass -1 --frame quad-x", &["a positive number"]),
    ("new mission a --vehicle x500 --planet venus", &["one of earth, titan, mars"]),
    ("init .", &["is there already"]),
    // A board's line.
    ("drop --serial :57600", &["`:57600`: DEV or DEV:BAUD is expected, BAUD from 1200 to 3000000"]),
    (
        "sim --serial /dev/ttyUSB0:57600",
        &["57600 Bd carry 5760 bytes a second", "230400 Bd are expected at the least"],
    ),
    ("drop x500_drop --serial /dev/ttyUSB0:115200", &["115200 Bd carry 11520 bytes a second"]),
    ("sim --serial /dev/ttyUSB0 --speed 2", &["--speed: 1 is expected with --serial"]),
    ("sim --serial /dev/ttyUSB0 --wait-for companion", &["cannot be used with"]),
    ("drop x500_drop --serial /dev/ttyUSB0 --autopilot reference", &["cannot be used with"]),
    ("drop x500_drop --serial /dev/ttyUSB0 --replan 2", &["--replan: not with --serial"]),
    ("drop x500_drop --serial /dev/ttyUSB0 --estimator ekf", &["--estimator: not with --serial"]),
    ("drop x500_no_wire --serial /dev/ttyUSB0", &["release.free_fall is found by the board's clock"]),
    // Folders.
    ("plan --out file/x", &["cannot make the output folder file/x"]),
    ("drop --out file", &["cannot make the output folder file"]),
];

#[test]
fn bad_command_lines_are_refused_with_what_was_expected() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    assert_eq!(code(&samara_in(here, &["init", "."])), 0);
    let mission = fs::read_to_string(here.join(MISSION)).unwrap();
    fs::write(here.join("empty.json"), " \n").unwrap();
    fs::write(here.join("cut.json"), &mission[..700]).unwrap();
    fs::write(here.join("list.json"), "[]").unwrap();
    let inside = mission.replace("\"../params", "\"params");
    fs::write(here.join("twice.json"), format!("{inside}{{}}\n")).unwrap();
    fs::write(here.join("latin1.json"), b"{ \"about\": \"\xe9\" }").unwrap();
    fs::write(here.join("text.json"), "mission\n").unwrap();
    fs::write(here.join("file"), "").unwrap();
    let secret = |name: &str, text: &str| {
        fs::write(here.join(name), text).unwrap();
        fs::set_permissions(here.join(name), fs::Permissions::from_mode(0o600)).unwrap();
    };
    fs::set_permissions(here.join("text.json"), fs::Permissions::from_mode(0o644)).unwrap();
    secret("long.key", &"titan".repeat(1000));
    secret("cut.key", &"7".repeat(63));
    secret("empty.key", "\n");
    secret("stamped.key", "titan");
    fs::write(here.join("stamped.key.1-1.stamps"), "latest 1\nhear 1\n").unwrap();
    secret("ahead.key", "titan");
    fs::write(here.join("ahead.key.1-1.stamps"), "latest 281474976710655\n").unwrap();
    let mut faults = Vec::new();
    for (line, words) in LINES {
        let args: Vec<&str> = line.split_whitespace().collect();
        let output = samara_in(here, &args);
        let said = stderr(&output);
        let right =
            code(&output) == 2 && words.iter().all(|word| said.contains(word)) && !said.contains("?: ");
        // The mission's name, where one was named; no half of a result.
        let printed = String::from_utf8_lossy(&output.stdout);
        if !right || printed.lines().any(|line| !line.starts_with("mission ")) {
            faults.push(format!("{line}: wanted {words:?}, code {}\n  {said}  {printed}", code(&output)));
        }
    }
    assert!(EDITS.len() + LINES.len() > 140, "{}", EDITS.len() + LINES.len());
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), LINES.len(), faults.join("\n"));
}

/// What is said of a vehicle that no rotors can hold about yaw names the axis, and nothing stands on stdout
/// before it.
#[test]
fn a_vehicle_whose_rotors_all_turn_one_way_is_refused_for_its_yaw() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(code(&samara_in(folder.path(), &["init", "."])), 0);
    let place = folder.path().join(VEHICLE);
    let text = fs::read_to_string(&place).unwrap();
    fs::write(&place, text.replace("\"ccw\"", "\"cw\"")).unwrap();
    let output = samara_in(folder.path(), &["drop", "mission/x500_drop.json"]);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert!(stderr(&output).contains("yaw: the rotors' torques do not cancel"), "{}", stderr(&output));
    assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
}
