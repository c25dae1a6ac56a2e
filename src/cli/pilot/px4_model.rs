//! The drop that PX4 is expected to fly, by the model of its control law, without a wire.

use std::ops::ControlFlow;
use std::path::Path;

use super::contract::{Flown, Pilot, PilotOption, PilotedDrop};
use super::px4::upload::{exported, preparation, whole};
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::args::{AutopilotArg, ChoiceArgs};
use crate::cli::mission::mission_for_px4;
use crate::cli::system::Stopwatch;
use crate::cli::terminal::print_remarks;
use samara::config::{Mission, check_site_for_px4, px4_senses, truth_remark};
use samara::control::px4::{Law, NotQuadX, Parameters, Px4Controller, is_quad_x};
use samara::params::{Against, ParameterFile, px4_model_parameters};
use samara::report::FlownBy;
use samara::report::params::given_parameters;
use samara::sim::{self, FlightPlan, FlightRecord, Reference};
use samara::trajectory::Trajectory;

/// The options of a drop that the model has.
pub const OPTIONS: &[PilotOption] = &[PilotOption::Px4sOwnGains];

/// The model of PX4's control law.
pub struct Px4Model {
    /// The law of PX4's version.
    law: Law,
    /// Parameters in place of the mission's gains.
    parameters: Option<ParameterFile>,
}

impl Px4Model {
    /// The model with its parameters, and the mission for it.
    pub fn new(law: Law, path: &Path, choice: &ChoiceArgs) -> Result<(Self, Mission), Failure> {
        let (mut mission, parameters) = mission_for_px4(path, choice, Some(Against::of_law(&law)))?;
        mission.note_choice("autopilot", &AutopilotArg::Px4Model(law).to_string());
        Ok((Self { law, parameters }, mission))
    }
}

impl Pilot for Px4Model {
    fn name(&self) -> &'static str {
        "px4-model"
    }

    fn introduction(&self) -> &'static str {
        ", flown by the model of PX4's control law"
    }

    fn check(&self, mission: &Mission, trajectory: &Trajectory, _: u16) -> Result<(), Failure> {
        mission.faults.check_without_wire().bad_input()?;
        let (_, mut remarks) = parameters_for(mission, trajectory, &self.law, self.parameters.as_ref())?;
        remarks.extend(truth_remark(mission, &self.law));
        print_remarks(&mission.control.gains_name, &remarks);
        Ok(())
    }

    fn parameters(&self, mission: &Mission, trajectory: &Trajectory) -> Result<Option<String>, Failure> {
        let whole = whole(mission, trajectory, self.parameters.as_ref(), !self.law.allocates)?;
        Ok(Some(given_parameters(mission, &whole.for_version(Against::of_law(&self.law)))))
    }

    /// Flies the mission, the release at the end of the hang.
    fn fly(&self, flight: &PilotedDrop<'_>) -> Result<Flown, Failure> {
        let PilotedDrop { mission, trajectory, .. } = *flight;
        let (parameters, _) = parameters_for(mission, trajectory, &self.law, self.parameters.as_ref())?;
        // k of Froude's scaling: PX4's clock is slower than the site's by it.
        let similarity = mission.px4_purpose().factors(mission.site.environment.gravity_m_s2).k;
        let mut flight = mission.released_simulation();
        let then_v_ned = Some(mission.target_v_ned);
        let feed_forward = mission.control.feed_forward;
        let reference = Reference::Plan { trajectory, then_v_ned, feed_forward };
        let plan = FlightPlan::under_px4(reference, &self.law, similarity, mission.duration_s);
        let watch = Stopwatch::start();
        let density_kg_m3 = mission.site.environment.density_kg_m3;
        let thrust_limit_n = mission.vehicle.static_thrust_n(density_kg_m3);
        let senses = px4_senses(mission, &parameters, &self.law);
        let mut controller = Px4Controller::new(parameters, similarity, thrust_limit_n).with_law(
            self.law,
            &mission.vehicle,
            density_kg_m3,
        );
        let mut log = Vec::new();
        let _ = sim::fly_sensing(&mut flight, &mut controller, &plan, senses, &mut |sample| {
            log.push(*sample);
            ControlFlow::Continue(())
        });
        let version = (self.law != Law::V1_12).then(|| self.law.since.to_string());
        Ok(Flown {
            replans: Vec::new(),
            fall: None,
            log,
            record: FlightRecord::of_motors(&flight),
            real_time_factor: Some(1e3 * mission.duration_s / watch.ms()),
            by: Some(FlownBy { name: self.name(), version }),
            trouble: None,
        })
    }
}

/// The parameters that a law flies the mission by, from a file or from the mission's gains; the error says
/// why it cannot.
pub fn suits(mission: &Mission, law: &Law, given: Option<&ParameterFile>) -> anyhow::Result<Parameters> {
    // What PX4 would take for a dead sensor the model's estimator takes.
    check_site_for_px4(mission)?;
    if !law.allocates {
        is_quad_x(&mission.vehicle).map_err(|why| allocated_by_hint(law, &why))?;
    }
    exported(mission, given, !law.allocates)?;
    Ok(px4_model_parameters(&mission.parameter_subject(), mission.px4_purpose(), law, given)?)
}

/// What PX4 is set to for the mission, by a file or by the mission's gains in its terms, and what there is to
/// remark on that.
fn parameters_for(
    mission: &Mission,
    trajectory: &Trajectory,
    law: &Law,
    given: Option<&ParameterFile>,
) -> Result<(Parameters, Vec<String>), Failure> {
    let mut parameters = suits(mission, law, given).bad_input()?;
    let upload = preparation(mission, trajectory, given, !law.allocates)?.upload;
    // Where PX4 would not get the file's value the model has not got it either.
    let own = given.into_iter().flat_map(ParameterFile::entries);
    for (name, value) in own.filter_map(|(_, name, _)| Some((name, upload.parameters.get(name)?))) {
        // What the model does not read, it does not get.
        let _ = parameters.set(name, value.as_f64());
    }
    Ok((parameters, upload.remarks))
}

/// That a law mixes by a file, for other rotors than these, and which do not.
fn allocated_by_hint(law: &Law, why: &NotQuadX) -> anyhow::Error {
    anyhow::anyhow!(
        "{why}: PX4 {} mixes by files; v1.14 and later take any rotors: px4-model=v1.14",
        law.since
    )
}
