//! Impostor families: flat stand-ins for parts of a tree. One file a family.

pub mod cross_quad;
pub mod planes;
