// The ground shadows of `ground.wgsl`, for the trees of a forest.

@vertex
fn vs_forest_patch(@builtin(vertex_index) index: u32, @builtin(instance_index) tree: u32) -> Patch {
    return patch_of(index, instance_of(tree));
}
