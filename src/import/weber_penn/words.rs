//! Numbers, curves and names in a script's words.

use super::Parameters;
use crate::math::round_to_u32;

/// A number as a script has it: three digits or so.
pub(super) fn n(x: f32) -> String {
    let digits: usize = match x.abs() {
        100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        0.1.. => 3,
        _ => 4,
    };
    let text = format!("{x:.digits$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text.as_str(),
    };
    if text == "-0" { "0" } else { text }.to_owned()
}

/// A whole number.
pub(super) fn n_whole(x: f32) -> String {
    round_to_u32(x).to_string()
}

/// A curve as a script has it; a bare number where it is level.
pub(super) fn points(curve: &[(f32, f32)]) -> String {
    let first = curve.first().map_or(0.0, |p| p.1);
    if curve.iter().all(|p| (p.1 - first).abs() < 5e-4) {
        return n(first);
    }
    let points: Vec<String> = curve
        .iter()
        .map(|(x, y)| format!("({}, {})", n(*x), n(*y)))
        .collect();
    format!("[{}]", points.join(", "))
}

/// An angle by position on the parent, and its random part.
pub(super) fn angle(at: &[(f32, f32)], vary: f32) -> String {
    match (points(at), n(vary.abs())) {
        (at, vary) if vary == "0" => at,
        (at, vary) => format!("(at: {at}, vary: {vary})"),
    }
}

/// How branches or leaves of a level stand around their parent.
pub(super) fn around(p: &Parameters, level: usize) -> String {
    let (rotate, vary) = (p.of(level, "Rotate"), p.of(level, "RotateV").abs());
    let vary = match n(vary) {
        none if none == "0" => String::new(),
        vary => format!(", vary: {vary}"),
    };
    if rotate < 0.0 && level > 1 {
        format!("(at: 90, step: 180{vary})")
    } else {
        format!("(step: {}{vary})", n(rotate.abs()))
    }
}

/// Text in quotes.
pub(super) fn quoted(text: &str) -> String {
    let plain: String = text.chars().filter(|c| !c.is_control()).collect();
    format!("\"{}\"", plain.replace('\\', "\\\\").replace('"', "\\\""))
}
