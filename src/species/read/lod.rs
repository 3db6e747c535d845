//! How the chain of LODs is made: budgets, order of simplifications, forms of levels.

use super::levels::Levels;
use crate::species::decode::{Fields, Report, Value};
use crate::species::fields::{
    self, BUDGET, CLOSED_FORMS, MAX_BUDGETS, MAX_LEVELS, MAX_TOLERANCES, PLANES, SEGMENTS,
    SELECTORS, SIMPLIFICATIONS, STRIPS, TOLERANCE,
};
use crate::species::schema::{ClosedForm, LevelKind, Lod, LodSelector, Simplification};
use crate::species::syntax::Kind;

/// The LOD part of a script; `levels` are those of the same script.
pub(super) fn lod(out: &mut Report, value: &Value<'_>, levels: &Levels<'_>) -> Lod {
    let fields = Fields::open_plain(out, value.clone(), &fields::LOD);
    let budgets = fields.read(out, "budgets", |out, value, _| Some(budgets(out, value)));
    let priorities = fields.read(out, "priorities", |out, value, _| {
        Some(priorities(out, value))
    });
    let tolerances = fields.read(out, "tolerances", |out, value, _| {
        Some(tolerances(out, value))
    });
    let selector = fields.read(out, "selector", |out, value, _| selector(out, value));
    let calibrate = fields.read(out, "calibrate", |out, value, _| truth(out, value));
    let forms = fields.read(out, "forms", |out, value, _| {
        Some(forms(out, value, levels))
    });
    Lod {
        budgets: budgets.unwrap_or_default(),
        priorities: priorities.unwrap_or_default(),
        tolerances: tolerances.unwrap_or_default(),
        selector: selector.unwrap_or_default(),
        calibrate: calibrate.unwrap_or(true),
        forms: forms.unwrap_or_default(),
    }
}

/// Items of a list that must have 1 to `most` of them.
fn some_items<'n>(out: &mut Report, value: &Value<'n>, what: &str, most: usize) -> Vec<Value<'n>> {
    let items = value.items(out, &format!("a list of {what}"));
    if matches!(value.node.kind, Kind::List(_)) && !(1..=most).contains(&items.len()) {
        let found = items.len();
        out.push(value.fault(format!("expected 1 to {most} {what}, found {found}")));
        return Vec::new();
    }
    items
}

fn budgets(out: &mut Report, value: &Value<'_>) -> Vec<u64> {
    let mut budgets: Vec<u64> = Vec::new();
    for item in some_items(out, value, "budgets", MAX_BUDGETS) {
        if let Kind::Number(text) = &item.node.kind
            && text.parse::<i64>().is_ok_and(|budget| budget < 4)
        {
            let message = format!(
                "a budget of {text} triangles cannot be met: the smallest form, one cross-quad, \
                 has {} triangles",
                BUDGET.0
            );
            out.push(item.fault(message));
            continue;
        }
        let Some(budget) = item.whole(out, BUDGET.0, BUDGET.1) else {
            continue;
        };
        if let Some(&last) = budgets.last()
            && budget >= last
        {
            let message = format!("budgets must fall: {budget} comes after {last}");
            out.push(item.fault(message));
        }
        budgets.push(budget);
    }
    budgets
}

fn priorities(out: &mut Report, value: &Value<'_>) -> Vec<Simplification> {
    let mut priorities = Vec::new();
    for item in some_items(out, value, "simplifications", SIMPLIFICATIONS.len()) {
        let simplification = match item.one_of(out, SIMPLIFICATIONS) {
            Some("Splines") => Simplification::Splines,
            Some("Branches") => Simplification::Branches,
            Some(_) => Simplification::Levels,
            None => continue,
        };
        if priorities.contains(&simplification) {
            out.push(item.fault(format!("`{simplification:?}` is listed twice")));
        }
        priorities.push(simplification);
    }
    priorities
}

fn tolerances(out: &mut Report, value: &Value<'_>) -> Vec<f32> {
    let mut tolerances: Vec<f32> = Vec::new();
    for item in some_items(out, value, "tolerances", MAX_TOLERANCES) {
        let Some(tolerance) = item.number(out, TOLERANCE) else {
            continue;
        };
        if let Some(&last) = tolerances.last()
            && tolerance <= last
        {
            let message = format!("tolerances must rise: {tolerance} comes after {last}");
            out.push(item.fault(message));
        }
        tolerances.push(tolerance);
    }
    tolerances
}

fn selector(out: &mut Report, value: &Value<'_>) -> Option<LodSelector> {
    Some(match value.one_of(out, SELECTORS)? {
        "Levels" => LodSelector::Levels,
        _ => LodSelector::Cut,
    })
}

