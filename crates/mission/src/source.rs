//! A file's text and the places in it: reading with a size limit, strict JSON, and the line and column of
//! anything that is refused.
//!
//! A place is where the refused thing *starts*: the value for a wrong value, the key for one that is unknown
//! or given twice, the object for one that lacks a key. Syntax errors are where the parser stopped.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::bounded::bytes_at_most;
use super::error::ConfigError;
use super::names::nearest;
use super::shipped;
use samara_core::printable::printable;

/// Larger files are refused: no mission, table or trajectory comes near, and a device file would never end.
const LIMIT_BYTES: u64 = 64 << 20;

/// A file that was read.
pub(super) struct Source {
    pub(super) file: PathBuf,
    pub(super) text: String,
    /// Paths whose values are not the file's, with what was asked for.
    set: Vec<(String, String)>,
}

impl Source {
    /// A text that is on no disk, as if `file` held it.
    pub(super) fn of_text(text: &str, file: &Path) -> Self {
        Self { file: file.to_owned(), text: text.to_owned(), set: Vec::new() }
    }

    /// Reads `path`, named in `named_in` or on the command line. `role` is for the message: "vehicle file".
    pub(super) fn read(
        path: &Path,
        role: &'static str,
        named_in: Option<&Path>,
    ) -> Result<Self, ConfigError> {
        let text = String::from_utf8(Self::bytes(path, role, named_in)?).map_err(|e| ConfigError::Read {
            role,
            path: path.to_owned(),
            named_in: named_in.map(Path::to_owned),
            reason: format!("it is not text: byte {} is not UTF-8", e.utf8_error().valid_up_to() + 1),
        })?;
        // A mark of the byte order, which some editors put in front, is no part of the text.
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        Ok(Self { file: path.to_owned(), text, set: Vec::new() })
    }

    /// The bytes of `path`, as [`Source::read`] finds it.
    pub(super) fn bytes(
        path: &Path,
        role: &'static str,
        named_in: Option<&Path>,
    ) -> Result<Vec<u8>, ConfigError> {
        let bytes = match shipped::read(path) {
            Some(found) => found.map(|text| text.as_bytes().to_vec()),
            None => bytes_at_most(path, LIMIT_BYTES).map_err(|e| e.to_string()),
        };
        bytes.map_err(|reason| ConfigError::Read {
            role,
            path: path.to_owned(),
            named_in: named_in.map(Path::to_owned),
            reason,
        })
    }

    /// Puts a value into the text, at a path that is there or is made; `asked` is for messages. Otherwise why
    /// not.
    pub(super) fn put(&mut self, path: &str, value: &serde_json::Value, asked: &str) -> Result<(), String> {
        let (mut there, mut inner) = (path, value.to_string());
        let span = loop {
            if let Some(span) = span(&self.text, there) {
                break span;
            }
            // What is not there is made inside of what is.
            let Some((before, name)) = there.rsplit_once('.').or((!there.is_empty()).then_some(("", there)))
            else {
                return Err("the file is no JSON object".to_owned());
            };
            if name.contains('[') {
                return Err(format!("there is no `{there}` in {}", self.file.display()));
            }
            if there.len() < path.len() {
                inner = format!("{{ {inner} }}");
            }
            inner = format!("{}: {inner}", serde_json::Value::from(name));
            there = before;
        };
        if there == path {
            self.text.replace_range(span, &inner);
        } else {
            let object = self.text.get(span.clone()).unwrap_or_default();
            let Some(inside) = object.strip_prefix('{') else {
                return Err(format!("`{there}` is no object in {}", self.file.display()));
            };
            let end = if inside.trim_start().starts_with('}') { " " } else { ", " };
            self.text.insert_str(span.start + 1, &format!(" {inner}{end}"));
        }
        self.set.push((path.to_owned(), asked.to_owned()));
        Ok(())
    }

    /// The value at a path; `None` where there is none.
    pub(super) fn value(&self, path: &str) -> Option<serde_json::Value> {
        serde_json::from_str(self.text.get(span(&self.text, path)?)?).ok()
    }

    /// A path that this file names: relative to this file's directory.
    pub(super) fn resolve(&self, path: &str) -> PathBuf {
        shipped::resolve(&self.file, path)
    }

