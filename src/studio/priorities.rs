//! How LODs are chosen: the selector, and the order in which simplifications are tried.

use super::budgets::list;
use super::document::Edit;
use super::form::Change;
use super::outline;
use super::panes::named;
use crate::species::schema::{Lod, LodSelector, Simplification};
use crate::species::syntax::Node;
use eframe::egui::{self, ComboBox, Frame, Id, RichText, Stroke, Ui};

/// A simplification that is dragged: its place in the order.
struct Dragged(usize);

/// The selector and the order as widgets; what they ask for goes into `changes`.
pub(super) fn ui(ui: &mut Ui, root: &Node, lod: &Lod, changes: &mut Vec<Change>) {
    let written = outline::field(root, "lod").and_then(|lod| outline::field(lod, "priorities"));
    ui.horizontal_wrapped(|ui| {
        selector(ui, lod.selector, changes);
        let label = ui.label("and simplified in this order");
        label.on_hover_text(
            "Where LODs go level by level, the outermost levels are simplified first. At each depth these are tried in \
             turn until the budget is met. Whether Splines or Branches come first is what matters: Levels closes a \
             whole level once there is nothing else left, wherever it stands.",
        );
    });
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let count = lod.priorities.len();
        for (index, what) in lod.priorities.iter().enumerate() {
            // What is dragged may have gone from the script meanwhile.
            if let Some([from, to]) = item(ui, index, count, *what)
                && let Some(what) = lod.priorities.get(from)
            {
                let name = format!("Try {what:?} in another place");
                let edit = moved(&lod.priorities, written.is_some(), [from, to]);
                changes.push(Change::Edit(name, None, edit));
            }
        }
    });
}

fn selector(ui: &mut Ui, now: LodSelector, changes: &mut Vec<Change>) {
    let label = ui.label("LODs chosen");
    let combo = ComboBox::from_id_salt("selector")
        .selected_text(selector_words(now).0)
        .show_ui(ui, |ui| {
            for selector in [LodSelector::Cut, LodSelector::Levels] {
                let (name, meaning) = selector_words(selector);
                let choice = ui.selectable_label(selector == now, name);
                if choice.on_hover_text(meaning).clicked() && selector != now {
                    let edit = Edit::Set {
                        path: "lod.selector".to_owned(),
                        value: format!("{selector:?}"),
                    };
                    changes.push(Change::Edit(format!("Choose LODs {name}"), None, edit));
                }
            }
        });
    combo
        .response
        .on_hover_text(selector_words(now).1)
        .labelled_by(label.id);
}

/// A selector's name and meaning.
fn selector_words(selector: LodSelector) -> (&'static str, &'static str) {
    match selector {
        LodSelector::Cut => (
            "node by node",
            "Each branch for itself: where it errs least for its triangles. Where level by level looks better, that is \
             taken.",
        ),
        LodSelector::Levels => (
            "level by level",
            "All branches of a level alike, in the order below.",
        ),
    }
}

/// What a simplification does.
fn meaning(what: Simplification) -> &'static str {
    match what {
        Simplification::Splines => "Branches as coarser tubes",
        Simplification::Branches => "Branches as pairs of quads, without what grows on them",
        Simplification::Levels => "Branches with all that grows on them as a few quads",
    }
}

/// One of the order, to be dragged onto another or moved by buttons: from where to where.
fn item(ui: &mut Ui, index: usize, count: usize, what: Simplification) -> Option<[usize; 2]> {
    let name = format!("{what:?}");
    let mut wanted = None;
    let frame = Frame::NONE
        .stroke(ui.visuals().widgets.noninteractive.bg_stroke)
        .corner_radius(3.0)
        .inner_margin(egui::Margin::symmetric(4, 1));
    let shown = frame.show(ui, |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            let id = Id::unique(("simplification", index));
            let source = ui.dnd_drag_source(id, Dragged(index), |ui| {
                let text = RichText::new(format!("{}. {name}", index + 1));
                ui.add(egui::Label::new(text).selectable(false))
            });
            source.response.widget_info(|| {
                let place = format!("{name}, place {} of {count}", index + 1);
                egui::WidgetInfo::labeled(egui::Role::Label, true, place)
            });
            let meaning = format!("{}. Drag it onto another.", meaning(what));
            source.response.on_hover_text(meaning);
            if named(ui, "<", &format!("Try {name} earlier"), index > 0) {
                wanted = Some([index, index - 1]);
            }
            if named(ui, ">", &format!("Try {name} later"), index + 1 < count) {
                wanted = Some([index, index + 1]);
            }
        });
    });
    let place = shown.response;
    if let Some(dragged) = place.dnd_hover_payload::<Dragged>()
        && dragged.0 != index
    {
        let stroke = Stroke::new(1.5, ui.visuals().selection.stroke.color);
        let inside = egui::StrokeKind::Inside;
        ui.painter().rect_stroke(place.rect, 3.0, stroke, inside);
    }
    if let Some(dragged) = place.dnd_release_payload::<Dragged>()
        && dragged.0 != index
    {
        wanted = Some([dragged.0, index]);
    }
    wanted
}

/// Moves one of the order, which the text holds or means.
fn moved(priorities: &[Simplification], is_written: bool, [from, to]: [usize; 2]) -> Edit {
    if is_written {
        let path = format!("lod.priorities.{from}");
        return Edit::Reorder { path, to };
    }
    let mut priorities = priorities.to_vec();
    let one = priorities.remove(from);
    priorities.insert(to.min(priorities.len()), one);
    Edit::Set {
        path: "lod.priorities".to_owned(),
        value: list(&priorities, |what| format!("{what:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::document::Document;
    use crate::studio::templates::BLANK;

    #[test]
    fn the_order_is_changed_where_the_text_has_it_and_where_it_means_it() {
        use Simplification::{Branches, Levels, Splines};
        let order = |document: &Document| match &document.reading().species {
            Ok(species) => species.lod.priorities.clone(),
            Err(faults) => panic!("{}", faults.render(false)),
        };
        let list = "[\n Splines, // first\n Branches, Levels]";
        let list = format!("lod: (priorities: {list}), format:");
        for text in [BLANK.to_owned(), BLANK.replacen("format:", &list, 1)] {
            let is_written = text != BLANK;
            let mut document = Document::new(text);
            for (places, expected) in [
                ([2, 0], [Levels, Splines, Branches]),
                ([0, 1], [Splines, Levels, Branches]),
                ([2, 1], [Splines, Branches, Levels]),
            ] {
                let is_there = document.text().contains("priorities");
                let edit = moved(&order(&document), is_there, places);
                document.apply("Move", None, edit).unwrap();
                assert_eq!(order(&document), expected);
                assert_eq!(document.text().contains("// first"), is_written);
            }
        }
    }
}
