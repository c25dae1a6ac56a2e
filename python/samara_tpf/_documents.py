"""Missions, vehicles and gains: their keys, made from params/schema by scripts/python_documents."""

# mypy: disable-error-code=empty-body

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from ._document import Choice, Document, Items, Part, either, inner, leaf, listed, section


class Mission(Document, kind="mission"):
    """A drop: what falls, where, how it is released, where it shall fly to, and how that is planned, judged and tuned.
    Paths are relative to this file. NED: north, east, down.
    """

    @leaf
    def about(self) -> str | None:
        """Description of the mission, for the reader."""

    @listed
    def estimated(self) -> Items[str]:
        """Keys of this file whose numbers are estimated or guessed, neither measured nor required, as paths (`limits`,
        `parachute.descent_m_s`); a section's key stands for all that is in it. None: `[]`. A release card asks for
        their acceptance, also where this key is left out, since nobody knows then.
        """

    @leaf
    def name(self) -> str:
        """Name of the mission; results go to `out/NAME/`."""

    @inner
    def vehicle(self) -> VehicleDocument:
        """Vehicle file."""

    @inner
    def gains(self) -> Gains:
        """Gains file."""

    @leaf
    def seed(self) -> int:
        """Seed of everything random."""

    @leaf
    def epoch_unix_us(self) -> int:
        """Time of the simulation's start for stamps in logs [us since 1970-01-01 UTC]."""

    @leaf
    def duration_s(self) -> float:
        """How long the simulation runs, from the start of the hang [s]."""

    @listed
    def target_v_ned_m_s(self) -> Items[float]:
        """Steady velocity to reach, v_cmd, NED [m/s]."""

    @section
    def site(self) -> Site:
        """Gravity, air and place."""

    @section
    def wind(self) -> Wind:
        """Wind by altitude, gusts and turbulence, in addition to site.wind_ned_m_s."""

    @section
    def vortex_ring(self) -> VortexRing:
        """Fluctuation of rotors' thrusts in the vortex ring; without it they have their means."""

    @section
    def parachute(self) -> Parachute:
        """Descent and swing before the release, and the delay after it."""

    @section
    def release(self) -> Release:
        """When and how the vehicle is cut loose."""

    @section
    def plan(self) -> Plan:
        """The optimal control problem, (25)-(32)."""

    @section
    def limits(self) -> Limits:
        """Safety limits, Table 1."""

    @section
    def control(self) -> Control:
        """Limits of the cascade."""

    @section
    def tuning(self) -> Tuning:
        """Releases that the gains are tuned on."""

    @section
    def monte_carlo(self) -> MonteCarlo:
        """Random releases, (40)-(44)."""

    @section
    def uncertain(self) -> Uncertain:
        """How far numbers of the vehicle, its air and its delays may be off: drawn in every campaign, study and search.
        A quantity that is named here has the vehicle's word for it overridden. Left out here and in the vehicle:
        campaigns fly what is known, and searches the program's usual ranges.
        """

    @section
    def design(self) -> Design:
        """How plan and gains are designed together."""

    @section
    def replan(self) -> Replan:
        """How plans are renewed during a drop, where that is asked for (`--replan`)."""

    @section
    def battery(self) -> Battery:
        """The battery; without it the vehicle flies for ever."""

    @section
    def sensors(self) -> Sensors:
        """Errors of the sensors; without it they are ideal."""

    @section
    def faults(self) -> Faults:
        """What fails, and when; without it nothing does."""

    @leaf
    def px4_clock(self) -> Literal["real", "froude"] | None:
        """How a PX4 that flies this mission is connected; "real" when left out. `real`: In the site's units and time;
        where gravity differs from Earth's, PX4's estimator does not start. `froude`: By Froude's similarity: time,
        velocities, accelerations and rates are scaled on the wire to 9.80665 m/s^2.
        """

    @leaf
    def px4_params(self) -> str | None:
        """Parameter file that PX4 flies this mission with; without it, or where gains are chosen, the gains in PX4's
        terms.
        """


class Site(Part):
    """Gravity, air and place."""

    @leaf
    def about(self) -> str | None:
        """Remarks on the place, for the reader."""

    @leaf
    def atmosphere(self) -> Literal["constant", "us1976", "titan"] | None:
        """Gravity and density by altitude; "constant" when left out: gravity_m_s2 and density_kg_m3 hold everywhere.
        `constant`: No change: gravity_m_s2 and density_kg_m3 hold at every altitude. `us1976`: The US Standard
        Atmosphere 1976, from -5 to 86 km. `titan`: Titan's, as Huygens measured it, from 0 to 10 km.
        """

    @leaf
    def gravity_m_s2(self) -> float | None:
        """Gravity; left out where an atmosphere has it [m/s^2]."""

    @leaf
    def density_kg_m3(self) -> float | None:
        """Density of the air; left out where an atmosphere has it [kg/m^3]."""

    @listed
    def wind_ned_m_s(self) -> Items[float]:
        """Velocity of the air over ground, NED [m/s]."""

    @leaf
    def latitude_deg(self) -> float:
        """Latitude of the local frame's origin, the point of release at the end of the hang [deg]."""

    @leaf
    def longitude_deg(self) -> float:
        """Longitude of the local frame's origin [deg]."""

    @leaf
    def altitude_m(self) -> float:
        """Altitude of the local frame's origin above mean sea level [m]."""

    @leaf
    def ground_altitude_m(self) -> float | None:
        """Altitude of level ground above mean sea level [m]; without it there is none."""


class Wind(Part):
    """Wind in addition to site.wind_ned_m_s. Plans take the mean wind at site.altitude_m; drops and campaigns fly in
    all of it.
    """

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @listed
    def by_altitude(self) -> Items[WindAt]:
        """Mean wind by altitude, in addition to site.wind_ned_m_s: linear between the entries, the outermost ones
        beyond them. Altitudes increase.
        """

    @listed
    def gusts(self) -> Items[Gust]:
        """Discrete gusts, in addition to the mean wind and to each other."""

    @section
    def turbulence(self) -> Turbulence:
        """Continuous turbulence."""


class VortexRing(Part):
    """Fluctuation of the thrust of rotors in the vortex ring, inside Johnson's stability boundary. Plans and the ideal
    plant do not have it.
    """

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @leaf
    def thrust_rms_share(self) -> float:
        """Standard deviation of each rotor's thrust well inside the ring, over its mean; measured were 0.1 to 0.3."""

    @leaf
    def frequency_hz(self) -> float:
        """Corner frequency of the spectrum [Hz]. A choice, since nothing measured was found: 0.1 to 0.3 of v_h/(2 R),
        the induced velocity of hover over the diameter.
        """

    @leaf
    def seed(self) -> int | None:
        """Seed of the random numbers; the mission's when left out. Each trial of a campaign and each rotor has its own
        draw.
        """


