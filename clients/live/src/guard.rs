//! Access control: only pages of this server on this machine are served; changes also need the
//! token.
//!
//! A page of another site in the same browser can send requests to this server, but cannot forge
//! `Host` or `Origin`. Checking `Host` stops names rebound to 127.0.0.1; checking `Origin` stops
//! scripts of other sites.

use axum::http::HeaderMap;
use axum::http::header::{AUTHORIZATION, HOST, ORIGIN};

#[derive(Clone, Debug)]
pub(crate) struct Guard {
    hosts: [String; 2],
    token: String,
}

impl Guard {
    /// Makes the access control of a server on this port, with a random token.
    pub(crate) fn new(port: u16) -> std::io::Result<Self> {
        let mut bytes = [0; 16];
        let filled = rustix::rand::getrandom(&mut bytes, rustix::rand::GetRandomFlags::empty())?;
        if filled < bytes.len() {
            return Err(std::io::Error::other(
                "could not draw a token: too few random bytes",
            ));
        }
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
        let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
        let is_ours = |host: &str| self.hosts.iter().any(|ours| ours == host);
        let from = text(ORIGIN).map(|origin| origin.strip_prefix("http://").unwrap_or("?"));
        text(HOST).is_some_and(is_ours) && from.is_none_or(is_ours)
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
}
