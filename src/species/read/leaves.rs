//! Leaf kinds.

use super::Reader;
use super::shape::Names;
use crate::species::decode::{Fields, Report, Value};
use crate::species::fields::{self, ARRANGEMENTS};
use crate::species::schema::{Arrangement, Blade, LeafArt, LeafKind, LeafLook};

/// All leaf kinds, and their names.
pub(super) fn leaves<'n>(reader: &mut Reader<'_>, root: &Fields<'n>) -> (Vec<LeafKind>, Names<'n>) {
    let mut names = Names::new("leaf kind");
    let mut kinds = Vec::new();
    if let Some(list) = root.get("leaves") {
        for item in reader.named_items(&list, "a list of leaf kinds") {
            let fields = Fields::open_plain(&mut reader.out, item, &fields::LEAF);
            let name = names.add(&mut reader.out, &fields);
            kinds.push(leaf(reader, name, &fields));
        }
    }
    (kinds, names)
}

fn leaf(reader: &mut Reader<'_>, name: String, fields: &Fields<'_>) -> LeafKind {
    let look = if fields.has("image") {
        for drawn in fields::DRAWN_LEAF {
            if let Some(value) = fields.get(drawn.name) {
                let message = format!("`{}` has no effect beside `image`", drawn.name);
                let fault = value.fault(message);
                reader.out.push(fault.help("remove one of the two"));
            }
        }
        LeafLook::Image(reader.image(fields, "image"))
    } else {
        LeafLook::Drawn(art(&mut reader.out, fields))
    };
    let out = &mut reader.out;
    LeafKind {
        name,
        length_m: fields.number(out, "length_m"),
        width_m: fields.number(out, "width_m"),
        fold_deg: fields.number(out, "fold_deg"),
        look,
    }
}

fn art(out: &mut Report, fields: &Fields<'_>) -> LeafArt {
    LeafArt {
        arrangement: fields
            .read(out, "arrangement", |out, value, _| arrangement(out, value))
            .unwrap_or(Arrangement::Single),
        blade: fields
            .read(out, "blade", |out, value, _| Some(blade(out, value)))
            .unwrap_or(NO_BLADE),
        colour: fields.colour(out, "colour"),
        colour_vary: fields.number(out, "colour_vary"),
        stalk_colour: fields.colour(out, "stalk_colour"),
        gloss: fields.number(out, "gloss"),
        translucency: fields.number(out, "translucency"),
    }
}

/// Stands in where a blade is at fault, until the report is given.
const NO_BLADE: Blade = Blade {
    width: 0.5,
    widest: 0.5,
    sharpness: 0.5,
    teeth: 0,
    tooth_depth: 0.0,
    veins: 0,
};

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
        _ => Arrangement::Single,
    })
}

fn blade(out: &mut Report, value: &Value<'_>) -> Blade {
    let fields = Fields::open_plain(out, value.clone(), &fields::BLADE);
    Blade {
        width: fields.number(out, "width"),
        widest: fields.number(out, "widest"),
        sharpness: fields.number(out, "sharpness"),
        teeth: fields.whole(out, "teeth"),
        tooth_depth: fields.number(out, "tooth_depth"),
        veins: fields.whole(out, "veins"),
    }
}