class Parachute(Part):
    """Descent and swing under the canopy."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def descent_m_s(self) -> float:
        """Rate of descent over ground [m/s]."""

    @leaf
    def delay_s(self) -> float:
        """Delay t_d between release and rotor start [s]."""

    @section
    def pendulum(self) -> Pendulum:
        """The swing in the north-down plane, (40)."""

    @section
    def canopy(self) -> Canopy:
        """The canopy as a body of its own, in whole drops; without it the motion until the release is prescribed by
        descent_m_s and pendulum. Needs a riser.
        """

    @section
    def riser(self) -> Riser:
        """The riser between canopy and vehicle; needs a canopy."""


class Release(Part):
    """When and how the vehicle is cut loose."""

    @leaf
    def start(self) -> Literal["release", "t0", "ground"]:
        """How the vehicle comes from the release to t = 0. `release`: A drop: it falls for t_d through the air. `t0`:
        The paper's study: (44) holds at t = 0, attitude and rates as at the release. `ground`: No drop: it stands on
        the ground, right below the local origin, without a parachute. The rest of the release and the parachute do not
        matter then.
        """

    @leaf
    def hang_s(self) -> float:
        """Time from the beginning to the nominal release [s]."""

    @leaf
    def hook_s(self) -> float | None:
        """Part of hang_s that a hook holds the vehicle still, before it is let go under its canopy [s]; 0 when left
        out. A canopy that is a body of its own takes over once the descent has built up.
        """

    @either
    def trigger(self) -> Literal["command", "time", "armed_offboard"] | Trigger:
        """Trigger of the release. `command`: The command MAV_CMD_DO_GRIPPER to the parachute component. `time`: The end
        of the hang. `altitude` (an object): An altitude, passed on the way down. `armed_offboard`: The autopilot is
        armed and in OFFBOARD.
        """

    @section
    def tip_off(self) -> TipOff:
        """What the cut gives the vehicle, in drops and in flights from t = 0; plans do not know of it."""

    @section
    def free_fall(self) -> FreeFall:
        """No wire leads from the canopy to the vehicle: the release is found by the fall that the accelerometer shows.
        Without it the parachute reports the release.
        """


class Plan(Part):
    """The optimal control problem, (25)-(32)."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def horizon_s(self) -> float:
        """Horizon t_f from the start of the rotors [s]."""

    @leaf
    def initial(self) -> Literal["paper", "release"] | None:
        """State that the plan starts from; "paper" when left out. `paper`: State (44) of the paper without the swing:
        level and still, descending at v_0 = descent + g t_d. `release`: State of the drop at t = 0 after a release at
        the end of the hang: with its swing, braked by the air.
        """

    @leaf
    def nodes(self) -> int:
        """Number of nodes N; N - 1 intervals fill the horizon."""

    @leaf
    def thrust_max_n(self) -> float | None:
        """Greatest thrust of a rotor [N]; left out, the thrust that rotor and motor hold in the site's air."""

    @leaf
    def thrust_slew_n_s(self) -> float | None:
        """Greatest rate of change of a rotor's thrust [N/s]; left out, the mean rate at which rotor and motor make 90 %
        of their thrust, or lose it, in the site's air.
        """

    @listed
    def cost_state(self) -> Items[float]:
        """Diagonal of Q and S over the state [q0, q1, q2, q3, vn, ve, vd, p, q, r] in SI."""

    @leaf
    def cost_input_per_n2(self) -> float:
        """Diagonal of R [1/N^2]."""

    @leaf
    def cost_input_reference(self) -> Literal["zero", "trim"]:
        """Thrust that costs nothing. `zero`: Zero, as in the paper. `trim`: The thrusts of the trim."""

    @leaf
    def terminal_tolerance_m_s(self) -> float | None:
        """Velocity at the plan's end within this of the target, axis by axis, from 1e-7 [m/s]; free when left out, as
        in the paper, whose optimum drifts off the target in its last seconds.
        """

    @section
    def x_ss(self) -> State:
        """Reference state x_ss of the cost, (31); the solved trim at the target velocity when left out."""

    @listed
    def final_cost_state(self) -> Items[float]:
        """Diagonal of S alone, in the order of `cost_state`; that of Q when left out, as in the paper."""

    @section
    def peak(self) -> Peak:
        """A cost for the peak of J_state (47), measured by `limits` of the mission, at nodes and midpoints."""

    @section
    def motion(self) -> Motion:
        """Bounds on the motion, held at nodes and midpoints from the second node on."""

    @leaf
    def rotor_acceleration_rad_s2(self) -> float | None:
        """Greatest rate of change of a rotor's speed [rad/s^2], so that the limit on a thrust's slew grows with the
        root of the thrust. Beside it `thrust_slew_n_s` holds only where it is given.
        """

    @section
    def avoid_vortex_ring(self) -> Ring:
        """Keeps every rotor out of the vortex ring, for vehicles with known blades."""

    @section
    def free_horizon(self) -> FreeHorizon:
        """Horizon that the planner chooses; `horizon_s` is then where it begins, and what `avoid_vortex_ring` counts
        its times on.
        """


class Limits(Part):
    """Safety limits, Table 1: where J_state is 1."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def speed_m_s(self) -> float:
        """Speed [m/s]."""

    @leaf
    def pitch_deg(self) -> float:
        """Pitch, either way [deg]."""

    @leaf
    def pitch_rate_deg_s(self) -> float:
        """Pitch rate, either way [deg/s]."""

    @leaf
    def vertical_acceleration_m_s2(self) -> float:
        """Vertical acceleration [m/s^2]; reported, not judged."""

    @leaf
    def steady_within_m_s(self) -> float | None:
        """How close to the target velocity is steady [m/s]; when left out, 1 % of the target and at least 0.02 m/s."""

    @leaf
    def steady_mean_over_s(self) -> float | None:
        """Time over which the mean of the velocity is to be so close, from the steady time to the end, for missions in
        turbulence; the root of the mean square about it is shown [s]; left out, the velocity at each instant is to be.
        """

    @leaf
    def impact_speed_m_s(self) -> float | None:
        """Whole speed over ground at a touch of the ground [m/s]; 2.1 when left out."""

    @leaf
    def impact_tilt_deg(self) -> float | None:
        """Angle between the body's up axis and the vertical at a touch of the ground [deg]; 15 when left out."""

    @leaf
    def altitude_lost_m(self) -> float | None:
        """Way down from the release to the plan's end [m]; left out, it is reported and not judged."""

    @leaf
    def tilt_deg(self) -> float | None:
        """Angle between the body's up axis and the vertical, from the release on [deg]; left out, it is reported and
        not judged.
        """

    @leaf
    def steady_after_s(self) -> float | None:
        """Time after t = 0 by which the flight is steady [s]; left out, it must be steady at the mission's end."""

    @leaf
    def separation_m(self) -> float | None:
        """Least distance from the canopy (parachute.canopy) to the centre of mass after the release: less is a contact
        [m]; left out, the distance is reported and not judged. Flights from t = 0 have no canopy.
        """


class Control(Part):
    """Limits of the cascade."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def tilt_limit_deg(self) -> float:
        """Largest commanded tilt [deg]."""

    @leaf
    def rate_command_limit_deg_s(self) -> float:
        """Largest commanded roll and pitch rate [deg/s]."""

    @leaf
    def yaw_rate_command_limit_deg_s(self) -> float:
        """Largest commanded yaw rate [deg/s]."""

    @leaf
    def rate_integral_limit_rad_s2(self) -> float:
        """Bound of the rate loops' integrals [rad/s^2]."""

    @leaf
    def feed_forward(self) -> bool | None:
        """Whether the plan's acceleration is sent with its velocity, and fed forward; no when left out, as in the
        paper.
        """

    @leaf
    def latency_s(self) -> float | None:
        """Time from a measurement to what the speed controllers do about it, beyond the control period [s]; none when
        left out.
        """

    @leaf
    def tilt_from(self) -> Literal["gravity", "thrust"] | None:
        """What the wanted horizontal acceleration is set against, to get a tilt; `thrust` when left out. What is said
        here PX4 is asked for too (MPC_ACC_DECOUPLE). `gravity`: Gravity, as in PX4 since v1.12. `thrust`: The thrust
        that is wanted upwards: near none the tilt jumps. PX4 has it from v1.15 on.
        """

    @leaf
    def thrust_curve(self) -> Literal["quadratic", "linear"] | None:
        """Curve of a rotor's thrust over its throttle that the controller has in mind; `quadratic` when left out. PX4
        is given it too (THR_MDL_FAC). `quadratic`: The square of the throttle, as the rotors have it: the throttle is
        the root of the wanted thrust (THR_MDL_FAC 1). `linear`: A line from rest through hover: the throttle is linear
        in the wanted thrust (THR_MDL_FAC 0, PX4's default).
        """

    @leaf
    def battery_scaling(self) -> bool | None:
        """Whether throttles are scaled by the measured voltage of a battery whose motors' throttle is a duty cycle; no
        when left out. PX4 then scales in its own way (MC_BAT_SCALE_EN).
        """


class Tuning(Part):
    """Releases that the gains are tuned on."""

    @leaf
    def about(self) -> str | None:
        """Where the cases come from."""

    @listed
    def cases(self) -> Items[Case]:
        """Releases by name; Table 3 for the paper's mission. Left out or empty: one without a swing and, as in that
        table, a swing of three standard deviations of monte_carlo at the phases 0, 36 .. 180 deg.
        """

    @listed
    def gains(self) -> Items[float]:
        """Least and greatest value of each gain that is searched, the space Y of (46); around a rule for the vehicle's
        lag when left out.
        """


