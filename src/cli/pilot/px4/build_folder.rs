//! A build folder of PX4's simulation.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow, bail};

use samara::config::bounded::bytes_at_most;
use samara::control::px4::Version;
use samara::control::px4::is_quad_x;
use samara::control::px4::versions::ToldBy;
use samara::link::px4_events::EventTexts;
use samara::link::shell::event_texts;
use samara::model::Vehicle;
use samara::params::Value;

/// Larger metadata of events is passed over [bytes].
const METADATA_MOST: u64 = 1 << 20;

/// Files that must be in a build folder.
const PROGRAM: &str = "bin/px4";
const STARTUP: &str = "etc/init.d-posix/rcS";
/// Larger start-up scripts are none [bytes].
const STARTUP_MOST: u64 = 1 << 20;
/// Larger programs are none [bytes]: PX4's has a tenth with all that a debugger wants.
const PROGRAM_MOST: u64 = 1 << 30;
/// A parameter that every version has.
const ALWAYS: &str = "SYS_AUTOSTART";
/// Where a source tree has its build folder.
const IN_SOURCES: &str = "build/px4_sitl_default";
/// Models of a plain quadrotor that start no simulator of their own and set no gains, by release: up to 1.13,
/// from 1.14 on.
const MODELS: [&str; 2] = ["iris", "none_iris"];
/// Motors that their airframes have outputs for.
const MODELS_MOTORS: usize = 4;
/// Output function of the first motor.
const FIRST_MOTORS_FUNCTION: i32 = 101;
/// The mixer of an X-quad, in releases whose mixers are files.
const QUAD_X: &str = "quad_x";

/// A build folder of PX4's simulation.
#[derive(Clone, Debug)]
pub struct BuildFolder {
    path: PathBuf,
}

impl BuildFolder {
    /// Opens the folder, or the one that a source tree has; refuses a folder that is no build.
    pub fn open(path: &Path) -> Result<Self> {
        if !path.is_dir() {
            bail!(
                "{}: there is no such folder; a build folder of PX4's simulation is expected",
                path.display()
            );
        }
        let inner = path.join(IN_SOURCES);
        let folder = if !path.join(PROGRAM).exists() && inner.join(PROGRAM).exists() { &inner } else { path };
        for missing in [PROGRAM, STARTUP] {
            if !folder.join(missing).is_file() {
                bail!(
                    "{}: no `{missing}` in it. A build folder of PX4's simulation is expected, as `make px4_sitl_default` leaves it in \
                     build/px4_sitl_default: it holds bin/px4 and etc/init.d-posix/rcS",
                    path.display()
                );
            }
        }
        let path = fs::canonicalize(folder).with_context(|| folder.display().to_string())?;
        Ok(Self { path })
    }

    /// The path of PX4's program.
    pub fn program(&self) -> PathBuf {
        self.path.join(PROGRAM)
    }

    /// The folder of scripts, mixers and airframes.
    pub fn etc(&self) -> PathBuf {
        self.path.join("etc")
    }

    /// How its start-up script is told parameters.
    pub fn told_by(&self) -> Result<ToldBy> {
        let path = self.path.join(STARTUP);
        let text = bytes_at_most(&path, STARTUP_MOST).with_context(|| path.display().to_string())?;
        Ok(ToldBy::of(&String::from_utf8_lossy(&text)))
    }

    /// The version that it is, by the parameters that it has, as a drop tells one that names none: their
    /// names are texts in the program.
    pub fn version(&self) -> Result<&'static Version> {
        let program = self.program();
        let bytes = bytes_at_most(&program, PROGRAM_MOST).with_context(|| program.display().to_string())?;
        // The linker may leave a text as the end of a longer one.
        let has = |name: &str| bytes.split(|byte| *byte == 0).any(|text| text.ends_with(name.as_bytes()));
        if !has(ALWAYS) {
            bail!("{}: the parameters of PX4 are expected in it, and {ALWAYS} is not", program.display());
        }
        Ok(Version::by_parameters(has))
    }

    /// The value of PX4_SIM_MODEL: the model whose airframe to start.
    pub fn model(&self) -> Result<&'static str> {
        let folder = self.etc().join("init.d-posix/airframes");
        let names = fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
        let mut found: Vec<String> =
            names.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
        found.sort();
        // `10016_iris`: its number, its name.
        let is_there =
            |model: &&str| found.iter().any(|name| name.split_once('_').is_some_and(|(_, m)| m == *model));
        MODELS.into_iter().find(is_there).ok_or_else(|| {
            let (folder, known) = (folder.display(), MODELS.join(", "));
            let found = if found.is_empty() { "none at all".to_owned() } else { found.join(" ") };
            anyhow!("{folder}: none of the models {known} in it, found {found}")
        })
    }

    /// The mixer to be asked for, in a release that has them as files; the model's own is for arms of another
    /// angle. `None`: PX4 allocates by its parameters CA_*.
    pub fn mixer(&self, name: &str, vehicle: &Vehicle) -> Result<Option<&'static str>> {
        if !self.etc().join(format!("mixers/{QUAD_X}.main.mix")).is_file() {
            return Ok(None);
        }
        is_quad_x(vehicle).with_context(|| {
            format!("vehicle {name}: this PX4 mixes by `quad_x`; v1.14 and later take any rotors")
        })?;
        Ok(Some(QUAD_X))
    }

    /// Parameters of a PX4 that allocates by CA_*, by which more motors than the model's get their outputs.
    pub fn outputs(motors: usize) -> impl Iterator<Item = (String, Value)> {
        let function = |motor: usize| Value::Int(FIRST_MOTORS_FUNCTION + motor as i32);
        (MODELS_MOTORS..motors).map(move |motor| (format!("PWM_MAIN_FUNC{}", motor + 1), function(motor)))
    }

    /// The texts of its events, of a version that has them.
    pub fn event_texts(&self) -> Option<Arc<EventTexts>> {
        let metadata = bytes_at_most(&self.etc().join("extras/all_events.json.xz"), METADATA_MOST).ok()?;
        event_texts(&metadata).ok().map(Arc::new)
    }

    /// Where the folder is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that makes files")]
