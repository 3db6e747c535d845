//! Plots of a few lines and marks as inline SVG; colours come from the page's style.

use super::html::escape;

/// Size of the drawing; the page scales it to its column.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 380.0;

/// Where the axes stand.
const LEFT: f64 = 62.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 322.0;

/// Room on the right: for the last tick, and for the names of lines if there are any.
const MARGIN: f64 = 16.0;
const NAMES_MARGIN: f64 = 76.0;

/// Room for the words beside a limit.
const LIMIT_NAME: f64 = 130.0;

/// Least distance between the names of two lines.
const NAME_GAP: f64 = 16.0;

/// An axis; `ticks` are values with their words.
pub(super) struct Axis {
    /// What runs along it, with the unit.
    pub title: &'static str,
    /// Logarithmic: the range must be above zero.
    pub log: bool,
    /// Values at its two ends.
    pub range: [f64; 2],
    /// Where numbers stand.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// A logarithmic axis around some positive values, with ticks at 1, 2 and 5 where there is room.
    pub(super) fn log_of(title: &'static str, values: impl Iterator<Item = f64>) -> Option<Self> {
        let [low, high] = range(values.filter(|v| *v > 0.0))?;
        let range = [low / 1.25, high * 1.25];
        let decades = libm::log10(range[1] / range[0]);
        let steps: &[f64] = if decades <= 3.2 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        let mut ticks = Vec::new();
        let mut decade = libm::pow(10.0, libm::floor(libm::log10(range[0])));
        while decade <= range[1] {
            let values = steps.iter().map(|step| step * decade);
            ticks.extend(
                values
                    .filter(|v| (range[0]..=range[1]).contains(v))
                    .map(|v| (v, short(v))),
            );
            decade *= 10.0;
        }
        if ticks.len() < 2 {
            // Too narrow for round numbers: the values themselves.
            ticks = vec![(low, format!("{low:.0}"))];
            if high > low * 1.1 {
                ticks.push((high, format!("{high:.0}")));
            }
        }
        Some(Self {
            title,
            log: true,
            range,
            ticks,
        })
    }

    /// A linear axis around some values and `with`, its ends on ticks; `words` writes a tick.
    pub(super) fn linear_of(
        title: &'static str,
        values: impl Iterator<Item = f64>,
        with: &[f64],
        words: impl Fn(f64) -> String,
    ) -> Option<Self> {
        let [low, high] = range(values)?;
        let low = with.iter().copied().fold(low, f64::min);
        let high = with.iter().copied().fold(high, f64::max);
        let span = (high - low).max(1e-3);
        let power = libm::pow(10.0, libm::floor(libm::log10(span / 5.0)));
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|s| s * power)
            .into_iter()
            .find(|step| span / step <= 6.0)
            .unwrap_or(span);
        // A hair of slack, so that an end on a tick stays there despite rounding.
        let first = libm::floor(low / step + 1e-6);
        let last = libm::ceil(high / step - 1e-6).max(first + 1.0);
        let mut ticks = Vec::new();
        let mut at = first;
        while at <= last {
            ticks.push((at * step, words(at * step)));
            at += 1.0;
        }
        Some(Self {
            title,
            log: false,
            range: [first * step, last * step],
            ticks,
        })
    }

    /// Place of a value, 0 at the axis' start and 1 at its end.
    fn part(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        if self.log {
            libm::log10(value / low) / libm::log10(high / low)
        } else {
            (value - low) / (high - low)
        }
    }
}

/// Shape of the points of a series.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// Filled disc.
    Disc,
    /// Empty square.
    Square,
    /// Empty triangle.
    Triangle,
    /// Empty diamond.
    Diamond,
    /// Cross.
    Cross,
}

/// Points that belong together.
pub(super) struct Series {
    /// Name, as plain text.
    pub label: String,
    /// Style class: the colour.
    pub class: String,
    /// Shape of the points.
    pub mark: Mark,
    /// True to write the name at the line's right end.
    pub named: bool,
    /// Value along x, along y, and what the point says when pointed at.
    pub points: Vec<(f64, f64, String)>,
}

/// A level line across the plot.
pub(super) struct Limit {
    /// Value along y.
    pub at: f64,
    /// Words beside it.
    pub words: String,
}

/// A whole plot.
pub(super) struct Plot {
    /// For those who do not see it.
    pub alt: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Lines, drawn in this order.
    pub series: Vec<Series>,
    /// Level line.
    pub limit: Option<Limit>,
}

impl Plot {
    /// The drawing.
    pub(super) fn svg(&self) -> String {
        let mut svg = format!(
            "<svg class=\"plot\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">\n",
            escape(&self.alt)
        );
        self.axes(&mut svg);
        if let Some(limit) = &self.limit {
            let y = self.y_at(limit.at);
            let (left, right) = (LEFT, self.right());
            let is_at_end = self.hides(left..left + LIMIT_NAME, y);
            svg.push_str(&format!(
                "<line class=\"limit\" x1=\"{left:.1}\" y1=\"{y:.1}\" x2=\"{right:.1}\" y2=\"{y:.1}\"></line>\
                 <text class=\"limit-name{}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
                if is_at_end { " end" } else { "" },
                if is_at_end { right - 6.0 } else { left + 6.0 },
                y - 5.0,
                escape(&limit.words)
            ));
        }
        for series in &self.series {
            self.line(&mut svg, series);
        }
        self.names(&mut svg);
        svg.push_str("</svg>\n");
        svg
    }

