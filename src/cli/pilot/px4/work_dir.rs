//! PX4's working directory: made anew for each flight, which removes what is left of the last one; and
//! nothing else.

use std::ffi::OsString;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};

use super::beginning::Beginning;
use crate::cli::results::gone;
use samara::control::px4::versions::ToldBy;

/// A folder in the working directory that stands first in PX4's PATH: the start-up script up to v1.15 takes
/// `px4-rc.params` from there.
const HOOKS: &str = "hooks";
/// A file in the working directory that says whose it is: only a folder with it is ever removed.
const MARKER: &str = ".samara";

/// Makes the directory, empty but for the hooks; gives its path with nothing relative in it. Refuses to make
/// it where another's folder or the build stands.
pub(super) fn make(work: &Path, build: &Path, beginning: &Beginning) -> Result<PathBuf> {
    let script = beginning.script();
    let context = || format!("cannot make PX4's working directory {}", work.display());
    let work = resolved(work).with_context(context)?;
    let place = work.display();
    if work.starts_with(build) || build.starts_with(&work) {
        bail!(
            "{place}: PX4's working directory is made anew there for each flight, and it lies in PX4's build folder {} or holds it: choose \
             another --out",
            build.display()
        );
    }
    if script.is_some() && path_with_hooks(&work).is_none() {
        bail!(
            "{place}: PX4's start-up script is told of the vehicle by way of its PATH, and a folder with a colon in its name cannot \
             stand there: choose another --out"
        );
    }
    let holds_something = match fs::read_dir(&work) {
        Ok(mut entries) => entries.next().is_some(),
        Err(e) if e.kind() == ErrorKind::NotFound => false,
        other => other.map(|_| false).with_context(context)?,
    };
    if holds_something && !work.join(MARKER).is_file() {
        bail!(
            "{place}: PX4's working directory is made anew there for each flight, and what stands there is not one that samara made (no \
             {MARKER} in it): move it away, or choose another --out"
        );
    }
    renew(&work, script.as_deref()).with_context(context)?;
    Ok(work)
}

/// The path without links and relative parts, whether it is there already or only its parent.
fn resolved(work: &Path) -> std::io::Result<PathBuf> {
    match (work.parent(), work.file_name()) {
        (Some(parent), Some(name)) if !work.exists() => Ok(fs::canonicalize(parent)?.join(name)),
        _ => fs::canonicalize(work),
    }
}

fn renew(work: &Path, script: Option<&str>) -> std::io::Result<()> {
    gone(fs::remove_dir_all(work))?;
    fs::create_dir_all(work.join(HOOKS))?;
    let write = |name: &str, text: &str| {
        #[expect(clippy::disallowed_methods, reason = "files for the child")]
        fs::write(work.join(name), text)
    };
    write(
        MARKER,
        "PX4's working directory: samara removes it with all that is in it before the next flight.\n",
    )?;
    script.map_or(Ok(()), |script| write(&format!("{HOOKS}/{}", ToldBy::SCRIPT), script))
}

/// The PATH with the hooks first; `None` for a folder with a colon in its name, which cannot be in a PATH.
pub(super) fn path_with_hooks(work: &Path) -> Option<OsString> {
    let rest = std::env::var_os("PATH").unwrap_or_default();
    let all = std::iter::once(work.join(HOOKS)).chain(std::env::split_paths(&rest));
    std::env::join_paths(all).ok()
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that makes files")]
mod tests {
    use super::*;

    const QUAD: Beginning = Beginning { mixer: Some("quad_x"), parameters: Vec::new(), by: ToldBy::Script };

    const NOTHING: Beginning = Beginning { mixer: None, parameters: Vec::new(), by: ToldBy::Script };

    /// A place with a build folder in it.
    fn place() -> (tempfile::TempDir, PathBuf) {
        let place = tempfile::tempdir().unwrap();
        let root = fs::canonicalize(place.path()).unwrap();
        fs::create_dir_all(root.join("px4/build/bin")).unwrap();
        fs::write(root.join("px4/build/bin/px4"), "").unwrap();
        (place, root)
    }

    #[test]
    fn a_folder_of_somebody_elses_is_left_alone() {
        let (_place, root) = place();
        let elsewhere = root.join("elsewhere");
        for (work, build) in [
            (root.join("px4"), root.join("px4/build")),
            (root.join("px4/build/px4"), root.join("px4/build")),
            (root.join("px4"), elsewhere.clone()),
        ] {
            let error = make(&work, &build, &QUAD).unwrap_err().to_string();
            assert!(error.contains("--out") && error.contains(work.to_str().unwrap()), "{error}");
            assert!(root.join("px4/build/bin/px4").is_file(), "{error}");
        }
        let link = root.join("link");
        std::os::unix::fs::symlink(root.join("px4"), &link).unwrap();
        let error = make(&link, &elsewhere, &NOTHING).unwrap_err().to_string();
        assert!(error.contains("not one that samara made"), "{error}");
    }

    #[test]
    fn our_own_is_made_anew() {
        let (_place, root) = place();
        let (work, build) = (root.join("out/px4"), root.join("px4/build"));
        let parameters = vec![("EKF2_GPS_DELAY", 110.0)];
        let beginning = Beginning { parameters, ..QUAD };
        fs::create_dir(root.join("out")).unwrap();
        for _ in 0..2 {
            assert_eq!(make(&work, &build, &beginning).unwrap(), work);
            let hook = fs::read_to_string(work.join("hooks/px4-rc.params")).unwrap();
            assert!(hook.ends_with("set MIXER quad_x\nparam set EKF2_GPS_DELAY 110\n"), "{hook}");
            assert!(!work.join("left.log").exists());
            fs::write(work.join("left.log"), "").unwrap();
        }
    }

    /// PX4's script finds its mixer by PATH: without it PX4 would fly by another one.
    #[test]
    fn a_colon_is_refused_where_the_mixer_hangs_on_it() {
        let (_place, root) = place();
        let (work, build) = (root.join("a:b/px4"), root.join("px4/build"));
        fs::create_dir(root.join("a:b")).unwrap();
        let error = make(&work, &build, &QUAD).unwrap_err().to_string();
        assert!(error.contains("colon") && error.contains("--out"), "{error}");
        make(&work, &build, &NOTHING).unwrap();
    }
}
