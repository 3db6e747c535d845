//! Arbaro's XML form: names and values with their places.

use crate::import::ImportFault;
use roxmltree::{Document, Node};

/// A tree's name and its parameters as they are written.
#[derive(Debug)]
pub(super) struct Read {
    pub(super) name: String,
    pub(super) entries: Vec<Entry>,
}

/// One parameter as it is written.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) value: String,
    pub(super) line: u32,
    pub(super) column: u32,
}

impl Entry {
    pub(super) fn fault(&self, message: impl Into<String>) -> ImportFault {
        ImportFault {
            line: self.line,
            column: self.column,
            message: message.into(),
        }
    }
}

pub(super) fn read(text: &str) -> Result<Read, Vec<ImportFault>> {
    let document = Document::parse(text).map_err(|error| {
        let at = error.pos();
        // Its text ends with the place, which stands before ours already.
        let message = error.to_string();
        let place = format!(" at {}:{}", at.row, at.col);
        vec![ImportFault {
            line: at.row,
            column: at.col,
            message: format!("not XML: {}", message.replace(&place, "")),
        }]
    })?;
    let species = document
        .descendants()
        .find(|node| node.has_tag_name("species"))
        .ok_or_else(|| {
            let root = document.root_element();
            let message = format!(
                "no tree here: expected <arbaro><species name='...'>, found <{}>",
                root.tag_name().name()
            );
            vec![fault(&root, message)]
        })?;
    let mut faults = Vec::new();
    let mut entries = Vec::new();
    for node in species
        .descendants()
        .filter(|node| node.has_tag_name("param"))
    {
        match (node.attribute("name"), node.attribute("value")) {
            (Some(name), Some(value)) => {
                let at = document.text_pos_at(node.range().start);
                entries.push(Entry {
                    name: name.trim().to_owned(),
                    value: value.trim().to_owned(),
                    line: at.row,
                    column: at.col,
                });
            }
            _ => faults.push(fault(
                &node,
                "a param needs a name and a value: <param name='Scale' value='13'/>",
            )),
        }
    }
    if faults.is_empty() {
        let name = species
            .attribute("name")
            .unwrap_or_default()
            .trim()
            .to_owned();
        Ok(Read { name, entries })
    } else {
        Err(faults)
    }
}

fn fault(node: &Node<'_, '_>, message: impl Into<String>) -> ImportFault {
    let at = node.document().text_pos_at(node.range().start);
    ImportFault {
        line: at.row,
        column: at.col,
        message: message.into(),
    }
}
