//! Tests of the bus schema: pinned layouts and texts, and robustness against arbitrary bytes.

mod codes;
mod dome;
mod header;
mod layout;
mod named_layouts;
mod reason_texts;
mod reasons;
mod seal;
mod services;
mod text;
