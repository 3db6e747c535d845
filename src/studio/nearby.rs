//! Values near a field's own, for drawings that tell what the field does.

use super::curve::{Curve, number};
use super::parts::{Parts, number_of};
use crate::species::fields::{Field, Holds, Limits};
use crate::species::syntax::{Kind, Node};

/// Factors on what is scaled, and degrees by which angles are turned.
const FACTORS: [f64; 3] = [0.5, 1.0, 1.7];
const TURNS: [f64; 3] = [-25.0, 0.0, 25.0];

/// Most names that are drawn beside one another.
const NAMES: usize = 4;

/// Values to draw in a row, from less to more, as captions and as a script writes them; none for what has no
/// order. `value` is the field's own, or what it means when it is left out.
pub(super) fn values(field: &Field, value: Option<&Node>) -> Vec<(String, String)> {
    let mut values = match field.holds {
        Holds::Number(limits) => {
            numbers(value.and_then(number_of).unwrap_or(1.0), limits, &FACTORS)
        }
        Holds::Whole(low, high) => whole(field, value, (low, high)),
        Holds::Angle(limits) => parts(value, limits, true),
        Holds::Factor(limits) => parts(value, limits, false),
        Holds::Curve(limits) => match value.and_then(Curve::of) {
            Some(curve) => FACTORS
                .iter()
                .map(|factor| scaled(&curve, limits, *factor))
                .map(|curve| (caption(&curve), curve.text()))
                .collect(),
            None => Vec::new(),
        },
        Holds::OneOf(names) => names
            .iter()
            .take(NAMES)
            .map(|name| ((*name).to_owned(), (*name).to_owned()))
            .collect(),
        Holds::Text | Holds::Colour | Holds::Path | Holds::Other(_) => Vec::new(),
    };
    values.dedup_by(|a, b| a.1 == b.1);
    if values.len() < 2 {
        values.clear();
    }
    values
}

fn clamped(value: f64, limits: Limits) -> f64 {
    value.clamp(f64::from(limits.min), f64::from(limits.max))
}

/// A number times each factor; one at zero, where factors do nothing, is shifted by a part of its range.
fn numbers(value: f64, limits: Limits, factors: &[f64]) -> Vec<(String, String)> {
    let range = f64::from(limits.max - limits.min).min(2.0);
    let near = |factor: &f64| {
        let moved = if value == 0.0 {
            (factor - 1.0) * range * 0.35
        } else {
            value * factor
        };
        let text = number(clamped(moved, limits));
        (text.clone(), text)
    };
    factors.iter().map(near).collect()
}

fn whole(field: &Field, value: Option<&Node>, (low, high): (u64, u64)) -> Vec<(String, String)> {
    let own = value.and_then(|node| match &node.kind {
        Kind::Number(number) => number.parse::<u64>().ok(),
        _ => None,
    });
    let own = own.unwrap_or(low.max(1));
    let near = if field.name == "seed" {
        [own, own.saturating_add(1), own.saturating_add(2)]
    } else {
        [own / 2, own, own.saturating_add((own / 2).max(1))]
    };
    let text = |value: u64| value.clamp(low, high).to_string();
    near.map(|value| (text(value), text(value))).to_vec()
}

fn parts(value: Option<&Node>, limits: Limits, is_angle: bool) -> Vec<(String, String)> {
    let Some(own) = value.and_then(Parts::of) else {
        return Vec::new();
    };
    let near = |step: usize| {
        let at = if is_angle {
            turned(&own.at, limits, TURNS[step])
        } else {
            scaled(&own.at, limits, FACTORS[step])
        };
        let caption = caption(&at);
        (caption, Parts { at, ..own.clone() }.text())
    };
    (0..3).map(near).collect()
}

fn mapped(curve: &Curve, to: impl Fn(f64) -> f64) -> Curve {
    match curve {
        Curve::Flat(value) => Curve::Flat(to(*value)),
        Curve::Points(points) => Curve::Points(points.iter().map(|[x, y]| [*x, to(*y)]).collect()),
    }
}

fn scaled(curve: &Curve, limits: Limits, factor: f64) -> Curve {
    mapped(curve, |value| clamped(value * factor, limits))
}

fn turned(curve: &Curve, limits: Limits, by: f64) -> Curve {
    mapped(curve, |value| clamped(value + by, limits))
}

/// A curve in a word or two.
fn caption(curve: &Curve) -> String {
    match curve {
        Curve::Flat(value) => number(*value),
        Curve::Points(points) => {
            let end = |point: Option<&[f64; 2]>| point.map_or_else(String::new, |p| number(p[1]));
            format!("{} to {}", end(points.first()), end(points.last()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::fields::{self, TABLES};
    use crate::species::syntax;

    fn near(field: &str, value: &str) -> Vec<String> {
        let tables = [&fields::BRANCH, &fields::SPECIES];
        let field = tables.iter().find_map(|t| t.field(field)).unwrap();
        let node = syntax::parse(value).0.unwrap();
        let values = values(field, Some(&node));
        values.into_iter().map(|(_, value)| value).collect()
    }

    #[test]
    fn values_lie_on_both_sides_and_within_their_range() {
        assert_eq!(near("links", "10"), ["5", "10", "15"]);
        assert_eq!(near("links", "1"), ["1", "2"]);
        assert_eq!(near("start", "0.8"), ["0.4", "0.8", "1"]);
        assert_eq!(near("tropism", "0"), ["-0.35", "0", "0.49"]);
        assert_eq!(
            near("down", "(at: 30, vary: 5)"),
            ["(at: 5, vary: 5)", "(at: 30, vary: 5)", "(at: 55, vary: 5)"]
        );
        assert_eq!(near("habit", "Open"), ["Open", "Forest"]);
        assert_eq!(near("name", "\"x\""), [] as [&str; 0]);
    }

    #[test]
    fn what_is_written_can_be_read_for_every_field() {
        for field in TABLES.iter().flat_map(|t| t.fields()) {
            let fields::Absent::Means(text) = field.absent else {
                continue;
            };
            let own = syntax::parse(text).0.unwrap();
            for (_, value) in values(field, Some(&own)) {
                let (node, faults) = syntax::parse(&value);
                assert!(
                    node.is_some() && faults.is_empty(),
                    "{}: {value}",
                    field.name
                );
            }
        }
    }
}
