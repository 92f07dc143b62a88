//! Access control: only pages of this server on this machine are served; changes also need the
//! token.
//!
//! A page of another site in the same browser can send requests to this server, but cannot forge
//! `Host` or `Origin`. Checking `Host` stops names rebound to 127.0.0.1; checking `Origin` stops
//! scripts of other sites.

use axum::http::header::{AUTHORIZATION, HOST, ORIGIN};
use axum::http::{HeaderMap, HeaderName};

/// Host of Foxglove's web application.
const FOXGLOVE_HOST: &str = "app.foxglove.dev";

#[derive(Clone, Debug)]
pub(crate) struct Guard {
    hosts: [String; 2],
    token: String,
}

impl Guard {
    /// Makes the access control of a server on this port, with a random token.
    pub(crate) fn new(port: u16) -> std::io::Result<Self> {
        let bytes: [u8; 16] = random_bytes()?;
        Ok(Self {
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
            token: bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
        })
    }

    pub(crate) fn token(&self) -> &str {
        &self.token
    }

    /// Returns true if the request names this server as host and does not come from another site's
    /// page.
    pub(crate) fn admits(&self, headers: &HeaderMap) -> bool {
        let from = text(headers, &ORIGIN);
        let from = from.map(|origin| origin.strip_prefix("http://").unwrap_or("?"));
        self.is_named(headers) && from.is_none_or(|host| self.is_ours(host))
    }

    /// Returns true if the request comes from a Foxglove viewer: a program, Foxglove's site, or a
    /// page of this machine. It must name this server as host.
    pub(crate) fn admits_viewer(&self, headers: &HeaderMap) -> bool {
        let is_viewer = |origin: &str| match origin.split_once("://") {
            Some(("http" | "https", host)) => {
                let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
                ["localhost", "127.0.0.1", FOXGLOVE_HOST].contains(&name)
            }
            // A desktop program. A page without a site sends `null`.
            Some(_) => true,
            None => false,
        };
        self.is_named(headers) && text(headers, &ORIGIN).is_none_or(is_viewer)
    }

    /// Returns true if the request names this server as host.
    fn is_named(&self, headers: &HeaderMap) -> bool {
        text(headers, &HOST).is_some_and(|host| self.is_ours(host))
    }

    fn is_ours(&self, host: &str) -> bool {
        self.hosts.iter().any(|ours| ours == host)
    }

    /// Returns true if the request may change something: it needs an accepted `Origin` and the
    /// token.
    pub(crate) fn trusts(&self, headers: &HeaderMap) -> bool {
        let bearer = headers
            .get(AUTHORIZATION)
            .and_then(|value| value.to_str().ok());
        let given = bearer
            .and_then(|text| text.strip_prefix("Bearer "))
            .unwrap_or("");
        self.admits(headers) && headers.contains_key(ORIGIN) && constant_time_eq(given, &self.token)
    }
}

/// Draws random bytes.
pub(crate) fn random_bytes<const N: usize>() -> std::io::Result<[u8; N]> {
    let mut bytes = [0; N];
    let filled = rustix::rand::getrandom(&mut bytes, rustix::rand::GetRandomFlags::empty())?;
    if filled < N {
        return Err(std::io::Error::other("too few random bytes"));
    }
    Ok(bytes)
}

/// Returns a header, or "?" if it is not text.
fn text<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let value = headers.get(name);
    value.map(|value| value.to_str().unwrap_or("?"))
}

/// Compares in constant time for texts of equal length.
fn constant_time_eq(a: &str, b: &str) -> bool {
    let differs = a
        .bytes()
        .zip(b.bytes())
        .fold(0, |differs, (a, b)| differs | (a ^ b));
    a.len() == b.len() && differs == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_own_pages_and_token_are_accepted() {
        let guard = Guard::new(8470).expect("random bytes");
        let check = |given: &[(&str, &str)], admitted, trusted| {
            let mut headers = HeaderMap::new();
            for (name, value) in given {
                let name: axum::http::HeaderName = name.parse().expect("a name");
                headers.insert(name, value.parse().expect("a value"));
            }
            assert_eq!(guard.admits(&headers), admitted, "{given:?}");
            assert_eq!(guard.trusts(&headers), trusted, "{given:?}");
        };
        let bearer = format!("Bearer {}", guard.token());
        let ours = ("host", "127.0.0.1:8470");
        let here = ("origin", "http://127.0.0.1:8470");
        check(&[], false, false);
        check(&[ours], true, false);
        check(&[("host", "localhost:8470")], true, false);
        check(&[("host", "rebound.example:8470")], false, false);
        check(&[ours, here], true, false);
        check(&[ours, ("origin", "http://other.example")], false, false);
        check(&[ours, ("origin", "https://127.0.0.1:8470")], false, false);
        check(&[ours, ("origin", "null")], false, false);
        check(&[ours, here, ("authorization", &bearer)], true, true);
        check(&[ours, ("authorization", &bearer)], true, false);
        check(&[ours, here, ("authorization", "Bearer ")], true, false);
        check(&[ours, here, ("authorization", &bearer[..20])], true, false);
    }

    #[test]
    fn viewers_are_programs_foxglove_and_local_pages() {
        let guard = Guard::new(8765).expect("random bytes");
        let check = |host: &str, origin: Option<&str>, admitted| {
            let mut headers = HeaderMap::new();
            headers.insert(HOST, host.parse().expect("a value"));
            if let Some(origin) = origin {
                headers.insert(ORIGIN, origin.parse().expect("a value"));
            }
            assert_eq!(guard.admits_viewer(&headers), admitted, "{host} {origin:?}");
        };
        check("127.0.0.1:8765", None, true);
        check("localhost:8765", Some("file://"), true);
        check("localhost:8765", Some("https://app.foxglove.dev"), true);
        check("localhost:8765", Some("http://localhost:8080"), true);
        check("rebound.example:8765", None, false);
        check("localhost:8765", Some("null"), false);
        check("localhost:8765", Some("https://other.example"), false);
        check(
            "localhost:8765",
            Some("https://app.foxglove.dev.other.example"),
            false,
        );
    }
}
