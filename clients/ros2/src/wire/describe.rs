//! Type descriptions and type hashes of ROS 2 (REP 2016, `RIHS01`).
//!
//! The description of a type follows from its Rust fields, so wire format and hash cannot differ.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

/// Codes of `type_description_interfaces/msg/FieldType`.
const NESTED: u8 = 1;
const ARRAY: u8 = 48;
const BOUNDED_SEQUENCE: u8 = 96;
const SEQUENCE: u8 = 144;

/// Type of a field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldType {
    /// Code of the type.
    pub id: u8,
    /// Length of an array, bound of a sequence, else 0.
    pub capacity: u64,
    /// Name of a nested type, else empty.
    pub nested: String,
}

/// Fields of a type by name, in order.
pub type Fields = Vec<(&'static str, FieldType)>;

/// Descriptions of nested types by name.
pub type Nested = BTreeMap<String, Fields>;

/// Value that can be a field of a message.
pub trait Field {
    /// Returns the type of the field and adds the descriptions of nested types.
    fn describe(nested: &mut Nested) -> FieldType;
}

/// Message, request or response on the wire.
pub trait Message:
    Serialize + DeserializeOwned + Clone + Default + Send + Sync + std::fmt::Debug + 'static
{
    /// Returns the name, for example `sensor_msgs/msg/JointState`.
    fn type_name() -> String;

    /// Returns the fields and adds the descriptions of nested types.
    fn fields(nested: &mut Nested) -> Fields;
}

/// ROS 2 service.
pub trait Service: Send + 'static {
    /// Request.
    type Request: Message;
    /// Response.
    type Response: Message;
    /// Returns the name, for example `std_srvs/srv/Trigger`.
    fn type_name() -> String;
}

impl<M: Message> Field for M {
    fn describe(nested: &mut Nested) -> FieldType {
        let name = M::type_name();
        if !nested.contains_key(&name) {
            let fields = M::fields(nested);
            nested.insert(name.clone(), fields);
        }
        FieldType {
            id: NESTED,
            capacity: 0,
            nested: name,
        }
    }
}

macro_rules! primitive {
    ($($type:ty: $id:expr),*) => {$(
        impl Field for $type {
            fn describe(_: &mut Nested) -> FieldType {
                FieldType { id: $id, capacity: 0, nested: String::new() }
            }
        }
    )*};
}
primitive!(i8: 2, u8: 3, i16: 4, u16: 5, i32: 6, u32: 7, i64: 8, u64: 9, f32: 10, f64: 11);
primitive!(bool: 15, Byte: 16, String: 17);

/// Byte without numeric meaning (`byte` of a ROS 2 definition, `octet` of IDL).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Byte(pub u8);

impl<T: Field> Field for Vec<T> {
    fn describe(nested: &mut Nested) -> FieldType {
        let element = T::describe(nested);
        FieldType {
            id: element.id + SEQUENCE,
            ..element
        }
    }
}

/// Sequence of at most `N` elements.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Bounded<T, const N: usize>(pub Vec<T>);

impl<T, const N: usize> Default for Bounded<T, N> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Field, const N: usize> Field for Bounded<T, N> {
    fn describe(nested: &mut Nested) -> FieldType {
        let element = T::describe(nested);
        FieldType {
            id: element.id + BOUNDED_SEQUENCE,
            capacity: N as u64,
            ..element
        }
    }
}

impl<T: Field, const N: usize> Field for [T; N] {
    fn describe(nested: &mut Nested) -> FieldType {
        let element = T::describe(nested);
        FieldType {
            id: element.id + ARRAY,
            capacity: N as u64,
            ..element
        }
    }
}

/// Returns the type hash of a message, for example `RIHS01_a1b2…`.
#[must_use]
pub fn message_hash<M: Message>() -> String {
    let mut nested = Nested::new();
    let fields = M::fields(&mut nested);
    hash(&M::type_name(), &fields, &nested)
}

/// Returns the type hash of a service: of its request, response and event.
#[must_use]
pub fn service_hash<S: Service>() -> String {
    let mut nested = Nested::new();
    let request = S::Request::describe(&mut nested);
    let response = S::Response::describe(&mut nested);
    let at_most_one = |of: &FieldType| FieldType {
        id: of.id + BOUNDED_SEQUENCE,
        capacity: 1,
        ..of.clone()
    };
    let info = super::standard::ServiceEventInfo::describe(&mut nested);
    let event = format!("{}_Event", S::type_name());
    let parts = vec![
        ("info", info),
        ("request", at_most_one(&request)),
        ("response", at_most_one(&response)),
    ];
    nested.insert(event.clone(), parts);
    let event = FieldType {
        id: NESTED,
        capacity: 0,
        nested: event,
    };
    let fields = vec![
        ("request_message", request),
        ("response_message", response),
        ("event_message", event),
    ];
    hash(&S::type_name(), &fields, &nested)
}

fn hash(name: &str, fields: &Fields, nested: &Nested) -> String {
    let parts: Vec<String> = nested
        .iter()
        .map(|(name, fields)| individual(name, fields))
        .collect();
    let text = format!(
        "{{\"type_description\": {}, \"referenced_type_descriptions\": [{}]}}",
        individual(name, fields),
        parts.join(", ")
    );
    let digest = Sha256::digest(text.as_bytes());
    let mut text = "RIHS01_".to_owned();
    for byte in digest {
        // Writing to a string cannot fail.
        let _written = write!(text, "{byte:02x}");
    }
    text
}

/// Returns the description of one type as JSON in the form that the hash requires.
fn individual(name: &str, fields: &Fields) -> String {
    let fields: Vec<String> = fields
        .iter()
        .map(|(name, of)| {
            format!(
                "{{\"name\": \"{name}\", \"type\": {{\"type_id\": {}, \"capacity\": {}, \
                 \"string_capacity\": 0, \"nested_type_name\": \"{}\"}}}}",
                of.id, of.capacity, of.nested
            )
        })
        .collect();
    format!(
        "{{\"type_name\": \"{name}\", \"fields\": [{}]}}",
        fields.join(", ")
    )
}

/// Defines messages: a Rust struct with the fields of the ROS 2 definition.
macro_rules! messages {
    ($($(#[$about:meta])* $name:ident as $ros:literal {
        $($(#[$of:meta])* $field:ident: $type:ty),* $(,)?
    })*) => {$(
        $(#[$about])*
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $name { $($(#[$of])* pub $field: $type),* }

        impl $crate::wire::Message for $name {
            fn type_name() -> String { $ros.to_owned() }

            fn fields(nested: &mut $crate::wire::Nested) -> $crate::wire::Fields {
                let _ = &nested;
                vec![$((
                    stringify!($field).trim_start_matches("r#"),
                    <$type as $crate::wire::Field>::describe(nested)
                )),*]
            }
        }

        #[cfg(feature = "dds")]
        impl ros2_client::Message for $name {}
    )*};
}

/// Defines services by request and response.
macro_rules! services {
    ($($(#[$about:meta])* $name:ident as $ros:literal: $request:ty => $response:ty;)*) => {$(
        $(#[$about])*
        #[derive(Clone, Copy, Debug)]
        pub enum $name {}

        impl $crate::wire::Service for $name {
            type Request = $request;
            type Response = $response;
            fn type_name() -> String { $ros.to_owned() }
        }
    )*};
}

pub(crate) use {messages, services};
