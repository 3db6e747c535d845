//! What the model does not tell: bark and colours, and what a leaf shape's name stands for.

/// Bark and leaf colour of trees whose name has a word in it.
struct Dress {
    words: &'static [&'static str],
    bark: &'static str,
    leaf: &'static str,
}

const DRESSES: &[Dress] = &[
    Dress {
        words: &["aspen", "birch"],
        bark: r##"Smooth(light: "#b9b8a8", dark: "#55564c", height_m: 1, depth_m: 0.008)"##,
        leaf: "#5d7a35",
    },
    Dress {
        words: &["willow"],
        bark: r##"Ridged(light: "#857b6a", dark: "#38322a", height_m: 0.9, depth_m: 0.03)"##,
        leaf: "#6a8440",
    },
    Dress {
        words: &["oak"],
        bark: r##"Ridged(light: "#6e655a", dark: "#2b2722", height_m: 0.8, depth_m: 0.03)"##,
        leaf: "#45602b",
    },
    Dress {
        words: &["palm"],
        bark: r##"Rings(light: "#8f8577", dark: "#4d4439", height_m: 0.5, depth_m: 0.012)"##,
        leaf: "#4b6a2c",
    },
];

const PLAIN: Dress = Dress {
    words: &[],
    bark: r##"Ridged(light: "#7d7466", dark: "#332d25", height_m: 0.8, depth_m: 0.025)"##,
    leaf: "#4a6b34",
};

fn dress(name: &str) -> &'static Dress {
    let name = name.to_lowercase();
    DRESSES
        .iter()
        .find(|dress| dress.words.iter().any(|word| name.contains(word)))
        .unwrap_or(&PLAIN)
}

/// A bark for a tree of this name, in a script's words.
pub(super) fn bark(name: &str) -> &'static str {
    dress(name).bark
}

/// A leaf colour for a tree of this name.
pub(super) fn leaf_colour(name: &str) -> &'static str {
    dress(name).leaf
}

/// Outline of a blade by the name of a leaf shape, without its width: a script's words. `None` for names that
/// are not known.
pub(super) fn blade(shape: &str) -> Option<&'static str> {
    Some(match shape.to_lowercase().as_str() {
        "" | "0" | "disc" | "elliptic" | "ovate" | "1" => "widest: 0.45, sharpness: 0.55",
        "linear" | "2" | "rectangle" => "widest: 0.5, sharpness: 0.4, veins: Parallel",
        "cordate" | "3" => "widest: 0.3, sharpness: 0.6, base: -0.5",
        "maple" | "palmate" | "4" | "5" => {
            "widest: 0.42, sharpness: 0.6, lobes: Palmate(count: 5), veins: Palmate"
        }
        "spiky oak" | "6" => "widest: 0.55, sharpness: 0.5, lobes: Pinnate(pairs: 4, sharp: 1)",
        "rounded oak" | "7" => "widest: 0.6, sharpness: 0.5, lobes: Pinnate(pairs: 4, sharp: 0)",
        "triangle" | "8" => "widest: 0.2, sharpness: 0.9",
        _ => return None,
    })
}
