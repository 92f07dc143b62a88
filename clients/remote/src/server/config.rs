//! Configuration of the server, a TOML file.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Deserialize;
use shm_bus::BusName;

use crate::message::ClientRight;
use crate::rejection::rejected;
use crate::tls::Files;

/// Range of `connections`: a bus has 8 reader slots for events and 16 for the status.
const CONNECTIONS: std::ops::RangeInclusive<usize> = 1..=16;
/// Range of `silence_s`. Below it a busy machine ends commands; above it an attached goal continues
/// too long without its client.
const SILENCE_S: std::ops::RangeInclusive<f64> = 0.2..=10.0;
/// Longest name of a client, characters: that of a DNS label.
const NAME_MAX: usize = 63;

/// Configuration; paths are relative to its file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Config {
    /// Address and port.
    #[serde(default = "default_listen")]
    pub(crate) listen: SocketAddr,
    /// Bus of the daemon.
    #[serde(skip)]
    pub(crate) bus: BusName,
    #[serde(rename = "bus")]
    bus_name: Option<String>,
    certificate: PathBuf,
    key: PathBuf,
    client_ca: PathBuf,
    /// Commands at the same time, of all clients.
    #[serde(default = "default_connections")]
    pub(crate) connections: usize,
    #[serde(default = "default_silence_s")]
    silence_s: f64,
    /// Folder of `atas recordings`.
    recordings: Option<PathBuf>,
    /// Permitted clients.
    #[serde(default)]
    clients: BTreeMap<String, ClientRight>,
    #[serde(skip)]
    folder: PathBuf,
}

fn default_listen() -> SocketAddr {
    SocketAddr::from(([127, 0, 0, 1], 7843))
}

fn default_connections() -> usize {
    8
}

fn default_silence_s() -> f64 {
    1.0
}

/// Returns true for a name that a certificate can carry as DNS name, in one spelling.
pub(crate) fn is_client_name(name: &str) -> bool {
    let plain = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || b"-.".contains(&c);
    (1..=NAME_MAX).contains(&name.len())
        && name.bytes().all(plain)
        && !name.starts_with(['-', '.'])
        && !name.ends_with(['-', '.'])
        && !name.contains("..")
}

impl Config {
    /// Reads and checks the file.
    pub(crate) fn read(file: &Path) -> anyhow::Result<Self> {
        let text = atas_text_file::read(file).map_err(|error| rejected(file, &error))?;
        let parsed: Result<Self, _> = toml::from_str(&text);
        let mut config = parsed.map_err(|error| rejected(file, &toml_error(&text, &error)))?;
        config.check().map_err(|why| rejected(file, &why))?;
        let bus = match &config.bus_name {
            Some(name) => name.parse(),
            None => BusName::from_env(),
        };
        config.bus = bus.map_err(|error| rejected(file, &error))?;
        config.folder = file.parent().unwrap_or(Path::new(".")).to_owned();
        Ok(config)
    }

    fn check(&self) -> Result<(), String> {
        if !CONNECTIONS.contains(&self.connections) {
            return Err(format!(
                "connections is {}, needs {} to {}",
                self.connections,
                CONNECTIONS.start(),
                CONNECTIONS.end()
            ));
        }
        if !SILENCE_S.contains(&self.silence_s) {
            return Err(format!(
                "silence_s is {}, needs {} to {}",
                self.silence_s,
                SILENCE_S.start(),
                SILENCE_S.end()
            ));
        }
        match self.clients.keys().find(|name| !is_client_name(name)) {
            Some(name) => Err(format!(
                "client name {name:?} needs small letters, digits, hyphens and dots"
            )),
            None => Ok(()),
        }
    }

    /// Files for TLS.
    pub(crate) fn tls(&self) -> [PathBuf; 3] {
        [&self.client_ca, &self.certificate, &self.key].map(|file| self.folder.join(file))
    }

    /// Longest silence of a client.
    pub(crate) fn silence(&self) -> Duration {
        Duration::from_secs_f64(self.silence_s)
    }

    /// Folder of the recordings.
    pub(crate) fn recordings(&self) -> Option<PathBuf> {
        self.recordings.as_ref().map(|path| self.folder.join(path))
    }

    /// Returns the client with one of these names, and its right.
    pub(crate) fn client(&self, names: &[String]) -> Option<(&str, ClientRight)> {
        let (name, right) = names
            .iter()
            .find_map(|name| self.clients.get_key_value(name))?;
        Some((name, *right))
    }
}

/// View of the three files.
pub(crate) fn files([authority, certificate, key]: &[PathBuf; 3]) -> Files<'_> {
    Files {
        authority,
        certificate,
        key,
    }
}

/// Formats an error of a TOML text on one line, with its line number.
pub(crate) fn toml_error(text: &str, error: &toml::de::Error) -> String {
    let start = error.span().map_or(0, |span| span.start);
    let line = text
        .get(..start)
        .map_or(1, |before| before.split('\n').count());
    format!("line {line}: {}", error.message().replace('\n', ", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILES: &str = "certificate = 'c.pem'\nkey = 'k.pem'\nclient_ca = 'ca.pem'\n";

    fn read(text: &str) -> Result<Config, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("remote.toml");
        std::fs::write(&file, format!("{FILES}{text}")).expect("written");
        Config::read(&file).map_err(|error| error.to_string())
    }

    #[test]
    fn example_configuration_is_valid() {
        let text = include_str!("../../remote.example.toml");
        let config: Config = toml::from_str(text).expect("valid");
        config.check().expect("in range");
        assert_eq!(config.connections, default_connections());
        assert_eq!(config.silence_s, default_silence_s());
    }

    #[test]
    fn invalid_configuration_is_refused_by_key() {
        let check = |text: &str, part: &str| {
            let why = read(text).expect_err("refused");
            assert!(why.contains(part), "{text}: {why}");
        };
        check("connections = 0", "connections is 0, needs 1 to 16");
        check("silence_s = 60.0", "silence_s is 60, needs 0.2 to 10");
        check("silence_s = nan", "silence_s is NaN");
        check("listen = 'robot'", "line 4: ");
        check("bus = 'a/b'", "a/b");
        check("password = 'x'", "password");
        check("clients.Alice = 'command'", "client name \"Alice\"");
        check("clients.alice = 'all'", "all");
    }

    #[test]
    fn only_listed_names_have_a_right() {
        let config = read("clients.alice = 'command'\nclients.pendant = 'stop'").expect("valid");
        let right = |name: &str| config.client(&[name.to_owned()]).map(|(_, right)| right);
        assert_eq!(right("alice"), Some(ClientRight::Command));
        assert_eq!(right("pendant"), Some(ClientRight::Stop));
        assert_eq!(right("alicea"), None);
        assert_eq!(right("*"), None);
        assert_eq!(config.client(&[]), None);
    }
}