class MonteCarlo(Part):
    """Random releases: amplitude theta_0 normal about 0, phase uniform over the turn."""

    @leaf
    def about(self) -> str | None:
        """Where the distribution comes from."""

    @leaf
    def trials(self) -> int:
        """Releases in a campaign."""

    @leaf
    def amplitude_sigma_deg(self) -> float:
        """Standard deviation of the amplitude [deg]."""

    @leaf
    def omega_rad_s(self) -> float:
        """Frequency of the swing [rad/s]."""

    @leaf
    def length_m(self) -> float:
        """Length of the pendulum [m]."""

    @leaf
    def wind_sigma_m_s(self) -> float | None:
        """Standard deviation of the wind in north and in east, about the site's, in campaigns of whole drops [m/s]; 0
        when left out.
        """

    @section
    def tip_off(self) -> TipOffSigma:
        """What the cut gives the vehicle, in addition to release.tip_off; nothing when left out."""


class Uncertain(Part):
    """How far quantities may be off what the files say, each with a distribution of its deviation: a share of the
    vehicle's number (0.05: 5 % more), or in the unit of its key. What is left out is known.
    """

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @section
    def mass(self) -> Distribution:
        """Mass, as a share."""

    @section
    def inertia(self) -> Distribution:
        """Moments of inertia, all alike, as a share."""

    @section
    def drag(self) -> Distribution:
        """Drag and side force of the body, as a share."""

    @section
    def pitching_moment(self) -> Distribution:
        """Pitching moment of the air on the body, as a share."""

    @section
    def density(self) -> Distribution:
        """Density of the air, as a share; a mission's alone."""

    @section
    def wind_north_m_s(self) -> Distribution:
        """Steady wind to the north in addition to the site's [m/s]; a mission's alone."""

    @section
    def latency_s(self) -> Distribution:
        """Latency from a command to the motors in addition to control.latency_s [s]; not negative."""

    @section
    def release_delay_s(self) -> Distribution:
        """Delay between the release and the start of the rotors in addition to parachute.delay_s [s]; a mission's
        alone.
        """

    @section
    def thrust(self) -> Distribution:
        """Thrusts of the rotors, all alike and with their torques as they are, as a share."""

    @section
    def motor_lag(self) -> Distribution:
        """Time constants of the motors, as a share."""

    @listed
    def together(self) -> Items[Together]:
        """Quantities that are normal together, in place of distributions of their own."""


class Design(Part):
    """How `samara design` searches plan and gains together. What is left out has a default; drops, plans and campaigns
    do not read it.
    """

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def objective(self) -> Literal["quantile", "worst"] | None:
        """Number of the random flights that is to be small; "quantile" when left out. `quantile`: A quantile of J_TPF.
        `worst`: The greatest J_TPF.
        """

    @leaf
    def quantile(self) -> float | None:
        """Share of the random flights that the objective "quantile" does not let exceed its number, from 0.5 to 1; 0.99
        when left out.
        """

    @leaf
    def draws(self) -> int | None:
        """Random flights that judge each design; 200 when left out."""

    @leaf
    def unknowns(self) -> bool | None:
        """Whether mass, inertia, air loads, density, steady wind and delays are unknown in them; true when left out."""

    @section
    def turbulence(self) -> LightTurbulence:
        """Turbulence in them where wind.turbulence has none; 0.5 m/s with a scale of 100 m when left out."""

    @leaf
    def settle_s(self) -> float | None:
        """Time that a flight goes on after the plan's end [s]; as long as the plan when left out."""

    @section
    def bounds(self) -> Bounds:
        """Bounds that a design keeps, beside coming to rest."""

    @section
    def search(self) -> Search:
        """Ranges that are searched."""


class Replan(Part):
    """How plans are renewed with `--replan`. What is left out has a default; without `--replan` nothing reads it."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def latency_s(self) -> float | None:
        """Time from a measurement until the plan made of it takes effect; 0.02 when left out [s]."""

    @leaf
    def iterations(self) -> int | None:
        """Most iterations of a solve; 50 when left out."""

    @leaf
    def until_s(self) -> float | None:
        """Latest time after t = 0 at which a renewed plan takes effect; 0.4 of `plan.horizon_s` when left out [s]."""

    @leaf
    def gains(self) -> str | None:
        """Gains file that is flown with `--replan`, where no other gains are chosen; the mission's own gains when left
        out.
        """


class Battery(Part):
    """A store of energy that the rotors' shafts take from; with `electric` a pack that the motors run on."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def capacity_wh(self) -> float:
        """Energy at the shafts when full; with `electric` the energy that the pack gives from full to empty without
        load, which over the mean of its voltage is its charge [Wh].
        """

    @leaf
    def charge_percent(self) -> int:
        """Charge at the start [%]."""

    @section
    def electric(self) -> Electric:
        """Voltage, resistance and limits; without it the battery has no voltage and never holds a motor back."""


class Sensors(Part):
    """Errors of the sensors that the simulator reports. A sensor that is left out is ideal."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @section
    def accelerometer(self) -> Accelerometer:
        """Accelerometer."""

    @section
    def gyroscope(self) -> Gyroscope:
        """Gyroscope."""

    @section
    def magnetometer(self) -> Magnetometer:
        """Magnetometer; in a dipole's field when left out."""

    @section
    def barometer(self) -> Barometer:
        """Barometer; with noise of 0.01 hPa when left out."""

    @section
    def gps(self) -> Gps:
        """Satellite receiver; 10 Hz when left out."""


class Faults(Part):
    """What fails, and when. Faults act in drops and in campaigns of whole drops; those of motors also in flights from t
    = 0. Plans are made and gains are tuned without them.
    """

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @listed
    def list(self) -> Items[Fault]:
        """The faults, in any order. A motor, a sensor, the setpoints, the parachute and its riser each have one at a
        time: a fault that begins ends the one before it.
        """

    @leaf
    def allow_command(self) -> bool | None:
        """Whether MAV_CMD_INJECT_FAILURE may begin and end faults in flight; false when left out."""


class WindAt(Part):
    """Mean wind at an altitude."""

    @leaf
    def altitude_m(self) -> float:
        """Altitude above mean sea level [m]."""

    @listed
    def wind_ned_m_s(self) -> Items[float]:
        """Velocity of the air over ground, NED [m/s]."""


class Gust(Part):
    """A discrete gust. Its length is a time or a distance."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def shape(self) -> Literal["step", "one_minus_cosine", "rise"]:
        """Velocity along the gust. `step`: At its peak from beginning to end. `one_minus_cosine`: From zero to the peak
        and back, (1 - cos)/2 over its length: EASA CS-25.341. `rise`: From zero to the peak, half a cosine wave over
        its length, and at the peak from there on: MIL-F-8785C.
        """

    @leaf
    def start_s(self) -> float:
        """Beginning, from the nominal t = 0, when the rotors are freed; negative: before [s]."""

    @leaf
    def length_s(self) -> float | None:
        """Time that it lasts; of the shape rise, that it rises [s]."""

    @leaf
    def length_m(self) -> float | None:
        """Instead of length_s: distance that the vehicle flies through the air meanwhile [m]."""

    @listed
    def peak_ned_m_s(self) -> Items[float]:
        """Largest velocity of the air, NED [m/s]."""


class Turbulence(Part):
    """Continuous turbulence."""

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @leaf
    def form(self) -> Literal["dryden"]:
        """Form of the spectra. `dryden`: Dryden's, MIL-F-8785C."""

    @listed
    def sigma_m_s(self) -> Items[float]:
        """Standard deviations of the air's velocity along the mean wind at site.altitude_m (north, where there is
        none), across it and vertically [m/s].
        """

    @either
    def scale_m(self) -> Items[float] | Literal["low_altitude", "free_atmosphere"]:
        """Scale lengths of the eddies along the mean wind, across it and vertically [m], or a rule by height."""

    @leaf
    def seed(self) -> int | None:
        """Seed of the random numbers; the mission's when left out. Each trial of a campaign has its own draw."""

    @leaf
    def noise(self) -> str | None:
        """CSV file of the random numbers, relative to this file, instead of drawn ones, the same in each trial: columns
        n_u, n_v1, n_v2, n_w1, n_w2 of mean 0 and variance 1; the first row begins the filters, each further one is a
        step of the simulation (4 ms in drops, 10 ms in flights from t = 0).
        """


