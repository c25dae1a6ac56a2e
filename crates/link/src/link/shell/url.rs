//! Endpoints as they are typed: `udpin:HOST:PORT`, `udpout:HOST:PORT`, `tcpin:HOST:PORT`, `tcpout:HOST:PORT`,
//! each with `?mode=normal` (as without) or `?mode=onboard` after it.
//!
//! `in` binds HOST:PORT and serves whoever comes; `out` sends to, or connects to, HOST:PORT. The names are
//! those of pymavlink and MAVSDK. HOST is a name, an IPv4 address, or an IPv6 address in brackets; only what
//! is typed here is ever bound outside the loopback interface.

use std::fmt;
use std::io;
use std::net::{SocketAddr, ToSocketAddrs as _};
use std::str::FromStr;

use super::super::session::Link;

/// A kind of endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A UDP socket that serves whoever speaks to it.
    UdpIn,
    /// A UDP socket that speaks to one remote.
    UdpOut,
    /// A TCP server.
    TcpIn,
    /// A TCP client that connects again and again.
    TcpOut,
}

/// The kinds by name.
const KINDS: [(&str, Kind); 4] =
    [("udpin", Kind::UdpIn), ("udpout", Kind::UdpOut), ("tcpin", Kind::TcpIn), ("tcpout", Kind::TcpOut)];

/// What an endpoint is for: the link whose streams and rates it has, by the names that PX4's `mavlink start
/// -m` has. Without one it is a ground station's.
const PROFILES: [(&str, Link); 2] = [("normal", Link::GroundStation), ("onboard", Link::Api)];

/// An endpoint as typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkUrl {
    /// What kind.
    pub kind: Kind,
    /// Name or address, without brackets.
    pub host: String,
    /// Port.
    pub port: u16,
    /// The autopilot's link that it belongs to: ground stations' or companions'.
    pub link: Link,
}

/// A reason why a text is no endpoint.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UrlError {
    /// Another scheme.
    #[error("`{0}`: udpin, udpout, tcpin or tcpout is expected before the first colon")]
    Kind(String),
    /// No host.
    #[error("`{0}`: a host is expected: KIND:HOST:PORT")]
    Host(String),
    /// No port, or none that exists.
    #[error("`{0}`: a port from 1 to 65535 is expected after the last colon: KIND:HOST:PORT")]
    Port(String),
    /// Colons that are not part of a bracketed address.
    #[error("`{0}`: an IPv6 address stands in brackets: KIND:[ADDRESS]:PORT")]
    Brackets(String),
    /// Something else than a profile after the question mark.
    #[error("`{0}`: mode=normal or mode=onboard is expected after the question mark")]
    Profile(String),
}

impl FromStr for LinkUrl {
    type Err = UrlError;

    fn from_str(text: &str) -> Result<Self, UrlError> {
        let (name, rest) = text.split_once(':').unwrap_or_default();
        let known = KINDS.iter().find(|(known, _)| *known == name);
        let kind = known.ok_or_else(|| UrlError::Kind(text.to_owned()))?.1;
        // `udpin://host:port` is common, too.
        let rest = rest.strip_prefix("//").unwrap_or(rest);
        let (rest, link) = match rest.split_once('?') {
            None => (rest, Link::GroundStation),
            Some((rest, query)) => {
                let name = query.strip_prefix("mode=").unwrap_or_default();
                let link = PROFILES.iter().find(|(known, _)| *known == name);
                (rest, link.ok_or_else(|| UrlError::Profile(text.to_owned()))?.1)
            }
        };
        let (host, port) = rest.rsplit_once(':').ok_or_else(|| UrlError::Port(text.to_owned()))?;
        let port = port.parse().ok().filter(|p| *p != 0).ok_or_else(|| UrlError::Port(text.to_owned()))?;
        let bracketed = host.strip_prefix('[').and_then(|h| h.strip_suffix(']'));
        let host = bracketed.unwrap_or(host);
        if host.is_empty() {
            return Err(UrlError::Host(text.to_owned()));
        }
        if bracketed.is_none() && host.contains([':', '[', ']']) {
            return Err(UrlError::Brackets(text.to_owned()));
        }
        Ok(Self { kind, host: host.to_owned(), port, link })
    }
}

