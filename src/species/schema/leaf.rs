//! Leaves: what a card shows, from the twig down to the teeth of a blade.

/// A leaf card: how large it is, and what is drawn on it.
#[derive(Clone, Debug, PartialEq)]
pub struct LeafKind {
    /// Unique name.
    pub name: String,
    /// Card length along the stalk, metres.
    pub length_m: f32,
    /// Card width, metres.
    pub width_m: f32,
    /// Angle by which each half is folded up along the midrib, degrees (0 is a flat card).
    pub fold_deg: f32,
    /// What is on the card.
    pub look: LeafLook,
}

/// What is drawn on a leaf card.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a species has a handful, and nearly all are drawn"
)]
pub enum LeafLook {
    /// Drawn from a description.
    Drawn(LeafArt),
    /// An image file with an alpha channel, stalk at the middle of the lower edge.
    Image(String),
}

/// A procedural leaf, or a spray of several on one card.
///
/// Three steps, from the outside in: an arrangement sets leaves on the card, a form makes a leaf of
/// one or more blades, and all blades have one outline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeafArt {
    /// How leaves stand on the card.
    pub arrangement: Arrangement,
    /// Side shoots that carry leaves as well; `None` is one twig.
    pub spray: Option<Spray>,
    /// How a leaf is made of blades.
    pub form: Form,
    /// Leaf stalk, as a part of the leaf's length; `None` is none on a single leaf, short in pairs,
    /// longer on alternate leaves.
    pub petiole: Option<f32>,
    /// One blade, leaflet, needle or scale.
    pub blade: Blade,
    /// Flowers among the leaves.
    pub flowers: Option<Flowers>,
    /// Summer colour of the upper side, linear; `None` takes that of `summer`.
    pub colour: Option<[f32; 3]>,
    /// Measured colour in summer.
    pub summer: Tissue,
    /// Measured colour in autumn; `None` keeps that of summer (evergreens).
    pub autumn: Option<Tissue>,
    /// Season, age and health.
    pub state: LeafState,
    /// Random change of lightness from blade to blade (0.1 is 10 % either way).
    pub colour_vary: f32,
    /// Colour of the stalk, linear.
    pub stalk_colour: [f32; 3],
    /// 0..=1: how mirror-smooth the surface is (wax); roughness falls as it rises.
    pub gloss: f32,
    /// 0..=1: light that passes through, as a part of the light that is reflected; `None` takes what
    /// was measured.
    pub translucency: Option<f32>,
}

/// What a leaf has been through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafState {
    /// 0 spring, 1 summer, 2 autumn, 3 winter, and anything between.
    pub season: f32,
    /// 0 unfolding, 0.5 grown, 1 about to fall.
    pub age: f32,
    /// 0 blighted (spots, holes, brown margins) ..= 1 whole.
    pub health: f32,
}

impl Default for LeafState {
    fn default() -> Self {
        Self {
            season: 1.0,
            age: 0.5,
            health: 1.0,
        }
    }
}

/// States of leaf tissue whose colour was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tissue {
    /// A young spring leaf.
    Young,
    /// Thin and light green: birch, aspen.
    LightGreen,
    /// Maple, lime.
    #[default]
    MidGreen,
    /// Oak, beech in summer.
    DarkGreen,
    /// Thick: olive, box, most conifers.
    Evergreen,
    /// Waxy conifers.
    BlueGreen,
    /// Yellow-green, on the turn.
    Turning,
    /// Birch, aspen, larch in autumn.
    Yellow,
    /// Cherry, beech in autumn.
    Orange,
    /// Maple in autumn.
    Red,
    /// Copper beech, purple maples.
    Purple,
    /// Oak, beech late in the year.
    Russet,
    /// Dead.
    Dead,
}

/// How leaves stand on a card. Lengths of leaves are parts of the card's length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Arrangement {
    /// One leaf that fills the card.
    #[default]
    Single,
    /// A twig with opposite pairs of leaves and one at the tip.
    Opposite {
        /// Pairs along the twig.
        pairs: u32,
        /// Angle of a leaf from the twig, degrees.
        angle_deg: f32,
        /// Leaf length.
        blade: f32,
    },
    /// A twig with single leaves on alternating sides and one at the tip.
    Alternate {
        /// Leaves along the twig.
        count: u32,
        /// Angle of a leaf from the twig, degrees.
        angle_deg: f32,
        /// Leaf length.
        blade: f32,
    },
    /// A twig with leaves (needles) all around it, in bundles.
    Brush {
        /// Bundles along the twig.
        count: u32,
        /// Leaves in a bundle: 1 spruce, 2 to 5 pines.
        bundle: u32,
        /// Angle of a bundle from the twig, degrees.
        angle_deg: f32,
        /// Leaf length.
        blade: f32,
    },
    /// A twig with short shoots, each a rosette of leaves (larch), or one at its end.
    Tufts {
        /// Tufts along the twig, the one at its end included.
        count: u32,
        /// Leaves of a tuft.
        leaves: u32,
        /// Angle that a tuft fills, degrees.
        spread_deg: f32,
        /// Leaf length.
        blade: f32,
    },
    /// A twig hidden under pairs of scales, each a quarter turn on from the last (cypress).
    Scales {
        /// Pairs along the twig.
        pairs: u32,
        /// Scale length.
        blade: f32,
    },
}

/// Side shoots in the plane of the card.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spray {
    /// Side shoots along the twig.
    pub shoots: u32,
    /// True for opposite pairs, false for alternate shoots.
    pub opposite: bool,
    /// Angle from the twig, degrees.
    pub angle_deg: f32,
    /// Length of the longest, as a part of the twig's.
    pub length: f32,
    /// How often shoots branch: 1 or 2.
    pub orders: u32,
}