mod tests {
    use super::*;
    use samara::config::load_mission;
    use samara::model::RotationSense;

    /// A build folder with these files, all empty.
    fn build(files: &[&str]) -> tempfile::TempDir {
        let place = tempfile::tempdir().unwrap();
        for file in files {
            let path = place.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        place
    }

    #[test]
    fn what_is_no_build_folder_is_refused_with_what_is_missing() {
        for (files, missing) in [
            (&["README"][..], "no `bin/px4` in it"),
            (&["bin/px4"][..], "no `etc/init.d-posix/rcS` in it"),
            (&["etc/init.d-posix/rcS", "bin/px4/x"][..], "no `bin/px4` in it"),
        ] {
            let place = build(files);
            let error = BuildFolder::open(place.path()).unwrap_err().to_string();
            assert!(error.contains(missing) && error.contains("make px4_sitl_default"), "{error}");
        }
    }

    /// Texts of a program as a compiler leaves them: a name, one within a text, none.
    #[test]
    fn the_version_is_that_of_the_newest_parameter_in_the_program() {
        let place = build(&["bin/px4", "etc/init.d-posix/rcS"]);
        let folder = BuildFolder::open(place.path()).unwrap();
        let version = |program: &[u8]| {
            fs::write(folder.program(), program).unwrap();
            folder.version().map(|version| version.number.to_string()).map_err(|error| error.to_string())
        };
        let all = b"\x7fELF\x01\0SYS_AUTOSTART\0COM_PARACHUTE\0\xffCOM_SPOOLUP_TIME\0COM_THROW_EN is new\0";
        assert_eq!(version(all).as_deref(), Ok("v1.14"));
        assert_eq!(version(b"SYS_AUTOSTART\0COM_PARACHUTE is old\0").as_deref(), Ok("v1.12"));
        let none = version(b"#!/bin/sh\nexec sleep 9\n").unwrap_err();
        assert!(none.contains("the parameters of PX4 are expected"), "{none}");
    }

    #[test]
    fn a_source_tree_stands_for_its_build_folder() {
        let inner = "build/px4_sitl_default";
        let place = build(&[&format!("{inner}/bin/px4"), &format!("{inner}/etc/init.d-posix/rcS")]);
        let folder = BuildFolder::open(place.path()).unwrap();
        assert!(folder.program().ends_with(format!("{inner}/bin/px4")));
    }

    #[test]
    fn the_model_and_the_mixer_are_those_of_the_release() {
        let common = ["bin/px4", "etc/init.d-posix/rcS", "etc/init.d-posix/airframes/3010_quadrotor_x"];
        let vehicle = load_mission(Path::new("mission/x500_drop.json")).unwrap().vehicle.as_ref().clone();
        let old = build(
            &[&common[..], &["etc/init.d-posix/airframes/10016_iris", "etc/mixers/quad_x.main.mix"]].concat(),
        );
        let folder = BuildFolder::open(old.path()).unwrap();
        assert_eq!((folder.model().unwrap(), folder.mixer("x", &vehicle).unwrap()), ("iris", Some("quad_x")));
        let mut turned = vehicle.clone();
        turned.rotors[2].spin = RotationSense::Ccw;
        let error = folder.mixer("x", &turned).unwrap_err();
        assert_eq!(
            error.root_cause().to_string(),
            "rotor 3 must be front left and turn clockwise in PX4's quadrotor in X"
        );
        let new = build(&[&common[..], &["etc/init.d-posix/airframes/10016_none_iris"]].concat());
        let folder = BuildFolder::open(new.path()).unwrap();
        assert_eq!((folder.model().unwrap(), folder.mixer("x", &vehicle).unwrap()), ("none_iris", None));
        let mut six = vehicle.clone();
        six.rotors.extend_from_within(..2);
        assert_eq!(folder.mixer("x", &six).unwrap(), None);
        let outputs: Vec<_> = BuildFolder::outputs(6).collect();
        let fifth = ("PWM_MAIN_FUNC5".to_owned(), Value::Int(105));
        assert_eq!(outputs, [fifth, ("PWM_MAIN_FUNC6".to_owned(), Value::Int(106))]);
        assert_eq!(BuildFolder::outputs(4).count(), 0);
        let other = build(&common);
        let error = BuildFolder::open(other.path()).unwrap().model().unwrap_err().to_string();
        assert!(error.contains("iris, none_iris") && error.contains("3010_quadrotor_x"), "{error}");
    }
}
