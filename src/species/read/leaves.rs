//! Leaf kinds.

use super::shape::Names;
use super::{Reader, art};
use crate::species::decode::Fields;
use crate::species::fields;
use crate::species::schema::{LeafKind, LeafLook};

/// All leaf kinds, and their names; they are drawn in the season of the species if they do not say.
pub(super) fn leaves<'n>(
    reader: &mut Reader<'_>,
    root: &Fields<'n>,
    season: f32,
) -> (Vec<LeafKind>, Names<'n>) {
    let mut names = Names::new("leaf kind");
    let mut kinds = Vec::new();
    if let Some(list) = root.get("leaves") {
        for item in reader.named_items(&list, "a list of leaf kinds") {
            let fields = Fields::open_plain(&mut reader.out, item, &fields::LEAF);
            let name = names.add(&mut reader.out, &fields);
            kinds.push(leaf(reader, name, &fields, season));
        }
    }
    (kinds, names)
}

fn leaf(reader: &mut Reader<'_>, name: String, fields: &Fields<'_>, season: f32) -> LeafKind {
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
        LeafLook::Drawn(art::art(&mut reader.out, fields, season))
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
