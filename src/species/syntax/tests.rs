use super::*;
use crate::species::fault::{Faults, Source};
use proptest::prelude::*;

fn report(source: &str) -> String {
    let (_, faults) = parse(source);
    Faults::new(vec![Source::new("x", source)], faults).to_string()
}

/// RON text again, for comparing trees without spans.
fn write(node: &Node) -> String {
    let list = |items: &[Node]| items.iter().map(write).collect::<Vec<_>>().join(",");
    match &node.kind {
        Kind::Number(text) | Kind::Ident(text) => text.clone(),
        Kind::Text(text) => format!("{text:?}"),
        Kind::Bool(value) => value.to_string(),
        Kind::None => "None".into(),
        Kind::Tuple { name, items } => {
            format!("{}({})", name.clone().unwrap_or_default(), list(items))
        }
        Kind::Struct { name, fields, .. } => {
            let fields: Vec<_> = fields
                .iter()
                .map(|entry| format!("{}:{}", entry.key, write(&entry.value)))
                .collect();
            format!("{}({})", name.clone().unwrap_or_default(), fields.join(","))
        }
        Kind::List(items) => format!("[{}]", list(items)),
        Kind::Map(entries) => {
            let entries: Vec<_> = entries
                .iter()
                .map(|(key, value)| format!("{}:{}", write(key), write(value)))
                .collect();
            format!("{{{}}}", entries.join(","))
        }
        Kind::Bad => "?".into(),
    }
}

fn reads_as(source: &str, expected: &str) {
    let (tree, faults) = parse(source);
    assert_eq!(faults, [], "{source}");
    assert_eq!(write(&tree.unwrap()), expected, "{source}");
}

#[test]
fn the_whole_subset_is_read() {
    reads_as(
        "#![enable(implicit_some)]\n// c\n( a : 1, /* /* */ , */ b: [1., .5, -2e-3, 1_000,], )",
        "(a:1,b:[1.,.5,-2e-3,1_000])",
    );
    reads_as(
        "Foo(x: Some((1, None)), y: Bar, z: Baz(true), w: ())",
        "Foo(x:(1,None),y:Bar,z:Baz(true),w:())",
    );
    reads_as(
        r##"["a\"\u{e9}\x41\n", r#"\"#, r"x"]"##,
        r#"["a\"éA\n","\\","x"]"#,
    );
    reads_as(
        "{\"k\": 1, 2: [inf, -inf, NaN]}",
        "{\"k\":1,2:[inf,-inf,NaN]}",
    );
    reads_as("(true: 1, None: 2, inf: 3, )", "(true:1,None:2,inf:3)");
}

#[test]
fn spans_cover_exactly_the_values() {
    let source = "( é\u{20}";
    assert!(parse(source).0.is_none());
    let source = "(name: \"Öl\", b: Foo( 1 ))";
    let Some(Node {
        kind: Kind::Struct { fields, .. },
        span,
    }) = parse(source).0
    else {
        panic!("not a struct")
    };
    assert_eq!(&source[span], source);
    assert_eq!(&source[fields[0].key_span.clone()], "name");
    assert_eq!(&source[fields[0].value.span.clone()], "\"Öl\"");
    assert_eq!(&source[fields[1].value.span.clone()], "Foo( 1 )");
    assert_eq!(&source[fields[1].value.head()], "Foo");
}

#[test]
fn several_faults_of_syntax_are_reported_with_their_places() {
    let source =
        "(\n  a: 5deg,\n  b = 2,\n  c 3\n  \"d\": “x”,\n  e: [1,, 2],\n  f: \"open,\n  g: 1\n)";
    assert_eq!(
        report(source),
        "x:2:6: `5deg` is not a number
    help: a number is written without its unit: the field's name tells it
x:3:5: b: expected `:`, found `=`
x:4:4: c: expected `:` between `c` and its value
x:4:6: c: expected `,` or `)` before text
x:5:3: d: a field's name is written without quotes
x:5:8: `“x”` does not belong here
    help: text is written in straight double quotes, `\"...\"`
x:6:9: e[1]: expected a value, found `,`
x:7:6: this text is not closed on its line
    help: end it with `\"`"
    );
    assert!(parse(source).0.is_some(), "read over");
}

#[test]
fn brackets_that_do_not_match_end_the_reading_and_name_both_places() {
    assert_eq!(
        report("(a: [1, 2), b: 3)"),
        "x:1:10: a: expected `]`, found `)`\n    1:5: `[` opened here"
    );
    assert!(report("(a: [(b: 1), c: 3)").contains("expected `]` before the field `c`"));
    assert_eq!(report("(a: (1"), "x:1:5: a: this `(` is never closed");
    assert!(report("(a: 1))").starts_with("x:1:7: `)` after the end of the script"));
    assert!(report("").contains("empty"));
}

#[test]
fn deep_nesting_is_a_fault_and_not_a_crash() {
    let deep = |n: usize| format!("{}{}", "[".repeat(n), "]".repeat(n));
    assert_eq!(report(&deep(MAX_DEPTH)), "");
    assert!(report(&deep(MAX_DEPTH + 1)).contains("nested deeper than 128"));
    assert!(report(&"(a:".repeat(100_000)).contains("nested deeper than 128"));
}