    /// The document as a `T`; unknown and repeated keys are refused by `T`, text after the document here.
    pub(super) fn parse<T: DeserializeOwned>(&self) -> Result<T, ConfigError> {
        if self.text.trim().is_empty() {
            let message = "the file is empty; a JSON object is expected".to_owned();
            return Err(self.error(0, String::new(), message));
        }
        let mut json = serde_json::Deserializer::from_str(&self.text);
        let mut track = serde_path_to_error::Track::new();
        let value = T::deserialize(serde_path_to_error::Deserializer::new(&mut json, &mut track))
            .map_err(|e| self.explain(&e, track.path().to_string()))?;
        json.end().map_err(|e| {
            let message = "text after the end of the document; expected nothing more".to_owned();
            self.error(self.offset(e.line(), e.column()), String::new(), message)
        })?;
        Ok(value)
    }

    /// A parser's error with its place and the path of the value that it was in.
    fn explain(&self, error: &serde_json::Error, path: String) -> ConfigError {
        // What was not read yet is a `?` of the path.
        let path = path.trim_end_matches('?').trim_end_matches('.').to_owned();
        let stop = self.offset(error.line(), error.column());
        let full = error.to_string();
        let suffix = format!(" at line {} column {}", error.line(), error.column());
        let mut message = full.strip_suffix(&suffix).unwrap_or(&full).to_owned();
        // An object by the name that it has in the code; a list in its place is read as one of too few or too
        // many entries.
        if let Some((found, _)) = message.split_once(", expected struct ") {
            let found = if found.starts_with("invalid length") { "invalid type: a list" } else { found };
            message = format!("{found}, expected an object");
        }
        if let Some(near) = misspelt(&message) {
            message = format!("did you mean `{near}`? {message}");
        }
        // serde's derive reports a repeated key for the object that holds it; the key comes second where it
        // stands now.
        let repeated = message.strip_prefix("duplicate field `").and_then(|m| m.split('`').next());
        let path = match repeated {
            Some(key) if path.is_empty() => key.to_owned(),
            Some(key) => format!("{path}.{key}"),
            None => path,
        };
        let place = match error.classify() {
            // A list or an object where something else belongs is only looked at: it starts after the stop.
            serde_json::error::Category::Data => locate(&self.text, &path, stop + 1).unwrap_or(stop),
            _ => {
                if ["N", "I", "-I", "nan", "inf"].iter().any(|s| self.text[stop..].starts_with(s))
                    || self.text[..stop].ends_with('-')
                {
                    message += " (NaN and infinity are not numbers here; expected a finite number)";
                } else if message == "number out of range" {
                    message += "; expected a finite number";
                } else if let Some(hint) = hint_at(&message, &self.text[stop..]) {
                    message += hint;
                }
                stop
            }
        };
        self.error(place, path, message)
    }

    /// Refuses the value at `path` in a document that parsed: what was found, what was expected.
    pub(super) fn refuse(&self, path: &str, message: impl Into<String>) -> ConfigError {
        let place = locate(&self.text, path, self.text.len()).unwrap_or(0);
        self.error(place, path.to_owned(), message.into())
    }

    fn error(&self, place: usize, json_path: String, mut message: String) -> ConfigError {
        if let Some((_, asked)) = self.set.iter().rev().find(|(path, _)| is_within(path, &json_path)) {
            message += &format!(" (--set {})", printable(asked));
        }
        let (line, column) = line_column(&self.text, place);
        ConfigError::Content { file: self.file.clone(), line, column, json_path, message }
    }

    /// Offset in bytes of the parser's line and column (which counts bytes), on a character's border.
    fn offset(&self, line: usize, column: usize) -> usize {
        let start: usize = self.text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
        let mut at = (start + column.saturating_sub(1)).min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }
}

/// The known key or choice that was probably meant, of an error about one that is unknown.
fn misspelt(message: &str) -> Option<String> {
    let unknown = ["unknown field `", "unknown variant `"];
    let rest = unknown.iter().find_map(|start| message.strip_prefix(start))?;
    let (word, expected) = rest.split_once("`, expected ")?;
    nearest(word, expected.split('`').skip(1).step_by(2)).map(str::to_owned)
}

