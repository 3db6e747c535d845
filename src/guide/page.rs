//! The guide's text, as Markdown.

use crate::asset::{AssetLod, TreeAsset};
use crate::evaluate::text::number;
use crate::species::schema::{Habit, Species, Variation};
use crate::survey::{Line, Verdict};
use core::fmt::Write as _;

/// What the guide tells of one species.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    name: String,
    latin: String,
    /// Path of the script, as links have it.
    script: String,
    /// Path of the plate, as links have it.
    plate: String,
    seed: u64,
    variations: Vec<String>,
    lods: Vec<String>,
    lines: Vec<Line>,
    /// Seeds that were measured.
    seeds: u16,
    sources: String,
}

impl Entry {
    /// The entry of a species: its tree, with full detail as the first LOD, the figures of so many `seeds`, and
    /// where the reference's come from. `script` and `plate` are paths from the page's folder.
    #[must_use]
    pub fn of(
        species: &Species,
        tree: &TreeAsset,
        (lines, seeds, sources): (Vec<Line>, u16, &str),
        [script, plate]: [&str; 2],
    ) -> Self {
        Self {
            name: species.name.clone(),
            latin: species.latin.clone(),
            script: script.to_owned(),
            plate: plate.to_owned(),
            seed: tree.seed,
            variations: species.variations.iter().map(variation).collect(),
            lods: tree.lods.iter().map(triangles).collect(),
            lines,
            seeds,
            sources: sources.to_owned(),
        }
    }

    /// Figures within their range, and figures that have one.
    fn within(&self) -> [usize; 2] {
        let count = |verdict| self.lines.iter().filter(|l| l.verdict == verdict).count();
        let within = count(Verdict::Within);
        [
            within,
            within + count(Verdict::Below) + count(Verdict::Above),
        ]
    }

    fn median(&self, name: &str) -> String {
        let line = self.lines.iter().find(|line| line.name == name);
        line.map_or_else(|| "-".to_owned(), |line| line.figures()[0].clone())
    }

    /// The line of the list that leads the guide.
    fn row(&self) -> String {
        let [within, judged] = self.within();
        format!(
            "| [{}](#{}) | *{}* | {} | {} | {} | {} | {within} of {judged} |",
            self.name,
            self.name.to_lowercase().replace(' ', "-"),
            self.latin,
            self.median("height"),
            self.median("DBH"),
            self.median("crown width"),
            self.lods.first().map_or("-", String::as_str),
        )
    }

    fn write(&self, page: &mut String) -> core::fmt::Result {
        let name = &self.name;
        writeln!(
            page,
            "\n## {name}\n\n*{}*, [{}]({})\n",
            self.latin, self.script, self.script
        )?;
        writeln!(
            page,
            "![{name}: tree, silhouette, leaf card, bark and LODs]({})\n",
            self.plate
        )?;
        writeln!(
            page,
            "Seed {}. Triangles, from full detail: {}.",
            self.seed,
            self.lods.join(", ")
        )?;
        if !self.variations.is_empty() {
            writeln!(page, "Variations: {}.", self.variations.join(", "))?;
        }
        let [within, judged] = self.within();
        writeln!(
            page,
            "\n<details><summary>Measured over {} seeds: {within} of {judged} figures within what real trees have\
             </summary>\n",
            self.seeds
        )?;
        writeln!(page, "| | median | P10 to P90 | real trees | verdict |")?;
        writeln!(page, "|---|---:|---:|---:|---|")?;
        for line in &self.lines {
            let [median, spread, range] = line.figures();
            let verdict = line.verdict.word();
            writeln!(
                page,
                "| {} | {median} | {spread} | {range} | {verdict} |",
                line.title()
            )?;
        }
        if !self.sources.is_empty() {
            writeln!(page, "\nReal trees: {}.", self.sources)?;
        }
        writeln!(page, "\n</details>")
    }
}

fn triangles(lod: &AssetLod) -> String {
    number(lod.triangles.total())
}

fn variation(variation: &Variation) -> String {
    let mut words = Vec::new();
    words.extend(variation.age.map(|age| format!("age {age}")));
    words.extend(variation.habit.map(|habit| match habit {
        Habit::Open => "open-grown".to_owned(),
        Habit::Forest => "forest-grown".to_owned(),
    }));
    words.extend(variation.season.map(|season| format!("season {season}")));
    words.push(format!("seed {}", variation.seed));
    format!("`{}` ({})", variation.name, words.join(", "))
}

/// The whole guide. `command` is what makes it again.
#[must_use]
pub fn page(entries: &[Entry], command: &str) -> String {
    let mut page = format!(
        "# Field guide\n\nMade by `{command}`; to change it, change a species and run that again.\n\n\
         A plate shows the tree at full detail and as a silhouette, a leaf card, the bark, and the chain of LODs that \
         packs hold, all from the same side. Heights and widths are metres, DBH centimetres, medians over seeds. \
         What real trees have, and where that is known from, stands in the details; a verdict is given for each \
         figure, also for those that fail.\n\n\
         | species | | height | DBH | crown | triangles | figures within |\n|---|---|---:|---:|---:|---:|---:|\n"
    );
    for entry in entries {
        page += &entry.row();
        page.push('\n');
    }
    for entry in entries {
        // Writing to a string cannot fail.
        let _ = entry.write(&mut page);
    }
    page
}
