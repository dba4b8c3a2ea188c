//! The time axis that all pictures of a flight share.

use can_twin::wire::time::Time;

use crate::fly::drawing::{Layout, Picture, Range, Scale};

/// Maps a window of virtual time to positions in a picture.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Layout of its picture.
    pub layout: Layout,
    from: Time,
    to: Time,
    /// Scale in seconds.
    scale: Scale,
}

impl Axis {
    /// Makes the axis of `from..to`.
    pub fn new(layout: Layout, from: Time, to: Time) -> Self {
        let range = Range::with_marks(from.as_secs_f64(), to.as_secs_f64(), layout.marks);
        Axis { layout, from, to, scale: Scale::new(range, layout.plot()) }
    }

    /// Returns whether the window contains `at`.
    pub fn shows(&self, at: Time) -> bool {
        (self.from..=self.to).contains(&at)
    }

    /// Returns the position of an instant; those outside the window are at its border.
    pub fn x(&self, at: Time) -> f64 {
        self.scale.place(at.as_secs_f64())
    }

    /// Draws vertical lines from `top` to `bottom` with their seconds below.
    pub fn draw(&self, picture: &mut Picture, top: f64, bottom: f64) {
        let decimals = if self.scale.marks().all(|(second, _)| second.fract() == 0.0) { 0 } else { 1 };
        self.scale.draw_across(picture, (top, bottom), |second| format!("{second:.decimals$} s"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_grow_with_time_and_stay_inside() {
        let axis = Axis::new(Layout::WIDE, Time::from_ms(1000), Time::from_ms(3000));
        let (left, right) = Layout::WIDE.plot();
        assert_eq!(axis.x(Time::from_ms(2000)), (left + right) / 2.0);
        assert_eq!(axis.x(Time::ZERO), left);
        assert!(!axis.shows(Time::from_ms(3001)));
    }
}