class Pendulum(Part):
    """The swing theta_0 sin(omega t + phi), t from the end of the hang. With a canopy, amplitude and phase are those of
    the vehicle's swing about the confluence point, whose frequency follows from riser and inertia; omega_rad_s and
    length_m do not count then.
    """

    @leaf
    def amplitude_deg(self) -> float:
        """Amplitude theta_0 [deg]."""

    @leaf
    def phase_deg(self) -> float:
        """Phase phi at the end of the hang [deg]."""

    @leaf
    def omega_rad_s(self) -> float:
        """Angular frequency omega of the swing [rad/s]."""

    @leaf
    def length_m(self) -> float:
        """Length r from the pivot to the centre of mass [m]."""


class Canopy(Part):
    """A canopy: a point mass with drag from all sides alike, and with the air that it takes along."""

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @leaf
    def mass_kg(self) -> float:
        """Mass, with that of riser and bridle [kg]."""

    @leaf
    def drag_area_m2(self) -> float:
        """Drag area C_d S of the full canopy [m^2]."""

    @leaf
    def apparent_mass_factor(self) -> float:
        """Apparent mass in units of the air of a hemisphere of the inflated radius, at the density of site.altitude_m:
        about 1.
        """

    @leaf
    def inflated_radius_m(self) -> float | None:
        """Radius of the full canopy [m]; when left out, that of a round one with the drag coefficient 0.8 of its
        nominal area, inflated to 0.67 of the nominal diameter: 0.423 sqrt(drag_area_m2).
        """

    @leaf
    def opening_s(self) -> float | None:
        """Time in which it fills, from the beginning of the hang: the drag area as the square of the time [s]; 0 when
        left out: it is full, and both bodies sink steadily.
        """

    @leaf
    def opening_descent_m_s(self) -> float | None:
        """Rate of descent through the air at the beginning of the opening [m/s]; parachute.descent_m_s when left out.
        """


class Riser(Part):
    """A riser: a spring with a damper that pulls and never pushes."""

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @leaf
    def length_m(self) -> float:
        """Length without load, from the canopy's centre to the confluence point [m]."""

    @leaf
    def stiffness_n_m(self) -> float:
        """Stiffness [N/m]."""

    @leaf
    def damping_n_s_m(self) -> float:
        """Damping along the riser [N s/m]."""

    @listed
    def attachment_body_m(self) -> Items[float]:
        """Confluence point: where the riser pulls at the vehicle and is cut, body axes from the centre of mass, above
        it (z below 0) [m].
        """


class Trigger(Choice):
    """Trigger of the release."""

    @section
    def altitude(self) -> TriggerAltitude:
        """An altitude, passed on the way down."""


class TipOff(Part):
    """What the cut gives the vehicle: rates and velocity in addition to those that it has."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @listed
    def rate_body_deg_s(self) -> Items[float]:
        """Rates, body axes: roll, pitch, yaw [deg/s]; none when left out."""

    @listed
    def velocity_body_m_s(self) -> Items[float]:
        """Velocity, body axes [m/s]; none when left out."""


class FreeFall(Part):
    """How a fall is found from the accelerometer: the specific force that lacks to a level is summed until it makes a
    fall, s := max(0, s + (level - |f|) dt).
    """

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @leaf
    def level_share(self) -> float | None:
        """The level, as a share of gravity; 0.3 when left out."""

    @leaf
    def time_s(self) -> float | None:
        """Time in which a fall is found that begins at once and without noise, less than parachute.delay_s [s]; 0.1
        when left out.
        """


class State(Part):
    """A state of the vehicle."""

    @listed
    def q_ned_from_body(self) -> Items[float]:
        """Attitude, body to NED, scalar first."""

    @listed
    def v_ned_m_s(self) -> Items[float]:
        """Velocity, NED [m/s]."""

    @listed
    def omega_body_rad_s(self) -> Items[float]:
        """Body rates [rad/s]."""


class Peak(Part):
    """A cost for the peak of J_state."""

    @leaf
    def weight(self) -> float:
        """Cost of a peak of 1."""

    @leaf
    def alone(self) -> bool | None:
        """Whether the peak is the whole cost; otherwise it is added to the cost (26). No when left out."""


class Motion(Part):
    """Bounds on the motion."""

    @leaf
    def speed_m_s(self) -> float | None:
        """Greatest speed [m/s]."""

    @leaf
    def pitch_deg(self) -> float | None:
        """Greatest pitch and roll, either way [deg]."""

    @leaf
    def pitch_rate_deg_s(self) -> float | None:
        """Greatest pitch and roll rate, either way [deg/s]."""

    @listed
    def v_north_m_s(self) -> Items[float]:
        """Least and greatest velocity north [m/s]."""

    @listed
    def v_east_m_s(self) -> Items[float]:
        """Least and greatest velocity east [m/s]."""

    @listed
    def v_down_m_s(self) -> Items[float]:
        """Least and greatest velocity down [m/s]."""

    @leaf
    def altitude_lost_m(self) -> float | None:
        """Greatest altitude lost from t = 0 on [m]."""


class Ring(Part):
    """A way around the vortex ring."""

    @leaf
    def share(self) -> float | None:
        """Size of what is kept out of: 1 is the ellipse through N, X and the greatest edgewise velocity of Johnson's
        boundary. 1 when left out.
        """

    @leaf
    def from_s(self) -> float | None:
        """Time from which it holds [s], at midpoints and nodes; 0 when left out."""

    @leaf
    def to_s(self) -> float | None:
        """Time until which it holds [s]; to the end when left out."""


class FreeHorizon(Part):
    """A horizon that the planner chooses."""

    @leaf
    def least_s(self) -> float:
        """Shortest horizon [s]."""

    @leaf
    def greatest_s(self) -> float:
        """Longest horizon [s]."""

    @leaf
    def cost_per_s(self) -> float | None:
        """Cost of a second; 0 when left out."""


class Case(Part):
    """A state at t = 0, rotors at rest."""

    @leaf
    def name(self) -> str:
        """Name of the case."""

    @listed
    def v_ned_m_s(self) -> Items[float]:
        """Velocity, NED [m/s]."""

    @leaf
    def pitch_deg(self) -> float:
        """Pitch [deg]."""

    @leaf
    def pitch_rate_deg_s(self) -> float:
        """Pitch rate [deg/s]."""


class TipOffSigma(Part):
    """Random rates and velocities that the cut gives the vehicle, normal about 0. In flights from t = 0 they are added
    to the state at t = 0.
    """

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @listed
    def rate_sigma_deg_s(self) -> Items[float]:
        """Standard deviations of the rates, body axes: roll, pitch, yaw [deg/s]; 0 when left out."""

    @listed
    def velocity_sigma_m_s(self) -> Items[float]:
        """Standard deviations of the velocity, body axes [m/s]; 0 when left out."""


class Distribution(Choice):
    """Distribution of a deviation."""

    @listed
    def uniform(self) -> Items[float]:
        """Uniform between the least and the greatest."""

    @section
    def normal(self) -> Normal:
        """Normal."""

    @section
    def truncated_normal(self) -> TruncatedNormal:
        """Normal, and never outside a range."""

    @listed
    def table(self) -> Items[Sequence[float]]:
        """Rows of a probability and the deviation that is not exceeded with it: probabilities ascend from 0 to 1,
        deviations do not descend; uniform between two rows.
        """


class Together(Part):
    """Quantities that are normal together."""

    @listed
    def quantities(self) -> Items[str]:
        """Keys of the quantities."""

    @listed
    def mean(self) -> Items[float]:
        """Their means; 0 when left out."""

    @listed
    def covariance(self) -> Items[Sequence[float]]:
        """Their covariance, row by row: symmetric and positive definite."""


class LightTurbulence(Part):
    """Turbulence in Dryden's form, alike in all directions."""

    @leaf
    def sigma_m_s(self) -> float:
        """Standard deviation of each component of the air's velocity [m/s]; 0: none."""

    @leaf
    def scale_m(self) -> float:
        """Scale length of the eddies [m]."""


class Bounds(Part):
    """Bounds on a design's flights from the release cases in still air, and on its plan."""

    @leaf
    def steady_after_s(self) -> float | None:
        """Time after t = 0 by which each is steady [s]; the plan's end when left out."""

    @leaf
    def altitude_lost_m(self) -> float | None:
        """Way down from the release to the plan's end [m]."""

    @leaf
    def tilt_deg(self) -> float | None:
        """Angle between the body's up axis and the vertical [deg]."""

    @leaf
    def energy_j(self) -> float | None:
        """Energy that the plan takes of the rotors' shafts [J]."""

    @leaf
    def modulus(self) -> float | None:
        """Distance of each loop's response from -1, at least: at the release, at the plan's peak and at the target,
        also with motors and thrusts that are off; 0.5 when left out.
        """

    @leaf
    def delay_margin_s(self) -> float | None:
        """Delay that takes a loop to the limit of stability, at least [s], at the same; 0.02, or a control period and
        twice control.latency_s, when left out.
        """


