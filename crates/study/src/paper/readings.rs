//! What the paper leaves open and what is chosen here, what another choice is known to change, and the
//! paper's slips of print: for the page beside the findings. `docs/paper.md` has the same sentences.

use samara_core::control::{ControlLimits, ThrustCurve, TiltFrom};

/// What the paper leaves open, and what is chosen here in the first reading of the control law.
pub const CHOICES: [(&str, &str); 12] = [
    (
        "tilt limit",
        "37.5 deg. The paper prints none; with this one the mean of the first campaign is the paper's 0.81. With 35.5 deg \
         case 0 of Table 5 is the paper's 0.77. Its least J_TPF of that campaign, 0.7744, is a pitch of 34.85 deg.",
    ),
    (
        "tilt and collective",
        "coupled: the wanted acceleration and gravity make one thrust vector, and the pitch command is theta = \
         atan2(-a, up), where up may go to zero. PX4 divides by gravity instead: theta = -atan(a/g).",
    ),
    (
        "priority",
        "the vertical's: the horizontal acceleration has what the vertical one leaves of tilt limit and thrust.",
    ),
    ("anti-windup", "an integral stands still while its command is at a limit and its error pushes further."),
    (
        "velocity errors",
        "in NED. The paper plots velocities in body axes, too, and does not say which are fed back.",
    ),
    (
        "throttle",
        "the square root of the wanted thrust over the largest: the thrust is linearised (PX4's THR_MDL_FAC 1, whose \
         default is 0).",
    ),
    ("rate command", "at most 220 deg/s; the paper prints no limit."),
    (
        "pendulum",
        "0.34 m in the Monte Carlo campaigns, as in the text; Table 3 is flown as printed, and comes out digit by digit \
         with 1.0 m alone.",
    ),
    (
        "initial guess",
        "a straight line from the release to the target, where the paper begins with simulated flights of the \
         near-hover controller; both lead to the same optimum.",
    ),
    (
        "number of intervals",
        "37 between 38 nodes: the paper's dt = t_f/38 and its end points exclude each other. Thrusts start from rest, u_1 = 0.",
    ),
    ("steady state", "(31) as printed, not solved for this vehicle."),
    (
        "motors",
        "63 % of a step of the speed in 0.23 s up and 1.15 s down; the paper has a time constant of about 1 s.",
    ),
];

/// What is chosen of the tilt in the second reading and in the one with a linear throttle.
pub const TILT_FROM_GRAVITY: (&str, &str) = (
    "tilt and collective",
    "from gravity, as in PX4 since v1.12: the pitch command is theta = -atan(a/g), and the collective is what has the wanted \
     part upwards at that tilt, up/cos(theta).",
);

/// What is chosen of the throttle in the reading with a linear one.
pub const LINEAR_THROTTLE: (&str, &str) = (
    "throttle",
    "linear in the wanted thrust T of a rotor, on the line from rest through hover: delta = delta_h T/T_h, where T_h = m g/4 \
     hovers and delta_h = sqrt(T_h/T_max) is its throttle (PX4's THR_MDL_FAC 0). The rotor then gives T^2/T_h, and the \
     controller counts on sqrt(T_h T_max) at full throttle.",
);

/// What is known of other readings of the control law: of two that are flown, and of those that another
/// program of the plane has flown, which agrees with this one in this one's reading.
pub const OTHER_READINGS: [&str; 6] = [
    "Two more readings are flown whole, each by a mission: titan_paper_second sets the tilt against gravity, and \
     titan_paper_linear has a linear throttle, too. Plan, releases, gains and limits are the first's. Nothing was searched for \
     them; the tilt limit was chosen for the first.",
    "With the tilt from gravity the limit cycle of the PSO gains is gone: the velocity's variance falls as figures 11 \
     and 13 have it, the PSO gains beat the near-hover gains, by more than the paper's margin, and J_TPF is higher \
     for negative pitch rates, as in figure 14. Lost are the means of the campaigns, Table 5's column of the PSO \
     gains, and figure 9, for the step's variance falls, too.",
    "With the linear throttle as well the means of the campaigns are the paper's again, and that of the PSO gains is \
     nearer than in the other two. Their margin is less than half of the paper's, figure 14 is lost, and Table 5's \
     column and figure 9 stay so.",
    "Not built here, and flown by another program only, which agrees with samara where it has samara's reading, are velocity \
     errors in body axes and a release whose pitch rate has the sign opposite to (42)'s. With both, on top of the tilt from \
     gravity and the linear throttle, figure 12 comes out as printed, and the mean reduction of Table 5 is 23 to 24 %.",
    "No reading that was tried has figure 10, the step's column of Table 5, which rises with the pitch to 1.01, or the \
     small deviations of the campaigns.",
    "These readings were tried with the paper's figures at hand. They show that the statements can be reached, not what \
     the authors flew.",
];