/// What else to say of a text that is no JSON: habits of other notations. `rest` is the text from where the
/// parser stopped.
fn hint_at(message: &str, rest: &str) -> Option<&'static str> {
    let next = rest.trim_start_matches(|c: char| c == '}' || c.is_whitespace());
    if rest.starts_with(['/', '#']) || next.starts_with("//") {
        return Some("; JSON has no comments: `about` is for remarks");
    }
    match message {
        "key must be a string" => Some("; keys stand in double quotes"),
        "expected value" if rest.starts_with('\'') => Some("; texts stand in double quotes"),
        "expected value" if next.starts_with(',') && !rest.starts_with(',') => {
            Some("; expected a single one of the alternatives here, and another key follows")
        }
        _ => None,
    }
}

/// A file that a mission or its vehicle names, beside those of vehicle and gains.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    /// "rotor table", "rotor coefficients", "turbulence noise" or "gains of renewed plans".
    pub role: &'static str,
    /// Path of the file; of what is inside the program it begins with `built-in:`.
    pub file: PathBuf,
    /// SHA-256, hexadecimal.
    pub sha256: String,
}

/// Hash of the inputs, in the order in which they are absorbed, and what is named by them.
#[derive(Clone, Debug, Default)]
pub(super) struct InputHash {
    hash: Sha256,
    named: Vec<NamedFile>,
}

impl InputHash {
    /// Takes the text of a file or of a choice in: its role, its length, its bytes - so that no two sets of
    /// inputs look alike.
    pub(super) fn absorb(&mut self, role: &str, text: &str) {
        self.hash.update(format!("{role} {}\n", text.len()));
        self.hash.update(text);
    }

    /// Takes the text of a file in that mission or vehicle name, and notes the file.
    pub(super) fn absorb_named(&mut self, role: &'static str, source: &Source) {
        self.absorb(role, &source.text);
        self.note(role, source);
    }

    /// Notes a file that mission or vehicle name, whose text was taken in.
    pub(super) fn note(&mut self, role: &'static str, source: &Source) {
        self.named.push(NamedFile { role, file: source.file.clone(), sha256: sha256(&source.text) });
    }

    /// The files that mission and vehicle name beside those of vehicle and gains, as they were noted.
    pub(super) fn named(&self) -> &[NamedFile] {
        &self.named
    }

    /// Takes another hash in.
    pub(super) fn follow(&mut self, hex: &str) {
        self.hash.update(hex);
    }

    /// SHA-256 in hexadecimal.
    pub(super) fn hex(&self) -> String {
        self.hash.clone().finalize().iter().map(|b| format!("{b:02x}")).collect()
    }
}

/// The text of an input file, of the disk or built in; `role` is what an error calls it: "mission file".
///
/// # Errors
/// [`ConfigError::Read`] when it cannot be read.
pub fn input_text(path: &Path, role: &'static str) -> Result<String, ConfigError> {
    Ok(Source::read(path, role, None)?.text)
}

/// SHA-256 of a text in hexadecimal, as `sha256sum` prints it.
pub(super) fn sha256(text: &str) -> String {
    let mut hash = InputHash::default();
    hash.follow(text);
    hash.hex()
}

/// Whether a path is another one or of something in it.
fn is_within(path: &str, inner: &str) -> bool {
    inner.strip_prefix(path).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

/// Line and column (characters), both from 1, of the byte at `offset`.
fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text[..offset];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// The last start of `path` - of its key or its value, whichever was reached - at or before the byte `stop`.
/// `None` when the text does not get there.
fn locate(text: &str, path: &str, stop: usize) -> Option<usize> {
    let mut scan = Scan { text, at: 0, path, stop, found: None, end: None };
    let _ = scan.value("", 0);
    scan.found
}

/// Where the value at `path` stands.
fn span(text: &str, path: &str) -> Option<Range<usize>> {
    let mut scan = Scan { text, at: 0, path, stop: text.len(), found: None, end: None };
    let _ = scan.value("", 0);
    Some(scan.found?..scan.end?)
}

/// A walk over a JSON text that was or is being parsed by serde_json; on anything unexpected it just ends.
struct Scan<'a> {
    text: &'a str,
    at: usize,
    path: &'a str,
    stop: usize,
    found: Option<usize>,
    /// Behind the value at the path.
    end: Option<usize>,
}

