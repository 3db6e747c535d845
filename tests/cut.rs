//! The cut selector on made-up menus, against walks and enumerations of its own; and the flattening of fronts.

mod common;

use common::{BranchSketch, LeafSketch, Sketch, cases, descent, sketches, small, stand_ins};
use pleach::lod::cut::{Cutter, Front, Menu, Offer};
use pleach::mesh::{Coat, Dress, Flattener, Mesh, Wardrobe, front};
use pleach::species::schema::Lod;
use pleach::tree::{Kind, Tree};
use proptest::prelude::*;

/// A stream of random numbers (splitmix64), so that a menu is one number to print.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: u64) -> u64 {
        self.roll() % end
    }

    /// Between two bounds, in 1024 steps.
    fn between(&mut self, low: f32, high: f32) -> f32 {
        let step = u16::try_from(self.below(1025)).expect("small");
        low + (high - low) * f32::from(step) / 1024.0
    }
}

fn is_leaf(tree: &Tree, level: usize) -> bool {
    tree.levels[level].kind == Kind::Leaf
}

/// Triangles of the leaves that hang on a prototype directly.
fn own_leaves(tree: &Tree, level: usize, prototype: usize) -> u64 {
    let links = &tree.prototype(level, prototype).links;
    let leaves = links.iter().filter(|l| is_leaf(tree, l.level as usize));
    leaves
        .map(|l| {
            let leaf = tree.prototype(l.level as usize, l.prototype as usize);
            leaf.part.full_triangles()
        })
        .sum()
}

/// Branches on a prototype: level, prototype, scale.
fn branches(tree: &Tree, level: usize, prototype: usize) -> Vec<(usize, usize, f32)> {
    let links = &tree.prototype(level, prototype).links;
    links
        .iter()
        .filter(|l| !is_leaf(tree, l.level as usize))
        .map(|l| (l.level as usize, l.prototype as usize, l.place.scale))
        .collect()
}

/// Offers with errors that fall as triangles rise. The finest open form has no error; closed forms start at
/// four triangles and are never more than the fewest that the sub-tree takes otherwise.
fn menu(tree: &Tree, dice: &mut Dice) -> Menu {
    let mut offers: Vec<Vec<Vec<Offer>>> = tree
        .levels
        .iter()
        .map(|l| vec![Vec::new(); l.prototypes.len()])
        .collect();
    // By level and prototype: the fewest triangles.
    let mut fewest: Vec<Vec<u64>> = tree
        .levels
        .iter()
        .map(|l| vec![0; l.prototypes.len()])
        .collect();
    // By level and prototype: the largest error, so that closing a node costs more than closing its branches.
    let mut largest: Vec<Vec<f32>> = fewest.iter().map(|l| vec![0.0; l.len()]).collect();
    for level in (0..tree.levels.len()).rev().filter(|&l| !is_leaf(tree, l)) {
        for prototype in 0..tree.levels[level].prototypes.len() {
            let below = own_leaves(tree, level, prototype)
                + branches(tree, level, prototype)
                    .iter()
                    .map(|&(l, p, _)| fewest[l][p])
                    .sum::<u64>();
            let mut all = Vec::new();
            let (mut triangles, mut error) = (4 + dice.below(60), 0.0);
            for _ in 0..=dice.below(3) {
                all.push(offer(triangles, error, true));
                triangles = 4 + dice.below(triangles - 3);
                error += dice.between(0.001, 0.05);
            }
            if below >= 4 && dice.below(2) == 0 {
                all.push(offer(0, error + dice.between(0.01, 0.1), true));
            }
            if tree.has_children(level) {
                let worst: f32 = branches(tree, level, prototype)
                    .iter()
                    .map(|&(l, p, scale)| largest[l][p] * scale * scale)
                    .sum();
                let (mut triangles, mut error) =
                    (4, (error + worst + 0.05) * dice.between(0.6, 3.0));
                largest[level][prototype] = error;
                for _ in 0..=dice.below(4) {
                    all.push(offer(triangles, error, false));
                    triangles += 2 * (1 + dice.below(8));
                    error *= dice.between(0.3, 0.95);
                }
                fewest[level][prototype] = 4;
            } else {
                largest[level][prototype] = error;
                fewest[level][prototype] = all.iter().map(|o| o.triangles).min().unwrap_or(0);
            }
            offers[level][prototype] = all;
        }
    }
    Menu { offers }
}

