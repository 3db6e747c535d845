//! The bark of a species.

use super::Reader;
use crate::species::decode::{Fields, Report, Value, with_nearest};
use crate::species::fields::{self, BARKS, Table};
use crate::species::schema::{Bark, BarkArt, BarkPattern};

/// Stands in where a bark is at fault, until the report is given.
const NO_BARK: BarkArt = BarkArt {
    pattern: BarkPattern::Rings { fissures: 0.0 },
    light: [0.0; 3],
    dark: [0.0; 3],
    accent: [0.0; 3],
    young: [0.0; 3],
    mature_radius_m: 0.0,
    height_m: 1.0,
    depth_m: 0.0,
    width_m: 0.1,
    length_m: 0.1,
    age: 1.0,
    roughness: 1.0,
    lichen: 0.0,
    moss: 0.0,
};

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
            young: fields.colour(&mut reader.out, "young"),
            mature_radius_m: fields.number(&mut reader.out, "mature_radius_m"),
        };
    }
    let drawn = root.read(&mut reader.out, "bark", |out, value, _| drawn(out, value));
    Bark::Drawn(drawn.unwrap_or(NO_BARK))
}

fn drawn(out: &mut Report, value: &Value<'_>) -> Option<BarkArt> {
    let Some(name) = value.variant() else {
        value.mismatch(out, &format!("a bark, one of {}", BARKS.join(", ")));
        return None;
    };
    let Some(table) = table(name) else {
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
    };
    let fields = Fields::open(out, value.clone(), table);
    Some(BarkArt {
        pattern: pattern(out, table.name, &fields),
        light: fields.colour(out, "light"),
        dark: fields.colour(out, "dark"),
        accent: fields.colour(out, "accent"),
        young: fields.colour(out, "young"),
        mature_radius_m: fields.number(out, "mature_radius_m"),
        height_m: fields.number(out, "height_m"),
        depth_m: fields.number(out, "depth_m"),
        width_m: fields.number(out, "width_m"),
        length_m: fields.number(out, "length_m"),
        age: fields.number(out, "age"),
        roughness: fields.number(out, "roughness"),
        lichen: fields.number(out, "lichen"),
        moss: fields.number(out, "moss"),
    })
}

/// The fields of a drawn bark, by its name.
fn table(name: &str) -> Option<&'static Table> {
    [
        &fields::RIDGED,
        &fields::GNARLED,
        &fields::SMOOTH,
        &fields::PAPERY,
        &fields::BANDED,
        &fields::PLATES,
        &fields::MOSAIC,
        &fields::FIBROUS,
        &fields::RINGS,
        &fields::LATTICE,
    ]
    .into_iter()
    .find(|table| table.name == name)
}

fn pattern(out: &mut Report, name: &str, fields: &Fields<'_>) -> BarkPattern {
    let mut part = |field| fields.number(out, field);
    match name {
        "Ridged" => BarkPattern::Ridged {
            braid: part("braid"),
            flat: part("flat"),
            cracks: part("cracks"),
        },
        "Gnarled" => BarkPattern::Gnarled {
            scales: part("scales"),
        },
        "Smooth" => BarkPattern::Smooth {
            wrinkles: part("wrinkles"),
            lenticels: part("lenticels"),
            scars: part("scars"),
        },
        "Papery" => BarkPattern::Papery {
            lenticels: part("lenticels"),
            peel: part("peel"),
            diamonds: part("diamonds"),
        },
        "Banded" => BarkPattern::Banded {
            lenticels: part("lenticels"),
            peel: part("peel"),
        },
        "Plates" => BarkPattern::Plates {
            flakes: part("flakes"),
            lift: part("lift"),
        },
        "Mosaic" => BarkPattern::Mosaic { shed: part("shed") },
        "Fibrous" => BarkPattern::Fibrous {
            shreds: part("shreds"),
        },
        "Lattice" => BarkPattern::Lattice {
            boots: part("boots"),
        },
        _ => BarkPattern::Rings {
            fissures: part("fissures"),
        },
    }
}
