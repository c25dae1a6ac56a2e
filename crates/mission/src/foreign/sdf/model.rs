//! Links and motors of a model, of those in it and of those that it includes, as one rigid body with all
//! joints at zero.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Vector3};
use roxmltree::{Document, ParsingOptions};

use super::element::Element;
use super::motor::Motor;
use super::pose::{Frames, Pose, own};
use crate::error::ConfigError;
use crate::foreign::known::{Place, ROLE};
use crate::foreign::rotors;
use crate::source::Source;
use samara_core::model::MAX_ROTORS;

/// Why a template is not read.
pub(crate) const TEMPLATE: &str = "a template, of which PX4's scripts/jinja_gen.py makes the .sdf that is read \
                                   (jinja_gen.py FILE.sdf.jinja FOLDER)";

/// Most elements, attributes and texts of a file, and most files.
const MOST_NODES: u32 = 200_000;
const MOST_FILES: usize = 64;
/// Models in models.
const DEEPEST: usize = 16;
/// Most links, and greatest mass of one [kg] and moment of inertia [kg m^2].
const MOST_LINKS: usize = 1000;
const HEAVIEST_KG: f64 = 100_000.0;
const MOST_INERTIA_KG_M2: f64 = 10_000_000.0;
/// Plugins of what is no multirotor, by what their names hold.
const OTHERS: [(&str, &str); 4] = [
    ("liftdrag", "wings: planes and VTOLs are not read"),
    ("lift-drag", "wings: planes and VTOLs are not read"),
    ("hydrodynamics", "water about it: boats and submarines are not read"),
    ("buoyancy", "lift by buoyancy: airships and submarines are not read"),
];

/// A link, in the frame of the outermost model: forward, left, up.
pub(super) struct Link {
    pub(super) name: String,
    pub(super) pose: Pose,
    pub(super) mass_kg: f64,
    /// Centre of mass [m].
    pub(super) centre: Vector3<f64>,
    /// Inertia about it [kg m^2].
    pub(super) inertia: Matrix3<f64>,
    /// Radius of what it collides by [m].
    pub(super) radius_m: Option<f64>,
    pub(super) place: Place,
}

/// A model with all that is in it.
pub(super) struct Model {
    pub(super) links: Vec<Link>,
    pub(super) motors: Vec<Motor>,
    pub(super) place: Place,
    /// Models that are included and not there, with where they were looked for.
    missing: Vec<String>,
    files: usize,
}

/// Where a model stands in the outermost one.
struct Stand {
    pose: Pose,
    /// What its links' names begin with.
    prefix: String,
    depth: usize,
}

impl Model {
    /// Reads a file and those that it includes.
    pub(super) fn read(file: &Path) -> Result<Self, ConfigError> {
        let place = Place { file: file.to_owned(), line: 1, column: 1, what: "sdf".to_owned() };
        let mut model = Self { links: Vec::new(), motors: Vec::new(), place, missing: Vec::new(), files: 0 };
        let stand = Stand { pose: Pose::IDENTITY, prefix: String::new(), depth: 0 };
        model.file(file, None, stand, None)?;
        if model.missing.is_empty() {
            return Ok(model);
        }
        let missing = model.missing.join("; ");
        Err(model.place.refuse(format!(
            "it includes what is not beside it: {missing}; put it there, or take the <include> out"
        )))
    }

