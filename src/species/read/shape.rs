//! Values with a form of their own: curves, parameters, colours, names and files.

use crate::math::{PI, linear_from_srgb};
use crate::species::decode::{Fields, Report, Value, nearest, with_nearest};
use crate::species::fields::{self, Holds, Limits};
use crate::species::files;
use crate::species::schema::{Curve, Param};
use crate::species::syntax::Kind;

/// Crown shapes of Weber and Penn, as functions of the position on the parent.
///
/// Jason Weber, Joseph Penn, 1995, Creation and Rendering of Realistic Trees, the function
/// `ShapeRatio`. Changes versus the paper: the ratio is 1 less the position on the *whole* parent,
/// not on its crowned part; straight pieces are kept as such, and the two sines become eight
/// pieces.
const CROWNS: &[&str] = &[
    "Conical",
    "Spherical",
    "Hemispherical",
    "Cylindrical",
    "TaperedCylindrical",
    "Flame",
    "InverseConical",
    "TendFlame",
];

/// The ratio of a crown shape, from 1 at the crown's foot to 0 at its top.
fn shape_ratio(crown: &str, r: f32) -> f32 {
    match crown {
        "Conical" => 0.2 + 0.8 * r,
        "Spherical" => 0.2 + 0.8 * libm::sinf(PI * r),
        "Hemispherical" => 0.2 + 0.8 * libm::sinf(0.5 * PI * r),
        "TaperedCylindrical" => 0.5 + 0.5 * r,
        "Flame" if r <= 0.7 => r / 0.7,
        "Flame" => (1.0 - r) / 0.3,
        "InverseConical" => 1.0 - 0.8 * r,
        "TendFlame" if r <= 0.7 => 0.5 + 0.5 * r / 0.7,
        "TendFlame" => 0.5 + 0.5 * (1.0 - r) / 0.3,
        _ => 1.0,
    }
}

/// A crown shape as a curve, held within limits.
fn crown_curve(crown: &str, limits: Limits) -> Curve {
    let positions: &[f32] = match crown {
        "Cylindrical" => &[0.0],
        "Spherical" | "Hemispherical" => &[0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0],
        "Flame" | "TendFlame" => &[0.0, 0.3, 1.0],
        _ => &[0.0, 1.0],
    };
    let point = |&x: &f32| {
        let ratio = shape_ratio(crown, 1.0 - x);
        (x, ratio.clamp(limits.min, limits.max))
    };
    let points = positions.iter().map(point).collect();
    Curve { points }
}

/// A number, a list of (position, value), or, for factors, a crown shape.
pub(super) fn curve(out: &mut Report, value: &Value<'_>, limits: Limits) -> Option<Curve> {
    let expected = "a number, a list of (position, value) or the name of a crown shape";
    match &value.node.kind {
        Kind::Number(_) => value.number(out, limits).map(Curve::constant),
        Kind::List(_) => curve_points(out, value, limits),
        Kind::Ident(name) => {
            let crown = CROWNS.iter().find(|crown| **crown == name.as_str());
            if limits.unit.is_empty() {
                let Some(crown) = crown else {
                    let list = CROWNS.join(", ");
                    let fault = value.fault(format!("unknown crown shape `{name}`; known: {list}"));
                    out.push(with_nearest(fault, name, CROWNS.iter().copied()));
                    return None;
                };
                return Some(crown_curve(crown, limits));
            }
            let message = format!(
                "expected a number or a list of (position, value) in {}, found the name `{name}`",
                limits.unit
            );
            let mut fault = value.fault(message);
            if crown.is_some() {
                fault = fault.help("a crown shape is a factor between 0 and 1");
            }
            out.push(fault);
            None
        }
        _ => {
            value.mismatch(out, expected);
            None
        }
    }
}

fn curve_points(out: &mut Report, value: &Value<'_>, limits: Limits) -> Option<Curve> {
    let before = out.count();
    let items = value.items(out, "a list of (position, value)");
    if items.is_empty() {
        out.push(value.fault("a curve needs at least one (position, value)"));
    }
    if items.len() > fields::MAX_CURVE_POINTS {
        let (found, most) = (items.len(), fields::MAX_CURVE_POINTS);
        out.push(value.fault(format!("a curve has at most {most} points, found {found}")));
        return None;
    }
    let mut points: Vec<(f32, f32)> = Vec::with_capacity(items.len());
    for item in &items {
        let Some(pair) = item.tuple(2) else {
            item.mismatch(out, "(position, value)");
            continue;
        };
        let [x, y] = pair.as_slice() else { continue };
        let position = x.number(out, fields::POSITION);
        let number = y.number(out, limits);
        if let (Some(position), Some(&(last, _))) = (position, points.last())
            && position <= last
        {
            let message = format!("positions must rise: {position} comes after {last}");
            out.push(x.fault(message));
        }
        if let (Some(position), Some(number)) = (position, number) {
            points.push((position, number));
        }
    }
    (out.count() == before).then_some(Curve { points })
}

