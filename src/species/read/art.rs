//! What is drawn on a leaf card.

use crate::species::decode::{Fields, Report, Value};
use crate::species::fields::{
    self, ARRANGEMENTS, FORMS, LOBES, MARGINS, SEASON, SEASONS, TISSUES, VEINS,
};
use crate::species::schema::{
    Arrangement, Blade, Flowers, Form, LeafArt, LeafState, Lobes, Margin, MarginKind, Spray,
    Tissue, Veins,
};
use crate::species::syntax::Kind;

/// The drawn fields of a leaf kind.
pub(super) fn art(out: &mut Report, fields: &Fields<'_>, of_species: f32) -> LeafArt {
    LeafArt {
        arrangement: fields
            .read(out, "arrangement", |out, value, _| arrangement(out, value))
            .unwrap_or_default(),
        spray: fields.get("spray").map(|value| spray(out, value)),
        form: fields
            .read(out, "form", |out, value, _| form(out, value))
            .unwrap_or_default(),
        petiole: fields.has("petiole").then(|| fields.number(out, "petiole")),
        blade: fields
            .read(out, "blade", |out, value, _| Some(blade(out, value)))
            .unwrap_or_default(),
        flowers: fields.get("flowers").map(|value| flowers(out, value)),
        colour: fields.has("colour").then(|| fields.colour(out, "colour")),
        summer: fields
            .read(out, "summer", |out, value, _| tissue(out, value))
            .unwrap_or_default(),
        autumn: fields.read(out, "autumn", |out, value, _| tissue(out, value)),
        state: LeafState {
            season: fields
                .get("season")
                .and_then(|value| season(out, &value))
                .unwrap_or(of_species),
            age: fields.number(out, "age"),
            health: fields.number(out, "health"),
        },
        colour_vary: fields.number(out, "colour_vary"),
        stalk_colour: fields.colour(out, "stalk_colour"),
        gloss: fields.number(out, "gloss"),
        translucency: fields
            .has("translucency")
            .then(|| fields.number(out, "translucency")),
    }
}

fn arrangement(out: &mut Report, value: &Value<'_>) -> Option<Arrangement> {
    Some(match value.one_of(out, ARRANGEMENTS)? {
        "Opposite" => {
            let fields = Fields::open(out, value.clone(), &fields::OPPOSITE);
            Arrangement::Opposite {
                pairs: fields.whole(out, "pairs"),
                angle_deg: fields.number(out, "angle_deg"),
                blade: fields.number(out, "blade"),
            }
        }
        "Alternate" => {
            let fields = Fields::open(out, value.clone(), &fields::ALTERNATE);
            Arrangement::Alternate {
                count: fields.whole(out, "count"),
                angle_deg: fields.number(out, "angle_deg"),
                blade: fields.number(out, "blade"),
            }
        }
        "Brush" => {
            let fields = Fields::open(out, value.clone(), &fields::BRUSH);
            Arrangement::Brush {
                count: fields.whole(out, "count"),
                bundle: fields.whole(out, "bundle"),
                angle_deg: fields.number(out, "angle_deg"),
                blade: fields.number(out, "blade"),
            }
        }
        "Tufts" => {
            let fields = Fields::open(out, value.clone(), &fields::TUFTS);
            Arrangement::Tufts {
                count: fields.whole(out, "count"),
                leaves: fields.whole(out, "leaves"),
                spread_deg: fields.number(out, "spread_deg"),
                blade: fields.number(out, "blade"),
            }
        }
        "Scales" => {
            let fields = Fields::open(out, value.clone(), &fields::SCALES);
            Arrangement::Scales {
                pairs: fields.whole(out, "pairs"),
                blade: fields.number(out, "blade"),
            }
        }
        _ => Arrangement::Single,
    })
}

fn spray(out: &mut Report, value: Value<'_>) -> Spray {
    let fields = Fields::open_plain(out, value, &fields::SPRAY);
    Spray {
        shoots: fields.whole(out, "shoots"),
        opposite: fields
            .read(out, "opposite", |out, value, _| truth(out, value))
            .unwrap_or_default(),
        angle_deg: fields.number(out, "angle_deg"),
        length: fields.number(out, "length"),
        orders: fields.whole(out, "orders"),
    }
}

fn truth(out: &mut Report, value: &Value<'_>) -> Option<bool> {
    if let Kind::Bool(truth) = value.node.kind {
        return Some(truth);
    }
    value.mismatch(out, "true or false");
    None
}

fn form(out: &mut Report, value: &Value<'_>) -> Option<Form> {
    Some(match value.one_of(out, FORMS)? {
        "Pinnate" => {
            let fields = Fields::open(out, value.clone(), &fields::PINNATE_LEAF);
            Form::Pinnate {
                pairs: fields.whole(out, "pairs"),
                leaflet: fields.number(out, "leaflet"),
                angle_deg: fields.number(out, "angle_deg"),
                bare: fields.number(out, "bare"),
                taper: fields.number(out, "taper"),
            }
        }
        "Bipinnate" => {
            let fields = Fields::open(out, value.clone(), &fields::BIPINNATE);
            Form::Bipinnate {
                pinnae: fields.whole(out, "pinnae"),
                pinna: fields.number(out, "pinna"),
                pairs: fields.whole(out, "pairs"),
                leaflet: fields.number(out, "leaflet"),
            }
        }
        "Palmate" => {
            let fields = Fields::open(out, value.clone(), &fields::PALMATE_LEAF);
            Form::Palmate {
                leaflets: fields.whole(out, "leaflets"),
                spread_deg: fields.number(out, "spread_deg"),
                outer: fields.number(out, "outer"),
                costa: fields.number(out, "costa"),
            }
        }
        _ => Form::Simple,
    })
}