fn offer(triangles: u64, error: f32, open: bool) -> Offer {
    Offer {
        triangles,
        error,
        open,
    }
}

/// Triangles and summed error of a front; panics unless its choices are exactly the nodes of a front.
fn counted(tree: &Tree, menu: &Menu, front: &Front) -> (u64, f64) {
    let mut choices = front.choices.iter().copied();
    let mut stack = vec![(0, 0, 1.0_f64)];
    let (mut triangles, mut error) = (0, 0.0);
    while let Some((level, prototype, scale)) = stack.pop() {
        let choice = choices.next().expect("a choice for every node");
        let offer = menu.offers[level][prototype][usize::from(choice)];
        triangles += offer.triangles;
        error += f64::from(offer.error) * scale * scale;
        if offer.open {
            triangles += own_leaves(tree, level, prototype);
            let below = branches(tree, level, prototype);
            let below = below.into_iter().rev();
            stack.extend(below.map(|(l, p, s)| (l, p, scale * f64::from(s))));
        }
    }
    assert_eq!(choices.next(), None, "no choice is left over");
    (triangles, error)
}

/// Every front of a sub-tree of scale 1: triangles and summed error.
fn all_fronts(tree: &Tree, menu: &Menu, level: usize, prototype: usize) -> Vec<(u64, f64)> {
    let mut below = vec![(own_leaves(tree, level, prototype), 0.0)];
    for (l, p, scale) in branches(tree, level, prototype) {
        let square = f64::from(scale) * f64::from(scale);
        let child = all_fronts(tree, menu, l, p);
        below = below
            .iter()
            .flat_map(|a| child.iter().map(move |b| (a.0 + b.0, a.1 + b.1 * square)))
            .collect();
    }
    let offers = &menu.offers[level][prototype];
    offers
        .iter()
        .flat_map(|o| {
            let own = (o.triangles, f64::from(o.error));
            let rest = if o.open { &below[..] } else { &[(0, 0.0)] };
            rest.iter().map(move |b| (own.0 + b.0, own.1 + b.1))
        })
        .collect()
}

/// Error gained per triangle from one front to a larger one; never positive.
fn slope(from: (u64, f64), to: (u64, f64)) -> f64 {
    (to.1 - from.1) / f64::from(u32::try_from(to.0 - from.0).expect("small"))
}

/// Corners that are the best front over a range of prices far wider than the tables' steps of 15 % can blur, and
/// both ends. Between two of them lies the optimum of every budget, one step away.
fn sharp(hull: &[(u64, f64)]) -> Vec<(u64, f64)> {
    let inner = hull
        .windows(3)
        .filter(|w| slope(w[0], w[1]) <= 2.5 * slope(w[1], w[2]));
    let mut corners = vec![hull[0]];
    corners.extend(inner.map(|w| w[1]));
    corners.extend(hull.last());
    corners
}

/// The corners of the lower convex hull, by triangles, as far as the error falls.
fn hull(mut fronts: Vec<(u64, f64)>) -> Vec<(u64, f64)> {
    fronts.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut hull: Vec<(u64, f64)> = Vec::new();
    for point in fronts {
        if hull.last().is_some_and(|last| point.1 >= last.1) {
            continue;
        }
        while let [.., a, b] = hull[..] {
            if slope(a, b) < slope(b, point) {
                break;
            }
            hull.pop();
        }
        hull.push(point);
    }
    hull
}

