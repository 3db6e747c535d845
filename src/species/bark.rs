//! What a species script says of its bark, as plain data.

/// Bark of all branches, seamless around the stem and along it.
#[derive(Clone, Debug, PartialEq)]
pub enum Bark {
    /// Drawn from a description.
    Drawn(BarkArt),
    /// An image file that repeats in both directions.
    Image {
        /// Path of the albedo image.
        path: String,
        /// Real height of one repeat, metres.
        height_m: f32,
        /// Colour of young bark, linear.
        young: [f32; 3],
        /// As in [`BarkArt::mature_radius_m`].
        mature_radius_m: f32,
    },
}

impl Bark {
    /// Real height of one repeat, metres.
    #[must_use]
    pub fn height_m(&self) -> f32 {
        match self {
            Self::Drawn(art) => art.height_m,
            Self::Image { height_m, .. } => *height_m,
        }
    }

    /// Colour of young bark, linear.
    #[must_use]
    pub fn young(&self) -> [f32; 3] {
        match self {
            Self::Drawn(art) => art.young,
            Self::Image { young, .. } => *young,
        }
    }

    /// Radius from which on stems have mature bark, metres; 0 if all have.
    #[must_use]
    pub fn mature_radius_m(&self) -> f32 {
        match self {
            Self::Drawn(art) => art.mature_radius_m,
            Self::Image {
                mature_radius_m, ..
            } => *mature_radius_m,
        }
    }
}

/// A procedural bark.
#[derive(Clone, Debug, PartialEq)]
pub struct BarkArt {
    /// The pattern, with what only it has.
    pub pattern: BarkPattern,
    /// Colour of the heights, linear.
    pub light: [f32; 3],
    /// Colour of the depths, linear.
    pub dark: [f32; 3],
    /// Third colour, linear; each pattern says of what.
    pub accent: [f32; 3],
    /// Colour of young bark, linear: what is to be seen on thin stems, and where `age` is below 1.
    pub young: [f32; 3],
    /// Radius from which on stems have mature bark, metres, 0..=3: thinner ones take on the colour of young bark,
    /// twigs wholly. 0 if all stems look alike.
    pub mature_radius_m: f32,
    /// Real height of one repeat along the stem, metres. One repeat around is as wide as it is high.
    pub height_m: f32,
    /// Real depth of the relief, metres.
    pub depth_m: f32,
    /// Mean width of the pattern's parts (ridges, plates, flakes) around the stem, metres; at most
    /// half a repeat.
    pub width_m: f32,
    /// Mean length of the pattern's parts along the stem, metres; at most half a repeat.
    pub length_m: f32,
    /// 0 the smooth skin of a twig ..= 1 the bark of an old trunk; between, old bark spreads in patches.
    pub age: f32,
    /// Roughness in the open, 0..=1.
    pub roughness: f32,
    /// Share of the surface under pale crusts of lichen, 0..=1.
    pub lichen: f32,
    /// Share of the furrows and hollows under moss or green algae, 0..=1.
    pub moss: f32,
}

/// Families of bark. Parts of them run over 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BarkPattern {
    /// Corky ridges along the stem between furrows (oak, ash, poplar, elm, willow, lime). The accent
    /// is the inner bark in the deepest cracks.
    Ridged {
        /// 0 ridges that furrows part ..= 1 a net of ridges around diamond-shaped furrows.
        braid: f32,
        /// 0 rounded crests ..= 1 flat-topped ridges with steep sides.
        flat: f32,
        /// Cracks across the ridges, from none to many.
        cracks: f32,
    },
    /// Rounded twisted ridges with soft furrows, scales and pits (olive). The accent is bare wood.
    Gnarled {
        /// How much of it breaks up into scales.
        scales: f32,
    },
    /// Nearly smooth (beech, hazel, Japanese maple). The accent is that of lenticels and scars.
    Smooth {
        /// Fine wrinkles across the stem.
        wrinkles: f32,
        /// Lenticels: how many of the places for them have one.
        lenticels: f32,
        /// Eye-shaped scars of lost branches: how many of the places for them have one.
        scars: f32,
    },
    /// White paper that peels (birch, aspen): width and length are those of the dark diamonds. The
    /// accent is the inner bark where paper has peeled off.
    Papery {
        /// Short dark lines across the stem: how many of the places for them have one.
        lenticels: f32,
        /// Share that has peeled off.
        peel: f32,
        /// Black rough diamonds and knots: how many of the places for them have one.
        diamonds: f32,
    },
    /// Satin skin with bands of corky lenticels across the stem (cherry): width is that of a
    /// lenticel, length the distance between bands. The accent is the cork's.
    Banded {
        /// Share of the bands that bear lenticels.
        lenticels: f32,
        /// Share that peels off in strips around the stem.
        peel: f32,
    },
    /// Plates or scales parted by cracks (pine, spruce, larch, horse chestnut). The accent is the
    /// fresh bark where flakes have come off.
    Plates {
        /// How much the plates are layered in flakes.
        flakes: f32,
        /// 0 flat plates ..= 1 scales whose lower edges lift over those below.
        lift: f32,
    },
    /// A mosaic of three layers (plane): light is the fresh innermost layer, the accent the middle
    /// one, dark the oldest.
    Mosaic {
        /// Share of the oldest layer that has come off.
        shed: f32,
    },
    /// Fibrous strips along the stem (cypress, redwood, juniper). The accent is the grey of weathered
    /// fibres.
    Fibrous {
        /// How much hangs in loose shreds.
        shreds: f32,
    },
    /// Rings of old leaf scars (palms): length is the distance between them, width that of the
    /// cracks. The accent is the scar's ledge.
    Rings {
        /// Cracks along the stem, from none to many.
        fissures: f32,
    },
    /// Leaf bases in a helical lattice of diamonds (date palm). The accent is the cut face.
    Lattice {
        /// How far the leaf bases stand out at their upper end.
        boots: f32,
    },
}