fn truth(out: &mut Report, value: &Value<'_>) -> Option<bool> {
    if let Kind::Bool(truth) = value.node.kind {
        return Some(truth);
    }
    value.mismatch(out, "true or false");
    None
}

/// The closed forms of levels, by the levels' names.
fn forms(out: &mut Report, value: &Value<'_>, levels: &Levels<'_>) -> Vec<(String, ClosedForm)> {
    let items = value.items(out, "a list of (level, form)");
    if items.len() > MAX_LEVELS {
        let found = items.len();
        let message = format!("a species has at most {MAX_LEVELS} levels, found {found} forms");
        out.push(value.fault(message));
        return Vec::new();
    }
    let mut forms = Vec::new();
    let mut named: Vec<(String, Value<'_>)> = Vec::new();
    for item in &items {
        let Some(pair) = item.tuple(2) else {
            item.mismatch(out, "(level, form), such as (\"twigs\", Cross)");
            continue;
        };
        let [level, form] = pair.as_slice() else {
            continue;
        };
        let name = branch_level(out, level, levels);
        let form = closed_form(out, form);
        let Some(name) = name else { continue };
        if let Some((_, first)) = named.iter().find(|(other, _)| *other == name) {
            let fault = level.fault(format!("level `{name}` is given two forms"));
            out.push(fault.also(first.node.head(), "first named here"));
        }
        named.push((name.clone(), level.clone()));
        if let Some(form) = form {
            forms.push((name, form));
        }
    }
    forms
}

/// The name of a level that has something to close.
fn branch_level(out: &mut Report, value: &Value<'_>, levels: &Levels<'_>) -> Option<String> {
    let name = value.text(out)?;
    let level = levels.levels.iter().find(|level| level.name == name);
    match level.map(|level| &level.kind) {
        Some(LevelKind::Leaf(_)) => {
            let message = format!("`{name}` is a leaf level: its cards are as flat as can be");
            let fault = value.fault(message);
            out.push(fault.help("name the level that carries the leaves"));
        }
        // A level that could not be read was reported, and may be meant.
        None if !levels.may_have(name) => {
            levels.names.find(out, value);
            return None;
        }
        Some(LevelKind::Branch(_)) | None => {}
    }
    Some(name.to_owned())
}

fn closed_form(out: &mut Report, value: &Value<'_>) -> Option<ClosedForm> {
    let name = value.one_of(out, CLOSED_FORMS)?;
    if name == "Planes" {
        return planes(out, value).map(ClosedForm::Planes);
    }
    if name == "Strips" {
        return strips(out, value);
    }
    // `Cross()` is `Cross` with nothing in it; anything inside would be lost.
    let is_bare = match &value.node.kind {
        Kind::Tuple { items, .. } => items.is_empty(),
        Kind::Struct { fields, .. } => fields.is_empty(),
        _ => true,
    };
    if !is_bare {
        out.push(value.fault(format!("`{name}` takes nothing in brackets")));
        return None;
    }
    Some(match name {
        "CrossTop" => ClosedForm::CrossTop,
        "StarTop" => ClosedForm::StarTop,
        _ => ClosedForm::Cross,
    })
}

/// The number in `Planes(8)`.
fn planes(out: &mut Report, value: &Value<'_>) -> Option<u32> {
    if let Kind::Tuple { items, .. } = &value.node.kind
        && let [count] = items.as_slice()
    {
        let count = Value::new(count, format!("{}.0", value.path));
        return u32::try_from(count.whole(out, PLANES.0, PLANES.1)?).ok();
    }
    let fault = value.fault("`Planes` takes one number: how many planes are fitted");
    out.push(fault.help("Planes(8)"));
    None
}

/// The numbers in `Strips(2, 4)`.
fn strips(out: &mut Report, value: &Value<'_>) -> Option<ClosedForm> {
    if let Kind::Tuple { items, .. } = &value.node.kind
        && let [count, segments] = items.as_slice()
    {
        let mut number = |item, index: u32, (least, most)| {
            let item = Value::new(item, format!("{}.{index}", value.path));
            u32::try_from(item.whole(out, least, most)?).ok()
        };
        let (count, segments) = (number(count, 0, STRIPS), number(segments, 1, SEGMENTS));
        return Some(ClosedForm::Strips(count?, segments?));
    }
    let what = "`Strips` takes two numbers: how many strips, and how many segments each has";
    let fault = value.fault(what);
    out.push(fault.help("Strips(2, 4)"));
    None
}
