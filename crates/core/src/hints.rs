//! A hint behind every no: what mostly causes it, and the command that looks closer or mends it.
//!
//! One table, that of [`No`], has the noes of the judge, of planning, of `samara check`, of searches and of
//! the reference autopilot. What says a no gives its [`No`], so that none can be said that has no row; what
//! comes over the wire as text is found by its words, [`No::of_words`]. The page "My drop is not safe: what
//! now" is [`page`].

/// What stands for the mission in a [`Hint`]'s command.
const MISSION: &str = "MISSION";

/// A no, with what there is to say of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hint {
    /// The no.
    pub no: No,
    /// Name in files.
    pub name: &'static str,
    /// How it is said: the words of an autopilot to the letter, of others the gist.
    pub said: &'static str,
    /// What mostly causes it, a sentence without a full stop.
    pub cause: &'static str,
    /// The command that looks closer or mends it, with MISSION for the mission.
    pub command: &'static str,
    /// What `samara check` finds that would explain it, the likeliest first.
    pub explained_by: &'static [No],
}

impl Hint {
    /// The words of the command for a mission.
    pub fn command_for(&self, typed: &Typed) -> Vec<String> {
        // A plan has no gains.
        let takes_gains = !self.command.starts_with("samara plan ");
        let gains = typed.gains.iter().filter(|_| takes_gains);
        let mission: Vec<String> = typed.mission.iter().chain(gains).cloned().collect();
        let words = self.command.split(' ');
        words.flat_map(|word| if word == MISSION { mission.clone() } else { vec![word.to_owned()] }).collect()
    }
}

/// A mission as commands name it: words, not quoted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Typed {
    /// Name or file, and the values that were set in it.
    pub mission: Vec<String>,
    /// The option of its gains, where others than its own were chosen.
    pub gains: Vec<String>,
}

/// Noes of one kind, as the page has them.
struct Section {
    title: &'static str,
    about: &'static str,
    hints: &'static [Hint],
}

macro_rules! noes {
    ($($section:ident $title:literal, $about:literal { $(
        $no:ident $name:literal $said:literal $cause:literal $command:literal $([$($by:ident),+])?;
    )+ })+) => {
        /// A kind of no.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum No {
            $($(#[doc = concat!("Said as: ", $said, ".")] $no,)+)+
        }

        impl No {
            /// What there is to say of it.
            pub const fn hint(self) -> &'static Hint {
                match self {
                    $($(Self::$no => &Hint {
                        no: Self::$no,
                        name: $name,
                        said: $said,
                        cause: $cause,
                        command: $command,
                        explained_by: &[$($(No::$by),+)?],
                    },)+)+
                }
            }
        }

        $(const $section: &[Hint] = &[$(*No::$no.hint()),+];)+

        const SECTIONS: &[Section] =
            &[$(Section { title: $title, about: $about, hints: $section }),+];
    };
}