/// A level of one prototype on one other.
fn plain_branch(links: u32, vary: f32) -> BranchSketch {
    BranchSketch {
        links,
        children: 1,
        variants: 1,
        splines: 1,
        gnarl: 0.0,
        vary,
        sides: 3,
        tropism: 0.0,
        skip: 0,
        pipe_model: 0.0,
    }
}

/// Trees of at most eight branches.
fn tiny() -> impl Strategy<Value = Sketch> {
    let shape = prop_oneof![
        (1..=7_u32).prop_map(|limbs| vec![limbs]),
        (1..=3_u32).prop_map(|limbs| vec![limbs, 1]),
        Just(vec![2, 2]),
        Just(vec![1, 3]),
        Just(vec![1, 2, 2]),
        Just(vec![1, 1, 3]),
    ];
    (any::<u64>(), shape, 1..=4_u32, 5..=40_i16).prop_map(|(seed, links, leaves, vary)| {
        let vary = f32::from(vary) / 100.0;
        let branch = |links| plain_branch(links, vary);
        let mut branches = vec![branch(1)];
        branches.extend(links.into_iter().map(branch));
        Sketch {
            seed,
            stems: None,
            roots: false,
            branches,
            leaves: LeafSketch {
                links: leaves,
                children: 1,
                kinds: 1,
                tropism: 0.0,
            },
        }
    })
}

/// A chain of a trunk, a limb and a twig, and the twig's scale on the limb.
fn chain() -> (Tree, f32) {
    let tree = Sketch {
        seed: 1,
        stems: None,
        roots: false,
        branches: vec![plain_branch(1, 0.0); 3],
        leaves: LeafSketch {
            links: 1,
            children: 1,
            kinds: 1,
            tropism: 0.0,
        },
    }
    .tree();
    let scale = branches(&tree, 1, 0)[0].2;
    (tree, scale)
}

#[test]
fn what_is_left_opens_a_node_that_no_price_opens() {
    let (tree, scale) = chain();
    // The limb is so good in eight triangles that all prices go from there to the whole twig at once.
    let poor_twig = offer(492, 0.9 / (scale * scale), false);
    let offers = vec![
        vec![vec![offer(4, 0.0, true), offer(4, 100.0, false)]],
        vec![vec![offer(4, 0.0, true), offer(8, 1.0, false)]],
        vec![vec![offer(1000, 0.0, true), poor_twig]],
        vec![vec![]],
    ];
    let menu = Menu { offers };
    let cutter = Cutter::new(&tree, &menu);
    let cut = |budget| cutter.cut(budget).expect("enough").choices;
    assert_eq!(cut(499), [0, 1], "too little for the twig");
    assert_eq!(cut(900), [0, 0, 1], "the twig as it fits");
    assert_eq!(cut(2000), [0, 0, 0]);
    // Where next to nothing is left, it stays.
    assert_eq!(cut(12), [0, 1]);
}

/// Budgets from the smallest form to above full detail, rising by a tenth.
fn budgets(full: u64) -> Vec<u64> {
    let mut budgets = vec![4];
    while let Some(&last) = budgets.last()
        && last <= full
    {
        budgets.push(last + 1 + last / 10);
    }
    budgets
}

