//! Tests of the judge: a correct command stream passes, and each broken one is rejected.

mod broken;
mod construction;
mod correct;
mod reference;
mod situations;
