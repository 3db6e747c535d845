//! Spline files: plain text, one control point a line.
//!
//! ```text
//! # a comment
//! knots centripetal        (or uniform, or chordal; may be left out)
//! 0 0 0                    x y z, in any unit: only the form counts
//! 0.1 1 0
//! ```

use std::ops::Range;

use super::decode::with_nearest;
use super::fault::Fault;
use super::fields::{COORDINATE, MAX_SPLINE_POINTS};
use super::schema::Knots;

/// What a spline file says.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineFile {
    /// Control points in order.
    pub points: Vec<[f32; 3]>,
    /// Parametrisation, if the file tells.
    pub knots: Option<Knots>,
}

/// Reads a spline file.
///
/// # Errors
/// All faults of the text, as spans of it: words that are no numbers, lines without three, fewer
/// than two points, a point that repeats the one before.
pub fn parse(text: &str) -> Result<SplineFile, Vec<Fault>> {
    let mut faults = Vec::new();
    let mut knots = None;
    let mut points: Vec<([f32; 3], Range<usize>)> = Vec::new();
    let mut line_start = 0;
    let mut whole = true;
    for line in text.split_inclusive('\n') {
        let content = line.split('#').next().unwrap_or("");
        let words = words(content, line_start);
        line_start += line.len();
        match words.as_slice() {
            [] => {}
            [(word, _), rest @ ..] if word.eq_ignore_ascii_case("knots") => {
                let line = words.first().map_or(0..0, |(_, span)| span.clone());
                knots = knots_line(&mut faults, line, rest).or(knots);
            }
            _ => match point(&mut faults, &words) {
                Some(found) if points.len() < MAX_SPLINE_POINTS => points.push(found),
                Some((_, span)) => {
                    let message = format!("a spline has at most {MAX_SPLINE_POINTS} points");
                    faults.push(Fault::new(span, "", message));
                    break;
                }
                None => whole = false,
            },
        }
    }
    if whole {
        check_points(&mut faults, &points, text.len()..text.len());
    }
    if faults.is_empty() {
        let points = points.into_iter().map(|(point, _)| point).collect();
        Ok(SplineFile { points, knots })
    } else {
        Err(faults)
    }
}

/// Reports fewer than two points, and a point equal to the one before: no curve runs between them.
pub(super) fn check_points(
    faults: &mut Vec<Fault>,
    points: &[([f32; 3], Range<usize>)],
    nowhere: Range<usize>,
) {
    if points.len() < 2 {
        let span = points.first().map_or(nowhere, |(_, span)| span.clone());
        let found = points.len();
        let message = format!("a spline needs at least two points, found {found}");
        faults.push(Fault::new(span, "", message));
    }
    for pair in points.windows(2) {
        if let [(before, first), (point, span)] = pair
            && before == point
        {
            let fault = Fault::new(span.clone(), "", "this point repeats the one before");
            faults.push(fault.also(first.clone(), "the point before"));
        }
    }
}

/// Words of a line, with their places in the text.
fn words(line: &str, line_start: usize) -> Vec<(&str, Range<usize>)> {
    let mut words = Vec::new();
    let mut rest = line;
    let mut at = line_start;
    loop {
        let trimmed = rest.trim_start();
        at += rest.len() - trimmed.len();
        let length = trimmed.find(char::is_whitespace).unwrap_or(trimmed.len());
        if length == 0 {
            return words;
        }
        let (word, after) = trimmed.split_at(length);
        words.push((word, at..at + length));
        at += length;
        rest = after;
    }
}

fn knots_line(
    faults: &mut Vec<Fault>,
    line: Range<usize>,
    rest: &[(&str, Range<usize>)],
) -> Option<Knots> {
    let expected = "centripetal, uniform or chordal";
    let [(word, span)] = rest else {
        let message = format!("expected one word after `knots`: {expected}");
        faults.push(Fault::new(line, "", message));
        return None;
    };
    match word.to_lowercase().as_str() {
        "centripetal" => Some(Knots::Centripetal),
        "uniform" => Some(Knots::Uniform),
        "chordal" => Some(Knots::Chordal),
        _ => {
            let message = format!("unknown knots `{word}`; expected {expected}");
            let fault = Fault::new(span.clone(), "", message);
            let names = ["centripetal", "uniform", "chordal"];
            faults.push(with_nearest(fault, word, names));
            None
        }
    }
}

fn point(
    faults: &mut Vec<Fault>,
    words: &[(&str, Range<usize>)],
) -> Option<([f32; 3], Range<usize>)> {
    let (first, last) = (words.first()?, words.last()?);
    let line = first.1.start..last.1.end;
    let mut numbers = Vec::with_capacity(3);
    for (word, span) in words.iter().take(3) {
        let number = word.parse::<f32>().ok().filter(|number| number.is_finite());
        let Some(number) = number else {
            let mut fault = Fault::new(span.clone(), "", format!("`{word}` is not a number"));
            if word.contains(',') {
                fault = fault.help("numbers are separated by spaces, with `.` for the decimals");
            }
            faults.push(fault);
            return None;
        };
        if !(COORDINATE.min..=COORDINATE.max).contains(&number) {
            let (min, max) = (COORDINATE.min, COORDINATE.max);
            let message = format!("{word} is out of range; expected {min} to {max}");
            faults.push(Fault::new(span.clone(), "", message));
            return None;
        }
        numbers.push(number);
    }
    let found = words.len();
    match (<[f32; 3]>::try_from(numbers), found) {
        (Ok(point), 3) => Some((point, line)),
        _ => {
            let message = format!("expected three numbers, `x y z`, found {found}");
            faults.push(Fault::new(line, "", message));
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn points_comments_and_knots_are_read() {
        let text = "# limb\r\nknots Chordal\r\n0 0 0 # foot\r\n\r\n\t.5 1e0 -2\r\n0 2 0";
        let file = parse(text).unwrap();
        assert_eq!(file.knots, Some(Knots::Chordal));
        assert_eq!(
            file.points,
            [[0.0, 0.0, 0.0], [0.5, 1.0, -2.0], [0.0, 2.0, 0.0]]
        );
        assert_eq!(parse("0 0 0\n1 1 1").unwrap().knots, None);
    }

    #[test]
    fn every_line_at_fault_is_reported_at_its_word() {
        let text = "0 0 0\nknots loose\n1 x 2\n1 2\n1 2 nan\n1 2 3 4\n";
        let faults = parse(text).unwrap_err();
        let at: Vec<&str> = faults.iter().map(|f| &text[f.span.clone()]).collect();
        assert_eq!(at, ["loose", "x", "1 2", "nan", "1 2 3 4"]);
    }

    #[test]
    fn too_few_points_and_repeated_points_are_faults() {
        for (text, expected) in [
            ("", "found 0"),
            ("1 2 3\n", "found 1"),
            ("1 2 3\n1 2 3\n", "repeats"),
        ] {
            let faults = parse(text).unwrap_err();
            assert!(faults[0].message.contains(expected), "{faults:?}");
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "[0-9a-k .#\n\r\té-]{0,80}") {
            if let Err(faults) = parse(&text) {
                for fault in faults {
                    prop_assert!(text.get(fault.span.clone()).is_some());
                }
            }
        }
    }
}
