//! What the paper leaves open and what is chosen here, what another choice is known to change, and the
//! paper's slips of print: for the page beside the findings. `docs/paper.md` has the same sentences.

/// What the paper leaves open, and what is chosen here.
pub const CHOICES: [(&str, &str); 12] = [
    (
        "tilt limit",
        "37.5 deg. The paper prints none; with this one the mean of the first campaign is the paper's 0.81. Its least \
         J_TPF of that campaign, 0.7744, would be a limit of 34.85 deg.",
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

/// What is known of another reading of the control law. It was found by a program of the plane of its own,
/// which agrees with this one in this one's reading.
pub const ANOTHER_READING: [&str; 4] = [
    "The paper's law is PX4's, and PX4 takes the pitch command from the wanted acceleration over gravity, theta = \
     -atan(a/g), and divides the collective by its cosine. The study has been flown with that reading by another program, \
     which agrees with samara where it has samara's reading: the limit cycle of the PSO gains is gone, and the velocity \
     variance falls 60 times (near-hover gains) and 28 times (PSO gains) from release to end, as figures 11 and 13 have it.",
    "Figure 12 comes out as printed, and the mean reduction of Table 5 is 23 to 24 %, with that reading, a throttle that is \
     linear in the thrust, velocity errors in body axes, and a release whose pitch rate has the sign opposite to (42)'s.",
    "No reading that was tried has figure 10, the step's column of Table 5, which rises with the pitch to 1.01, or the \
     small deviations of the campaigns.",
    "These readings were tried with the paper's figures at hand. They show that the statements can be reached, not what \
     the authors flew.",
];

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

    /// `docs/paper.md` has what the page has, to the word.
    #[test]
    fn the_page_in_docs_has_the_same_sentences() {
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let docs = words(include_str!("../../../../docs/paper.md"));
        let choices = CHOICES.map(|(what, chosen)| format!("**{what}**: {chosen}"));
        let said = choices.iter().map(String::as_str).chain(ANOTHER_READING).chain(SLIPS);
        for sentence in said {
            assert!(docs.contains(&words(sentence)), "docs/paper.md has not: {sentence}");
        }
    }
}
