//! Branching levels: what grows on what, where, and how much of it.

use super::shape::Names;
use crate::species::decode::{Fields, Report, Value, with_nearest};
use crate::species::fields::{self, LEVELS, MAX_LEVELS, MAX_LINKS, MAX_NODES, NOT_FOR_TRUNK};
use crate::species::schema::{
    BranchParams, Curve, Envelope, Flare, Flutes, LeafParams, Level, LevelKind, Placement, Size,
};
use crate::species::syntax::Kind;

/// Names that levels refer to.
pub(super) struct Known<'a, 'n> {
    pub(super) splines: &'a Names<'n>,
    pub(super) leaves: &'a Names<'n>,
}

/// Corners of a cross-section by depth, the trunk first.
const SIDES: [u32; 4] = [16, 10, 6, 4];

/// All levels that could be read, and what is known of the others.
pub(super) struct Levels<'n> {
    pub(super) levels: Vec<Level>,
    pub(super) names: Names<'n>,
    /// Names of all items of the list, readable or not; none if there is no list.
    written: Vec<Option<&'n str>>,
}

impl Levels<'_> {
    fn unknown() -> Self {
        Self {
            levels: Vec::new(),
            names: Names::new("level"),
            written: Vec::new(),
        }
    }

    /// True if a level has this name, or if there is no telling.
    pub(super) fn may_have(&self, name: &str) -> bool {
        self.written.is_empty() || self.written.contains(&Some(name))
    }
}

/// All levels.
pub(super) fn levels<'n>(out: &mut Report, root: &Fields<'n>, known: &Known<'_, 'n>) -> Levels<'n> {
    let Some(list) = root.require(out, "levels") else {
        return Levels::unknown();
    };
    let items = list.items(out, "a list of levels");
    if items.is_empty() && matches!(list.node.kind, Kind::List(_)) {
        let fault = list.fault("a species has at least one level, the trunk");
        out.push(fault.help("Branch(name: \"trunk\", ...)"));
    }
    if items.len() > MAX_LEVELS {
        let found = items.len();
        out.push(list.fault(format!(
            "a species has at most {MAX_LEVELS} levels, found {found}"
        )));
        return Levels::unknown();
    }
    let all_names: Vec<Option<&str>> = items.iter().map(name_of).collect();
    let mut reading = Reading {
        known,
        all_names,
        names: Names::new("level"),
        seen: Vec::new(),
        links: 0,
        levels: Vec::new(),
        skips: Vec::new(),
    };
    let before = out.count();
    for item in items {
        reading.level(out, item);
    }
    // Of levels that could not be read there is no telling what grows on them.
    if out.count() == before {
        for (level, value) in &reading.skips {
            skips(out, &reading.levels, *level, value);
        }
    }
    Levels {
        levels: reading.levels,
        names: reading.names,
        written: reading.all_names,
    }
}

/// The name that a level will have, for telling "later" from "nowhere".
fn name_of<'n>(value: &Value<'n>) -> Option<&'n str> {
    let Kind::Struct { fields, .. } = &value.node.kind else {
        return None;
    };
    let entry = fields.iter().find(|entry| entry.key == "name")?;
    match &entry.value.kind {
        Kind::Text(text) => Some(text),
        _ => None,
    }
}

struct Reading<'a, 'n> {
    known: &'a Known<'a, 'n>,
    all_names: Vec<Option<&'n str>>,
    names: Names<'n>,
    /// One for each item of the list so far, readable or not, so that indices are right.
    seen: Vec<Seen>,
    /// Links that all prototypes so far hold.
    links: u64,
    levels: Vec<Level>,
    /// Levels of which some places skip levels, and where that is written.
    skips: Vec<(usize, Value<'n>)>,
}

/// What later levels need to know of one.
struct Seen {
    name: String,
    is_branch: bool,
    /// Branches between it and the ground.
    depth: usize,
    variants: u64,
    nodes: u64,
}

impl<'n> Reading<'_, 'n> {
    fn level(&mut self, out: &mut Report, value: Value<'n>) {
        let before = out.count();
        let Some(kind) = kind_of(out, &value) else {
            // Whatever it is, what says it grows on it is not at fault.
            self.seen.push(Seen {
                name: name_of(&value).unwrap_or_default().to_owned(),
                is_branch: true,
                depth: 0,
                variants: 1,
                nodes: 1,
            });
            return;
        };
        let leaves = kind == "Leaves";
        let table = if leaves {
            &fields::LEAVES
        } else {
            &fields::BRANCH
        };
        let fields = Fields::open(out, value, table);
        let name = self.names.add(out, &fields);
        let parent = if self.seen.is_empty() {
            trunk(out, &fields, leaves);
            None
        } else {
            self.parent(out, &fields)
        };
        let carrier = parent.and_then(|parent| self.seen.get(parent));
        let depth = carrier.map_or(0, |seen| seen.depth + 1);
        let placement = placement(out, &fields, leaves);
        if let Some(value) = fields.get("skip") {
            self.skips.push((self.levels.len(), value));
        }
        let kind = if leaves {
            let list = fields.require(out, "kinds");
            let kinds = list.map(|list| self.known.leaves.choices(out, &list));
            LevelKind::Leaf(LeafParams {
                kinds: kinds.unwrap_or_default(),
            })
        } else {
            LevelKind::Branch(self.branch(out, &fields, depth))
        };
        let variants = match &kind {
            LevelKind::Branch(branch) => u64::from(branch.variants),
            LevelKind::Leaf(_) => 1,
        };
        let is_whole = out.count() == before;
        let nodes = match carrier {
            Some(carrier) if is_whole => count(out, &fields, &placement, carrier, &mut self.links),
            Some(carrier) => carrier.nodes,
            None => 1,
        };
        self.seen.push(Seen {
            name: name.clone(),
            is_branch: !leaves,
            depth,
            variants,
            nodes,
        });
        self.levels.push(Level {
            name,
            parent,
            placement,
            kind,
        });
    }