/// Whether the law is read as in the shipped study of the paper.
pub fn is_the_first(law: &ControlLimits) -> bool {
    (law.tilt_from, law.thrust_curve) == (TiltFrom::Thrust, ThrustCurve::Quadratic)
}

/// What is chosen in a reading of the law where the paper is silent.
pub fn choices(law: &ControlLimits) -> [(&'static str, &'static str); CHOICES.len()] {
    let tilt = (law.tilt_from == TiltFrom::Gravity).then_some(TILT_FROM_GRAVITY);
    let throttle = (law.thrust_curve == ThrustCurve::Linear).then_some(LINEAR_THROTTLE);
    CHOICES.map(|first| {
        [tilt, throttle].into_iter().flatten().find(|(what, _)| *what == first.0).unwrap_or(first)
    })
}

/// Slips of print in the paper.
pub const SLIPS: [&str; 8] = [
    "Section V: the best improvement is 45 % in Table 5 and 44 % in the text below it.",
    "Table 5 has values below the least of the Monte Carlo simulation of the same controller: 0.55 and 0.60 against 0.6069.",
    "Figures 7 and 8: marks at intervals of 1.56 s are two collocation points apart, not three; dt is 0.79 s.",
    "Section II: 0.6 m/s of descent velocity is 0.675 m/s, as (44) has it; 0.16 m, 0.67 m and 1.3 m/s are cut off, not \
     rounded, too.",
    "(39): the second term of the sum is printed L_d; it is L.",
    "Below (9): gravity is printed as a force [0 0 g], without the mass.",
    "(16): the element (3,3) is printed 1; it is cos alpha.",
    "(32): dt = t_f/38 and 38 points from t_0 to t_f exclude each other.",
];

#[cfg(test)]
mod tests {
    use super::*;

    /// A reading changes what is said of tilt and throttle, and nothing else.
    #[test]
    fn choices_are_those_of_the_reading() {
        let first = ControlLimits::default();
        let second = ControlLimits { tilt_from: TiltFrom::Gravity, ..first };
        let linear = ControlLimits { thrust_curve: ThrustCurve::Linear, ..second };
        assert!(is_the_first(&first) && !is_the_first(&second) && !is_the_first(&linear));
        assert_eq!(choices(&first), CHOICES);
        for (law, others) in
            [(second, vec![TILT_FROM_GRAVITY]), (linear, vec![TILT_FROM_GRAVITY, LINEAR_THROTTLE])]
        {
            let differ = choices(&law).into_iter().filter(|choice| !CHOICES.contains(choice));
            assert_eq!(differ.collect::<Vec<_>>(), others);
        }
    }

    /// `docs/paper.md` has what the page has, to the word.
    #[test]
    fn the_page_in_docs_has_the_same_sentences() {
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let docs = words(include_str!("../../../../docs/paper.md"));
        let choices = CHOICES.into_iter().chain([TILT_FROM_GRAVITY, LINEAR_THROTTLE]);
        let choices: Vec<_> = choices.map(|(what, chosen)| format!("**{what}**: {chosen}")).collect();
        let said = choices.iter().map(String::as_str).chain(OTHER_READINGS).chain(SLIPS);
        for sentence in said {
            assert!(docs.contains(&words(sentence)), "docs/paper.md has not: {sentence}");
        }
    }
}
