//! The time axis that all pictures of a report share.

use can_wire::time::Time;

use super::svg::Svg;

/// How wide a picture is, in SVG units, and how many words there is room for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Width of the picture.
    pub width: f64,
    /// Where the plot begins: left of it stand the names of the rows.
    pub left: f64,
    /// Room right of the plot.
    margin: f64,
    /// Marks of the axis, at most about so many.
    marks: f64,
    /// Short names instead of long ones.
    pub brief: bool,
}

impl Layout {
    /// For screens and paper.
    pub const WIDE: Layout = Layout { width: 1160.0, left: 150.0, margin: 20.0, marks: 10.0, brief: false };

    /// For a phone: as wide as a page of 400 px leaves it, so that letters keep their size.
    pub const NARROW: Layout = Layout { width: 348.0, left: 90.0, margin: 16.0, marks: 5.0, brief: true };

    /// Left and right end of the plot.
    pub fn plot(&self) -> (f64, f64) {
        (self.left, self.width - self.margin)
    }

    /// Whether a text that begins at `x` ends inside the picture, by the width of an average letter.
    pub fn has_room(&self, x: f64, text: &str) -> bool {
        x + text_width(text) <= self.width
    }
}

/// About the width of bold letters of the usual size.
pub fn text_width(text: &str) -> f64 {
    7.4 * text.chars().count() as f64
}

/// Maps a window of virtual time to places in a picture.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    layout: Layout,
    from: f64,
    to: f64,
}

impl Axis {
    /// For `from..to`.
    pub fn new(layout: Layout, from: Time, to: Time) -> Self {
        Axis { layout, from: from.as_secs_f64(), to: to.as_secs_f64() }
    }

    /// Of its picture.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Whether the window contains `at`.
    pub fn shows(&self, at: Time) -> bool {
        (self.from..=self.to).contains(&at.as_secs_f64())
    }

    /// The place of an instant; those outside the window stand at its border.
    pub fn x(&self, at: Time) -> f64 {
        self.place(at.as_secs_f64().clamp(self.from, self.to))
    }

    fn place(&self, second: f64) -> f64 {
        let (left, right) = self.ends();
        left + (second - self.from) / (self.to - self.from) * (right - left)
    }

    /// Left and right end of the plot.
    pub fn ends(&self) -> (f64, f64) {
        self.layout.plot()
    }

    /// Vertical lines from `top` to `bottom` with their seconds below.
    pub fn draw(&self, svg: &mut Svg, top: f64, bottom: f64) {
        let step = step(self.to - self.from, self.layout.marks);
        let decimals = if step < 1.0 { 1 } else { 0 };
        let first = (self.from / step).ceil() as i64;
        let last = (self.to / step + 1e-9).floor() as i64;
        for count in first..=last {
            let second = count as f64 * step;
            let x = self.place(second);
            svg.line("grid", (x, top), (x, bottom));
            svg.text("soft middle", x, bottom + 16.0, &format!("{second:.decimals$} s"));
        }
    }
}

/// A round distance between marks, at most about `marks` of them.
fn step(span: f64, marks: f64) -> f64 {
    let rough = span / marks;
    let magnitude = 10f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|factor| factor * magnitude)
        .into_iter()
        .find(|step| *step >= rough * 0.999)
        .unwrap_or(rough)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stand_at_round_seconds() {
        assert_eq!(step(40.0, 10.0), 5.0);
        assert_eq!(step(1.0, 10.0), 0.1);
        assert_eq!(step(3600.0, 10.0), 500.0);
        assert_eq!(step(40.0, 5.0), 10.0);
    }

    #[test]
    fn places_grow_with_time_and_stay_inside() {
        let axis = Axis::new(Layout::WIDE, Time::from_ms(1000), Time::from_ms(3000));
        let (left, right) = axis.ends();
        assert_eq!(axis.x(Time::from_ms(2000)), (left + right) / 2.0);
        assert_eq!(axis.x(Time::ZERO), left);
        assert!(!axis.shows(Time::from_ms(3001)));
    }
}
