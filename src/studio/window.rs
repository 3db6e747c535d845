//! Opens the studio's window.

use super::app::{Begin, Studio};
use crate::viewer::{self, WindowError};

/// Shows the studio until it is closed; `size` is the window's, points.
///
/// # Errors
/// [`WindowError`].
pub fn run(begin: Begin, size: [f32; 2]) -> Result<(), WindowError> {
    viewer::open("Pleach studio", size, move |state, ctx| {
        let wake = {
            let ctx = ctx.clone();
            move || ctx.request_repaint()
        };
        Ok(Box::new(Studio::new(state, begin, wake)?))
    })
}