class Search(Part):
    """Ranges of a search: least and greatest. Equal numbers are not searched."""

    @listed
    def attitude_weight(self) -> Items[float]:
        """Factor on plan.cost_state of q0 to q3; 0.01 to 100 when left out."""

    @listed
    def horizontal_weight(self) -> Items[float]:
        """Factor on plan.cost_state of vn and ve; not searched when left out: the others are measured by it."""

    @listed
    def vertical_weight(self) -> Items[float]:
        """Factor on plan.cost_state of vd; 0.01 to 100 when left out."""

    @listed
    def rate_weight(self) -> Items[float]:
        """Factor on plan.cost_state of p, q and r; 0.01 to 100 when left out."""

    @listed
    def final_weight(self) -> Items[float]:
        """Factor on the weights of the final state, on top of the others; not searched when left out."""

    @listed
    def input_weight(self) -> Items[float]:
        """Factor on plan.cost_input_per_n2; 0.01 to 100 when left out."""

    @listed
    def input_references(self) -> Items[Literal["zero", "trim"]]:
        """Values of plan.cost_input_reference to choose among; both when left out."""

    @listed
    def nodes(self) -> Items[int]:
        """Values of plan.nodes to choose among; the mission's own, and with each interval halved, when left out."""

    @listed
    def peak_weights(self) -> Items[float]:
        """Values of plan.peak.weight to choose among, 0 for none; the mission's own when left out."""

    @listed
    def pitch_deg(self) -> Items[float | None]:
        """Values of plan.motion.pitch_deg to choose among, null for no bound; the mission's own when left out."""

    @listed
    def pitch_rate_deg_s(self) -> Items[float | None]:
        """Values of plan.motion.pitch_rate_deg_s to choose among, null for no bound; the mission's own when left out.
        """

    @listed
    def feed_forward(self) -> Items[bool]:
        """Values of control.feed_forward to choose among; both when left out."""

    @listed
    def tilt_from(self) -> Items[Literal["gravity", "thrust"]]:
        """Values of control.tilt_from to choose among; both when left out."""

    @listed
    def tilt_limit_deg(self) -> Items[float]:
        """control.tilt_limit_deg; from a fifth to four fifths of limits.pitch_deg, or up to the mission's own, when
        left out.
        """

    @listed
    def rate_command_limit_deg_s(self) -> Items[float]:
        """control.rate_command_limit_deg_s; from a fifth to four fifths of limits.pitch_rate_deg_s, or up to the
        mission's own, when left out.
        """

    @listed
    def gains(self) -> Items[float]:
        """Each of the seven longitudinal gains; around the rule for the vehicle's lag when left out."""


class Electric(Part):
    """A pack and its bus: the voltage falls with charge and current, and all motors run on it. In whole drops; flights
    from t = 0 have the battery as it is when a drop begins, and plans motors on a stiff supply.
    """

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @listed
    def open_circuit(self) -> Items[OpenCircuit]:
        """Voltage of the pack without load by its charge: linear between entries, held beyond them."""

    @leaf
    def internal_resistance_ohm(self) -> float:
        """Internal resistance of the pack with that of the wires [ohm]."""

    @leaf
    def pack_current_max_a(self) -> float | None:
        """Most current of the pack; no limit when left out [A]."""

    @leaf
    def esc_current_max_a(self) -> float | None:
        """Most current that a speed controller takes from the bus; no limit when left out [A]."""

    @leaf
    def esc_efficiency(self) -> float:
        """Share of a speed controller's electric power that reaches its motor, above 0, at most 1."""

    @section
    def motor(self) -> SuppliedMotor:
        """What the motors make of it, where the vehicle's are first_order; those that are esc_dc have all of this in
        the vehicle file.
        """


class Accelerometer(Part):
    """Errors of the accelerometer, the same on each axis."""

    @leaf
    def noise_m_s2_per_sqrt_hz(self) -> float:
        """Noise density N: Allan's deviation is N / sqrt(tau) [m/s^2/sqrt(Hz)]."""

    @leaf
    def walk_m_s2_per_sqrt_s(self) -> float:
        """Random walk K of the bias: its standard deviation after t is K sqrt(t) [m/s^2/sqrt(s)]."""

    @leaf
    def turn_on_bias_m_s2(self) -> float:
        """Standard deviation of the bias at turn-on [m/s^2]."""

    @leaf
    def resolution_m_s2(self) -> float:
        """Smallest step of a reading [m/s^2]; 0: none."""

    @leaf
    def range_m_s2(self) -> float | None:
        """Greatest reading, either way [m/s^2]; no limit when left out."""


class Gyroscope(Part):
    """Errors of the gyroscope, the same on each axis."""

    @leaf
    def noise_rad_s_per_sqrt_hz(self) -> float:
        """Noise density N: Allan's deviation is N / sqrt(tau) [rad/s/sqrt(Hz)]."""

    @leaf
    def walk_rad_s_per_sqrt_s(self) -> float:
        """Random walk K of the bias: its standard deviation after t is K sqrt(t) [rad/s/sqrt(s)]."""

    @leaf
    def turn_on_bias_rad_s(self) -> float:
        """Standard deviation of the bias at turn-on [rad/s]."""

    @leaf
    def resolution_rad_s(self) -> float:
        """Smallest step of a reading [rad/s]; 0: none."""

    @leaf
    def range_rad_s(self) -> float | None:
        """Greatest reading, either way [rad/s]; no limit when left out."""


class Magnetometer(Part):
    """The magnetometer."""

    @leaf
    def field(self) -> Literal["dipole", "world_magnetic_model"]:
        """The field at the site. `dipole`: A dipole along the axis of rotation: no declination. `world_magnetic_model`:
        Earth's, by the World Magnetic Model on the day of epoch_unix_us (2020 to 2029); on Earth, or where px4_clock is
        "froude": PX4 looks up the declination of Earth's field where it is.
        """

    @leaf
    def rate_hz(self) -> int | None:
        """Readings in a second [Hz], by the site's time; one at each step of the simulation when left out."""

    @leaf
    def noise_gauss(self) -> float:
        """Standard deviation of a reading's noise, each axis [gauss]."""


class Barometer(Part):
    """Errors of the barometer."""

    @leaf
    def rate_hz(self) -> int | None:
        """Readings in a second [Hz], by the site's time; one at each step of the simulation when left out."""

    @leaf
    def noise_hpa(self) -> float:
        """Standard deviation of a reading's noise [hPa]; PX4 takes a barometer without any for dead."""

    @leaf
    def drift_hpa_per_sqrt_s(self) -> float:
        """Random walk of the bias: its standard deviation after t is this sqrt(t) [hPa/sqrt(s)]."""


class Gps(Part):
    """Rate and errors of the satellite receiver."""

    @leaf
    def rate_hz(self) -> int:
        """Fixes in a second [Hz]."""

    @leaf
    def horizontal_noise_m(self) -> float:
        """Standard deviation of north and east, each [m]."""

    @leaf
    def vertical_noise_m(self) -> float:
        """Standard deviation of the altitude [m]."""

    @leaf
    def velocity_noise_m_s(self) -> float:
        """Standard deviation of each component of the velocity [m/s]."""

    @leaf
    def delay_s(self) -> float:
        """Age of a fix when it is reported, to the nearest step of the simulation [s]."""


