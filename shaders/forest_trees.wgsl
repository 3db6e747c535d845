// What `tree.wgsl` draws, for the trees of a forest.

@vertex
fn vs_forest(vertex: Vertex, @builtin(instance_index) index: u32) -> Varyings {
    return tree_drawn(vertex, instance_of(index));
}

@vertex
fn vs_forest_cast(vertex: Vertex, @builtin(instance_index) index: u32) -> Cast {
    return tree_cast(vertex, instance_of(index));
}