    /// The level that carries this one.
    fn parent(&self, out: &mut Report, fields: &Fields<'_>) -> Option<usize> {
        let index = self.seen.len();
        let Some(value) = fields.get("on") else {
            let before = index.checked_sub(1)?;
            let seen = self.seen.get(before)?;
            if !seen.is_branch {
                let message = format!(
                    "the level before, `{}`, is a leaf level and carries nothing; say `on`",
                    seen.name
                );
                let fault = fields.whole.fault(message);
                let branch = self.seen.iter().rev().find(|seen| seen.is_branch);
                out.push(match branch {
                    Some(branch) => fault.help(format!("on: \"{}\"", branch.name)),
                    None => fault,
                });
            }
            return Some(before);
        };
        let text = value.text(out)?;
        match self.all_names.iter().position(|name| *name == Some(text)) {
            Some(at) if at == index => {
                out.push(value.fault(format!("level `{text}` cannot grow on itself")));
                None
            }
            Some(at) if at > index => {
                let message = format!("level `{text}` comes later; a level grows on one before it");
                out.push(value.fault(message));
                None
            }
            Some(at) if self.seen.get(at).is_some_and(|seen| seen.is_branch) => Some(at),
            Some(_) => {
                out.push(value.fault(format!("`{text}` is a leaf level and carries nothing")));
                None
            }
            None => self.names.find(out, &value),
        }
    }

    fn branch(&self, out: &mut Report, fields: &Fields<'_>, depth: usize) -> BranchParams {
        let splines = fields.require(out, "splines");
        let splines = splines.map(|list| self.known.splines.choices(out, &list));
        let taper = fields.curve(out, "taper");
        if taper.max() <= 0.0
            && let Some(value) = fields.get("taper")
        {
            out.push(value.fault("the taper is 0 everywhere, so the branch has no thickness"));
        }
        let is_trunk = self.seen.is_empty();
        BranchParams {
            variants: fields.whole(out, "variants"),
            splines: splines.unwrap_or_default(),
            length: size(out, fields, ["length_m", "length_of_parent"], is_trunk),
            length_vary: fields.number(out, "length_vary"),
            radius: size(out, fields, ["radius_m", "radius_of_parent"], is_trunk),
            taper,
            pipe_model: fields.number(out, "pipe_model"),
            gnarl: fields.number(out, "gnarl"),
            collar: fields.number(out, "collar"),
            flare: fields.get("flare").map(|value| flare(out, value)),
            flutes: fields.get("flutes").map(|value| flutes(out, value)),
            sides: if fields.has("sides") {
                fields.whole(out, "sides")
            } else {
                SIDES.get(depth).or(SIDES.last()).copied().unwrap_or(4)
            },
        }
    }
}