class Fault(Part):
    """A fault."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @either
    def fault(
        self,
    ) -> (
        Literal["gyro_off", "gyro_stuck", "gyro_garbage", "accelerometer_off", "accelerometer_stuck",
        "accelerometer_garbage", "magnetometer_off", "magnetometer_stuck", "magnetometer_garbage", "barometer_off",
        "barometer_stuck", "barometer_garbage", "gps_loss", "gps_off", "gps_stuck", "gps_garbage", "setpoint_loss",
        "parachute_silent", "parachute_holds"] | FaultKind
    ):
        """What fails. `motor_off` (an object): No current flows in the motor. `motor_stuck` (an object): The rotor
        keeps the speed that it has. `motor_slow` (an object): The motor follows its command late. `motor_weak` (an
        object): The motor turns slower than it is commanded to. `esc_no_start` (an object): The speed controller does
        not start a motor that is at rest. `gyro_off`: No body rates are read. `gyro_stuck`: The last body rates are
        repeated. `gyro_drift` (an object): An error of the body rates grows. `gyro_wrong` (an object): The body rates
        are wrong. `gyro_garbage`: The body rates are random. `accelerometer_off`: No specific force is read.
        `accelerometer_stuck`: The last specific force is repeated. `accelerometer_drift` (an object): An error of the
        specific force grows. `accelerometer_wrong` (an object): The specific force is wrong. `accelerometer_garbage`:
        The specific force is random. `magnetometer_off`: No magnetic field is read. `magnetometer_stuck`: The last
        field is repeated. `magnetometer_drift` (an object): An error of the field grows. `magnetometer_wrong` (an
        object): The field is wrong. `magnetometer_garbage`: The field is random. `barometer_off`: No pressure is read.
        `barometer_stuck`: The last pressure is repeated. `barometer_drift` (an object): An error of the pressure grows.
        `barometer_wrong` (an object): The pressure is wrong. `barometer_garbage`: The pressure is random. `gps_loss`:
        The satellite receiver reports that it has no fix. `gps_off`: Nothing comes from the satellite receiver.
        `gps_stuck`: The last position and velocity are repeated. `gps_drift` (an object): An error of the position
        grows; the velocity is right. `gps_wrong` (an object): The position is wrong; the velocity is right.
        `gps_garbage`: Position and velocity are random. `setpoint_loss`: The streamer sends nothing.
        `parachute_silent`: The parachute's component sends no HEARTBEAT, as one that leaves with its canopy.
        `parachute_holds`: The parachute does not let go, whatever asks it to; at the fault's end it does what it was
        asked to. `late_release` (an object): The parachute lets go later than it is asked to. `riser_hung_up` (an
        object): One leg of the bridle stays fixed at the release, and the canopy (parachute.canopy) pulls by it until
        the fault's end.
        """

    @leaf
    def at_s(self) -> float:
        """Beginning, from the nominal t = 0, when the rotors are freed; negative: before [s]."""

    @leaf
    def until_s(self) -> float | None:
        """End, likewise [s]; it stays when left out."""


class TriggerAltitude(Part):
    """An altitude, passed on the way down."""

    @leaf
    def altitude_m(self) -> float:
        """Altitude above mean sea level [m]."""


class Normal(Part):
    """A normal distribution."""

    @leaf
    def mean(self) -> float | None:
        """Mean; 0 when left out."""

    @leaf
    def sigma(self) -> float:
        """Standard deviation."""


class TruncatedNormal(Part):
    """A normal distribution of which only a range is drawn."""

    @leaf
    def mean(self) -> float | None:
        """Mean before it is cut; 0 when left out."""

    @leaf
    def sigma(self) -> float:
        """Standard deviation before it is cut."""

    @listed
    def range(self) -> Items[float]:
        """The least and the greatest that is drawn."""


class OpenCircuit(Part):
    """The voltage of a pack without load at a charge."""

    @leaf
    def charge_percent(self) -> float:
        """Charge [%]."""

    @leaf
    def voltage_v(self) -> float:
        """Voltage of the pack, all its cells, without load [V]."""


class SuppliedMotor(Part):
    """Electric properties of motors of first order."""

    @leaf
    def efficiency(self) -> float:
        """Shaft power over electric power, above 0, at most 1."""

    @leaf
    def nominal_v(self) -> float:
        """Bus voltage at which a motor reaches omega_max_rad_s at full throttle [V]."""

    @leaf
    def throttle(self) -> Literal["speed", "duty_cycle"]:
        """Meaning of the throttle. `speed`: A speed over omega_max_rad_s: the speed controller holds it as long as the
        voltage allows it. `duty_cycle`: A part of the bus voltage: the speed goes with the voltage, on a full battery
        beyond omega_max_rad_s.
        """


class FaultKind(Choice):
    """What fails. `samara faults` lists what each does."""

    @section
    def motor_off(self) -> FaultyRotor:
        """No current flows in the motor."""

    @section
    def motor_stuck(self) -> FaultyRotor:
        """The rotor keeps the speed that it has."""

    @section
    def motor_slow(self) -> FaultKindMotorSlow:
        """The motor follows its command late."""

    @section
    def motor_weak(self) -> FaultKindMotorWeak:
        """The motor turns slower than it is commanded to."""

    @section
    def esc_no_start(self) -> FaultyRotor:
        """The speed controller does not start a motor that is at rest."""

    @section
    def gyro_drift(self) -> FaultKindGyroDrift:
        """An error of the body rates grows."""

    @section
    def gyro_wrong(self) -> FaultKindGyroWrong:
        """The body rates are wrong."""

    @section
    def accelerometer_drift(self) -> FaultKindAccelerometerDrift:
        """An error of the specific force grows."""

    @section
    def accelerometer_wrong(self) -> FaultKindAccelerometerWrong:
        """The specific force is wrong."""

    @section
    def magnetometer_drift(self) -> FaultKindMagnetometerDrift:
        """An error of the field grows."""

    @section
    def magnetometer_wrong(self) -> FaultKindMagnetometerWrong:
        """The field is wrong."""

    @section
    def barometer_drift(self) -> FaultKindBarometerDrift:
        """An error of the pressure grows."""

    @section
    def barometer_wrong(self) -> FaultKindBarometerWrong:
        """The pressure is wrong."""

    @section
    def gps_drift(self) -> FaultKindGpsDrift:
        """An error of the position grows; the velocity is right."""

    @section
    def gps_wrong(self) -> FaultKindGpsWrong:
        """The position is wrong; the velocity is right."""

    @section
    def late_release(self) -> FaultKindLateRelease:
        """The parachute lets go later than it is asked to."""

    @section
    def riser_hung_up(self) -> FaultKindRiserHungUp:
        """One leg of the bridle stays fixed at the release, and the canopy (parachute.canopy) pulls by it until the
        fault's end.
        """


class FaultyRotor(Part):
    """A rotor."""

    @leaf
    def rotor(self) -> int:
        """Number of the rotor, from 1, in the order of the vehicle's file."""


class FaultKindMotorSlow(Part):
    """The motor follows its command late."""

    @leaf
    def rotor(self) -> int:
        """Number of the rotor, from 1."""

    @leaf
    def lag_s(self) -> float:
        """Time constant of a first-order lag of the command [s]."""


class FaultKindMotorWeak(Part):
    """The motor turns slower than it is commanded to."""

    @leaf
    def rotor(self) -> int:
        """Number of the rotor, from 1."""

    @leaf
    def factor(self) -> float:
        """Speed that it goes for over the speed commanded."""


class FaultKindGyroDrift(Part):
    """An error of the body rates grows."""

    @listed
    def rate_rad_s2(self) -> Items[float]:
        """Rate of the error, body [rad/s^2]."""


class FaultKindGyroWrong(Part):
    """The body rates are wrong."""

    @listed
    def offset_rad_s(self) -> Items[float]:
        """Error that is added, body [rad/s]; 0 when left out."""

    @leaf
    def scale(self) -> float | None:
        """Factor on them; 1 when left out."""


class FaultKindAccelerometerDrift(Part):
    """An error of the specific force grows."""

    @listed
    def rate_m_s3(self) -> Items[float]:
        """Rate of the error, body [m/s^3]."""


class FaultKindAccelerometerWrong(Part):
    """The specific force is wrong."""

    @listed
    def offset_m_s2(self) -> Items[float]:
        """Error that is added, body [m/s^2]; 0 when left out."""

    @leaf
    def scale(self) -> float | None:
        """Factor on it; 1 when left out."""


class FaultKindMagnetometerDrift(Part):
    """An error of the field grows."""

    @listed
    def rate_gauss_s(self) -> Items[float]:
        """Rate of the error, body [gauss/s]."""


class FaultKindMagnetometerWrong(Part):
    """The field is wrong."""

    @listed
    def offset_gauss(self) -> Items[float]:
        """Error that is added, body [gauss]; 0 when left out."""

    @leaf
    def scale(self) -> float | None:
        """Factor on it; 1 when left out."""


class FaultKindBarometerDrift(Part):
    """An error of the pressure grows."""

    @leaf
    def rate_hpa_s(self) -> float:
        """Rate of the error [hPa/s]."""


