//! The script's text, laid out like those in `species/`.

use super::Parameters;
use super::levels::{LevelText, Plan};
use super::words::{n, quoted};
use crate::import::Note;
use crate::survey::reference;

/// Columns of a line.
const WIDTH: usize = 100;

pub(super) fn script(p: &Parameters, plan: &Plan, notes: &[Note]) -> String {
    let name = name(p);
    let mut out = String::new();
    let head = format!(
        "{name}, made by `pleach import weber-penn` of a set of Weber and Penn's parameters. Change what you like: \
         `olive.ron` among Pleach's species explains the format."
    );
    comment(&mut out, "", &head);
    out += "//\n";
    let key = "What became of the parameters: = used, ~ approximated, - without a counterpart or effect, ! look here.";
    comment(&mut out, "", key);
    for note in notes {
        comment(&mut out, "  ", &note.to_string());
    }
    out += "(\n    format: 1,\n";
    out += &format!("    name: {},\n", quoted(&name));
    if let Some(known) = reference::of_common(&name) {
        // So that `pleach measure` finds it.
        out += &format!("    latin: {},\n", quoted(&known.latin));
    }
    out.push('\n');
    out += "    seed: 1,\n\n";
    out += "    // The model knows neither bark nor colours: these are guesses by the name.\n";
    out += &format!("    bark: {},\n\n", super::dress::bark(&p.name));
    out += "    // Branches grow along +y; +z is their upper side.\n    splines: [\n";
    for (name, points) in &plan.splines {
        let points: Vec<String> = points
            .iter()
            .map(|[x, y, z]| format!("({}, {}, {})", n(*x), n(*y), n(*z)))
            .collect();
        let fields = [
            ("name", quoted(name)),
            ("points", format!("[{}]", points.join(", "))),
        ];
        block(&mut out, "(", &fields);
    }
    out += "    ],\n\n";
    if !plan.leaf.is_empty() {
        out += "    leaves: [\n";
        block(&mut out, "(", &plan.leaf);
        out += "    ],\n\n";
    }
    out += "    levels: [\n";
    for LevelText {
        kind,
        comment: about,
        fields,
    } in &plan.levels
    {
        if !about.is_empty() {
            comment(&mut out, "        ", about);
        }
        block(&mut out, &format!("{kind}("), fields);
    }
    out += "    ],\n)\n";
    out
}

/// The tree's name, or what it is called if the file does not say.
fn name(p: &Parameters) -> String {
    let name: String = p
        .name
        .chars()
        .filter(|c| !c.is_control())
        .take(100)
        .collect();
    let words: Vec<&str> = name
        .split(['_', ' '])
        .filter(|word| !word.is_empty())
        .collect();
    if words.is_empty() {
        "Weber and Penn tree".to_owned()
    } else {
        words.join(" ")
    }
}

/// A comment in lines of bounded width; what follows the first line is set in.
fn comment(out: &mut String, indent: &str, text: &str) {
    // Notes are set in behind the slashes, comments of a level before them.
    let (before, behind) = match indent.len() {
        0 | 2 => ("", indent),
        _ => (indent, ""),
    };
    let mut line = format!("{before}// {behind}");
    let mut empty = true;
    for word in text.split_whitespace() {
        if !empty && line.len() + 1 + word.len() > WIDTH {
            out.push_str(line.trim_end());
            out.push('\n');
            let deeper = if behind.is_empty() { "" } else { "    " };
            line = format!("{before}// {deeper}{behind}");
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line += word;
        empty = false;
    }
    out.push_str(&line);
    out.push('\n');
}

/// An item of a list with its fields, on one line if it fits.
fn block(out: &mut String, open: &str, fields: &[(&str, String)]) {
    let fields: Vec<String> = fields
        .iter()
        .map(|(name, value)| format!("{name}: {value}"))
        .collect();
    let one = format!("        {open}{}),\n", fields.join(", "));
    if one.len() <= WIDTH {
        out.push_str(&one);
        return;
    }
    out.push_str(&format!("        {open}\n"));
    let mut line = String::new();
    for field in &fields {
        let parts = parts(field);
        for (index, part) in parts.iter().enumerate() {
            // What takes several lines begins on one of its own.
            let begins = index == 0 && parts.len() > 1;
            if !line.is_empty() && (begins || 12 + line.len() + 2 + part.len() > WIDTH) {
                out.push_str(&format!("            {line}\n"));
                line.clear();
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line += part;
            line.push(',');
        }
    }
    if !line.is_empty() {
        out.push_str(&format!("            {line}\n"));
    }
    out.push_str("        ),\n");
}

/// A field, or where it is longer than a line its parts: a list is broken between its items.
fn parts(field: &str) -> Vec<&str> {
    if 12 + field.len() < WIDTH {
        return vec![field];
    }
    let mut parts = Vec::new();
    let mut rest = field;
    while let Some(at) = rest.find("), (") {
        parts.push(&rest[..=at]);
        rest = rest[at + 2..].trim_start();
    }
    parts.push(rest);
    parts
}