    /// Takes a file's model, at a pose in the outermost model, or else at its own in what includes it.
    fn file(
        &mut self,
        file: &Path,
        named_in: Option<&Path>,
        stand: Stand,
        included_at: Option<Pose>,
    ) -> Result<(), ConfigError> {
        let source = Source::read(file, ROLE, named_in)?;
        let at = |line: u32, column: u32| Place {
            file: file.to_owned(),
            line: line as usize,
            column: column as usize,
            what: String::new(),
        };
        if source.text.contains("{%") || source.text.contains("{{") {
            return Err(at(1, 1).refuse(TEMPLATE));
        }
        let options =
            ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
        let text = with_prefixes(&source.text);
        let document = Document::parse_with_options(&text, options)
            .map_err(|e| at(e.pos().row, e.pos().col).refuse(words(&e)))?;
        let root = Element { file, node: document.root_element() };
        let found = root.node.tag_name().name();
        if found != "sdf" {
            let message = if found == "robot" {
                "expected Gazebo's SDF, found URDF; `gz sdf -p FILE` makes SDF of it".to_owned()
            } else {
                format!("expected Gazebo's SDF, `<sdf>`, found `<{found}>`")
            };
            return Err(root.refuse(message));
        }
        let Some(model) = root.child("model") else {
            let found = if root.child("world").is_some() { "a world" } else { "none" };
            return Err(root.refuse(format!("expected a `<model>` in it, found {found}")));
        };
        // Where the outermost model stands in its world is nobody's concern.
        let usual = if stand.depth == 0 { Pose::IDENTITY } else { own(model)? };
        let pose = included_at.unwrap_or(stand.pose.then(usual));
        self.model(model, &Stand { pose, ..stand })
    }

    /// The pose in the outermost model of an element of a model.
    fn pose(&self, model: Element, element: Element, stand: &Stand) -> Result<Pose, ConfigError> {
        let included = |name: &str| {
            let name = format!("{}{name}", stand.prefix);
            self.links.iter().find(|link| link.name == name).map(|link| link.pose)
        };
        Frames { model, pose: stand.pose, included: &included }.of(element)
    }