impl LinkUrl {
    /// The address behind host and port, the first if there are several.
    ///
    /// # Errors
    /// The system's, if the host has none.
    pub fn resolve(&self) -> io::Result<SocketAddr> {
        let mut found = (self.host.as_str(), self.port).to_socket_addrs()?;
        found.next().ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the host has no address"))
    }
}

impl fmt::Display for LinkUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = KINDS.iter().find(|(_, kind)| *kind == self.kind).map_or("", |(name, _)| *name);
        if self.host.contains(':') {
            write!(f, "{name}:[{}]:{}", self.host, self.port)?;
        } else {
            write!(f, "{name}:{}:{}", self.host, self.port)?;
        }
        if self.link == Link::Api { f.write_str("?mode=onboard") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_what_is_typed_is_what_is_meant() {
        for (text, kind, host, port) in [
            ("udpin:127.0.0.1:14555", Kind::UdpIn, "127.0.0.1", 14555),
            ("udpout:qgc.local:14550", Kind::UdpOut, "qgc.local", 14550),
            ("tcpin:0.0.0.0:5760", Kind::TcpIn, "0.0.0.0", 5760),
            ("tcpout:[::1]:5760", Kind::TcpOut, "::1", 5760),
        ] {
            let url: LinkUrl = text.parse().unwrap();
            assert_eq!((url.kind, url.host.as_str(), url.port), (kind, host, port));
            assert_eq!(url.to_string(), text);
        }
        let typed = |text: &str| text.parse::<LinkUrl>().unwrap();
        for (text, link) in
            [("", Link::GroundStation), ("?mode=normal", Link::GroundStation), ("?mode=onboard", Link::Api)]
        {
            let url = typed(&format!("udpout:127.0.0.1:14541{text}"));
            assert_eq!((url.port, url.link), (14541, link));
            assert_eq!(typed(&url.to_string()), url);
        }
        assert_eq!("udpin://127.0.0.1:1".parse::<LinkUrl>().unwrap().to_string(), "udpin:127.0.0.1:1");
    }

    #[test]
    fn what_is_wrong_is_named_with_what_was_expected() {
        for (text, reason) in [
            ("", "udpin, udpout, tcpin or tcpout is expected"),
            ("14550", "udpin, udpout, tcpin or tcpout is expected"),
            ("serial:/dev/ttyACM0:57600", "udpin, udpout, tcpin or tcpout is expected"),
            ("udpin:14550", "a port from 1 to 65535 is expected after the last colon"),
            ("udpin:127.0.0.1:", "a port from 1 to 65535 is expected"),
            ("udpin:127.0.0.1:0", "a port from 1 to 65535 is expected"),
            ("udpin:127.0.0.1:70000", "a port from 1 to 65535 is expected"),
            ("udpin:127.0.0.1:14550?mode=osd", "mode=normal or mode=onboard is expected"),
            ("udpin:127.0.0.1:14550?", "mode=normal or mode=onboard is expected"),
            ("udpin:127.0.0.1:14550?onboard", "mode=normal or mode=onboard is expected"),
            ("udpin::14550", "a host is expected"),
            ("tcpout:::1:5760", "an IPv6 address stands in brackets"),
        ] {
            let error = text.parse::<LinkUrl>().unwrap_err().to_string();
            assert!(error.contains(reason) && error.contains(&format!("`{text}`")), "{text}: {error}");
        }
        let (kind, host, link) = (Kind::UdpOut, "no such host".to_owned(), Link::Api);
        let nowhere = LinkUrl { kind, host, port: 1, link };
        assert!(nowhere.resolve().is_err());
    }
}
