//! Tests of the words on the bus: what is pinned for ever, and what bytes from anywhere must not break.

mod codes;
mod dome;
mod header;
mod layout;
mod named_layouts;
mod reasons;
mod seal;
mod services;
mod text;