    /// True if a point stands where words above the height `y` would.
    fn hides(&self, columns: core::ops::Range<f64>, y: f64) -> bool {
        let mut points = self.series.iter().flat_map(|s| &s.points);
        points.any(|(x, value, _)| {
            columns.contains(&self.x_at(*x)) && (y - 24.0..y + 8.0).contains(&self.y_at(*value))
        })
    }

    fn right(&self) -> f64 {
        let has_names = self.series.iter().any(|s| s.named);
        WIDTH - if has_names { NAMES_MARGIN } else { MARGIN }
    }

    fn x_at(&self, value: f64) -> f64 {
        LEFT + (self.right() - LEFT) * self.x.part(value)
    }

    fn y_at(&self, value: f64) -> f64 {
        BOTTOM - (BOTTOM - TOP) * self.y.part(value)
    }

    fn axes(&self, svg: &mut String) {
        let (left, top, right, bottom) = (LEFT, TOP, self.right(), BOTTOM);
        for (value, words) in &self.y.ticks {
            let y = self.y_at(*value);
            svg.push_str(&format!(
                "<line class=\"grid\" x1=\"{left:.1}\" y1=\"{y:.1}\" x2=\"{right:.1}\" y2=\"{y:.1}\"></line>\
                 <text class=\"tick y\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
                left - 9.0,
                y + 4.0,
                escape(words)
            ));
        }
        for (value, words) in &self.x.ticks {
            let x = self.x_at(*value);
            svg.push_str(&format!(
                "<line class=\"axis\" x1=\"{x:.1}\" y1=\"{bottom:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\"></line>\
                 <text class=\"tick x\" x=\"{x:.1}\" y=\"{:.1}\">{}</text>\n",
                bottom + 5.0,
                bottom + 20.0,
                escape(words)
            ));
        }
        let (middle_x, middle_y) = ((left + right) / 2.0, (top + bottom) / 2.0);
        svg.push_str(&format!(
            "<line class=\"axis\" x1=\"{left:.1}\" y1=\"{bottom:.1}\" x2=\"{right:.1}\" y2=\"{bottom:.1}\"></line>\
             <text class=\"title\" x=\"{middle_x:.1}\" y=\"{:.1}\">{}</text>\
             <text class=\"title\" transform=\"translate(14 {middle_y:.1}) rotate(-90)\">{}</text>\n",
            HEIGHT - 14.0,
            self.x.title,
            self.y.title
        ));
    }

    fn line(&self, svg: &mut String, series: &Series) {
        let at: Vec<[f64; 2]> = series
            .points
            .iter()
            .map(|(x, y, _)| [self.x_at(*x), self.y_at(*y)])
            .collect();
        svg.push_str(&format!("<g class=\"{}\">", series.class));
        if at.len() > 1 {
            let corners: Vec<String> = at.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
            svg.push_str(&format!(
                "<polyline points=\"{}\"></polyline>",
                corners.join(" ")
            ));
        }
        for ([x, y], (_, _, words)) in at.iter().zip(&series.points) {
            svg.push_str(&format!(
                "<g class=\"mark\">{}<title>{}</title></g>",
                shape(series.mark, *x, *y),
                escape(words)
            ));
        }
        svg.push_str("</g>\n");
    }

    /// Names at the right ends of the lines, moved apart where they would touch.
    fn names(&self, svg: &mut String) {
        let mut names: Vec<(f64, f64, &Series)> = self
            .series
            .iter()
            .filter(|s| s.named)
            .filter_map(|s| {
                let (x, y, _) = s.points.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
                Some((self.y_at(*y), self.x_at(*x), s))
            })
            .collect();
        names.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Down from the top, then up from the bottom: no name leaves the frame while there is room.
        let mut least = TOP;
        for name in &mut names {
            name.0 = name.0.max(least);
            least = name.0 + NAME_GAP;
        }
        let mut most = BOTTOM;
        for name in names.iter_mut().rev() {
            name.0 = name.0.min(most);
            most = name.0 - NAME_GAP;
        }
        for (y, x, series) in names {
            svg.push_str(&format!(
                "<text class=\"name {}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
                series.class,
                x + 11.0,
                y + 4.0,
                escape(&series.label)
            ));
        }
    }
}