/// Triangles of the front of least error.
fn richest(tree: &Tree, menu: &Menu) -> u64 {
    let front = Cutter::new(tree, menu).cut(1 << 39).expect("all fits");
    front.triangles
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn fronts_keep_their_budgets_and_count_their_triangles(
        sketch in sketches(true),
        seed in any::<u64>(),
    ) {
        let tree = sketch.tree();
        let menu = menu(&tree, &mut Dice(seed));
        let cutter = Cutter::new(&tree, &menu);
        let again = Cutter::new(&tree, &menu);
        for budget in budgets(richest(&tree, &menu)) {
            let front = cutter.cut(budget).expect("the root's smallest form has four triangles");
            prop_assert!(front.triangles <= budget, "{} > {budget}", front.triangles);
            let (triangles, error) = counted(&tree, &menu, &front);
            prop_assert_eq!(triangles, front.triangles, "budget {}", budget);
            let told = f64::from(cutter.error(&front));
            prop_assert!((told - error).abs() <= 1e-3 * (1.0 + error), "{told} for {error}");
            prop_assert_eq!(again.cut(budget), Some(front), "the same front twice");
        }
    }

    #[test]
    fn budgets_below_the_smallest_form_get_no_front(sketch in sketches(true), seed in any::<u64>()) {
        let tree = sketch.tree();
        let menu = menu(&tree, &mut Dice(seed));
        let cutter = Cutter::new(&tree, &menu);
        for budget in 0..4 {
            prop_assert_eq!(cutter.cut(budget), None);
        }
        prop_assert_eq!(cutter.cut(4).map(|f| f.triangles), Some(4));
    }

    #[test]
    fn budgets_that_full_detail_meets_get_full_detail(sketch in sketches(true), seed in any::<u64>()) {
        let tree = sketch.tree();
        let menu = menu(&tree, &mut Dice(seed));
        let cutter = Cutter::new(&tree, &menu);
        let full = cutter.cut(u64::MAX).expect("all fits");
        prop_assert_eq!(cutter.error(&full), 0.0);
        prop_assert_eq!(cutter.cut(full.triangles), Some(full.clone()));
        let less = cutter.cut(full.triangles - 1).expect("more than four");
        prop_assert!(less.triangles < full.triangles && cutter.error(&less) > 0.0);
    }

    #[test]
    fn an_open_root_is_open_or_there_is_no_front(sketch in sketches(true), seed in any::<u64>()) {
        let tree = sketch.tree();
        let menu = menu(&tree, &mut Dice(seed));
        let cutter = Cutter::new(&tree, &menu);
        let opened = cutter.with_open_root();
        let mut found = false;
        for budget in budgets(richest(&tree, &menu)) {
            let Some(front) = opened.cut(budget) else {
                prop_assert!(!found, "a larger budget of {budget} has none");
                continue;
            };
            found = true;
            prop_assert!(menu.offers[0][0][usize::from(front.choices[0])].open);
            prop_assert!(front.triangles <= budget);
            prop_assert_eq!(counted(&tree, &menu, &front).0, front.triangles);
        }
        prop_assert!(found, "full detail is open");
    }

    #[test]
    fn barred_offers_are_never_taken(sketch in sketches(true), seed in any::<u64>()) {
        let tree = sketch.tree();
        let mut dice = Dice(seed);
        let mut menu = menu(&tree, &mut dice);
        for offers in menu.offers.iter_mut().flatten() {
            // The smallest closed form and full detail stay.
            for offer in offers.iter_mut().filter(|o| o.error > 0.0 && (o.open || o.triangles > 4)) {
                if dice.below(2) == 0 {
                    *offer = Offer::BARRED;
                }
            }
        }
        let cutter = Cutter::new(&tree, &menu);
        for budget in budgets(richest(&tree, &menu)).into_iter().chain([u64::MAX]) {
            let cuts = [cutter.cut(budget), cutter.with_open_root().cut(budget)];
            for front in cuts.into_iter().flatten() {
                prop_assert!(front.triangles <= budget);
                prop_assert!(counted(&tree, &menu, &front).1.is_finite(), "budget {budget}");
            }
        }
    }

    #[test]
    fn more_triangles_never_look_much_worse(sketch in sketches(true), seed in any::<u64>()) {
        let tree = sketch.tree();
        let menu = menu(&tree, &mut Dice(seed));
        let cutter = Cutter::new(&tree, &menu);
        let mut least = f32::INFINITY;
        for budget in budgets(richest(&tree, &menu)) {
            let front = cutter.cut(budget).expect("enough");
            let error = cutter.error(&front);
            prop_assert!(error <= least * 1.1, "{error} after {least} at {budget}");
            least = least.min(error);
        }
    }
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn tiny_trees_get_fronts_as_good_as_the_last_sharp_corner_of_the_hull(
        sketch in tiny(),
        seed in any::<u64>(),
    ) {
        let tree = sketch.tree();
        let menu = menu(&tree, &mut Dice(seed));
        let fronts = all_fronts(&tree, &menu, 0, 0);
        let hull = hull(fronts.clone());
        let corners = sharp(&hull);
        let cutter = Cutter::new(&tree, &menu);
        let full = hull.last().expect("a front").0;
        for budget in 4..=full + 1 {
            let front = cutter.cut(budget).expect("enough");
            let error = counted(&tree, &menu, &front).1;
            let corner = corners.iter().rev().find(|c| c.0 <= budget).expect("four triangles");
            let best = fronts.iter().filter(|f| f.0 <= budget).map(|f| f.1).fold(f64::INFINITY, f64::min);
            prop_assert!(error >= best - 1e-4 * best.max(1.0), "{error} below the optimum {best}");
            prop_assert!(error <= corner.1 * 1.5 + 1e-6, "{error} above {} at {budget}", corner.1);
        }
    }
}

