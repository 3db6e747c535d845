//! Plain tables for people.

pub(crate) use crate::evaluate::text::number;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// A table; columns whose header starts with `#` are right-aligned numbers.
pub(crate) fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    arranged(header, rows, ContentArrangement::Dynamic)
}

/// Columns of a note's line.
const NOTE_WIDTH: usize = 100;

/// A table whose rows have a note each, which stands on lines of its own below the row.
pub(crate) fn noted_table(
    header: &[&str],
    rows: impl IntoIterator<Item = (Vec<String>, String)>,
) -> String {
    let (rows, notes): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
    // Never wrapped, so that each row is one line.
    let text = arranged(header, rows, ContentArrangement::Disabled);
    let mut out = String::new();
    let notes = std::iter::once("").chain(notes.iter().map(String::as_str));
    for (line, note) in text.lines().zip(notes) {
        out += line;
        out.push('\n');
        for part in wrapped(note, NOTE_WIDTH) {
            out += &format!("   {part}\n");
        }
    }
    out.truncate(out.trim_end().len());
    out
}

/// Text in lines of up to `width` characters, broken between words.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

fn arranged(
    header: &[&str],
    rows: impl IntoIterator<Item = Vec<String>>,
    arrangement: ContentArrangement,
) -> String {
    let mut table = Table::new();
    table
        .load_preset(presets::NOTHING)
        .set_content_arrangement(arrangement);
    table.set_header(header.iter().map(|h| h.trim_start_matches('#')));
    table.add_rows(rows);
    for (index, name) in header.iter().enumerate() {
        if let Some(column) = table.column_mut(index).filter(|_| name.starts_with('#')) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let text = table.to_string();
    text.lines()
        .map(str::trim_end)
        .collect::<Vec<_>>()
        .join("\n")
}

/// Bytes in the unit that a person would use.
pub(crate) fn bytes(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..10_000_000 => format!("{} KB", bytes / 1000),
        _ => format!("{} MB", bytes / 1_000_000),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_keep_their_thousands_apart() {
        assert_eq!(super::number(0), "0");
        assert_eq!(super::number(999), "999");
        assert_eq!(super::number(1_000), "1,000");
        assert_eq!(super::number(12_345_678), "12,345,678");
    }

    #[test]
    fn a_note_stands_below_its_row_in_lines_of_bounded_width() {
        let long = "some words ".repeat(20);
        let rows = [("1", "short"), ("22", long.as_str())];
        let rows =
            rows.map(|(cell, note)| (vec!["x".to_owned(), cell.to_owned()], note.to_owned()));
        let text = super::noted_table(&["name", "#count"], rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[2].trim(), "short");
        assert!(lines[3].contains("22"), "{text}");
        assert_eq!(lines.len(), 7, "{text}");
        assert!(lines.iter().all(|line| line.len() <= 103), "{text}");
        assert_eq!(lines[4..].join(" ").matches("words").count(), 20);
    }
}
