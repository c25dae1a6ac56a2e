//! The door of the server: a browser on this machine that was given the token may ask, on the server's own
//! page.
//!
//! Another page in that browser cannot: it has another origin, and gets no answer that it may read; a name of
//! its own that leads here is another host. Another program of the same user can, as it can do all else.

use std::fmt;
use std::io;

use hyper::Method;
use hyper::header::{CONTENT_TYPE, COOKIE, HOST, HeaderMap, HeaderName, HeaderValue, ORIGIN};
use hyper::http::request::Parts;

/// Most bytes of the head of a request.
pub const HEAD_MOST: usize = 16 << 10;
/// Most bytes of the body of a request.
pub const BODY_MOST: usize = 64 << 10;

/// What every answer says of itself: it loads nothing from elsewhere, nobody may frame it, it is kept
/// nowhere.
pub const HEADERS: [(&str, &str); 4] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; connect-src 'self'; \
         img-src 'self' data: blob:; font-src data:; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'",
    ),
    ("referrer-policy", "no-referrer"),
    ("x-content-type-options", "nosniff"),
    ("cache-control", "no-store"),
];

/// 128 bits that only the browser knows that was given them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token([u8; 16]);

impl Token {
    /// A token of the system's randomness.
    ///
    /// # Errors
    /// Of the system, where it has none.
    pub fn new() -> io::Result<Self> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(io::Error::other)?;
        Ok(Self(bytes))
    }

    /// Whether a text is this token; how long that takes does not depend on where it differs.
    pub fn is(&self, text: &str) -> bool {
        let own = self.to_string();
        let differs = own.bytes().zip(text.bytes()).fold(0, |differs, (a, b)| differs | (a ^ b));
        own.len() == text.len() && std::hint::black_box(differs) == 0
    }
}

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// The door of a server on a port.
#[derive(Debug)]
pub struct Guard {
    hosts: [String; 2],
    cookie: String,
    token: Token,
}

/// Why a request is not heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// It is somebody else's: 403.
    Forbidden,
    /// The body is no JSON: 415.
    NoJson,
}

impl Guard {
    /// The door of the server on a port, for this token.
    pub fn new(port: u16, token: Token) -> Self {
        let hosts = ["127.0.0.1", "localhost"].map(|host| format!("{host}:{port}"));
        Self { hosts, cookie: format!("samara_{port}"), token }
    }

    /// Whether a request is for this server and from its own page; of one with a body, whether that is JSON.
    ///
    /// # Errors
    /// [`Closed`] says why not.
    pub fn admits(&self, head: &Parts) -> Result<(), Closed> {
        let own = |host: &str| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        let host = only(&head.headers, &HOST).ok_or(Closed::Forbidden)?;
        let named = head.uri.authority().is_none_or(|authority| own(authority.as_str()));
        let origin = match only(&head.headers, &ORIGIN) {
            Some(origin) => origin.strip_prefix("http://").is_some_and(own),
            None => !head.headers.contains_key(ORIGIN),
        };
        // Where the browser says so: from another page, also one of another port of this machine.
        let site = head.headers.get("sec-fetch-site").map(HeaderValue::as_bytes);
        let near = matches!(site, None | Some(b"same-origin" | b"none")) || head.uri.path() == "/";
        if !(own(host) && named && origin && near) {
            return Err(Closed::Forbidden);
        }
        let kind = only(&head.headers, &CONTENT_TYPE).unwrap_or_default();
        let kind = kind.split(';').next().unwrap_or_default().trim();
        let is_json = kind.eq_ignore_ascii_case("application/json");
        if head.method == Method::POST && !is_json { Err(Closed::NoJson) } else { Ok(()) }
    }

    /// Whether a request bears the cookie.
    pub fn knows(&self, head: &Parts) -> bool {
        let cookies = head.headers.get_all(COOKIE).iter().filter_map(|cookies| cookies.to_str().ok());
        let mut pairs =
            cookies.flat_map(|cookies| cookies.split(';')).filter_map(|one| one.trim().split_once('='));
        pairs.any(|(name, value)| name == self.cookie && self.token.is(value))
    }

    /// The cookie for who has brought this token, if it is the token.
    pub fn lets_in(&self, token: &str) -> Option<String> {
        let cookie = || format!("{}={}; HttpOnly; SameSite=Strict; Path=/", self.cookie, self.token);
        self.token.is(token).then(cookie)
    }
}

/// The value of a header that is there once.
fn only<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next().filter(|_| values.next().is_none())?;
    value.to_str().ok()
}
