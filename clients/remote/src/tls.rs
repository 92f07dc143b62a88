//! TLS 1.3 with certificates on both sides.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use rustls::client::WebPkiServerVerifier;
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::WebPkiClientVerifier;
use rustls::{
    AlertDescription, CertificateError, ClientConfig, Error, RootCertStore, ServerConfig, version,
};

use crate::rejection::rejected;
use crate::{ALPN, permission};

/// Files of one side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Files<'a> {
    /// Certificates of the authorities of the other side.
    pub(crate) authority: &'a Path,
    /// Own certificate, with intermediate certificates.
    pub(crate) certificate: &'a Path,
    /// Own private key.
    pub(crate) key: &'a Path,
}

/// Loads the server's side: each client needs a certificate of the authority.
pub(crate) fn server(files: Files<'_>) -> anyhow::Result<Arc<ServerConfig>> {
    let (roots, chain, key) = load(files)?;
    let verifier = WebPkiClientVerifier::builder_with_provider(roots, provider())
        .build()
        .map_err(|error| rejected(files.authority, &error))?;
    let mut config = ServerConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&version::TLS13])
        .context("TLS 1.3 is not available")?
        .with_client_cert_verifier(verifier)
        .with_single_cert(chain, key)
        .map_err(|error| rejected(files.certificate, &error))?;
    config.alpn_protocols = vec![ALPN.to_vec()];
    // A resumed session would skip the check of the expiry date.
    config.send_tls13_tickets = 0;
    Ok(Arc::new(config))
}

/// Loads the client's side.
pub(crate) fn client(files: Files<'_>) -> anyhow::Result<Arc<ClientConfig>> {
    let (roots, chain, key) = load(files)?;
    let verifier = WebPkiServerVerifier::builder_with_provider(roots, provider())
        .build()
        .map_err(|error| rejected(files.authority, &error))?;
    let mut config = ClientConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&version::TLS13])
        .context("TLS 1.3 is not available")?
        .with_webpki_verifier(verifier)
        .with_client_auth_cert(chain, key)
        .map_err(|error| rejected(files.certificate, &error))?;
    config.alpn_protocols = vec![ALPN.to_vec()];
    Ok(Arc::new(config))
}

fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}

type Loaded = (
    Arc<RootCertStore>,
    Vec<CertificateDer<'static>>,
    PrivateKeyDer<'static>,
);

fn load(files: Files<'_>) -> anyhow::Result<Loaded> {
    let mut roots = RootCertStore::empty();
    for authority in certificates(files.authority)? {
        let added = roots.add(authority);
        added.map_err(|error| rejected(files.authority, &error))?;
    }
    let chain = certificates(files.certificate)?;
    let text = permission::read_private(files.key)?;
    let key = PrivateKeyDer::from_pem_slice(text.as_bytes())
        .map_err(|error| rejected(files.key, &error))?;
    Ok((Arc::new(roots), chain, key))
}

fn certificates(file: &Path) -> anyhow::Result<Vec<CertificateDer<'static>>> {
    let text = atas_text_file::read(file).map_err(|error| rejected(file, &error))?;
    let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(text.as_bytes()).collect();
    let found = found.map_err(|error| rejected(file, &error))?;
    if found.is_empty() {
        return Err(rejected(file, &"it contains no certificate in PEM format"));
    }
    Ok(found)
}

/// Returns the names of the host or person in a certificate.
pub(crate) fn names(certificate: &CertificateDer<'_>) -> Vec<String> {
    let parsed = webpki::EndEntityCert::try_from(certificate);
    parsed.map_or_else(
        |_| Vec::new(),
        |parsed| parsed.valid_dns_names().map(str::to_owned).collect(),
    )
}

/// Formats a failure of TLS with its remedy.
pub(crate) fn error_text(error: &Error) -> String {
    let known = match error {
        Error::AlertReceived(alert) => alert_text(*alert),
        Error::InvalidCertificate(why) => certificate_text(why),
        Error::NoCertificatesPresented => {
            Some("it sent no certificate; configure one with its key")
        }
        Error::NoApplicationProtocol => Some("it is no client of ATAS"),
        Error::InvalidMessage(_) => Some("it does not speak TLS 1.3"),
        _ => None,
    };
    known.map_or_else(|| format!("TLS failed: {error}"), str::to_owned)
}

/// Formats the reason with which the other side rejected this side.
fn alert_text(alert: AlertDescription) -> Option<&'static str> {
    Some(match alert {
        AlertDescription::CertificateRequired => {
            "the other side requires a certificate; configure one with its key"
        }
        AlertDescription::UnknownCA | AlertDescription::DecryptError => {
            "the other side does not accept the authority of this side's certificate; use a \
             certificate of the authority in its configuration"
        }
        AlertDescription::CertificateExpired => {
            "this side's certificate has expired or is not yet valid for the other side's clock; \
             check both clocks, then create a new one"
        }
        AlertDescription::BadCertificate
        | AlertDescription::UnsupportedCertificate
        | AlertDescription::CertificateUnknown => {
            "the other side does not accept this side's certificate; it must be valid for this \
             purpose (client or server)"
        }
        AlertDescription::NoApplicationProtocol | AlertDescription::ProtocolVersion => {
            "the other side is no ATAS server of this version"
        }
        _ => return None,
    })
}

/// Formats the reason with which this side rejected a certificate.
fn certificate_text(why: &CertificateError) -> Option<&'static str> {
    Some(match why {
        CertificateError::UnknownIssuer | CertificateError::BadSignature => {
            "its certificate is not from the configured authority; configure the authority that \
             issued it"
        }
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
            "its certificate has expired; create a new one"
        }
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => {
            "its certificate is not yet valid; check both clocks"
        }
        CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => {
            "its certificate is for another name; connect with the name in the certificate, or \
             configure `server_name`"
        }
        CertificateError::InvalidPurpose | CertificateError::InvalidPurposeContext { .. } => {
            "its certificate is for another purpose; clients and servers need different ones"
        }
        _ => return None,
    })
}