impl Scan<'_> {
    fn peek(&mut self) -> Option<u8> {
        let bytes = self.text.as_bytes();
        while bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        bytes.get(self.at).copied()
    }

    fn take(&mut self, expected: u8) -> Option<()> {
        (self.peek()? == expected).then(|| self.at += 1)
    }

    /// Notes that `path` starts here; ends the walk beyond the stop.
    fn note(&mut self, path: &str) -> Option<()> {
        self.peek()?;
        if self.at > self.stop {
            return None;
        }
        if path == self.path {
            self.found = Some(self.at);
        }
        Some(())
    }

    fn value(&mut self, path: &str, depth: usize) -> Option<()> {
        self.note(path)?;
        let walked = match self.peek()? {
            _ if depth > 128 => None,
            b'{' => self.object(path, depth),
            b'[' => self.array(path, depth),
            b'"' => self.string().map(|_| ()),
            _ => {
                let rest = &self.text.as_bytes()[self.at..];
                let length = rest.iter().position(|b| b",]} \t\r\n".contains(b)).unwrap_or(rest.len());
                self.at += length;
                // The end of something that was not begun is no value, and the walk must go on.
                (length > 0).then_some(())
            }
        };
        if path == self.path && walked.is_some() {
            self.end = Some(self.at);
        }
        walked
    }

    fn object(&mut self, path: &str, depth: usize) -> Option<()> {
        self.take(b'{')?;
        while self.peek()? != b'}' {
            self.peek()?;
            let start = self.at;
            let key = self.string()?;
            let child = if path.is_empty() { key } else { format!("{path}.{key}") };
            let after = std::mem::replace(&mut self.at, start);
            self.note(&child)?;
            self.at = after;
            self.take(b':')?;
            self.value(&child, depth + 1)?;
            if self.peek()? == b',' {
                self.at += 1;
            }
        }
        self.take(b'}')
    }

    fn array(&mut self, path: &str, depth: usize) -> Option<()> {
        self.take(b'[')?;
        let mut index = 0;
        while self.peek()? != b']' {
            self.value(&format!("{path}[{index}]"), depth + 1)?;
            index += 1;
            if self.peek()? == b',' {
                self.at += 1;
            }
        }
        self.take(b']')
    }

    /// A string, unescaped.
    fn string(&mut self) -> Option<String> {
        let start = self.at;
        self.take(b'"')?;
        let bytes = self.text.as_bytes();
        while *bytes.get(self.at)? != b'"' {
            self.at += if bytes[self.at] == b'\\' { 2 } else { 1 };
        }
        self.at += 1;
        serde_json::from_str(self.text.get(start..self.at)?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fuzzer's finding: the walk stood still before an end that nothing had begun.
    #[test]
    fn regress_a_broken_text_is_walked_to_its_end() {
        for text in [
            "{\"a\": [1, 2}",
            "{\"a\": [1\n}\n",
            "[}",
            "{\"a\": }",
            "[,]",
            "{\"a\":,}",
            "[[[",
            "{\"a\": [1 2}",
        ] {
            assert_eq!(locate(text, "b", text.len()), None, "{text}");
        }
        assert_eq!(locate("{\"a\": [1, 2}", "a[1]", 12), Some(10));
    }

    /// A value is replaced where it stands; what is not there is made in the innermost object that is.
    #[test]
    fn closed_form_values_are_put_into_a_text() {
        let text = "{\n  \"a\": { \"b\": [1, { \"c\": 2 }] },\n  \"d\": {}\n}\n";
        let put = |path: &str| {
            let mut source = Source::of_text(text, Path::new("m.json"));
            source.put(path, &9.into(), path).map(|()| source.text)
        };
        for (path, expected) in [
            ("a.b", text.replace("[1, { \"c\": 2 }]", "9")),
            ("a.b[0]", text.replace("[1,", "[9,")),
            ("a.b[1].c", text.replace(": 2 }", ": 9 }")),
            ("a.b[1].e", text.replace("{ \"c\"", "{ \"e\": 9,  \"c\"")),
            ("d.e.f", text.replace("{}", "{ \"e\": { \"f\": 9 } }")),
            ("g", text.replacen('{', "{ \"g\": 9, ", 1)),
        ] {
            assert_eq!(put(path).unwrap(), expected, "{path}");
        }
        assert_eq!(put("a.b.c").unwrap_err(), "`a.b` is no object in m.json");
        assert_eq!(put("a.b[2]").unwrap_err(), "there is no `a.b[2]` in m.json");
    }
}