/// `(at:, step:, vary:)`, or a curve alone, or a number alone. `default_step` is the step inside the
/// brackets when none is given there.
fn angle(out: &mut Report, value: &Value<'_>, limits: Limits, default_step: f32) -> Option<Param> {
    if !matches!(value.node.kind, Kind::Struct { .. }) {
        let at = curve(out, value, limits)?;
        return Some(Param {
            at,
            step: 0.0,
            vary: 0.0,
        });
    }
    let parts = Fields::open_plain(out, value.clone(), &fields::ANGLE);
    let at = parts.read(out, "at", |out, value, _| curve(out, value, limits));
    let step = if parts.has("step") {
        parts.number(out, "step")
    } else {
        default_step
    };
    let vary = parts.number(out, "vary");
    at.map(|at| Param { at, step, vary })
}

/// `(at:, vary:)`, or a curve, a crown shape or a number alone.
fn factor(out: &mut Report, value: &Value<'_>, limits: Limits) -> Option<Param> {
    if !matches!(value.node.kind, Kind::Struct { .. }) {
        let at = curve(out, value, limits)?;
        return Some(Param {
            at,
            step: 0.0,
            vary: 0.0,
        });
    }
    let parts = Fields::open_plain(out, value.clone(), &fields::FACTOR_PARTS);
    let at = parts.read(out, "at", |out, value, _| curve(out, value, limits));
    let vary = parts.number(out, "vary");
    at.map(|at| Param {
        at,
        step: 0.0,
        vary,
    })
}

/// `"#rrggbb"`, sRGB, as linear red, green and blue.
fn colour(out: &mut Report, value: &Value<'_>) -> Option<[f32; 3]> {
    let text = value.text(out)?;
    let digits = text
        .strip_prefix('#')
        .filter(|digits| digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()));
    let Some(number) = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()) else {
        let fault = value.fault(format!("`{text}` is not a colour"));
        out.push(fault.help("a colour is written \"#rrggbb\", like \"#455f34\""));
        return None;
    };
    let [_, r, g, b] = number.to_be_bytes();
    Some([r, g, b].map(linear_from_srgb))
}

impl<'n> Fields<'n> {
    /// A curve; flat at 1 if at fault.
    pub(super) fn curve(&self, out: &mut Report, name: &'static str) -> Curve {
        let read = self.read(out, name, |out, value, holds| match holds {
            Holds::Curve(limits) => curve(out, value, limits),
            _ => None,
        });
        read.unwrap_or_else(|| Curve::constant(1.0))
    }

    /// An angle or a factor; constant if at fault.
    pub(super) fn param(&self, out: &mut Report, name: &'static str) -> Param {
        let step = if name == "around" { 137.5 } else { 0.0 };
        let read = self.read(out, name, |out, value, holds| match holds {
            Holds::Angle(limits) => angle(out, value, limits, step),
            Holds::Factor(limits) => factor(out, value, limits),
            _ => None,
        });
        read.unwrap_or_else(|| Param::constant(1.0))
    }

    /// A colour, linear; black if at fault.
    pub(super) fn colour(&self, out: &mut Report, name: &'static str) -> [f32; 3] {
        self.read(out, name, |out, value, _| colour(out, value))
            .unwrap_or_default()
    }

    /// A name, neither empty nor endless; empty if at fault.
    pub(super) fn name(&self, out: &mut Report) -> String {
        let name = self.text(out, "name");
        if let Some(value) = self.get("name")
            && matches!(value.node.kind, Kind::Text(_))
        {
            let length = name.chars().count();
            if name.trim().is_empty() {
                out.push(value.fault("a name is empty"));
            } else if length > fields::MAX_NAME {
                let most = fields::MAX_NAME;
                out.push(value.fault(format!(
                    "a name has at most {most} characters, found {length}"
                )));
            }
        }
        name
    }

    /// A file's path and where it stands, if it is given and allowed.
    pub(super) fn path(&self, out: &mut Report, name: &'static str) -> Option<(String, Value<'n>)> {
        let value = self.get(name)?;
        let path = value.text(out)?;
        if let Some(reason) = files::refuse(path) {
            out.push(value.fault(format!("`{path}`: {reason}")));
            return None;
        }
        Some((path.to_owned(), value))
    }
}

/// Names of things that others refer to, in order.
#[derive(Debug)]
pub(super) struct Names<'n> {
    /// What they name, such as "spline".
    what: &'static str,
    names: Vec<(String, Option<Value<'n>>)>,
}