noes! {
    VERDICT "A drop is not safe", "The judge's words stand after \"NOT safe\". What `samara check` finds comes first:
where it explains the no, its words are the cause that is shown." {
    Speed "speed" "J_TPF at or over its bound: speed"
        "the fall with stopped rotors adds gravity times `parachute.delay_s` to the rate of descent, and the pull-out has too little thrust or comes too late for `limits.speed_m_s`"
        "samara plan MISSION" [TooWeak, ReleasePassesLimits, ThrustToWeight, PlanFails, CannotControl, LoopsUnstable];
    Pitch "pitch" "J_TPF at or over its bound: pitch"
        "the plan or the cascade tilts further than `limits.pitch_deg`: the target is fast, the swing is large, or the commanded tilt may go as far as the limit"
        "samara study sobol MISSION" [LoopsUnstable, LoopsLackMargin, GainsOutsideTheRule, ReleasePassesLimits, PlanFails];
    PitchRate "pitch_rate" "J_TPF at or over its bound: pitch rate"
        "a pitch or pitch-rate loop near instability, a tip-off at the release, or a plan that turns as fast as `limits.pitch_rate_deg_s`"
        "samara study sobol MISSION" [LoopsUnstable, LoopsLackMargin, GainsOutsideTheRule, Inertia, ReleasePassesLimits];
    Roll "roll" "J_TPF at or over its bound: roll"
        "wind or a swing across the plan's plane, or a roll loop near instability"
        "samara study sobol MISSION" [LoopsUnstable, LoopsLackMargin, GainsOutsideTheRule, ReleasePassesLimits];
    RollRate "roll_rate" "J_TPF at or over its bound: roll rate"
        "a roll or roll-rate loop near instability, or a tip-off about the roll axis"
        "samara study sobol MISSION" [LoopsUnstable, LoopsLackMargin, GainsOutsideTheRule, Inertia];
    JTpf "j_tpf" "J_TPF at or over its bound"
        "`--bound` asks for more room than the limits themselves"
        "samara design MISSION" [LoopsUnstable, ReleasePassesLimits];
    NotFinite "not_finite" "a state is no number"
        "the flight ran away: an unstable loop, or a vehicle in other units"
        "samara check MISSION" [LoopsUnstable, GainsOutsideTheRule, Inertia, CannotControl];
    Tilt "tilt" "tilt over its limit"
        "the commanded tilt may go as far as `limits.tilt_deg`, and the cascade overshoots it"
        "samara design MISSION" [LoopsUnstable, LoopsLackMargin, GainsOutsideTheRule];
    AltitudeLost "altitude_lost" "altitude lost over its limit"
        "fall and pull-out need more height than `limits.altitude_lost_m` leaves: a shorter `parachute.delay_s`, more thrust or a target with less descent takes less"
        "samara plan MISSION" [TooWeak, ThrustToWeight, SlowLoop];
    SteadyAfter "steady_after" "steady too late"
        "the velocity loops are slow, or their integral gains too small to take the wind out in time"
        "samara tune MISSION" [SlowLoop, GainsOutsideTheRule, LoopsLackMargin];
    NeverSteady "never_steady" "never steady"
        "wind that the integral gains have not taken out, turbulence judged without `limits.steady_mean_over_s`, or a target that no steady flight reaches"
        "samara study effects MISSION" [LoopsUnstable, SlowLoop, TargetNeedsThrust, GainsOutsideTheRule, LoopsLackMargin];
    Impact "impact" "impact too fast"
        "the vehicle came to the ground faster than `limits.impact_speed_m_s`: it had not been slowed by then"
        "samara check MISSION" [RoomBelow, SlowLoop];
    ImpactTilt "impact_tilt" "tilted at the touch"
        "the vehicle came to the ground tilted: wind, or it was still under way to the target"
        "samara check MISSION" [RoomBelow, SlowLoop];
    Separation "separation" "closer to the canopy than allowed"
        "the canopy sinks onto the vehicle or drifts with it: a target across the wind and a longer `parachute.delay_s` part them"
        "samara study effects MISSION" [TwoBodies];
    OnTheGround "on_the_ground" "on the ground before the plan's end"
        "the release is lower than what fall and pull-out take"
        "samara check MISSION" [RoomBelow, TooWeak, ThrustToWeight, LoopsUnstable];
    NeverReleased "never_released" "the vehicle was never released"
        "nobody gave the release, or the autopilot was not ready for it: armed and in OFFBOARD before `release.hang_s`"
        "samara doctor" [DurationShort];
    ReleasedUnarmed "released_unarmed" "released while the autopilot was not armed"
        "the autopilot was not asked to arm in time, or refused: its words stand above"
        "samara doctor";
    MotorsNeverStarted "motors_never_started" "the motors were never started"
        "no throttle came after the release: the mode was not OFFBOARD, or the outputs are not the simulator's (PX4: HIL_ACT_FUNC)"
        "samara doctor";
    Failsafe "failsafe" "a failsafe flew"
        "setpoints, data link, position or battery were lost for longer than the autopilot's parameters allow; its line above says which"
        "samara params list";
    Trouble "trouble" "the autopilot left or refused"
        "the autopilot's own words are the reason"
        "samara doctor";
    Stopped "stopped" "stopped before the mission's end"
        "Ctrl-C, a time limit, or a party that left"
        "samara drop MISSION";
    PlanCut "plan_cut" "the mission ended before the plan"
        "`duration_s` is less than hang, fall and `plan.horizon_s` together"
        "samara check MISSION" [DurationShort];
    }
    PLAN "There is no plan", "`samara plan` says how the solve ended; these are its statuses." {
    PlanBudget "iteration_limit" "the iteration budget is used up"
        "many nodes or a start far from the target take more iterations than the usual 300"
        "samara plan MISSION --max-iterations 3000" [TooWeak, ReleasePassesLimits, PlanThrust];
    PlanStopped "plan_stopped" "the solve was stopped"
        "Ctrl-C, or `--time-limit`"
        "samara plan MISSION --verbose";
    PlanInfeasible "infeasible" "no trajectory satisfies dynamics and bounds"
        "the horizon is too short, thrust or its rate too small for the fall that the plan begins with, or bounds shut the target out"
        "samara plan MISSION --verbose" [TargetNeedsThrust, ThrustToWeight, ReleasePassesLimits, PlanThrust];
    TooWeak "too_weak" "steady flight at the target needs more thrust than a rotor may give"
        "`plan.thrust_max_n` is too small for the weight in this air, or the target too fast"
        "samara check MISSION" [ThrustToWeight, OtherAir, Inertia];
    PullsDown "pulls_down" "steady flight at the target needs thrust below zero"
        "the air carries more than the weight at the target: it sinks, or flies, too fast for this vehicle"
        "samara check MISSION";
    PlanBounds "plan_bounds" "bounds contradict the end of the plan"
        "a bound on the motion leaves out the target's velocity"
        "samara check MISSION";
    PlanStalled "stalled" "no step gets nearer to the optimum"
        "the tolerance asks for more digits than rounding leaves"
        "samara plan MISSION --tolerance 1e-6";
    PlanDiverged "diverged" "the iterates left the model's range"
        "a vehicle in other units, or a start beyond the model's range"
        "samara check MISSION" [Inertia, CannotControl, ReleasePassesLimits];
    PlanNodes "nodes" "too few nodes"
        "the flight between the nodes is not the plan's: more nodes make it so"
        "samara plan MISSION --nodes 100";
    PlanUnposed "unposed" "the plan cannot be posed"
        "no steady flight is known at the target, or the plan is made for 4, 6 or 8 rotors and the vehicle has others"
        "samara check MISSION";
    }
    CHECK "`samara check` finds something odd", "Each finding names its key and its number." {
    PlanThrust "plan_thrust" "plan.thrust_max_n: more than a rotor makes"
        "a number of a data sheet, of other propellers or of denser air; without the key the rotor's own is taken in new missions"
        "samara study effects MISSION";
    PlanSlew "plan_slew" "plan.thrust_slew_n_s: faster than a rotor's thrust comes and goes"
        "a plan that no motor follows: the rate in the finding is the motors'"
        "samara plan MISSION";
    ThrustToWeight "thrust_to_weight" "the rotors lift too little of the weight"
        "thin air, a heavy load, or thrust that was measured with another battery; a draft with its true mass and altitude says what is missing"
        "samara new vehicle --help";
    Descent "descent" "parachute.descent_m_s: faster than the vehicle falls alone"
        "the canopy's drag is less than the vehicle's own: another unit, or another planet's number"
        "samara check MISSION --json";
    ReleasePassesLimits "release_passes_limits" "limits: passed by the release already"
        "the speed at t = 0, descent and fall, is beyond `limits.speed_m_s`: a shorter `parachute.delay_s`, a slower descent or a higher limit"
        "samara check MISSION --set parachute.delay_s=0.2s";
    SteadyWide "steady_wide" "limits.steady_within_m_s: more than half of limits.speed_m_s"
        "steady flight that wide is no answer"
        "samara check MISSION --set limits.steady_within_m_s=0.3";
    SteadyLong "steady_long" "limits.steady_mean_over_s: longer than the plan"
        "the mean is taken over more than there is"
        "samara check MISSION --set limits.steady_mean_over_s=2s";
    TwoBodies "two_bodies" "the two bodies of the parachute move otherwise"
        "numbers of one pendulum beside a canopy that is a body: the canopy's own motion is what flies"
        "samara study effects MISSION";
    Inertia "inertia" "inertia that no such vehicle has"
        "g cm^2 or kg mm^2 typed as kg m^2, or the whole vehicle's number for one arm"
        "samara new vehicle --help";
    RotorsMeet "rotors_meet" "propellers meet"
        "an arm or a diameter in another unit, or the arm measured from motor to motor"
        "samara new vehicle --help";
    Wake "wake" "a rotor in another's wake without a factor"
        "rotors on one axis without `coaxial`"
        "samara new vehicle --help";
    OtherAir "other_air" "site.density_kg_m3: air of another altitude"
        "a density of sea level at an altitude, or of another planet"
        "samara study effects MISSION";
    CannotControl "cannot_control" "the cascade cannot control the vehicle"
        "rotors that make no moment about an axis, all turning one way, or fewer than four"
        "samara new vehicle --help";
    BatteryTooWeak "battery_too_weak" "battery.electric: more than the battery can give"
        "cells, capacity or resistance of another pack, or current limits of another speed controller"
        "samara check MISSION --json";
    RotorStarts "rotor_start" "rotor_start.esc: a rotor does not catch"
        "the rotor windmills faster than its speed controller can brake and start"
        "samara study effects MISSION";
    TargetNeedsThrust "target_thrust" "steady flight at the target is beyond the rotors"
        "a target that is too fast, or in the vortex ring, for this thrust"
        "samara plan MISSION";
    DurationShort "duration_short" "duration_s: the plan goes on longer"
        "hang, fall and horizon together are longer than the mission"
        "samara drop MISSION --set duration_s=60s";
    PlanFails "plan_fails" "plan: the solve does not converge"
        "`samara plan` says how it ended and where"
        "samara plan MISSION";
    RoomBelow "room_below" "site.ground_altitude_m: too little room below the release"
        "the release is too low for fall and pull-out, or the ground's altitude is one above another zero"
        "samara plan MISSION";
    LoopsUnstable "loops_unstable" "loops are unstable"
        "gains of another vehicle, too high for the lag of motors and commands"
        "samara tune MISSION";
    LoopsLackMargin "loops_lack_margin" "a loop keeps less to instability than it should"
        "gains that are high for the lag of motors and commands, or motors and thrust that may be off by much"
        "samara design MISSION";
    SlowLoop "slow_loop" "a velocity loop is too slow for the mission"
        "velocity gains of another vehicle, or integral gains of nearly nothing"
        "samara tune MISSION";
    GainsOutsideTheRule "gains_outside_the_rule" "gains outside the range about the rule for the vehicle"
        "gains of another vehicle"
        "samara tune MISSION";
    GainsLean "gains_lean" "gains lean on the old search box"
        "they were searched in the paper's range, made for a lander of 790 kg"
        "samara design MISSION";
    }
    SEARCH "A search finds nothing better", "`tune` and `design` say which numbers stand at a wall, and what breaks a bound." {
    AtAWall "at_a_wall" "numbers stand at an end of their range"
        "the best may lie beyond: the range is the rule's for the vehicle, or PX4's own, and the lag of motors and commands sets how high gains may be"
        "samara check MISSION";
    NotBetter "not_better" "not better than the mission's own"
        "the mission's own is as good as chance can tell: more candidates may find a better one"
        "samara design MISSION --budget 1000";
    BreaksABound "breaks_a_bound" "breaks a bound or passes a limit"
        "in this air no design that was tried keeps all limits and margins: more thrust, a gentler release, or wider limits are wanted"
        "samara study sobol MISSION" [LoopsUnstable, ThrustToWeight, ReleasePassesLimits];
    NoGainsFly "no_gains_fly" "no gains were found that fly it"
        "the vehicle is too weak or too slow for this release: the guess that is written loses its drops"
        "samara check MISSION" [TooWeak, ThrustToWeight, PlanThrust, RoomBelow, ReleasePassesLimits, Inertia];
    NothingJudged "nothing_judged" "stopped before anything was judged"
        "the search ended before its finalists had flown"
        "samara design MISSION --resume";
    }
    AUTOPILOT "The autopilot refuses", "Words of the reference autopilot, which are PX4's where it has such; PX4 itself may say
