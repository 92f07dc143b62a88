//! Version of this program and of its bus: product, commit and ABI.
//!
//! The ABI is everything that two processes must agree on: payload layouts, service settings and
//! the release of iceoryx2. [`Abi::current`] reduces it to a number and a hash. The first process
//! on a bus writes its version to the bus's folder. Every later process compares the ABI before it
//! joins ([`crate::Bus::open`]), because services of another ABI have other names and would stay
//! silent.

use std::fmt::{self, Write as _};
use std::fs;
use std::io;
use std::sync::LazyLock;

use iceoryx2_bb_elementary::package_version::PackageVersion;
use shm_schemas::catalogue::PAYLOADS;
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::schema::{PayloadType, Type};

use crate::EXCHANGES;
use crate::error::BusError;
use crate::exchange::Exchange;
use crate::folder::Folder;
use crate::location::{VERSION_FILE, replace};
use crate::qos::{STREAMS, Stream};

/// Longest version text of another program in a message, characters.
const TEXT_MAX: usize = 80;
/// Version of the product.
const PRODUCT: &str = env!("CARGO_PKG_VERSION");
/// Commit of a release build. Only the compiler's environment sets it: a new commit alone rebuilds
/// nothing.
const COMMIT: Option<&str> = option_env!("ATAS_COMMIT");

/// Application binary interface of the bus.
///
/// Programs of equal ABI can share a bus, whatever their product versions are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abi {
    /// Number, raised with every change of the hash.
    pub number: u32,
    /// FNV-1a 64 hash of the layout of all payloads and the settings of all services.
    pub hash: u64,
}

impl Abi {
    /// Number of the current ABI. `tests/abi.golden` lists the hash of each number.
    const NUMBER: u32 = 4;

    /// The ABI of this program.
    #[must_use]
    pub fn current() -> Self {
        static HASH: LazyLock<u64> = LazyLock::new(|| {
            let iceoryx2 = PackageVersion::get();
            hash(&description(
                [iceoryx2.major(), iceoryx2.minor(), iceoryx2.patch()],
                PAYLOADS,
                &STREAMS,
                &EXCHANGES,
            ))
        });
        Self {
            number: Self::NUMBER,
            hash: *HASH,
        }
    }
}

impl fmt::Display for Abi {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "v{} 0x{:016x}", self.number, self.hash)
    }
}

/// Version of this program, as `--version` prints it after the program's name:
/// `0.1.0 (commit 1a2b3c4d5e6f, ABI v1 0x0123456789abcdef)`.
///
/// Release builds set the environment variable `ATAS_COMMIT`. Other builds print `development
/// build` in place of the commit.
#[must_use]
pub fn long_version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| version_text(COMMIT, Abi::current()));
    &TEXT
}

fn version_text(commit: Option<&str>, abi: Abi) -> String {
    let build = match commit {
        Some(commit) if !commit.is_empty() => format!("commit {commit}"),
        _ => "development build".to_owned(),
    };
    format!("{PRODUCT} ({build}, ABI {abi})")
}

/// Stores the version of this program. Call under the start-up lock only, when no process is on the
/// bus.
pub(crate) fn store(folder: &Folder) -> Result<(), BusError> {
    replace(folder, VERSION_FILE, &format!("{}\n", bus_version()))
}

/// Version that this program writes to the folder of a bus.
pub(crate) fn bus_version() -> String {
    format!("atas {PRODUCT} ({})", abi_text())
}

fn abi_text() -> String {
    format!("ABI {}", Abi::current())
}

/// The version that the folder names, if its ABI differs from the one of this program.
pub(crate) fn other_version(folder: &Folder) -> Result<Option<String>, BusError> {
    let path = folder.path.join(VERSION_FILE);
    match fs::read(&path) {
        Ok(bytes) => Ok(differing_version(&String::from_utf8_lossy(&bytes))),
        // Only a development build before 0.1.0 creates a bus without this file.
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            Ok(Some("an unknown version of atas".to_owned()))
        }
        Err(e) => Err(BusError::io("read", &path)(e)),
    }
}

/// The text, shortened for a message, unless it names the ABI of this program.
fn differing_version(text: &str) -> Option<String> {
    let printable = text.trim().chars().filter(|c| !c.is_control());
    let shortened = || printable.take(TEXT_MAX).collect();
    (!text.contains(&format!("({})", abi_text()))).then(shortened)
}

/// Describes the ABI, one line per fact. Comments and known code values are not part of it: a
/// reader displays an unknown value as a number.
fn description(
    iceoryx2: [u16; 3],
    payloads: &[&PayloadType],
    streams: &[Stream],
    exchanges: &[Exchange],
) -> String {
    let [major, minor, patch] = iceoryx2;
    let mut text = format!("iceoryx2 {major}.{minor}.{patch}\n");
    let mut line = |words: fmt::Arguments<'_>| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{words}");
    };
    for payload in payloads {
        let PayloadType {
            wire, size, align, ..
        } = payload;
        line(format_args!("{wire} size {size} align {align}"));
        for field in payload.fields {
            let (name, offset, size) = (field.name, field.offset, field.size);
            let kind = type_text(&field.kind);
            line(format_args!("  {name} at {offset} size {size} {kind}"));
        }
    }
    for stream in streams {
        let (service, payload) = (stream.service, stream.payload);
        let buffers = [stream.buffer, stream.history];
        let peers = [stream.publishers, stream.subscribers, stream.nodes()];
        line(format_args!("{service} {payload} {buffers:?} {peers:?}"));
    }
    for exchange in exchanges {
        let (service, payloads) = (exchange.service, exchange.payloads.join(" "));
        let buffers = [exchange.open_requests, exchange.responses];
        let peers = [exchange.clients, exchange.nodes()];
        line(format_args!("{service} {payloads} {buffers:?} {peers:?}"));
    }
    text
}

