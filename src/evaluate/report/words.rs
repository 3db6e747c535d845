//! What each figure means, in one sentence; the page says the same wherever the figure stands.

pub(super) const IOU: &str = "IoU: shared part of the two silhouettes; 1 is equal.";
pub(super) const AREA: &str =
    "Area: how much more (+) or less (\u{2212}) of the picture is covered than by the full tree.";
pub(super) const AREA_OFF: &str =
    "Area off: error of the covered area in each view, without its sign; 0% is equal.";
pub(super) const FLIP: &str = "FLIP: the difference that an eye sees when it flips between the two pictures; 0 is none, 1 the most. Mean of two lights.";
pub(super) const WORST: &str = "Worst: FLIP under the worse of the two lights, a high sun before mid-grey and a low one across before a dark grey.";
pub(super) const POP: &str =
    "Pop: FLIP when the LOD takes the place of the next finer one, at the size at which it does.";
pub(super) const FLICKER: &str = "Flicker: change from frame to frame of a slow orbit, 64 px high, by that of the full tree; more than 1 is restless.";
pub(super) const INTERVAL: &str =
    "\u{b1}: half of the 95% interval of the mean, from resampled views.";
pub(super) const NORMALS: &str = "Normals: mean angle between the two surfaces where both cover a pixel; light falls alike at 0\u{b0}.";
pub(super) const LAYERS: &str = "Layers: how often a pixel of the full tree's frame is drawn, transparent texels too; the fill cost.";
pub(super) const ERROR: &str =
    "Error: edge, in metres, of the blocks whose covered area is right to within a tenth.";
pub(super) const UP_TO: &str =
    "Up to: height of the tree on a screen of 1080 lines up to which the LOD may be shown.";
pub(super) const TRIANGLES: &str =
    "Triangles: what is drawn, as a number and as a part of the full tree.";
pub(super) const TEXTURE: &str =
    "Foliage texture: colour and alpha as RGBA8 without mips, once for all LODs.";
pub(super) const RIVAL: &str =
    "A rival is another way of simplifying, held to the budget of one of the LODs.";

pub(super) const PAST: &str = "<em class=\"past\">Marked</em> figures are past a limit, which holds only at the size at which a LOD is shown.";

/// All of the figures, in the order of the tables.
pub(super) const ALL: [&str; 14] = [
    IOU, AREA, AREA_OFF, FLIP, WORST, POP, FLICKER, NORMALS, INTERVAL, LAYERS, TRIANGLES, ERROR,
    UP_TO, TEXTURE,
];
