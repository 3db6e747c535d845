//! Figures in words, with fixed digits, for the page and the terminal.

/// A number with `digits` after the point; `-` if it is none.
pub(super) fn fixed(x: f32, digits: usize) -> String {
    if !x.is_finite() {
        return "-".to_owned();
    }
    let text = format!("{x:.digits$}");
    match text.strip_prefix('-') {
        // A small negative number must not become "-0.00".
        Some(zero) if zero.bytes().all(|b| matches!(b, b'0' | b'.')) => zero.to_owned(),
        _ => text,
    }
}

/// Half of an interval's length, as what may be added or taken away; empty if there is no interval.
pub(super) fn plus_minus([low, high]: [f32; 2], digits: usize) -> String {
    match fixed((high - low) * 0.5, digits) {
        none if none == "-" => String::new(),
        half => format!("\u{b1}{half}"),
    }
}

/// A part of one in percent; `-` if it is no number.
pub(super) fn percent(x: f32) -> String {
    match fixed(x * 100.0, 1) {
        none if none == "-" => none,
        text => text + "%",
    }
}

/// A change in percent, with its sign.
pub(super) fn signed_percent(x: f32) -> String {
    let text = percent(x);
    let rises = x > 0.0 && x.is_finite() && text != "0.0%";
    if rises { format!("+{text}") } else { text }
}

/// A whole number with its thousands apart.
pub(crate) fn number(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Bytes in the unit that a person would use.
pub(super) fn bytes(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..1_000_000 => format!("{} KB", bytes / 1000),
        _ => {
            let tenths = bytes.saturating_add(50_000) / 100_000;
            format!("{}.{} MB", tenths / 10, tenths % 10)
        }
    }
}

/// One thing or several.
pub(super) fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_a_dash() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(fixed(x, 2), "-");
            assert_eq!(percent(x), "-");
            assert_eq!(signed_percent(x), "-");
        }
        assert_eq!(percent(f32::MAX), "-", "too large for a percentage");
    }

    #[test]
    fn signs_stand_only_before_what_is_not_zero() {
        assert_eq!(fixed(-0.001, 2), "0.00");
        assert_eq!(fixed(-0.01, 2), "-0.01");
        assert_eq!(signed_percent(0.000_1), "0.0%");
        assert_eq!(signed_percent(-0.000_1), "0.0%");
        assert_eq!(signed_percent(0.05), "+5.0%");
        assert_eq!(signed_percent(-0.125), "-12.5%");
    }

    #[test]
    fn numbers_keep_their_thousands_apart() {
        assert_eq!(number(0), "0");
        assert_eq!(number(1_234_567), "1,234,567");
        assert_eq!(bytes(16_777_216), "16.8 MB");
        assert_eq!(bytes(999_999), "999 KB");
    }
}
