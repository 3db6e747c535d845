//! Leaf kinds and bark.

use super::shape::Names;
use super::{Reader, art};
use crate::species::decode::{Fields, Report, Value, with_nearest};
use crate::species::fields::{self, BARKS};
use crate::species::schema::{Bark, BarkArt, BarkPattern, LeafKind, LeafLook};

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
        LeafLook::Drawn(art::art(&mut reader.out, fields))
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

/// The bark of a species.
pub(super) fn bark(reader: &mut Reader<'_>, root: &Fields<'_>) -> Bark {
    // An image is looked for on disk, which the default never is.
    if let Some(value) = root.get("bark")
        && value.variant() == Some("Image")
    {
        let fields = Fields::open(&mut reader.out, value, &fields::BARK_IMAGE);
        fields.require(&mut reader.out, "path");
        return Bark::Image {
            path: reader.image(&fields, "path"),
            height_m: fields.number(&mut reader.out, "height_m"),
        };
    }
    let drawn = root.read(&mut reader.out, "bark", |out, value, _| drawn(out, value));
    Bark::Drawn(drawn.unwrap_or(BarkArt {
        pattern: BarkPattern::Smooth,
        light: [0.0; 3],
        dark: [0.0; 3],
        height_m: 1.0,
        depth_m: 0.0,
    }))
}

fn drawn(out: &mut Report, value: &Value<'_>) -> Option<BarkArt> {
    let Some(name) = value.variant() else {
        value.mismatch(out, &format!("a bark, one of {}", BARKS.join(", ")));
        return None;
    };
    let pattern = match name {
        "Ridged" => BarkPattern::Ridged,
        "Gnarled" => BarkPattern::Gnarled,
        "Smooth" => BarkPattern::Smooth,
        "Rings" => BarkPattern::Rings,
        _ => {
            let message = format!(
                "unknown bark `{name}`; expected one of {}",
                BARKS.join(", ")
            );
            out.push(with_nearest(
                value.fault(message),
                name,
                BARKS.iter().copied(),
            ));
            return None;
        }
    };
    let fields = Fields::open(out, value.clone(), &fields::BARK);
    Some(BarkArt {
        pattern,
        light: fields.colour(out, "light"),
        dark: fields.colour(out, "dark"),
        height_m: fields.number(out, "height_m"),
        depth_m: fields.number(out, "depth_m"),
    })
}