impl<'n> Names<'n> {
    pub(super) fn new(what: &'static str) -> Self {
        let names = Vec::new();
        Self { what, names }
    }

    /// Adds the name that a struct gives itself, and reports it if it is taken.
    pub(super) fn add(&mut self, out: &mut Report, fields: &Fields<'n>) -> String {
        let name = fields.name(out);
        let value = fields.get("name");
        let taken = self.names.iter().find(|(other, _)| *other == name);
        if let (Some((_, first)), Some(value), false) = (taken, &value, name.is_empty()) {
            let mut fault = value.fault(format!("two {}s are named `{name}`", self.what));
            if let Some(first) = first {
                fault = fault.also(first.node.head(), "first named here");
            }
            out.push(fault);
        }
        self.names.push((name.clone(), value));
        name
    }

    fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|(other, _)| other == name)
    }

    /// The index of a name that is referred to.
    pub(super) fn find(&self, out: &mut Report, value: &Value<'_>) -> Option<usize> {
        let name = value.text(out)?;
        let index = self.position(name);
        if index.is_none() {
            let what = self.what;
            let names = || self.names.iter().map(|(name, _)| name.as_str());
            // In the order of the script, but a name that is taken twice only once.
            let mut list: Vec<&str> = Vec::new();
            for name in names() {
                if !list.contains(&name) {
                    list.push(name);
                }
            }
            let list = list.join("`, `");
            let fault = value.fault(format!("no {what} is named `{name}`"));
            out.push(match nearest(name, names()) {
                Some(near) => fault.help(format!("did you mean `{near}`?")),
                None if list.is_empty() => fault.help(format!("the script names no {what}s")),
                None => fault.help(format!("{what}s of this script: `{list}`")),
            });
        }
        index
    }

    /// A list of names, or of (name, weight), of which one or more must have a weight.
    pub(super) fn choices(&self, out: &mut Report, list: &Value<'_>) -> Vec<(usize, f32)> {
        let before = out.count();
        let expected = format!("a list of {} names, or of (name, weight)", self.what);
        let items = list.items(out, &expected);
        if items.len() > fields::MAX_NAMED {
            let (found, most) = (items.len(), fields::MAX_NAMED);
            out.push(list.fault(format!(
                "a list to choose from has at most {most} items, found {found}"
            )));
            return Vec::new();
        }
        let mut choices = Vec::with_capacity(items.len());
        for item in &items {
            let (name, weight) = match item.tuple(2) {
                Some(pair) => {
                    let [name, weight] = pair.as_slice() else {
                        continue;
                    };
                    let weight = weight.number(out, fields::WEIGHT);
                    (self.find(out, name), weight)
                }
                None if matches!(item.node.kind, Kind::Text(_)) => {
                    (self.find(out, item), Some(1.0))
                }
                None => {
                    item.mismatch(out, "a name in quotes, or (name, weight)");
                    continue;
                }
            };
            if let (Some(index), Some(weight)) = (name, weight) {
                choices.push((index, weight));
            }
        }
        if out.count() == before {
            let what = self.what;
            if choices.is_empty() {
                out.push(list.fault(format!("the list is empty; name at least one {what}")));
            } else if choices.iter().all(|&(_, weight)| weight == 0.0) {
                out.push(list.fault("all weights are 0; at least one must be more"));
            }
        }
        choices
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BARE: Limits = Limits {
        min: 0.001,
        max: 10.0,
        unit: "",
    };

    #[test]
    fn crown_shapes_are_those_of_the_paper_at_foot_middle_and_top() {
        for (crown, foot, middle, top) in [
            ("Conical", 1.0, 0.6, 0.2),
            ("Spherical", 0.2, 1.0, 0.2),
            ("Hemispherical", 1.0, 0.765_685, 0.2),
            ("Cylindrical", 1.0, 1.0, 1.0),
            ("TaperedCylindrical", 1.0, 0.75, 0.5),
            ("Flame", 0.001, 0.714_286, 0.001),
            ("InverseConical", 0.2, 0.6, 1.0),
            ("TendFlame", 0.5, 0.857_143, 0.5),
        ] {
            let curve = crown_curve(crown, BARE);
            for (x, expected) in [(0.0, foot), (0.5, middle), (1.0, top)] {
                let found = curve.at(x);
                assert!((found - expected).abs() < 1e-3, "{crown} {x}: {found}");
            }
        }
    }

    #[test]
    fn every_crown_curve_stays_near_its_formula() {
        for crown in CROWNS {
            let curve = crown_curve(crown, BARE);
            for i in 0..=200_u8 {
                let x = f32::from(i) / 200.0;
                let error = (curve.at(x) - shape_ratio(crown, 1.0 - x).max(0.001)).abs();
                assert!(error < 0.02, "{crown} {x}: {error}");
            }
        }
    }
}