    fn model(&mut self, model: Element, stand: &Stand) -> Result<(), ConfigError> {
        if stand.depth > DEEPEST {
            return Err(model.refuse(format!("models stand in one another more than {DEEPEST} deep")));
        }
        for element in model.node.children().map(|node| Element { node, ..model }) {
            match element.node.tag_name().name() {
                "link" => self.link(model, element, stand)?,
                "plugin" => self.plugin(element, stand)?,
                "model" => {
                    let pose = self.pose(model, element, stand)?;
                    let prefix = format!("{}{}::", stand.prefix, element.name());
                    self.model(element, &Stand { pose, prefix, depth: stand.depth + 1 })?;
                }
                "include" => self.include(model, element, stand)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn include(&mut self, model: Element, include: Element, stand: &Stand) -> Result<(), ConfigError> {
        let uri = include.needed("uri")?;
        let name = uri.text().strip_prefix("model://").unwrap_or(uri.text());
        if name.is_empty() || name.starts_with('.') || name.contains(['/', '\\', ':', '\0']) {
            let shown: String = uri.text().chars().take(80).collect();
            return Err(
                uri.refuse(format!("expected model://NAME, a model beside this one, found `{shown}`"))
            );
        }
        if include.child("placement_frame").is_some() {
            return Err(include.refuse("a `<placement_frame>` is not read: its `<pose>` is expected alone"));
        }
        self.files += 1;
        if self.files > MOST_FILES || stand.depth >= DEEPEST {
            return Err(include.refuse(format!("more than {MOST_FILES} models are included, or in a circle")));
        }
        let folder = beside(include.file).join(name);
        let tried = [folder.join("model.sdf"), folder.join(format!("{name}.sdf"))];
        let Some(file) = tried.iter().find(|file| file.is_file()) else {
            let place = uri.place();
            self.missing.push(format!(
                "{} on line {} of {} (looked for {} and {name}.sdf)",
                uri.text(),
                place.line,
                place.file.display(),
                tried[0].display()
            ));
            return Ok(());
        };
        let at = include.child("pose").map(|_| self.pose(model, include, stand)).transpose()?;
        let prefix = match include.attribute("merge") {
            Some("true" | "1") => stand.prefix.clone(),
            _ => format!("{}{}::", stand.prefix, include.child("name").map_or(name, Element::text)),
        };
        let stand = Stand { pose: stand.pose, prefix, depth: stand.depth + 1 };
        self.file(file, Some(include.file), stand, at)
    }

    fn link(&mut self, model: Element, link: Element, stand: &Stand) -> Result<(), ConfigError> {
        if self.links.len() >= MOST_LINKS {
            return Err(link.refuse(format!("more than {MOST_LINKS} links")));
        }
        let inertial = link.needed("inertial")?;
        let mass_kg = inertial.needed("mass")?.positive(HEAVIEST_KG)?;
        let inertia = inertial.needed("inertia")?;
        let diagonal = |name| inertia.needed(name)?.positive(MOST_INERTIA_KG_M2);
        let beside = |name| {
            let entry = inertia.child(name).map(|entry| entry.from(-MOST_INERTIA_KG_M2, MOST_INERTIA_KG_M2));
            Ok::<_, ConfigError>(entry.transpose()?.unwrap_or(0.0))
        };
        let (xx, yy, zz) = (diagonal("ixx")?, diagonal("iyy")?, diagonal("izz")?);
        let (xy, xz, yz) = (beside("ixy")?, beside("ixz")?, beside("iyz")?);
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let pose = self.pose(model, link, stand)?;
        let centre = pose.then(own(inertial)?);
        self.links.push(Link {
            name: format!("{}{}", stand.prefix, link.name()),
            pose,
            mass_kg,
            centre: centre.position,
            inertia: centre.turned_tensor(tensor),
            radius_m: radius_m(link)?,
            place: link.place(),
        });
        Ok(())
    }

    fn plugin(&mut self, plugin: Element, stand: &Stand) -> Result<(), ConfigError> {
        let names = ["filename", "name"].map(|name| plugin.attribute(name).unwrap_or_default());
        let names = names.join(" ").to_ascii_lowercase();
        if let Some((_, what)) = OTHERS.iter().find(|(part, _)| names.contains(part)) {
            return Err(plugin.refuse(format!("expected a multirotor, found {what}")));
        }
        if plugin.child("motorConstant").is_some() {
            if self.motors.len() >= MAX_ROTORS {
                rotors::check_count(MAX_ROTORS + 1, &plugin.place())?;
            }
            self.motors.push(Motor::read(plugin, &stand.prefix)?);
        }
        Ok(())
    }
}

/// The folder that a model's folder lies in.
fn beside(file: &Path) -> PathBuf {
    let folder = file.parent().unwrap_or(Path::new(""));
    match (folder.parent(), folder.file_name()) {
        (Some(above), Some(_)) => above.to_owned(),
        _ => folder.join(".."),
    }
}

/// The text with the prefixes declared that Gazebo's files use without.
fn with_prefixes(text: &str) -> Cow<'_, str> {
    let used = ["gz", "ignition"]
        .into_iter()
        .filter(|prefix| text.contains(&format!("{prefix}:")) && !text.contains(&format!("xmlns:{prefix}")));
    let declared: String = used.map(|prefix| format!(" xmlns:{prefix}=\"{prefix}\"")).collect();
    match text.split_once("<sdf ").filter(|_| !declared.is_empty()) {
        Some((before, after)) => format!("{before}<sdf{declared} {after}").into(),
        None => text.into(),
    }
}

/// Radius of what a link collides by: a cylinder's, or half of a box's longer side [m].
fn radius_m(link: Element) -> Result<Option<f64>, ConfigError> {
    let Some(geometry) = link.child("collision").and_then(|collision| collision.child("geometry")) else {
        return Ok(None);
    };
    if let Some(radius) = geometry.child("cylinder").and_then(|cylinder| cylinder.child("radius")) {
        return radius.positive(100.0).map(Some);
    }
    let Some(size) = geometry.child("box").and_then(|shape| shape.child("size")) else { return Ok(None) };
    let [x, y, _] = size.numbers()?;
    Ok(Some(0.5 * f64::max(x, y)).filter(|radius| *radius > 0.0))
}

/// The parser's error without the place, which stands before it.
fn words(error: &roxmltree::Error) -> String {
    let text = error.to_string();
    let text = text.rsplit_once(" at ").map_or(text.as_str(), |(before, _)| before);
    format!("no XML that is read: {text}")
}