/// How a leaf is made of blades.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Form {
    /// One blade.
    #[default]
    Simple,
    /// Leaflets in pairs along a rachis, and one at its tip (ash, palm fronds).
    Pinnate {
        /// Pairs of leaflets.
        pairs: u32,
        /// Length of the longest leaflet, as a part of the leaf's.
        leaflet: f32,
        /// Angle of a leaflet from the rachis, degrees.
        angle_deg: f32,
        /// Part of the rachis without leaflets.
        bare: f32,
        /// How much shorter the last leaflets are, 0..=1.
        taper: f32,
    },
    /// Pinnae in pairs along a rachis, each pinnate itself (acacia).
    Bipinnate {
        /// Pairs of pinnae.
        pinnae: u32,
        /// Length of a pinna, as a part of the leaf's.
        pinna: f32,
        /// Pairs of leaflets on a pinna.
        pairs: u32,
        /// Length of a leaflet, as a part of the pinna's.
        leaflet: f32,
    },
    /// Leaflets that spread from one point (horse chestnut, fan palms).
    Palmate {
        /// Leaflets.
        leaflets: u32,
        /// Angle between the outermost, degrees.
        spread_deg: f32,
        /// Length of the outermost, as a part of the middle one's.
        outer: f32,
        /// Length of a midrib from which they spread, as a part of the leaf's.
        costa: f32,
    },
}

/// Outline of one blade: a beta profile, `w(u) ~ u^a (1-u)^b`, widest at `a / (a + b)`, with a base,
/// a tip, lobes and a margin of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blade {
    /// Greatest width over length.
    pub width: f32,
    /// Where along the midrib it is widest, 0..1.
    pub widest: f32,
    /// Fullness: 0.3 nearly parallel-sided, 0.5 elliptic, 1 rhombic.
    pub sharpness: f32,
    /// -1..=1: below 0 heart-shaped, above 0 drawn out into a wedge.
    pub base: f32,
    /// -1..=1: below 0 notched, above 0 drawn out to a point.
    pub tip: f32,
    /// 0..=1: how much lower one half begins than the other (elms).
    pub oblique: f32,
    /// 0..=1: size of two ears at the foot (oak).
    pub auricles: f32,
    /// Lobes.
    pub lobes: Lobes,
    /// Teeth.
    pub margin: Margin,
    /// Veins.
    pub veins: Veins,
}

impl Default for Blade {
    fn default() -> Self {
        Self {
            width: 0.5,
            widest: 0.45,
            sharpness: 0.6,
            base: 0.0,
            tip: 0.0,
            oblique: 0.0,
            auricles: 0.0,
            lobes: Lobes::None,
            margin: Margin::default(),
            veins: Veins::Pinnate {
                pairs: 6,
                angle_deg: 50.0,
            },
        }
    }
}

/// Lobes of a blade.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lobes {
    /// None.
    #[default]
    None,
    /// Along both sides (oak).
    Pinnate {
        /// Pairs of lobes below the end lobe.
        pairs: u32,
        /// Depth, as a part of the half width.
        depth: f32,
        /// 0 rounded ..= 1 pointed.
        sharp: f32,
    },
    /// Spread from the foot (maple). `widest` and `sharpness` are a lobe's.
    Palmate {
        /// Lobes.
        count: u32,
        /// Angle between the outermost, degrees.
        spread_deg: f32,
        /// Depth of the cuts, as a part of the way from tip to foot.
        depth: f32,
        /// Length of the outermost, as a part of the middle one's.
        outer: f32,
    },
}

/// Teeth of a blade.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margin {
    /// Their shape.
    pub kind: MarginKind,
    /// Teeth on each side of the blade.
    pub teeth: u32,
    /// Depth, as a part of the half width.
    pub depth: f32,
}

/// Shapes of teeth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MarginKind {
    /// None.
    #[default]
    Entire,
    /// Saw teeth that point to the tip.
    Serrate,
    /// Saw teeth with smaller ones on them.
    DoublySerrate,
    /// Rounded teeth.
    Crenate,
    /// Pointed teeth with wide hollows between them.
    Dentate,
    /// Shallow waves.
    Wavy,
}

/// Main veins of a blade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Veins {
    /// Only a midrib.
    Midrib,
    /// Side veins that run out into the margin (beech, oak, elm).
    Pinnate {
        /// Side veins on each side.
        pairs: u32,
        /// Angle from the midrib, degrees.
        angle_deg: f32,
    },
    /// Side veins that bend round inside the margin and join (cherry, willow).
    Looping {
        /// Side veins on each side.
        pairs: u32,
        /// Angle from the midrib, degrees.
        angle_deg: f32,
    },
    /// Several main veins from the foot (maple, lime), with side veins.
    Palmate {
        /// Main veins; those of a palmately lobed blade run into its lobes whatever the number.
        count: u32,
        /// Side veins on each side of a main vein.
        pairs: u32,
    },
    /// Veins beside the midrib from base to tip (palms).
    Parallel {
        /// Veins on each side.
        count: u32,
    },
}

/// Flowers among the leaves of a twig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flowers {
    /// Flowers on the card.
    pub count: u32,
    /// Petals of a flower.
    pub petals: u32,
    /// Width of a flower, as a part of the card's length.
    pub size: f32,
    /// Colour of the petals, linear.
    pub colour: [f32; 3],
}