/// The marks and names of some series as a list, for plots whose lines bear no names.
pub(super) fn legend(series: &[Series]) -> String {
    let items: String = series
        .iter()
        .map(|s| {
            format!(
                "<li><svg class=\"key {}\" viewBox=\"0 0 30 14\" aria-hidden=\"true\">\
                 <line x1=\"1\" y1=\"7\" x2=\"29\" y2=\"7\"></line><g class=\"mark\">{}</g></svg>{}</li>",
                s.class,
                shape(s.mark, 15.0, 7.0),
                escape(&s.label)
            )
        })
        .collect();
    format!("<ul class=\"legend\">{items}</ul>\n")
}

fn shape(mark: Mark, x: f64, y: f64) -> String {
    let path = |steps: &str| format!("<path d=\"M{x:.1} {y:.1}{steps}\"></path>");
    match mark {
        Mark::Disc => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"></circle>"),
        Mark::Square => path("m-4.5 -4.5h9v9h-9z"),
        Mark::Triangle => path("m0 -5.5l5.5 9.5h-11z"),
        Mark::Diamond => path("m0 -6l6 6l-6 6l-6 -6z"),
        Mark::Cross => path("m-4.5 -4.5l9 9m0 -9l-9 9"),
    }
}

/// Least and largest of some values; none if there are none that are numbers.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values
        .filter(|v| v.is_finite())
        .fold(None, |range, v| match range {
            None => Some([v, v]),
            Some([low, high]) => Some([low.min(v), high.max(v)]),
        })
}

/// `2k` for 2000.
pub(super) fn short(value: f64) -> String {
    if value >= 1e9 {
        format!("{:.0}G", value / 1e9)
    } else if value >= 1e6 {
        format!("{:.0}M", value / 1e6)
    } else if value >= 1e3 {
        format!("{:.0}k", value / 1e3)
    } else {
        format!("{value:.0}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_the_ends_of_a_linear_axis_are_ticks() {
        let percent = |v: f64| format!("{:.0}%", v * 100.0);
        let axis = Axis::linear_of("y", [0.02, 0.17].into_iter(), &[0.0], percent).unwrap();
        let words: Vec<&str> = axis.ticks.iter().map(|t| t.1.as_str()).collect();
        assert_eq!(words, ["0%", "5%", "10%", "15%", "20%"]);
        assert_eq!(axis.part(axis.ticks[0].0), 0.0);
        assert_eq!(axis.part(axis.ticks[4].0), 1.0);
    }

    #[test]
    fn a_log_axis_spaces_decades_evenly() {
        let axis = Axis::log_of("x", [200.0, 50_000.0].into_iter()).unwrap();
        let words: Vec<&str> = axis.ticks.iter().map(|t| t.1.as_str()).collect();
        assert_eq!(words, ["200", "500", "1k", "2k", "5k", "10k", "20k", "50k"]);
        let (first, second) = (
            axis.part(2_000.0) - axis.part(200.0),
            axis.part(20_000.0) - axis.part(2_000.0),
        );
        assert!((first - second).abs() < 1e-12);
        let wide = Axis::log_of("x", [4.0, 7e6].into_iter()).unwrap();
        assert_eq!(wide.ticks.len(), 6, "decades only");
        let narrow = Axis::log_of("x", [2_900.0, 3_100.0].into_iter()).unwrap();
        assert_eq!(narrow.ticks, [(2_900.0, "2900".to_owned())]);
    }

    #[test]
    fn axes_of_nothing_or_of_one_value_do_not_break() {
        assert!(Axis::log_of("x", [0.0, f64::NAN].into_iter()).is_none());
        assert!(Axis::linear_of("y", [f64::INFINITY].into_iter(), &[], short).is_none());
        let axis = Axis::linear_of("y", [1.0].into_iter(), &[], |v| format!("{v:.3}")).unwrap();
        assert!(axis.range[1] > axis.range[0]);
        assert!((0.0..=1.0).contains(&axis.part(1.0)));
        assert!(axis.ticks.len() < 10);
    }

    #[test]
    fn names_of_lines_never_touch() {
        let series = |label: &str, y: f64| Series {
            label: label.to_owned(),
            class: "s0".to_owned(),
            mark: Mark::Disc,
            named: true,
            points: vec![(10.0, y, String::new())],
        };
        let plot = Plot {
            alt: String::new(),
            x: Axis::log_of("x", [10.0, 100.0].into_iter()).unwrap(),
            y: Axis::linear_of("y", [0.0, 1.0].into_iter(), &[], short).unwrap(),
            series: vec![series("a", 0.0), series("b", 0.0), series("c", 0.01)],
            limit: None,
        };
        let svg = plot.svg();
        let mut heights: Vec<f64> = svg
            .lines()
            .filter(|l| l.contains("class=\"name"))
            .map(|l| {
                let rest = l.split(" y=\"").nth(1).unwrap();
                rest.split('"').next().unwrap().parse().unwrap()
            })
            .collect();
        heights.sort_by(f64::total_cmp);
        assert_eq!(heights.len(), 3);
        assert!(heights.windows(2).all(|w| w[1] - w[0] >= NAME_GAP - 0.11));
        assert!(heights[2] <= BOTTOM + 5.0, "inside the frame");
    }
}
