//! How large a tree may be, so that a slip in a script is refused and not grown.

/// Upper bounds. A tree past one of them is refused before anything is built, with the number that it
/// would have had and the level that makes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Nodes of all levels together. Nodes cost nothing by themselves (the graph holds prototypes),
    /// but captures and shadows have to draw them.
    pub nodes: u64,
    /// Links of one prototype: what the graph does hold.
    pub links: u64,
    /// Triangles of the tree at full detail, which is what `full` would write.
    pub triangles: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            nodes: 50_000_000,
            links: 200_000,
            triangles: 400_000_000,
        }
    }
}