more, by events." {
    WaitsForInertial "waits_for_inertial" "estimator waits for accelerometer and gyro"
        "no HIL_SENSOR comes: the simulator is not connected, or waits"
        "samara doctor";
    WaitsForField "waits_for_field" "estimator waits for the magnetometer"
        "HIL_SENSOR comes without its magnetometer bits, or a fault has stopped it"
        "samara faults";
    WaitsForPressure "waits_for_pressure" "estimator waits for the barometer"
        "HIL_SENSOR comes without its barometer bits, or a fault has stopped it"
        "samara faults";
    WaitsForFix "waits_for_fix" "estimator waits for a GPS fix"
        "no HIL_GPS has come yet, or a fault has stopped it"
        "samara faults";
    NothingCarries "nothing_carries" "estimator waits: nothing carries the vehicle"
        "it falls: the estimator begins under the canopy or on the ground"
        "samara sim MISSION";
    EstimatorStarts "estimator_starts" "estimator is starting"
        "all sensors are heard: it takes a quarter of a second more"
        "samara sim MISSION";
    TiltUncertain "tilt_uncertain" "estimator: tilt uncertain"
        "a swing that has not been seen long enough: a longer `release.hang_s` gives it time"
        "samara sim MISSION --set release.hang_s=30s";
    HeadingUncertain "heading_uncertain" "estimator: heading uncertain"
        "a magnetometer that disagrees, or a site whose field is not the world's"
        "samara sim MISSION --set release.hang_s=30s";
    VelocityUncertain "velocity_uncertain" "estimator: velocity uncertain"
        "few or late GPS fixes: a longer `release.hang_s` gives it time"
        "samara sim MISSION --set release.hang_s=30s";
    NoFixBelieved "no_fix_believed" "estimator: no GPS fix it believes"
        "fixes that jump or disagree with the accelerometer, as a fault or a wrong home makes them"
        "samara faults";
    NoState "no_state" "Arming denied: no attitude and velocity yet"
        "the simulator has sent nothing yet"
        "samara sim MISSION";
    StaleState "stale_state" "Arming denied: attitude and velocity are stale"
        "the simulator stands still or has left: nothing has come for half a second"
        "samara doctor";
    TiltedToArm "tilted_to_arm" "Arming denied: tilted by more than 60 deg"
        "the swing or the attitude at the start is beyond what PX4 arms in"
        "samara check MISSION";
    NoSticks "no_sticks" "no manual control input"
        "a mode that is flown with sticks, and no MANUAL_CONTROL comes: connect a joystick in the ground station, or choose OFFBOARD or HOLD"
        "samara params list";
    HighThrottle "high_throttle" "Arming denied: high throttle"
        "the throttle stick is not at the bottom"
        "samara params list";
    ThrottleAboveCenter "throttle_above_center" "Arming denied: throttle above center"
        "the throttle stick asks for a climb"
        "samara params list";
    NoOffboardSignal "no_offboard_signal" "Arming denied: no offboard signal"
        "OFFBOARD wants setpoints before it is armed: stream them at 2 Hz or more first"
        "samara stream --help";
    NoSetpoint "no_setpoint" "OFFBOARD refused: no setpoint"
        "OFFBOARD wants setpoints before it is chosen: stream them at 2 Hz or more first"
        "samara stream --help";
    NoMission "no_mission" "no valid mission"
        "no mission was uploaded, or one with items that are not flown"
        "samara autopilot --help";
    Terminated "terminated" "flight terminated, start the autopilot again"
        "a failsafe has stopped the motors for good"
        "samara params list";
    ModeNotFlown "mode_not_flown" "is not flown here"
        "the reference autopilot flies OFFBOARD, HOLD, TAKEOFF, LAND, RETURN, MISSION and the modes of sticks"
        "samara autopilot --help";
    NoPosition "no_position" "refused: no valid position estimate"
        "the estimator has no fix that it believes"
        "samara faults";
    Flying "flying" "Disarming denied: flying (force with 21196)"
        "the motors carry the vehicle: land first, or force it by param2 = 21196"
        "samara autopilot --help";
    SetpointNotFinite "setpoint_not_finite" "setpoint refused: NaN or infinite"
        "a number that the type mask does not ignore is no number"
        "samara stream --help";
    SetpointQuaternion "setpoint_quaternion" "setpoint refused: quaternion not of unit length"
        "the order is w, x, y, z, and its length is one"
        "samara stream --help";
    SetpointThrust "setpoint_thrust" "setpoint refused: thrust must be within 0..1"
        "the thrust of SET_ATTITUDE_TARGET is a part of the greatest, not newtons"
        "samara stream --help";
    SetpointHeading "setpoint_heading" "setpoint refused: no heading known yet"
        "a setpoint in the body's frame came before the first state"
        "samara stream --help";
    }
}

