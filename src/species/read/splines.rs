//! Named splines, from the script or from files beside it.

use super::Reader;
use super::shape::Names;
use crate::species::decode::{Fields, Report, Value};
use crate::species::fault::{Fault, Source};
use crate::species::fields::{self, KNOTS, MAX_SPLINE_POINTS};
use crate::species::schema::{Knots, Spline};
use crate::species::spline_file;

/// All splines, and their names.
pub(super) fn splines<'n>(reader: &mut Reader<'_>, root: &Fields<'n>) -> (Vec<Spline>, Names<'n>) {
    let mut names = Names::new("spline");
    let mut splines = Vec::new();
    if let Some(list) = root.require(&mut reader.out, "splines") {
        for item in reader.named_items(&list, "a list of splines") {
            let fields = Fields::open_plain(&mut reader.out, item, &fields::SPLINE);
            let name = names.add(&mut reader.out, &fields);
            splines.push(spline(reader, name, &fields));
        }
    }
    (splines, names)
}

fn spline(reader: &mut Reader<'_>, name: String, fields: &Fields<'_>) -> Spline {
    fields.either(&mut reader.out, "points", "file");
    let (points, told) = match (fields.get("points"), fields.path(&mut reader.out, "file")) {
        (Some(value), _) => (points(&mut reader.out, &value), None),
        (None, Some((path, value))) => {
            let file = from_file(reader, &path, &value);
            file.map_or((Vec::new(), None), |file| (file.points, file.knots))
        }
        (None, None) => (Vec::new(), None),
    };
    let out = &mut reader.out;
    let knots = fields.get("knots").and_then(|value| {
        Some(match value.one_of(out, KNOTS)? {
            "Uniform" => Knots::Uniform,
            "Chordal" => Knots::Chordal,
            _ => Knots::Centripetal,
        })
    });
    Spline {
        name,
        points,
        knots: knots.or(told).unwrap_or_default(),
    }
}

fn points(out: &mut Report, value: &Value<'_>) -> Vec<[f32; 3]> {
    let before = out.count();
    let items = value.items(out, "a list of points (x, y, z)");
    if items.len() > MAX_SPLINE_POINTS {
        let found = items.len();
        let most = MAX_SPLINE_POINTS;
        out.push(value.fault(format!("a spline has at most {most} points, found {found}")));
        return Vec::new();
    }
    let mut points = Vec::with_capacity(items.len());
    for item in &items {
        let Some(parts) = item.tuple(3) else {
            item.mismatch(out, "a point (x, y, z)");
            continue;
        };
        let numbers: Vec<f32> = parts
            .iter()
            .filter_map(|part| part.number(out, fields::COORDINATE))
            .collect();
        if let Ok(point) = <[f32; 3]>::try_from(numbers) {
            points.push((point, item.node.span.clone()));
        }
    }
    if out.count() == before {
        let mut faults = Vec::new();
        spline_file::check_points(&mut faults, &points, value.node.head());
        for mut fault in faults {
            fault.path.clone_from(&value.path);
            out.push(fault);
        }
    }
    points.into_iter().map(|(point, _)| point).collect()
}

fn from_file(
    reader: &mut Reader<'_>,
    path: &str,
    value: &Value<'_>,
) -> Option<spline_file::SplineFile> {
    reader.note(path);
    let text = match reader.files.read_text(path) {
        Ok(text) => text,
        Err(reason) => {
            reader.out.push(value.fault(reason));
            return None;
        }
    };
    match spline_file::parse(&text) {
        Ok(file) => Some(file),
        Err(faults) => {
            let source = reader.sources.len();
            reader.sources.push(Source::new(path, text));
            for fault in faults {
                reader.out.push(Fault { source, ..fault });
            }
            None
        }
    }
}