class FaultKindBarometerWrong(Part):
    """The pressure is wrong."""

    @leaf
    def offset_hpa(self) -> float | None:
        """Error that is added [hPa]; 0 when left out."""

    @leaf
    def scale(self) -> float | None:
        """Factor on it; 1 when left out."""


class FaultKindGpsDrift(Part):
    """An error of the position grows; the velocity is right."""

    @listed
    def rate_ned_m_s(self) -> Items[float]:
        """Rate of the error, NED [m/s]."""


class FaultKindGpsWrong(Part):
    """The position is wrong; the velocity is right."""

    @listed
    def offset_ned_m(self) -> Items[float]:
        """Error that is added, NED [m]."""


class FaultKindLateRelease(Part):
    """The parachute lets go later than it is asked to."""

    @leaf
    def delay_s(self) -> float:
        """By how much [s]."""


class FaultKindRiserHungUp(Part):
    """One leg of the bridle stays fixed at the release, and the canopy (parachute.canopy) pulls by it until the fault's
    end.
    """

    @listed
    def attachment_body_m(self) -> Items[float]:
        """Where the leg is fixed, from the centre of mass, body axes [m]."""


class VehicleDocument(Document, kind="vehicle"):
    """A multirotor: mass, rotors, body aerodynamics, rotor and motor models. Body axes: x forward, y right, z down."""

    @leaf
    def about(self) -> str | None:
        """Description of the vehicle, for the reader."""

    @leaf
    def name(self) -> str:
        """Name of the vehicle."""

    @leaf
    def mass_kg(self) -> float:
        """Mass [kg]."""

    @listed
    def inertia_kg_m2(self) -> Items[float]:
        """Moments of inertia about the centre of mass, Jxx, Jyy, Jzz [kg m^2]. Each is at most the sum of the others.
        """

    @listed
    def inertia_off_diagonal_kg_m2(self) -> Items[float]:
        """Off-diagonal entries Jxy, Jxz, Jyz of the inertia matrix [kg m^2], with the sign that they have in the
        matrix; 0 when left out.
        """

    @listed
    def rotors(self) -> Items[Rotor]:
        """The rotors, 1 to 8, in PX4's order (quad-X: front right, rear left, front left, rear right)."""

    @section
    def coaxial(self) -> Coaxial:
        """What the upper rotor of a coaxial pair leaves to the lower one; without it each rotor works as if alone."""

    @section
    def effects(self) -> Effects:
        """Which reactions of the rotors on the body are modelled."""

    @section
    def body_aero(self) -> BodyAero:
        """Body aerodynamics, (13)-(18); none when left out."""

    @section
    def rotor(self) -> RotorModel:
        """The rotor model, the same for all rotors."""

    @section
    def rotor_factors(self) -> RotorFactors:
        """Factors on thrust and torque of the rotor model, as flights have shown them; 1 when left out."""

    @section
    def motor(self) -> Motor:
        """The motor model, the same for all rotors."""

    @section
    def rotor_start(self) -> RotorStart:
        """Rotors before their motors drive them, and their start; without it rotors are held at rest until t = 0, and
        driven from there on.
        """

    @section
    def uncertain(self) -> Uncertain:
        """How far numbers of the vehicle may be off; missions draw it, and may override it."""

    @listed
    def estimated(self) -> Items[str]:
        """Keys of this file whose numbers are estimated or guessed, neither measured nor given by a data sheet, as
        paths (`inertia_kg_m2`, `motor.first_order.tau_up_s`); a section's key stands for all that is in it. None: `[]`.
        A release card asks for their acceptance, also where this key is left out, since nobody knows then.
        """

    @listed
    def origins(self) -> Items[Origin]:
        """Where numbers of this file are from, as data: each key once. Those estimated or guessed count as `estimated`,
        too.
        """

    @listed
    def provenance(self) -> Items[str]:
        """Where the numbers come from, for the reader."""


class Rotor(Part):
    """Where a rotor sits, which way it pushes and turns."""

    @listed
    def position_body_m(self) -> Items[float]:
        """Hub, from the centre of mass, body axes [m]."""

    @listed
    def axis_body(self) -> Items[float]:
        """Unit vector of the thrust, body axes; [0, 0, -1] pushes up."""

    @leaf
    def spin_from_above(self) -> Literal["cw", "ccw"]:
        """Sense of rotation, seen from above. `cw`: Clockwise. `ccw`: Counter-clockwise."""


class Coaxial(Part):
    """Interference of coaxial rotors, steady. A rotor is a lower one when another sits on its axis, ahead of it in the
    direction of its thrust; it works in that one's wake, whatever the speed of that one. The upper rotor works as if
    alone.
    """

    @leaf
    def about(self) -> str | None:
        """Where the factors come from."""

    @leaf
    def lower_thrust_factor(self) -> float:
        """Thrust of a lower rotor over that of the same rotor alone, at the same speed."""

    @leaf
    def lower_torque_factor(self) -> float:
        """Torque of the air on a lower rotor over that on the same rotor alone, at the same speed."""


class Effects(Part):
    """Which reactions of the rotors on the body are modelled."""

    @leaf
    def about(self) -> str | None:
        """Remarks for the reader."""

    @leaf
    def reaction_torque(self) -> bool:
        """The torque that turns a rotor turns the body the other way."""

    @leaf
    def rotor_momentum(self) -> bool:
        """The rotors' angular momentum acts on the body, (19)-(22)."""


class BodyAero(Part):
    """Either `drag_area_m2`, or coefficients over the angle of attack with their reference area and span; a periodic
    cubic spline runs through the coefficients. Both may have `side_drag_area_m2` beside them.
    """

    @leaf
    def about(self) -> str | None:
        """Where the coefficients come from."""

    @leaf
    def drag_area_m2(self) -> float | None:
        """Drag area at every angle of attack; without lift and moment. Stands instead of all other keys but
        side_drag_area_m2 [m^2].
        """

    @leaf
    def side_drag_area_m2(self) -> float | None:
        """Drag area of flow across the plane of symmetry, which gives a side force; where left out there is none, as in
        the paper [m^2].
        """

    @leaf
    def reference_area_m2(self) -> float | None:
        """Reference area S [m^2]."""

    @leaf
    def reference_span_m(self) -> float | None:
        """Reference span b [m]."""

    @listed
    def alpha_deg(self) -> Items[float]:
        """Angles of attack, increasing from -180 to 180 [deg]; five do: -180, -90, 0, 90, 180."""

    @listed
    def c_drag(self) -> Items[float]:
        """Drag coefficient at each angle, (13)."""

    @listed
    def c_lift(self) -> Items[float]:
        """Lift coefficient at each angle, (14)."""

    @listed
    def c_pitch(self) -> Items[float]:
        """Pitching moment coefficient at each angle, (15)."""


class RotorModel(Choice):
    """The rotor model."""

    @section
    def blade_element(self) -> BladeElement:
        """Thrust, in-plane force and torque of known blades in any flow, from rest on."""

    @section
    def table(self) -> RotorTable:
        """Thrust and torque by table over rotor speed, airspeed and flow angle."""

    @section
    def quadratic(self) -> Quadratic:
        """Thrust = k omega^2, torque = c thrust, in-plane force = h omega V."""


class RotorFactors(Part):
    """Factors on what the rotor model has."""

    @leaf
    def about(self) -> str | None:
        """Where the factors come from."""

    @leaf
    def thrust_factor(self) -> float:
        """Factor on the thrust, and on the force in the rotor's plane."""

    @leaf
    def torque_factor(self) -> float:
        """Factor on the torque of the air."""


class Motor(Choice):
    """The motor with its speed controller."""

    @section
    def esc_dc(self) -> EscDc:
        """Speed controller and DC motor with limits of voltage and current."""

    @section
    def first_order(self) -> FirstOrder:
        """First-order lag with separate time constants up and down."""


class RotorStart(Part):
    """Rotors before their motors drive them, and how the speed controllers start them, in drops; flights from t = 0
    begin with rotors at rest that are driven at once. Wants a rotor of `blade_element`.
    """

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @leaf
    def before(self) -> Literal["braked", "free"]:
        """How the rotors are before t = 0. `braked`: Held at rest. `free`: Turning as the air drives them, backwards in
        a descent.
        """

    @leaf
    def friction_nm(self) -> float:
        """Friction of a shaft that its motor does not drive, cogging with it [N m]."""

    @section
    def esc(self) -> EscStart:
        """How the speed controllers start; at once and from any speed when left out."""


