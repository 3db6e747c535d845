//! Places of shots on a sheet of samples: in rows, as they come.

/// Width of a sheet, samples; wider where one shot is.
const WIDTH: u32 = 4096;

/// Rows of shots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    /// Largest edge that the adapter allows.
    limit: u32,
    /// Samples across what is placed.
    width: u32,
    /// End of the row that is being filled, and its top and height.
    x: u32,
    y: u32,
    row: u32,
}

impl Sheet {
    /// Nothing placed, on an adapter that allows so many samples along an edge.
    pub(super) fn new(limit: u32) -> Self {
        Self {
            limit,
            width: 0,
            x: 0,
            y: 0,
            row: 0,
        }
    }

    /// Samples across and down, at least one.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.width.max(1), (self.y + self.row).max(1)]
    }

    /// Samples, air between shots included.
    pub(super) fn samples(&self) -> u64 {
        let [across, down] = self.size();
        u64::from(across) * u64::from(down)
    }

    /// Where a shot of a size fits, or `None` if the sheet would be larger than the adapter allows.
    pub(super) fn place(&mut self, [width, height]: [u32; 2]) -> Option<[u32; 2]> {
        let widest = WIDTH.max(width).min(self.limit);
        let mut next = *self;
        if next.x > 0 && next.x + width > widest {
            (next.x, next.y, next.row) = (0, next.y + next.row, 0);
        }
        let at = [next.x, next.y];
        next.x += width;
        next.row = next.row.max(height);
        next.width = next.width.max(next.x);
        let [across, down] = next.size();
        if across > self.limit || down > self.limit {
            return None;
        }
        *self = next;
        Some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shots_lie_apart_inside_the_sheet() {
        let mut sheet = Sheet::new(8192);
        let sizes: Vec<[u32; 2]> = (1..60)
            .map(|i| [i * 37 % 700 + 1, i * 91 % 600 + 1])
            .collect();
        let places: Vec<[u32; 2]> = sizes.iter().filter_map(|&s| sheet.place(s)).collect();
        assert_eq!(places.len(), sizes.len(), "all fit");
        let [width, height] = sheet.size();
        for (i, (a, size)) in places.iter().zip(&sizes).enumerate() {
            assert!(a[0] + size[0] <= width && a[1] + size[1] <= height);
            for (b, other) in places.iter().zip(&sizes).take(i) {
                let apart = |k: usize| a[k] + size[k] <= b[k] || b[k] + other[k] <= a[k];
                assert!(apart(0) || apart(1), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_shot_wider_than_usual_widens_the_sheet_and_one_beyond_the_limit_has_none() {
        assert_eq!(Sheet::new(16_384).place([9000, 9000]), Some([0, 0]));
        assert_eq!(Sheet::new(8192).place([9000, 10]), None);
        let mut sheet = Sheet::new(16_384);
        assert!(sheet.place([9000, 9000]).is_some());
        assert_eq!(sheet.place([10, 10]), Some([0, 9000]), "below it");
        assert_eq!(sheet.samples(), 9000 * 9010);
        assert_eq!(sheet.place([10, 8000]), None, "a full sheet");
    }
}
