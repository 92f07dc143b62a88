//! Client configuration: addresses of servers, and the files of this client.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use atas_console::arguments::RemoteArgument;
use atas_console::{Exit, ExitError};
use rustls::ClientConfig;
use rustls::pki_types::ServerName;
use serde::Deserialize;

use crate::rejection::rejected;
use crate::server::toml_error;
use crate::tls::{self, Files};

/// Configuration; paths are relative to its file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {
    ca: PathBuf,
    certificate: PathBuf,
    key: PathBuf,
    #[serde(default)]
    servers: BTreeMap<String, Server>,
}

/// A named server.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Server {
    /// HOST:PORT.
    address: String,
    /// Name in its certificate, if it differs from the host.
    server_name: Option<String>,
}

/// Server to connect to.
#[derive(Clone)]
pub(super) struct Target {
    /// Name for messages, as the user entered it.
    pub(super) label: String,
    /// HOST:PORT.
    pub(super) address: String,
    /// Name in the certificate.
    pub(super) name: ServerName<'static>,
    pub(super) tls: Arc<ClientConfig>,
}

impl Target {
    /// Finds the server of `--remote`.
    pub(super) fn find(argument: &RemoteArgument) -> anyhow::Result<Self> {
        let label = argument.remote.clone().unwrap_or_default();
        let file = match &argument.remote_config {
            Some(file) => file.clone(),
            None => default_file()?,
        };
        let text = atas_text_file::read(&file).map_err(|error| unreadable(&file, &error))?;
        let config: Config =
            toml::from_str(&text).map_err(|error| rejected(&file, &toml_error(&text, &error)))?;
        let server = match config.servers.get(&label) {
            Some(server) => server.clone(),
            None if label.contains(':') => Server {
                address: label.clone(),
                server_name: None,
            },
            None => return Err(unknown(&label, &file, &config)),
        };
        let name = server_name(&server).map_err(|why| ExitError::with_code(Exit::Usage, why))?;
        let folder = file.parent().unwrap_or(Path::new("."));
        let path = |path: &PathBuf| folder.join(path);
        let tls = tls::client(Files {
            authority: &path(&config.ca),
            certificate: &path(&config.certificate),
            key: &path(&config.key),
        })?;
        Ok(Self {
            label,
            address: server.address,
            name,
            tls,
        })
    }
}

fn default_file() -> anyhow::Result<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from);
    let folder = folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")));
    folder
        .map(|folder| folder.join("atas/remote.toml"))
        .ok_or_else(|| {
            ExitError::with_code(
                Exit::Input,
                "no client configuration: HOME is not set; use --remote-config FILE",
            )
        })
}

fn unreadable(file: &Path, error: &std::io::Error) -> anyhow::Error {
    let why = format!(
        "{error}; a client needs a certificate: `atas remote keys` creates one with its \
         configuration, and --remote-config selects another file"
    );
    rejected(file, &why)
}

fn unknown(label: &str, file: &Path, config: &Config) -> anyhow::Error {
    let names: Vec<&str> = config.servers.keys().map(String::as_str).collect();
    let known = match names.as_slice() {
        [] => "it lists no servers".to_owned(),
        names => format!("it lists {}", names.join(", ")),
    };
    let sentence = format!(
        "--remote {label} is not in {}: {known}; add [servers.{label}], or use HOST:PORT",
        file.display()
    );
    ExitError::with_code(Exit::Usage, sentence)
}

/// Returns the name that the certificate must contain.
fn server_name(server: &Server) -> Result<ServerName<'static>, String> {
    let address = &server.address;
    let (host, port) = address
        .rsplit_once(':')
        .ok_or_else(|| format!("address {address} has no port; use HOST:PORT"))?;
    if port.parse::<u16>().is_err() {
        return Err(format!(
            "address {address} has no valid port; use HOST:PORT"
        ));
    }
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let name = server.server_name.as_deref().unwrap_or(host);
    ServerName::try_from(name.to_owned())
        .map_err(|_| format!("{name:?} is neither a host name nor an IP address"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_in_certificate_is_host_or_configured() {
        let name = |address: &str, server_name: Option<&str>| {
            server_name_text(&Server {
                address: address.into(),
                server_name: server_name.map(str::to_owned),
            })
        };
        assert_eq!(name("robot.lab:7843", None).as_deref(), Ok("robot.lab"));
        assert_eq!(name("192.0.2.7:7843", None).as_deref(), Ok("192.0.2.7"));
        assert_eq!(
            name("[2001:db8::7]:7843", None).as_deref(),
            Ok("2001:db8::7")
        );
        assert_eq!(
            name("192.0.2.7:1", Some("robot.lab")).as_deref(),
            Ok("robot.lab")
        );
        for address in ["robot.lab", "robot.lab:", "robot.lab:http", ":7843"] {
            assert!(name(address, None).is_err(), "{address}");
        }
    }

    fn server_name_text(server: &Server) -> Result<String, String> {
        server_name(server).map(|name| name.to_str().into_owned())
    }
}
