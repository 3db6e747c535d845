//! Small parts of HTML: text that cannot break out of its element, pictures inside the page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Text for an element or for an attribute in quotes.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// A figure with a true minus sign; a lone `-`, which means "none", stays.
pub(super) fn minus(figure: &str) -> String {
    match figure.strip_prefix('-') {
        Some(rest) if !rest.is_empty() => format!("\u{2212}{rest}"),
        _ => figure.to_owned(),
    }
}

/// How a picture is shown.
#[derive(Clone, Copy)]
pub(super) enum Size {
    /// As wide as its place, at most as wide as it is.
    Fit,
    /// Enlarged to about this many times, its pixels seen as squares; narrower if the place is.
    Enlarged(u32),
    /// Pixel for pixel.
    True,
}

/// Adds a picture that the page's style holds under a class; a note if its bytes are no PNG.
pub(super) fn picture(page: &mut String, name: &str, png: &[u8], alt: &str, size: Size) {
    if png_size(png).is_none() {
        page.push_str("<span class=\"missing\">no picture</span>");
        return;
    }
    let (class, style) = match size {
        Size::Fit => ("fit", String::new()),
        Size::Enlarged(factor) => ("enlarged", format!(" style=\"--k:{factor}\"")),
        Size::True => ("true", String::new()),
    };
    page.push_str(&format!(
        "<span class=\"pic {class} {name}\" role=\"img\"{style} aria-label=\"{}\"></span>",
        escape(alt)
    ));
}

/// Adds the style that holds a picture under a class; none if its bytes are no PNG.
pub(super) fn png_rule(style: &mut String, name: &str, png: &[u8]) {
    let Some([width, height]) = png_size(png) else {
        return;
    };
    style.push_str(&format!(
        ".{name}{{--pw:{width};--ph:{height};background-image:url(data:image/png;base64,"
    ));
    STANDARD.encode_string(png, style);
    style.push_str(")}\n");
}

/// Width and height from a PNG's first chunk; none if the bytes are no PNG.
pub(super) fn png_size(png: &[u8]) -> Option<[u32; 2]> {
    let number = |at: usize| {
        let bytes = png.get(at..at + 4)?;
        Some(u32::from_be_bytes(bytes.try_into().ok()?))
    };
    let is_png = png.starts_with(b"\x89PNG\r\n\x1a\n") && png.get(12..16) == Some(b"IHDR");
    if is_png {
        Some([number(16)?, number(20)?])
    } else {
        None
    }
}

/// A list of names and values; the values are HTML already.
pub(super) fn facts(pairs: &[(&str, String)]) -> String {
    let pairs: String = pairs
        .iter()
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>"))
        .collect();
    format!("<dl class=\"facts\">{pairs}</dl>\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, png};

    #[test]
    fn a_picture_knows_its_size_and_keeps_its_bytes() {
        let bytes = png::encode(&Image::filled(30, 20, [9_u8; 3])).unwrap();
        assert_eq!(png_size(&bytes), Some([30, 20]));
        assert_eq!(png_size(&bytes[..20]), None, "cut off");
        assert_eq!(png_size(b"GIF89a"), None);
        let (mut page, mut style) = (String::new(), String::new());
        picture(&mut page, "p7", &bytes, "a \"leaf\"", Size::Enlarged(4));
        assert!(page.contains("class=\"pic enlarged p7\"") && page.contains("--k:4"));
        assert!(page.contains("aria-label=\"a &quot;leaf&quot;\""));
        png_rule(&mut style, "p7", &bytes);
        assert!(style.starts_with(".p7{--pw:30;--ph:20;"), "{style}");
        let encoded = style
            .split("base64,")
            .nth(1)
            .and_then(|rest| rest.strip_suffix(")}\n"))
            .unwrap();
        assert_eq!(STANDARD.decode(encoded).unwrap(), bytes);
    }

    #[test]
    fn a_minus_is_a_minus_and_a_dash_stays_a_dash() {
        assert_eq!(minus("-3.0%"), "\u{2212}3.0%");
        assert_eq!(minus("-"), "-");
        assert_eq!(minus("+1"), "+1");
    }
}
