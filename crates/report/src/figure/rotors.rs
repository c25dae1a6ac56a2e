//! Rotors in a figure: those whose thrusts run together share a line, named by where they are.

use super::track::Track;
use samara_core::model::RotorMount;
use samara_mission::Mission;

/// Part of the plan's greatest thrust by which thrusts on one line may differ.
const TOGETHER: f64 = 0.03;
/// A rotor is ahead, behind or aside when its place is that part of the farthest rotor's distance away.
const APART: f64 = 0.2;

/// Rotors on one line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RotorGroup {
    /// Where they are: "front", "rear left", "all rotors".
    pub(crate) name: String,
    /// Numbers of the rotors, from 0.
    pub(crate) rotors: Vec<usize>,
}

/// The groups of a track, in order of their first rotors.
pub(crate) fn rotor_groups(mission: &Mission, track: &Track) -> Vec<RotorGroup> {
    let rotors = &mission.vehicle.rotors;
    let most_n = TOGETHER * mission.plan.thrust_max_n;
    let together =
        |a: usize, b: usize| !track.instants.iter().any(|i| (i.thrust_n[a] - i.thrust_n[b]).abs() > most_n);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for i in 0..rotors.len() {
        match groups.iter_mut().find(|group| together(group[0], i)) {
            Some(group) => group.push(i),
            None => groups.push(vec![i]),
        }
    }
    named(rotors, groups)
}

fn named(rotors: &[RotorMount], groups: Vec<Vec<usize>>) -> Vec<RotorGroup> {
    let places: Vec<Vec<&str>> = rotors.iter().map(|rotor| place(rotors, rotor)).collect();
    let alone = groups.len() == 1 && rotors.len() > 1;
    let common = |group: &[usize]| -> Vec<&str> {
        let words = &places[group[0]];
        words.iter().copied().filter(|word| group.iter().all(|i| places[*i].contains(word))).collect()
    };
    let name = |group: &[usize]| {
        let words = common(group);
        // Words that name another group as well name none.
        let unique = groups.iter().filter(|other| common(other) == words).count() == 1;
        if alone {
            "all rotors".to_owned()
        } else if words.is_empty() || !unique {
            let numbers: Vec<String> = group.iter().map(|i| (i + 1).to_string()).collect();
            format!("rotor {}", numbers.join(", "))
        } else {
            words.join(" ")
        }
    };
    let names: Vec<String> = groups.iter().map(|group| name(group)).collect();
    groups.into_iter().zip(names).map(|(rotors, name)| RotorGroup { name, rotors }).collect()
}

/// Where a rotor is, in words.
fn place(rotors: &[RotorMount], rotor: &RotorMount) -> Vec<&'static str> {
    let farthest = rotors.iter().map(|r| r.position_body_m.xy().norm()).fold(0.0, f64::max);
    let side = |x: f64, [high, low]: [&'static str; 2]| {
        if x > APART * farthest {
            Some(high)
        } else if x < -APART * farthest {
            Some(low)
        } else {
            None
        }
    };
    let at = rotor.position_body_m;
    [side(at.x, ["front", "rear"]), side(at.y, ["right", "left"])].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use samara_core::model::{Interference, RotationSense};

    fn names(places: &[(f64, f64)], groups: &[&[usize]]) -> Vec<String> {
        let mount = |&(x, y): &(f64, f64)| RotorMount {
            position_body_m: Vector3::new(x, y, 0.0),
            axis_body: -Vector3::z(),
            spin: RotationSense::Ccw,
            interference: Interference::NONE,
        };
        let rotors: Vec<RotorMount> = places.iter().map(mount).collect();
        let groups = groups.iter().map(|group| group.to_vec()).collect();
        named(&rotors, groups).into_iter().map(|group| group.name).collect()
    }

    /// PX4's quadrotor and hexacopter in X: the words by hand.
    #[test]
    fn groups_are_named_by_what_their_places_share() {
        let quad = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];
        assert_eq!(names(&quad, &[&[0, 2], &[1, 3]]), ["front", "rear"]);
        assert_eq!(names(&quad, &[&[0, 1, 2, 3]]), ["all rotors"]);
        assert_eq!(
            names(&quad, &[&[0], &[1], &[2], &[3]]),
            ["front right", "rear left", "front left", "rear right"]
        );
        assert_eq!(names(&quad, &[&[0, 1], &[2, 3]]), ["rotor 1, 2", "rotor 3, 4"]);
        let hexa = [(0.0, 1.0), (0.0, -1.0), (0.87, -0.5), (-0.87, 0.5), (0.87, 0.5), (-0.87, -0.5)];
        assert_eq!(names(&hexa, &[&[0, 3, 4], &[1, 2, 5]]), ["right", "left"]);
        assert_eq!(names(&hexa, &[&[0], &[1], &[2, 4], &[3, 5]]), ["right", "left", "front", "rear"]);
        // Two rotors on one arm.
        assert_eq!(
            names(&[(1.0, 0.0), (1.0, 0.0), (-1.0, 0.0)], &[&[0], &[1], &[2]]),
            ["rotor 1", "rotor 2", "rear"]
        );
    }
}
