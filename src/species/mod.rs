//! Species scripts.

pub mod schema;
