//! Arguments of remote operation: `--remote`, `atas remote` and `atas recordings`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::values::mcap;

/// Selection of a daemon on another machine, for every command.
#[derive(Args, Clone, Debug, Default)]
pub struct RemoteArgument {
    /// Run the command at a daemon on another machine, over TLS: a name of the client
    /// configuration, or HOST:PORT
    #[arg(long, global = true, value_name = "NAME|HOST:PORT")]
    pub remote: Option<String>,
    /// Client configuration for --remote, with certificate and key [default:
    /// ~/.config/atas/remote.toml]
    #[arg(long, global = true, value_name = "FILE", env = "ATAS_REMOTE_CONFIG")]
    pub remote_config: Option<PathBuf>,
}

/// `atas remote`.
#[derive(Clone, Debug, Subcommand)]
pub enum RemoteAction {
    /// Serve the daemon of this machine to clients with a certificate, until SIGTERM
    Serve {
        /// Configuration: address, certificates, clients and their rights
        #[arg(long, value_name = "FILE")]
        config: PathBuf,
    },
    /// Create a certificate authority and certificates for a laboratory
    ///
    /// The folder gets the authority, one certificate for the server and one per client. A second
    /// call with the same folder adds certificates of the same authority.
    Keys {
        /// Output folder
        #[arg(long, value_name = "FOLDER")]
        out: PathBuf,
        /// Name or IP address of the server, as clients enter it; may be repeated
        #[arg(long = "host", value_name = "NAME")]
        hosts: Vec<String>,
        /// Name of a client; may be repeated
        #[arg(long = "client", value_name = "NAME")]
        clients: Vec<String>,
        /// Validity of the certificates, days
        #[arg(long, value_name = "DAYS", default_value = "365", value_parser = clap::value_parser!(u16).range(1..=3650))]
        days: u16,
    },
    /// Connect with --remote, show the right of this client and measure round trips
    Check {
        /// Number of round trips
        #[arg(long, value_name = "N", default_value = "100", value_parser = clap::value_parser!(u16).range(1..=10_000))]
        count: u16,
    },
}

/// `atas recordings`.
#[derive(Clone, Debug, Subcommand)]
pub enum Recordings {
    /// List the recordings of a folder with size and age, the newest first
    List {
        /// Folder [default: the current one; with --remote that of the server]
        #[arg(long, value_name = "FOLDER")]
        folder: Option<PathBuf>,
    },
    /// Copy a recording into a new file
    Fetch {
        /// Name of the recording, as `list` prints it
        #[arg(value_name = "NAME.mcap", value_parser = recording)]
        name: String,
        /// Output file; it must not exist [default: NAME.mcap in the current folder]
        #[arg(long, value_name = "FILE.mcap", value_parser = mcap)]
        out: Option<PathBuf>,
        /// Folder [default: the current one; with --remote that of the server]
        #[arg(long, value_name = "FOLDER")]
        folder: Option<PathBuf>,
        /// Write the recording to standard output
        #[arg(long, hide = true, conflicts_with = "out")]
        stdout: bool,
    },
}

/// Parses the name of a recording: a visible `.mcap` file without a folder.
fn recording(text: &str) -> Result<String, String> {
    mcap(text)?;
    if text.starts_with('.') || text.contains(['/', '\0']) {
        return Err("needs the name of a file, without its folder".into());
    }
    Ok(text.to_owned())
}
