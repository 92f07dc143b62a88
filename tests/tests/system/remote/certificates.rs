//! Tests of certificates: without one, of another authority, purpose or name, expired, and of
//! private keys that others can read.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::Duration;

use rcgen::{CertificateParams, DnType, ExtendedKeyUsagePurpose, Issuer, KeyPair, PublicKeyData};
use system_tests::{lock_exclusive, wait_for};
use time::OffsetDateTime;

use super::fixture::*;
use super::parts;

#[test]
fn foreign_certificates_are_refused_on_both_sides() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::new();
    // Without a certificate.
    let mut link = rig.raw(None);
    let refused = std::io::Read::read(&mut link, &mut [0; 64]).expect_err("refused");
    assert!(
        refused.to_string().contains("CertificateRequired"),
        "{refused}"
    );
    // A client of another laboratory, with the authority of this server.
    create_keys(
        &rig.path("foreign"),
        &["localhost", "127.0.0.1"],
        &["alice"],
    );
    let swap = |from: &str, to: &str| {
        fs::copy(rig.path(from), rig.path(to)).expect("copied");
    };
    swap("lab/ca.pem", "foreign/alice/ca.pem");
    fs::rename(rig.path("foreign/alice"), rig.path("lab/intruder")).expect("moved");
    rig.check("intruder", "status", 4, "does not accept the authority");
    rig.check("intruder", "estop", 4, "stop not confirmed");
    // The certificate of the server does not serve as that of a client.
    fs::create_dir(rig.path("lab/thief")).expect("made");
    for file in ["ca.pem", "certificate.pem", "key.pem"] {
        swap(&format!("lab/server/{file}"), &format!("lab/thief/{file}"));
    }
    swap("lab/alice/remote.toml", "lab/thief/remote.toml");
    rig.check("thief", "status", 4, "could not connect");
    // An expired certificate of this laboratory.
    issue_expired(&rig.path("lab"), "former");
    swap("lab/alice/remote.toml", "lab/former/remote.toml");
    rig.check("former", "status", 4, "has expired");
    for part in [
        "it sent no certificate",
        "not from the configured authority",
        "has expired",
    ] {
        wait_for(part, || rig.server.log().contains(part).then_some(()));
    }

    // A client rejects a server of another laboratory, and of another name.
    swap("foreign/ca.pem", "lab/display/ca.pem");
    rig.check("display", "status", 4, "not from the configured authority");
    let port = rig.address.rsplit(':').next().expect("a port");
    let other = rig
        .remote_at(&format!("127.0.0.2:{port}"), "alice", "status")
        .output();
    assert_ne!(parts(&other.expect("it starts")).0, Some(0));
    // A key that others can read.
    let key = rig.path("lab/alice/key.pem");
    fs::set_permissions(&key, fs::Permissions::from_mode(0o644)).expect("set");
    rig.check("alice", "status", 7, "chmod 600");
    rig.check("alice", "estop", 7, "stop not sent");
}

/// Name of an authority, as `atas remote keys` derives it from its key.
fn authority_name(pair: &KeyPair) -> String {
    let key = pair.der_bytes().iter().rev().take(6);
    key.fold("ATAS laboratory ".to_owned(), |name, byte| {
        name + &format!("{byte:02x}")
    })
}

/// Issues a certificate that has expired, with the authority of a folder.
fn issue_expired(folder: &Path, name: &str) {
    let key = fs::read_to_string(folder.join("ca.key")).expect("readable");
    let pair = KeyPair::from_pem(&key).expect("a key");
    let mut authority = CertificateParams::new(Vec::<String>::new()).expect("valid");
    authority
        .distinguished_name
        .push(DnType::CommonName, authority_name(&pair));
    let issuer = Issuer::new(authority, pair);
    let mut params = CertificateParams::new(vec![name.to_owned()]).expect("a name");
    params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ClientAuth];
    params.not_before = OffsetDateTime::now_utc() - Duration::from_secs(7_200);
    params.not_after = OffsetDateTime::now_utc() - Duration::from_secs(60);
    let pair = KeyPair::generate().expect("a key");
    let certificate = params.signed_by(&pair, &issuer).expect("signed").pem();
    let own = folder.join(name);
    fs::create_dir(&own).expect("made");
    fs::copy(folder.join("ca.pem"), own.join("ca.pem")).expect("copied");
    fs::write(own.join("certificate.pem"), certificate).expect("written");
    let key = own.join("key.pem");
    fs::write(&key, pair.serialize_pem()).expect("written");
    fs::set_permissions(&key, fs::Permissions::from_mode(0o600)).expect("set");
}
