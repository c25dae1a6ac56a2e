//! The register of random numbers: what each stream is drawn for, and which numbers the trials of a study
//! have.
//!
//! Whoever needs random numbers takes a line here, and no other place invents the number of a stream or of a
//! trial.

/// What a stream of random numbers is drawn for. Of one seed no two purposes have a stream in common, so that
/// everything drawn is independent of everything else. The number of a purpose is part of the key of its
/// streams and is never given again: what all flights draw hangs on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A trial's swing, then the wind of its drop and the seed of its sensors; numbered by trial.
    Release = 1,
    /// A trial's rates and velocity from the cut; numbered by trial.
    TipOff = 2,
    /// A trial's vehicle and air as a search varies them; numbered by trial.
    Unknowns = 3,
    /// What a trial of the free-fall study hangs under and in; numbered by trial.
    FreeFall = 4,
    /// Turbulence, in parts along the mean wind (0), across it (1) and vertical (2); numbered by flight.
    Turbulence = 5,
    /// Fluctuation of thrust in the vortex ring, a part for each rotor; numbered by flight.
    VortexRing = 6,
    /// An accelerometer's turn-on bias.
    AccelerometerBias = 7,
    /// An accelerometer's random walk.
    AccelerometerWalk = 8,
    /// An accelerometer's white noise.
    AccelerometerNoise = 9,
    /// A gyroscope's turn-on bias.
    GyroscopeBias = 10,
    /// A gyroscope's random walk.
    GyroscopeWalk = 11,
    /// A gyroscope's white noise.
    GyroscopeNoise = 12,
    /// A magnetometer's white noise.
    MagnetometerNoise = 13,
    /// A barometer's white noise.
    BarometerNoise = 14,
    /// A barometer's drift.
    BarometerDrift = 15,
    /// Noise of a satellite receiver's position.
    SatellitePosition = 16,
    /// Noise of a satellite receiver's velocity.
    SatelliteVelocity = 17,
    /// Garbage of failed sensors, a part for each sensor.
    Garbage = 18,
    /// A particle of a swarm, its place, velocity and steps; numbered by particle.
    Swarm = 19,
    /// A sample of an evolution strategy; numbered by its place in a generation.
    EvolutionStrategy = 20,
    /// A step of a chain that climbs to rare failures; numbered by population, level, chain and step.
    RareFailures = 21,
    /// A point of Sobol's indices; numbered by row and matrix.
    Sobol = 22,
    /// Dice of tests and examples: nothing that flies draws them.
    Dice = 23,
    /// What the estimated state of a rehearsed manoeuvre is off by.
    Estimate = 24,
}

/// Whose trials a number counts. What was chosen on some trials is judged on others: the trials of a search,
/// of those that judge what it found, and of a campaign are numbered apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trials {
    /// Campaigns, and the last judgement of a search.
    Campaign,
    /// Flights that a search judges its candidates by.
    Search,
    /// Draws of the air that blows on a search's release cases.
    SearchAir,
    /// Flights that a search's last few candidates are judged by.
    Finalists,
    /// Flights that an envelope's edge is sought with.
    Envelope,
    /// Flights that an envelope's edge is confirmed on.
    EnvelopeFresh,
    /// Releases that the axes of a grid of plans span.
    GridSpan,
    /// Releases that a grid of plans is judged by.
    GridJudged,
}

impl Trials {
    /// How many trials each has numbers for.
    pub const EACH: u64 = 1 << 48;

    /// The number of the first trial.
    pub const fn first(self) -> u64 {
        self as u64 * Self::EACH
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of all trials, and those of the flights that count one more, are whole numbers of JSON.
    #[test]
    fn prop_numbers_of_trials_are_apart_and_exact_in_json() {
        let all = [
            Trials::Campaign,
            Trials::Search,
            Trials::SearchAir,
            Trials::Finalists,
            Trials::Envelope,
            Trials::EnvelopeFresh,
            Trials::GridSpan,
            Trials::GridJudged,
        ];
        for pair in all.windows(2) {
            assert_eq!(pair[1].first() - pair[0].first(), Trials::EACH);
        }
        assert!(all[all.len() - 1].first() + Trials::EACH < 1 << 53);
    }
}