fn blade(out: &mut Report, value: &Value<'_>) -> Blade {
    let fields = Fields::open_plain(out, value.clone(), &fields::BLADE);
    Blade {
        width: fields.number(out, "width"),
        widest: fields.number(out, "widest"),
        sharpness: fields.number(out, "sharpness"),
        base: fields.number(out, "base"),
        tip: fields.number(out, "tip"),
        oblique: fields.number(out, "oblique"),
        auricles: fields.number(out, "auricles"),
        lobes: match fields.get("lobes") {
            Some(value) => lobes(out, &value).unwrap_or_default(),
            None => Lobes::None,
        },
        margin: fields
            .read(out, "margin", |out, value, _| margin(out, value))
            .unwrap_or_default(),
        veins: fields
            .read(out, "veins", |out, value, _| veins(out, value))
            .unwrap_or(Veins::Midrib),
    }
}

fn lobes(out: &mut Report, value: &Value<'_>) -> Option<Lobes> {
    Some(match value.one_of(out, LOBES)? {
        "Pinnate" => {
            let fields = Fields::open(out, value.clone(), &fields::PINNATE_LOBES);
            Lobes::Pinnate {
                pairs: fields.whole(out, "pairs"),
                depth: fields.number(out, "depth"),
                sharp: fields.number(out, "sharp"),
            }
        }
        "Palmate" => {
            let fields = Fields::open(out, value.clone(), &fields::PALMATE_LOBES);
            Lobes::Palmate {
                count: fields.whole(out, "count"),
                spread_deg: fields.number(out, "spread_deg"),
                depth: fields.number(out, "depth"),
                outer: fields.number(out, "outer"),
            }
        }
        _ => Lobes::None,
    })
}

fn margin(out: &mut Report, value: &Value<'_>) -> Option<Margin> {
    let kind = match value.one_of(out, MARGINS)? {
        "Serrate" => MarginKind::Serrate,
        "DoublySerrate" => MarginKind::DoublySerrate,
        "Crenate" => MarginKind::Crenate,
        "Dentate" => MarginKind::Dentate,
        "Wavy" => MarginKind::Wavy,
        _ => return Some(Margin::default()),
    };
    let fields = Fields::open(out, value.clone(), &fields::MARGIN);
    Some(Margin {
        kind,
        teeth: fields.whole(out, "teeth"),
        depth: fields.number(out, "depth"),
    })
}

fn veins(out: &mut Report, value: &Value<'_>) -> Option<Veins> {
    Some(match value.one_of(out, VEINS)? {
        "Pinnate" => {
            let fields = Fields::open(out, value.clone(), &fields::PINNATE_VEINS);
            Veins::Pinnate {
                pairs: fields.whole(out, "pairs"),
                angle_deg: fields.number(out, "angle_deg"),
            }
        }
        "Looping" => {
            let fields = Fields::open(out, value.clone(), &fields::LOOPING_VEINS);
            Veins::Looping {
                pairs: fields.whole(out, "pairs"),
                angle_deg: fields.number(out, "angle_deg"),
            }
        }
        "Palmate" => {
            let fields = Fields::open(out, value.clone(), &fields::PALMATE_VEINS);
            Veins::Palmate {
                count: fields.whole(out, "count"),
                pairs: fields.whole(out, "pairs"),
            }
        }
        "Parallel" => {
            let fields = Fields::open(out, value.clone(), &fields::PARALLEL_VEINS);
            Veins::Parallel {
                count: fields.whole(out, "count"),
            }
        }
        _ => Veins::Midrib,
    })
}

fn flowers(out: &mut Report, value: Value<'_>) -> Flowers {
    let fields = Fields::open_plain(out, value, &fields::FLOWERS);
    Flowers {
        count: fields.whole(out, "count"),
        petals: fields.whole(out, "petals"),
        size: fields.number(out, "size"),
        colour: fields.colour(out, "colour"),
    }
}

/// A season by name or number.
pub(super) fn season(out: &mut Report, value: &Value<'_>) -> Option<f32> {
    if matches!(value.node.kind, Kind::Number(_)) {
        return value.number(out, SEASON);
    }
    Some(match value.one_of(out, SEASONS)? {
        "Spring" => 0.0,
        "Autumn" => 2.0,
        "Winter" => 3.0,
        _ => 1.0,
    })
}

fn tissue(out: &mut Report, value: &Value<'_>) -> Option<Tissue> {
    Some(match value.one_of(out, TISSUES)? {
        "Young" => Tissue::Young,
        "LightGreen" => Tissue::LightGreen,
        "DarkGreen" => Tissue::DarkGreen,
        "Evergreen" => Tissue::Evergreen,
        "BlueGreen" => Tissue::BlueGreen,
        "Turning" => Tissue::Turning,
        "Yellow" => Tissue::Yellow,
        "Orange" => Tissue::Orange,
        "Red" => Tissue::Red,
        "Purple" => Tissue::Purple,
        "Russet" => Tissue::Russet,
        "Dead" => Tissue::Dead,
        _ => Tissue::MidGreen,
    })
}