/// The wardrobe in which every level has one offer: its form in a level-wide state.
fn one_offer_each(tree: &Tree, form: &pleach::mesh::Form) -> Wardrobe {
    let offers = form.templates.iter().enumerate().map(|(level, templates)| {
        let dress = |template: &Option<_>| {
            vec![Dress {
                template: template.clone(),
                open: form.open[level] && !is_leaf(tree, level),
            }]
        };
        templates.iter().map(dress).collect()
    });
    Wardrobe {
        offers: offers.collect(),
    }
}

fn bounds_differ(a: &Mesh, b: &Mesh) -> f32 {
    let (a, b) = (a.bounds(), b.bounds());
    let low = (a.min - b.min).abs().max_element();
    low.max((a.max - b.max).abs().max_element())
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn a_level_wide_front_is_the_flatteners_mesh(sketch in sketches(true)) {
        let tree = sketch.tree();
        let quads = stand_ins(&tree);
        let nodes: u64 = tree.nodes().iter().flatten().sum();
        let choices = vec![0; usize::try_from(nodes).expect("few")];
        for (state, _) in descent(&tree, &Lod::default()) {
            let form = quads.form(&tree, &state, Coat::plain(0.5));
            let flat = Flattener::new(&tree, &form).tree().expect("small");
            let cut = front(&tree, &one_offer_each(&tree, &form), &choices).expect("small");
            let name = state.describe(&tree);
            prop_assert_eq!(cut.bark.triangles(), flat.bark.triangles(), "{}", name);
            prop_assert_eq!(cut.foliage.triangles(), flat.foliage.triangles(), "{}", name);
            prop_assert_eq!(&cut.bark.indices, &flat.bark.indices, "{}", name);
            prop_assert_eq!(&cut.foliage.indices, &flat.foliage.indices, "{}", name);
            let apart = bounds_differ(&cut, &flat);
            prop_assert!(apart < 1e-3, "{name}: bounds are {apart} apart");
        }
    }
}

#[test]
fn missing_choices_draw_nothing() {
    let tree = small().tree();
    let quads = stand_ins(&tree);
    let (state, _) = &descent(&tree, &Lod::default())[0];
    let wardrobe = one_offer_each(&tree, &quads.form(&tree, state, Coat::plain(0.5)));
    let drawn = |choices: &[u16]| {
        let mesh = front(&tree, &wardrobe, choices).expect("small");
        mesh.triangles()
    };
    assert_eq!(drawn(&[]), 0);
    assert_eq!(drawn(&[1]), 0, "there is one offer only");
    let trunk = drawn(&[0]);
    assert!(0 < trunk && trunk < drawn(&[0, 0]));
}