class Origin(Part):
    """Where numbers of the file are from."""

    @listed
    def keys(self) -> Items[str]:
        """Keys of the numbers, as paths (`inertia_kg_m2`, `motor.first_order.tau_up_s`); a section's key stands for all
        that is in it.
        """

    @leaf
    def kind(self) -> Literal["measured", "given", "estimated", "guessed"]:
        """How they came to be known. `measured`: Measured on the vehicle, or read off its logs. `given`: Given by a
        data sheet, a drawing or a file of another program. `estimated`: Computed from other numbers by a formula.
        `guessed`: Assumed.
        """

    @leaf
    def file(self) -> str | None:
        """The file, page or address that they are from."""

    @leaf
    def formula(self) -> str | None:
        """The formula that they were computed by, or how they were measured, in words."""


class BladeElement(Part):
    """Known blades by blade elements and momentum theory, with the vortex ring and the windmill brake; the coefficients
    stand in a CSV file, which `samara rotor` makes of the other keys.
    """

    @leaf
    def about(self) -> str | None:
        """Where the blades come from."""

    @leaf
    def file(self) -> str:
        """CSV file of the coefficients, relative to this file."""

    @leaf
    def radius_m(self) -> float:
        """Radius [m]."""

    @leaf
    def blades(self) -> int:
        """Number of blades."""

    @listed
    def radius_share(self) -> Items[float]:
        """Stations along a blade, increasing from the root cut-out to the tip, as shares of the radius; pitch and chord
        are linear between them.
        """

    @listed
    def chord_share(self) -> Items[float]:
        """Chord over the radius at each station."""

    @listed
    def pitch_deg(self) -> Items[float]:
        """Pitch of the chord against the rotor's plane at each station [deg]."""

    @leaf
    def tip_loss(self) -> float | None:
        """Share of the radius inside which the blades lift (tip loss); 0.97 when left out."""

    @section
    def profile(self) -> Profile:
        """Profile of the blades."""


class RotorTable(Part):
    """A table of thrust and torque, in a CSV file."""

    @leaf
    def about(self) -> str | None:
        """How the table was made."""

    @leaf
    def file(self) -> str:
        """CSV file, relative to this file; columns omega_rad_s, airspeed_m_s, angle_deg, thrust_n, torque_nm, a full
        grid with the angle running fastest, then the airspeed.
        """

    @leaf
    def density_kg_m3(self) -> float:
        """Density that the table holds for; thrust and torque scale with density [kg/m^3]."""

    @leaf
    def radius_m(self) -> float | None:
        """Radius [m]."""


class Quadratic(Part):
    """Thrust = k omega^2, torque = c thrust, in-plane force = h omega V."""

    @leaf
    def about(self) -> str | None:
        """Where the coefficients come from."""

    @leaf
    def thrust_n_per_rad2_s2(self) -> float:
        """Thrust coefficient k [N/(rad/s)^2]."""

    @leaf
    def torque_per_thrust_m(self) -> float:
        """Torque per thrust, c [m]."""

    @leaf
    def drag_n_s2_per_rad_m(self) -> float | None:
        """Force in the rotor's plane, against its motion, over rotor speed and speed across the axis
        [N/((rad/s)(m/s))], as rotorDragCoefficient of Gazebo's motor model; none when left out.
        """

    @leaf
    def density_kg_m3(self) -> float:
        """Density that thrust and drag hold for [kg/m^3]."""

    @leaf
    def radius_m(self) -> float | None:
        """Radius [m]."""


class EscDc(Part):
    """Speed controller and DC motor."""

    @leaf
    def omega_max_rad_s(self) -> float:
        """Rotor speed at full throttle [rad/s]."""

    @leaf
    def torque_constant_nm_a(self) -> float:
        """Torque per current [N m/A]."""

    @leaf
    def back_emf_constant_v_s_rad(self) -> float:
        """Voltage per speed [V s/rad]."""

    @leaf
    def resistance_ohm(self) -> float:
        """Resistance of the winding [ohm]."""

    @leaf
    def voltage_max_v(self) -> float:
        """Largest voltage [V]."""

    @leaf
    def current_max_a(self) -> float:
        """Largest current [A]."""

    @leaf
    def current_min_a(self) -> float:
        """Smallest current [A]; 0: no active braking, negative: braking."""

    @leaf
    def esc_gain_v_s_rad(self) -> float:
        """Voltage per speed error [V s/rad]."""

    @leaf
    def rotor_inertia_kg_m2(self) -> float:
        """Moment of inertia of rotor and motor about the shaft [kg m^2]."""


class FirstOrder(Part):
    """First-order lag of the rotor speed."""

    @leaf
    def omega_max_rad_s(self) -> float:
        """Rotor speed at full throttle [rad/s]."""

    @leaf
    def tau_up_s(self) -> float:
        """Time constant speeding up [s]."""

    @leaf
    def tau_down_s(self) -> float:
        """Time constant slowing down [s]."""

    @leaf
    def rotor_inertia_kg_m2(self) -> float:
        """Moment of inertia of rotor and motor about the shaft [kg m^2], for the gyroscopic moment."""


class EscStart(Part):
    """How a speed controller without sensors starts a motor: below the catch speed blindly, in tries."""

    @leaf
    def about(self) -> str | None:
        """Where the numbers come from."""

    @leaf
    def start_torque_nm(self) -> float:
        """Torque of a try on a rotor at rest or turning forwards [N m]."""

    @leaf
    def brake_torque_nm(self) -> float:
        """Torque of a try on a rotor that turns backwards, which brakes it [N m]."""

    @leaf
    def catch_speed_rad_s(self) -> float:
        """Speed forwards from which the controller knows where the rotor is [rad/s]; what is commanded slower is off.
        """

    @leaf
    def try_s(self) -> float:
        """Time of a try [s]."""

    @leaf
    def tries(self) -> int:
        """Tries before the controller gives up, until its command goes."""

    @leaf
    def wait_s(self) -> float:
        """Time without current between two tries [s]."""


class Profile(Part):
    """Lift and drag of a blade's profile: a straight line of lift up to the stall, a flat plate beyond it."""

    @leaf
    def about(self) -> str | None:
        """Where the profile comes from."""

    @leaf
    def lift_slope_per_rad(self) -> float:
        """Slope of the lift coefficient [1/rad]."""

    @leaf
    def zero_lift_deg(self) -> float:
        """Angle of attack without lift [deg]; negative for a cambered profile."""

    @listed
    def stall_lift(self) -> Items[float]:
        """Lift coefficients of the stall, lowest (negative) and highest."""

    @leaf
    def drag_min(self) -> float:
        """Least drag coefficient."""

    @leaf
    def lift_at_drag_min(self) -> float:
        """Lift coefficient of the least drag."""

    @leaf
    def drag_rise(self) -> float:
        """Rise of the drag coefficient with the square of the lift coefficient."""

    @leaf
    def drag_across(self) -> float:
        """Drag coefficient across the flow, over the least."""


class Gains(Document, kind="gains"):
    """Gains of the cascade, acceleration-normalised: they carry neither mass nor inertia. Table 4, and yaw."""

    @leaf
    def about(self) -> str | None:
        """Where the gains come from."""

    @leaf
    def name(self) -> str:
        """Name of the set."""

    @leaf
    def k_pq_per_s(self) -> float:
        """Pitch (and roll) rate, proportional [1/s]."""

    @leaf
    def k_iq_per_s2(self) -> float:
        """Pitch (and roll) rate, integral [1/s^2]."""

    @leaf
    def k_ptheta_per_s(self) -> float:
        """Pitch (and roll) angle, proportional [1/s]."""

    @leaf
    def k_pvz_per_s(self) -> float:
        """Vertical velocity, proportional [1/s]."""

    @leaf
    def k_ivz_per_s2(self) -> float:
        """Vertical velocity, integral [1/s^2]."""

    @leaf
    def k_pvx_per_s(self) -> float:
        """Horizontal velocity, proportional [1/s]."""

    @leaf
    def k_ivx_per_s2(self) -> float:
        """Horizontal velocity, integral [1/s^2]."""

    @leaf
    def k_ppsi_per_s(self) -> float:
        """Heading, proportional [1/s]."""

    @leaf
    def k_pr_per_s(self) -> float:
        """Yaw rate, proportional [1/s]."""