fn space() -> BoxedStrategy<String> {
    prop_oneof![
        8 => Just(String::new()),
        2 => Just(" ".into()),
        1 => Just("\n\t".into()),
        1 => Just("/* , /* ] */ */".into()),
        1 => Just("// ) \"\n".into()),
    ]
    .boxed()
}

fn scalar() -> impl Strategy<Value = String> {
    prop_oneof![
        "-?[0-9]{1,12}(\\.[0-9]{0,4})?([eE][+-]?[0-9]{1,2})?",
        "[+-]?[0-9]_?[0-9]{0,3}",
        "-?\\.[0-9]{1,3}",
        Just("inf".to_owned()),
        Just("-inf".to_owned()),
        Just("NaN".to_owned()),
        Just("true".to_owned()),
        Just("false".to_owned()),
        Just("None".to_owned()),
        Just("()".to_owned()),
        "[A-Z][a-z0-9_]{0,6}",
        "[ -!#-\\[\\]-~é]{0,8}".prop_map(|text| format!("\"{text}\"")),
        "[a-z]{0,3}(\\\\[nrt0\\\\\"']|\\\\x[0-7][0-9a-fA-F]|\\\\u\\{[0-9a-c]{1,4}\\})"
            .prop_map(|text| format!("\"{text}\"")),
        "[ -!#-~]{0,8}".prop_map(|text| format!("r#\"{text}\"#")),
    ]
}

/// Values of the subset, with some that are not quite.
fn value() -> impl Strategy<Value = String> {
    scalar().prop_recursive(5, 48, 5, |inner| {
        let item = (space(), inner, space())
            .prop_map(|(a, v, b)| format!("{a}{v}{b}"))
            .boxed();
        let comma = prop_oneof![3 => Just(""), 1 => Just(",")];
        let items = prop::collection::vec(item.clone(), 1..5);
        let field = ("[a-z_]{1,5}", space(), item).prop_map(|(k, s, v)| format!("{k}{s}:{v}"));
        let fields = prop::collection::vec(field, 1..5);
        let join = |(items, comma): (Vec<String>, &str)| items.join(",") + comma;
        let items = (items, comma.clone()).prop_map(join).boxed();
        let fields = (fields, comma).prop_map(join).boxed();
        prop_oneof![
            items.clone().prop_map(|items| format!("[{items}]")),
            items.clone().prop_map(|items| format!("({items})")),
            ("[A-Z][a-z]{0,4}", items.clone()).prop_map(|(name, items)| format!("{name}({items})")),
            items.prop_map(|items| format!("Some({items})")),
            fields.clone().prop_map(|fields| format!("({fields})")),
            ("[A-Z][a-z]{0,4}", fields).prop_map(|(name, fields)| format!("{name} ({fields})")),
        ]
    })
}

/// One small damage: a byte range replaced by some other text.
fn damage(source: &str, at: usize, length: usize, with: &str) -> String {
    let edge = |mut i: usize| {
        i = i.min(source.len());
        while !source.is_char_boundary(i) {
            i -= 1;
        }
        i
    };
    let start = edge(at % (source.len() + 1));
    let end = edge(start + length).max(start);
    format!("{}{with}{}", &source[..start], &source[end..])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn what_is_generated_is_accepted_here_and_by_ron(source in value()) {
        let ours = parse(&source);
        let theirs = source.parse::<ron::Value>();
        prop_assert_eq!(
            ours.1.is_empty(), theirs.is_ok(), "{}\n{:?}\n{:?}", source, ours.1, theirs
        );
    }

    #[test]
    fn a_scalar_has_the_value_that_ron_gives_it(source in scalar()) {
        match parse(&source).0.map(|node| node.kind) {
            Some(Kind::Text(text)) => {
                prop_assert_eq!(ron::from_str::<String>(&source), Ok(text));
            }
            Some(Kind::Number(text)) => {
                let ours: f32 = text.replace('_', "").parse().unwrap();
                let theirs: f32 = ron::from_str(&source).unwrap();
                prop_assert!(ours == theirs || ours.is_nan() && theirs.is_nan(), "{source}");
            }
            _ => {}
        }
    }

    #[test]
    fn what_is_accepted_after_damage_ron_accepts_too(
        source in value(), at in any::<usize>(), length in 0_usize..4, with in "[\\[\\](){}:,\"a1.e_ +/*\n#-]{0,3}",
    ) {
        let source = damage(&source, at, length, &with);
        let (tree, faults) = parse(&source);
        prop_assert_eq!(tree.is_none() && faults.is_empty(), false);
        if faults.is_empty() {
            let theirs = source.parse::<ron::Value>();
            prop_assert!(theirs.is_ok(), "{}\n{:?}", source, theirs);
        }
    }

    #[test]
    fn no_text_makes_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let source = String::from_utf8_lossy(&bytes);
        let (_, faults) = parse(&source);
        for fault in &faults {
            prop_assert!(source.get(fault.span.clone()).is_some(), "{fault:?}");
        }
    }

    #[test]
    fn no_soup_of_tokens_makes_the_reader_panic(source in "[\\[\\](){}:=,\"'a1.r#\n /*-]{0,60}") {
        let (tree, faults) = parse(&source);
        prop_assert!(tree.is_some() || !faults.is_empty());
        let faults = Faults::new(vec![Source::new("x", source.as_str())], faults);
        prop_assert!(faults.list().is_empty() || !faults.render(true).is_empty());
    }
}
