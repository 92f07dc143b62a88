//! `atas remote keys`: a certificate authority of a laboratory, and certificates of its members.
//!
//! ```text
//!  FOLDER/ca.pem, ca.key                       authority; its key stays here
//!  FOLDER/server/{ca,certificate}.pem, key.pem copy to the robot's machine
//!  FOLDER/NAME/{ca,certificate}.pem, key.pem, remote.toml   copy to the machine of client NAME
//! ```

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, ensure};
use atas_console::{Exit, ExitError, Output};
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose, PublicKeyData,
};
use serde_json::json;
use time::{Duration, OffsetDateTime};

use crate::permission::{read_private, write_new};
use crate::rejection::rejected;
use crate::server::is_client_name;

/// Begin of an authority's name. The rest distinguishes the authorities of several laboratories.
const AUTHORITY: &str = "ATAS laboratory ";
/// Bytes of the public key in the name.
const NAME_BYTES: usize = 6;
/// Folder of the server's files.
const SERVER: &str = "server";
/// Start of validity before the present time: clocks differ.
const CLOCK_ERROR: Duration = Duration::HOUR;
/// Validity of the authority. Design choice: longer than that of each certificate.
const AUTHORITY_VALIDITY: Duration = Duration::days(3_660);

/// Creates the files and lists them.
pub(crate) fn create(
    folder: &Path,
    hosts: &[String],
    clients: &[String],
    days: u16,
    output: &mut Output,
) -> anyhow::Result<()> {
    if hosts.is_empty() && clients.is_empty() {
        let sentence =
            "nothing to create: give --host NAME for a server, --client NAME for clients";
        return Err(ExitError::with_code(Exit::Usage, sentence));
    }
    for name in clients {
        if !is_client_name(name) || name == SERVER {
            let sentence = format!(
                "client name {name:?} was rejected: needs small letters, digits, hyphens and dots, \
                 and not {SERVER:?}"
            );
            return Err(ExitError::with_code(Exit::Usage, sentence));
        }
    }
    let mut keys = Keys::open(folder, days)?;
    if !hosts.is_empty() {
        let purpose = ExtendedKeyUsagePurpose::ServerAuth;
        keys.issue(SERVER, hosts, purpose)?;
    }
    for name in clients {
        let purpose = ExtendedKeyUsagePurpose::ClientAuth;
        keys.issue(name, std::slice::from_ref(name), purpose)?;
        keys.write_client_configuration(name)?;
    }
    print(&keys, output)
}

fn print(keys: &Keys, output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&json!({ "files": keys.written }));
    }
    for file in &keys.written {
        output.line(file.display())?;
    }
    output.line("copy each folder to its machine only; keep ca.key offline")
}

/// Authority in a folder.
struct Keys {
    folder: PathBuf,
    days: u16,
    authority: String,
    issuer: Issuer<'static, KeyPair>,
    written: Vec<PathBuf>,
}

impl Keys {
    /// Opens the authority of a folder, or creates it.
    fn open(folder: &Path, days: u16) -> anyhow::Result<Self> {
        fs::create_dir_all(folder)
            .with_context(|| format!("could not create {}", folder.display()))?;
        let (certificate, key) = (folder.join("ca.pem"), folder.join("ca.key"));
        let mut written = Vec::new();
        let (authority, params, pair) = if key.exists() {
            let pair = KeyPair::from_pem(&read_private(&key)?);
            let pair = pair.map_err(|error| rejected(&key, &error))?;
            let text = atas_text_file::read(&certificate);
            let text = text.map_err(|error| rejected(&certificate, &error))?;
            (text, authority_of(&pair)?, pair)
        } else {
            let pair = KeyPair::generate()?;
            let params = authority_of(&pair)?;
            let text = params.self_signed(&pair)?.pem();
            write_new(&key, &pair.serialize_pem(), true)?;
            write_new(&certificate, &text, false)?;
            written.extend([certificate, key]);
            (text, params, pair)
        };
        Ok(Self {
            folder: folder.to_owned(),
            days,
            authority,
            issuer: Issuer::new(params, pair),
            written,
        })
    }

    /// Creates key and certificate in a new folder.
    fn issue(
        &mut self,
        name: &str,
        names: &[String],
        purpose: ExtendedKeyUsagePurpose,
    ) -> anyhow::Result<()> {
        let folder = self.folder.join(name);
        ensure!(
            !folder.exists(),
            "{} exists; remove it, or choose another name",
            folder.display()
        );
        let mut params = CertificateParams::new(names)
            .map_err(|error| anyhow!("name {names:?} was rejected: {error}"))?;
        params.distinguished_name.push(DnType::CommonName, name);
        params.use_authority_key_identifier_extension = true;
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = vec![purpose];
        set_validity(&mut params, Duration::days(self.days.into()));
        let pair = KeyPair::generate()?;
        let certificate = params.signed_by(&pair, &self.issuer)?.pem();
        fs::create_dir(&folder)
            .with_context(|| format!("could not create {}", folder.display()))?;
        let authority = self.authority.clone();
        self.write(folder.join("ca.pem"), &authority, false)?;
        self.write(folder.join("certificate.pem"), &certificate, false)?;
        self.write(folder.join("key.pem"), &pair.serialize_pem(), true)
    }

    fn write_client_configuration(&mut self, name: &str) -> anyhow::Result<()> {
        let text = "# Client configuration of `atas --remote HOST:PORT`.\n\
                    ca = \"ca.pem\"\ncertificate = \"certificate.pem\"\nkey = \"key.pem\"\n";
        self.write(self.folder.join(name).join("remote.toml"), text, false)
    }

    fn write(&mut self, file: PathBuf, text: &str, is_private: bool) -> anyhow::Result<()> {
        write_new(&file, text, is_private)?;
        self.written.push(file);
        Ok(())
    }
}

/// Parameters of the authority with this key. Its name follows from the key, so that certificates
/// of a later call have the same issuer.
fn authority_of(pair: &KeyPair) -> anyhow::Result<CertificateParams> {
    let mut params = CertificateParams::new(Vec::<String>::new())?;
    let key = pair.der_bytes().iter().rev().take(NAME_BYTES);
    let name = key.fold(AUTHORITY.to_owned(), |name, byte| {
        name + &format!("{byte:02x}")
    });
    params.distinguished_name.push(DnType::CommonName, name);
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    set_validity(&mut params, AUTHORITY_VALIDITY);
    Ok(params)
}

fn set_validity(params: &mut CertificateParams, validity: Duration) {
    let now = OffsetDateTime::now_utc();
    params.not_before = now - CLOCK_ERROR;
    params.not_after = now + validity;
}