fn kind_of(out: &mut Report, value: &Value<'_>) -> Option<&'static str> {
    let Some(kind) = value.variant() else {
        value.mismatch(out, "a level, Branch(...) or Leaves(...)");
        return None;
    };
    let known = LEVELS.iter().find(|known| **known == kind);
    if known.is_none() {
        let message = format!("unknown kind of level `{kind}`; expected Branch or Leaves");
        out.push(with_nearest(
            value.fault(message),
            kind,
            LEVELS.iter().copied(),
        ));
    }
    known.copied()
}

/// Nodes of a level; reports what would not fit in memory, or could not be counted.
fn count(
    out: &mut Report,
    fields: &Fields<'_>,
    placement: &Placement,
    carrier: &Seen,
    links: &mut u64,
) -> u64 {
    let each = u64::from(placement.links) * u64::from(placement.children);
    let place = fields.get("links").or_else(|| fields.get("children"));
    let place = place.unwrap_or_else(|| fields.whole.clone());
    // Neither can overflow: 16 levels of at most 640,000 links on 16 prototypes, and nodes stop at
    // the limit.
    *links += each * carrier.variants;
    if *links > MAX_LINKS {
        let message = format!(
            "{each} children on each of {} prototypes make {links} links with the levels before; \
             at most {MAX_LINKS} can be held",
            carrier.variants
        );
        out.push(
            place
                .fault(message)
                .help("use fewer links, children or variants"),
        );
        *links = 0;
    }
    let nodes = carrier.nodes.saturating_mul(each);
    if nodes <= MAX_NODES {
        return nodes;
    }
    let message = format!(
        "this level would have {} x {each} nodes; at most {MAX_NODES} can be counted",
        carrier.nodes
    );
    out.push(place.fault(message));
    carrier.nodes
}

/// Only levels that are there can be skipped, and not by all places.
fn skips(out: &mut Report, levels: &[Level], level: usize, value: &Value<'_>) {
    let (name, placement) = (&levels[level].name, &levels[level].placement);
    let after = |level: usize| {
        levels
            .iter()
            .position(|l| l.parent == Some(level) && matches!(l.kind, LevelKind::Branch(_)))
    };
    let there = std::iter::successors(after(level), |&l| after(l)).count();
    let most = usize::try_from(placement.most_skipped()).unwrap_or(usize::MAX);
    if most > there {
        let found = match there {
            0 => format!("no branches grow on `{name}`, so that no place can skip it"),
            1 => format!("places would skip {most} levels of branches, and 1 grows on `{name}`"),
            _ => format!(
                "places would skip {most} levels of branches, and {there} grow on `{name}` one on another"
            ),
        };
        out.push(
            value
                .fault(found)
                .help(format!("keep the curve below {there}.5")),
        );
    } else if (0..placement.links).all(|index| placement.skipped(index) > 0) {
        let message = format!("every place skips `{name}`, so that the tree has none");
        out.push(
            value
                .fault(message)
                .help("let the curve begin at 0: [(0, 0), (1, 1)]"),
        );
    }
}

/// The trunk grows on nothing, and is a branch.
fn trunk(out: &mut Report, fields: &Fields<'_>, leaves: bool) {
    if leaves {
        let message = "the first level is the trunk, and must be a Branch";
        out.push(fields.whole.fault(message));
        return;
    }
    for name in NOT_FOR_TRUNK {
        if let Some(value) = fields.get(name) {
            let fault = value.fault(format!(
                "the first level is the trunk: `{name}` has no meaning"
            ));
            out.push(match name.strip_suffix("_of_parent") {
                Some(size) => fault.help(format!("it has no parent; give `{size}_m` instead")),
                None => fault.help("remove it; the trunk stands on the ground"),
            });
        }
    }
}

fn size(
    out: &mut Report,
    fields: &Fields<'_>,
    [metres, of_parent]: [&'static str; 2],
    is_trunk: bool,
) -> Size {
    if !is_trunk {
        fields.either(out, metres, of_parent);
    } else if !fields.has_or_excused(metres) && !fields.has(of_parent) {
        let message = format!("missing field `{metres}` in Branch; the trunk has no parent");
        out.push(fields.whole.fault(message));
    }
    // A relative size of the trunk is reported with what else it may not have.
    if fields.has(metres) {
        Size::Metres(fields.number(out, metres))
    } else if fields.has(of_parent) {
        Size::OfParent(fields.number(out, of_parent))
    } else {
        Size::OfParent(1.0)
    }
}

fn placement(out: &mut Report, fields: &Fields<'_>, leaves: bool) -> Placement {
    let before = out.count();
    let (start, end) = (fields.number(out, "start"), fields.number(out, "end"));
    if out.count() == before && start > end {
        let value = fields.get("start").or_else(|| fields.get("end"));
        let message = format!("`start` ({start}) is beyond `end` ({end})");
        out.push(value.unwrap_or_else(|| fields.whole.clone()).fault(message));
    }
    Placement {
        links: fields.whole(out, "links"),
        children: fields.whole(out, "children"),
        start,
        end,
        jitter: fields.number(out, "jitter"),
        crowding: fields.number(out, "crowding"),
        skip: if leaves {
            Curve::constant(0.0)
        } else {
            fields.curve(out, "skip")
        },
        around: fields.param(out, "around"),
        down: fields.param(out, "down"),
        sideways: fields.param(out, "sideways"),
        spin: fields.param(out, "spin"),
        scale: fields.param(out, "scale"),
        thickness: fields.param(out, "thickness"),
        tropism: fields.number(out, "tropism"),
        envelope: fields.get("envelope").map(|value| {
            let fields = Fields::open_plain(out, value, &fields::ENVELOPE);
            Envelope {
                height_m: fields.number(out, "height_m"),
                radius_m: fields.curve(out, "radius_m"),
            }
        }),
    }
}

fn flare(out: &mut Report, value: Value<'_>) -> Flare {
    let fields = Fields::open_plain(out, value, &fields::FLARE);
    Flare {
        height_m: fields.number(out, "height_m"),
        amount: fields.number(out, "amount"),
        lobes: fields.whole(out, "lobes"),
        depth: fields.number(out, "depth"),
    }
}

fn flutes(out: &mut Report, value: Value<'_>) -> Flutes {
    let fields = Fields::open_plain(out, value, &fields::FLUTES);
    Flutes {
        count: fields.whole(out, "count"),
        depth: fields.number(out, "depth"),
        twist_turns: fields.number(out, "twist_turns"),
    }
}