impl No {
    /// The no of an autopilot that is in a text, as it comes over the wire; `None` where there is none that
    /// is known.
    pub fn of_words(text: &str) -> Option<Self> {
        let inside = |hint: &&Hint| text.contains(hint.said);
        // Of words that are part of others the longer ones.
        AUTOPILOT.iter().filter(inside).max_by_key(|hint| hint.said.len()).map(|hint| hint.no)
    }
}

/// All hints, in the order of the page.
pub fn all() -> impl Iterator<Item = &'static Hint> {
    SECTIONS.iter().flat_map(|section| section.hints)
}

/// The page "My drop is not safe: what now", as Markdown.
pub fn page() -> String {
    let mut page = "# My drop is not safe: what now\n\n\
        For whoever was told no. Wherever samara says one, it adds what mostly causes it and a command; this page\n\
        is the table that they come from. `MISSION` stands for a mission's name or file.\n\n\
        First of all: `samara check MISSION` says in a tenth of a second what is odd about the numbers, and\n\
        `samara view MISSION` shows [in the browser](view.md) what another value does, while you turn it.\n"
        .to_owned();
    for Section { title, about, hints } in SECTIONS {
        page += &format!("\n## {title}\n\n{about}\n\n| said | mostly because | then |\n|---|---|---|\n");
        for hint in *hints {
            page += &format!("| {} | {} | `{}` |\n", hint.said, hint.cause, hint.command);
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Names are unlike, sentences have no full stop, and what explains a no is not itself.
    #[test]
    fn closed_form_of_the_table() {
        let names: BTreeSet<&str> = all().map(|hint| hint.name).collect();
        assert_eq!(names.len(), all().count());
        for hint in all() {
            assert!(std::ptr::eq(hint.no.hint().name, hint.name));
            assert!(hint.command.starts_with("samara "), "{}", hint.command);
            for words in [hint.said, hint.cause] {
                assert!(!words.is_empty() && !words.ends_with('.') && !words.contains('|'), "{words}");
            }
            assert!(!hint.explained_by.contains(&hint.no), "{}", hint.name);
        }
    }

    /// Of words that are in others the longer ones are meant.
    #[test]
    fn closed_form_words_are_found_in_a_text() {
        let of = No::of_words;
        assert_eq!(of("Arming denied: estimator: tilt uncertain"), Some(No::TiltUncertain));
        assert_eq!(of("OFFBOARD refused: no setpoint in the last 1 s"), Some(No::NoSetpoint));
        assert_eq!(of("POSCTL refused: no manual control input"), Some(No::NoSticks));
        assert_eq!(of("Takeoff detected"), None);
    }
}
