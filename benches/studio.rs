//! What an author waits for in the studio, on whatever adapter there is: the picture after an edit, a frame while a
//! handle moves, captures and shadows, and the whole tree with its LODs.

use divan::Bencher;
use eframe::egui::vec2;
use eframe::egui_wgpu::RendererOptions;
use egui_kittest::Harness;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use pleach::gpu::Gpu;
use pleach::studio::document::{Document, Edit};
use pleach::studio::{Begin, Studio, templates};
use pleach::viewer;
use std::time::{Duration, Instant};

fn main() {
    match Gpu::headless() {
        Ok(gpu) => println!("adapter: {}", gpu.describe()),
        Err(error) => {
            println!("no adapter, nothing to measure: {error}");
            return;
        }
    }
    divan::main();
}

/// The olive has 104,000 triangles at full detail; the oak has more than three times as many.
const SPECIES: [&str; 2] = ["Olive", "English oak"];

/// The studio on a species, its tree grown and shown.
struct Desk {
    window: Harness<'static, Studio>,
    begun: Instant,
    lengths: std::iter::Cycle<std::array::IntoIter<&'static str, 3>>,
}

impl Desk {
    fn new(name: &str) -> Self {
        let (_, text) = templates::ALL
            .iter()
            .find(|(title, _)| *title == name)
            .expect("a template");
        let state = create_render_state(viewer::setup(), RendererOptions::PREDICTABLE);
        let begin = Begin::new(Document::new((*text).to_owned()));
        let studio = Studio::new(&state, begin, || ()).expect("the window begins");
        let window = Harness::builder()
            .with_size(vec2(1280.0, 720.0))
            .with_context_setup(viewer::panel::style)
            .renderer(WgpuTestRenderer::from_render_state(state))
            .build_ui_state(|ui, studio: &mut Studio| studio.ui(ui), studio);
        let mut desk = Self {
            window,
            begun: Instant::now(),
            lengths: ["0.9", "1", "1.1"].into_iter().cycle(),
        };
        desk.until(|studio| studio.subject().is_some());
        desk
    }

    /// Makes the trunk's children longer or shorter, as a hand does that drags a slider.
    fn drag(&mut self) {
        let value = self.lengths.next().expect("they go round").to_owned();
        let path = "levels.1.scale".to_owned();
        let studio = self.window.state_mut();
        studio
            .apply("Set scale", Some("drag"), Edit::Set { path, value })
            .expect("levels have a scale");
    }

    /// A frame of the window, whose clock is the wall's: what it does when a hand rests depends on that.
    fn step(&mut self) {
        self.window.input_mut().time = Some(self.begun.elapsed().as_secs_f64());
        self.window.step();
    }

    fn until(&mut self, so: impl Fn(&Studio) -> bool) {
        while !so(self.window.state()) {
            self.step();
            std::thread::sleep(Duration::from_micros(200));
        }
    }
}

/// From an edit to the picture of the tree that it makes.
#[divan::bench(args = SPECIES, sample_count = 30)]
fn edit_to_picture(bencher: Bencher, name: &str) {
    let mut desk = Desk::new(name);
    bencher.bench_local(|| {
        desk.drag();
        desk.until(Studio::is_up_to_date);
    });
}

/// One frame of the whole window, its widgets painted, while a hand drags: ten a second are wanted.
#[divan::bench(args = SPECIES, sample_count = 60)]
fn frame_while_a_hand_drags(bencher: Bencher, name: &str) {
    let mut desk = Desk::new(name);
    bencher.bench_local(|| {
        desk.drag();
        desk.step();
        desk.window.render().expect("a picture")
    });
}

/// From an edit to the captures and shadows of the tree that it makes.
#[divan::bench(args = SPECIES, sample_count = 10)]
fn edit_to_captures_and_shadows(bencher: Bencher, name: &str) {
    let mut desk = Desk::new(name);
    bencher.bench_local(|| {
        desk.drag();
        desk.until(Studio::is_furnished);
    });
}

/// From an edit to the tree with all its LODs, captures and shadows, the quarter of a second that a hand must rest
/// included.
#[divan::bench(args = SPECIES, sample_count = 5)]
fn edit_to_whole_tree(bencher: Bencher, name: &str) {
    let mut desk = Desk::new(name);
    bencher.bench_local(|| {
        desk.drag();
        desk.until(|studio| studio.subject().is_some());
    });
}