fn type_text(kind: &Type) -> String {
    match kind {
        Type::F32 => "f32".to_owned(),
        Type::F64 => "f64".to_owned(),
        Type::U32 => "u32".to_owned(),
        Type::U64 => "u64".to_owned(),
        Type::Text(bytes) => format!("text {bytes}"),
        Type::Code(code) => format!("code {}", code.name),
        Type::Payload(part) => part.wire.to_owned(),
        Type::Array(of, count) => format!("{}[{count}]", type_text(of)),
    }
}

fn hash(description: &str) -> u64 {
    fnv1a(FNV_OFFSET, description.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::schema::Field;

    const ICEORYX2: [u16; 3] = [0, 10, 0];

    fn payload(wire: &'static str, align: usize, fields: &'static [Field]) -> PayloadType {
        PayloadType {
            name: "Sample",
            wire,
            doc: &[],
            size: 16,
            align,
            fields,
        }
    }

    const fn field(name: &'static str, offset: usize, kind: Type) -> Field {
        Field {
            name,
            offset,
            size: 8,
            kind,
            doc: &[],
        }
    }

    #[test]
    fn every_change_of_layout_changes_the_hash() {
        static FIELDS: &[Field] = &[field("a_n", 0, Type::F64), field("b_n", 8, Type::F64)];
        static RENAMED: &[Field] = &[field("a_m", 0, Type::F64), field("b_n", 8, Type::F64)];
        static SWAPPED: &[Field] = &[field("b_n", 0, Type::F64), field("a_n", 8, Type::F64)];
        static RETYPED: &[Field] = &[field("a_n", 0, Type::U64), field("b_n", 8, Type::F64)];
        static TEXT: &[Field] = &[field("a_n", 0, Type::Text(8)), field("b_n", 8, Type::F64)];
        static ARRAY: &[Field] = &[
            field("a_n", 0, Type::Array(&Type::F32, 2)),
            field("b_n", 8, Type::F64),
        ];
        static SHORTER: &[Field] = &[field("a_n", 0, Type::F64)];
        let of_payload =
            |payload: &PayloadType| hash(&description(ICEORYX2, &[payload], &STREAMS, &EXCHANGES));
        let mut hashes = vec![
            of_payload(&payload("atas.Sample.v1", 8, FIELDS)),
            of_payload(&payload("atas.Sample.v2", 8, FIELDS)),
            of_payload(&payload("atas.Sample.v1", 4, FIELDS)),
        ];
        let fields = [RENAMED, SWAPPED, RETYPED, TEXT, ARRAY, SHORTER];
        hashes.extend(fields.map(|fields| of_payload(&payload("atas.Sample.v1", 8, fields))));
        let sample = payload("atas.Sample.v1", 8, FIELDS);
        let of_services = |streams: &[Stream], exchanges: &[Exchange]| {
            hash(&description(ICEORYX2, &[&sample], streams, exchanges))
        };
        let mut streams = STREAMS;
        streams[0].buffer += 1;
        let mut exchanges = EXCHANGES;
        exchanges[0].service = "atas/v0/goal";
        hashes.push(of_services(&streams, &EXCHANGES));
        hashes.push(of_services(&STREAMS, &exchanges));
        hashes.push(hash(&description(
            [0, 10, 1],
            &[&sample],
            &STREAMS,
            &EXCHANGES,
        )));
        for (i, hash) in hashes.iter().enumerate() {
            assert!(!hashes[..i].contains(hash), "change {i} keeps the hash");
        }
    }

    #[test]
    fn version_names_commit_or_development_build() {
        let abi = Abi {
            number: 7,
            hash: 0x1234,
        };
        let check = |commit, build: &str| {
            let expected = format!("{PRODUCT} ({build}, ABI v7 0x0000000000001234)");
            assert_eq!(version_text(commit, abi), expected);
        };
        check(Some("1a2b3c4d5e6f"), "commit 1a2b3c4d5e6f");
        check(Some(""), "development build");
        check(None, "development build");
    }

    #[test]
    fn only_another_abi_differs() {
        let same = bus_version();
        assert_eq!(differing_version(&same), None);
        // Another release with the same ABI.
        assert_eq!(differing_version(&same.replace(PRODUCT, "9.9.9")), None);
        let other = "atas 9.9.9 (ABI v9 0x0123456789abcdef)";
        let found = differing_version(&format!("{other}\n"));
        assert_eq!(found.as_deref(), Some(other));
        let long = differing_version(&"\u{1b}x".repeat(1000)).expect("not a version");
        assert_eq!(long, "x".repeat(TEXT_MAX));
    }
}
