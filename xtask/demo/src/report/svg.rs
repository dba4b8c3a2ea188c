//! Just enough SVG: elements with classes, painted by their attributes.

use std::fmt::Write;

use super::paint::{self, attributes};

/// A picture under construction.
pub struct Svg {
    width: f64,
    height: f64,
    title: String,
    body: String,
}

impl Svg {
    /// An empty picture; the title is for those who cannot see it.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        Svg { width, height, title: escape(title), body: String::new() }
    }

    /// A filled rectangle.
    pub fn rect(&mut self, class: &str, x: f64, y: f64, width: f64, height: f64) {
        let _ = writeln!(
            self.body,
            r#"<rect {} x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}"/>"#,
            attributes(class)
        );
    }

    /// A rectangle that tells more when pointed at.
    pub fn rect_with_hint(&mut self, class: &str, [x, y, width, height]: [f64; 4], hint: &str) {
        let hint = escape(hint);
        let _ = writeln!(
            self.body,
            r#"<rect {} x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}"><title>{hint}</title></rect>"#,
            attributes(class)
        );
    }

    /// A straight line.
    pub fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        let ((x1, y1), (x2, y2)) = (from, to);
        let _ = writeln!(
            self.body,
            r#"<line {} x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}"/>"#,
            attributes(class)
        );
    }

    /// Text, its baseline at `(x, y)`; classes `end` and `middle` align it.
    pub fn text(&mut self, class: &str, x: f64, y: f64, text: &str) {
        let text = escape(text);
        let _ = writeln!(self.body, r#"<text {} x="{x:.1}" y="{y:.1}">{text}</text>"#, attributes(class));
    }

    /// Vertical ticks of one height at many places, in tenths of a unit; one element for all.
    pub fn ticks(&mut self, class: &str, tenths: impl IntoIterator<Item = i64>, y: f64, height: f64) {
        let mut path = String::new();
        for x in tenths {
            let _ = write!(path, "M{}.{} {y:.1}v{height:.1}", x / 10, x % 10);
        }
        if !path.is_empty() {
            let _ = writeln!(self.body, r#"<path {} d="{path}"/>"#, attributes(class));
        }
    }

    /// To be placed into a page that has [`paint::dark`].
    pub fn inline(&self) -> String {
        self.render("", "")
    }

    /// To be a file of its own.
    pub fn standalone(&self) -> String {
        self.render(r#" xmlns="http://www.w3.org/2000/svg""#, &format!("<style>{}</style>\n", paint::dark()))
    }

    fn render(&self, namespace: &str, style: &str) -> String {
        let Svg { width, height, title, body } = self;
        format!(
            "<svg{namespace} class=\"chart\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             role=\"img\" {}>\n<title>{title}</title>\n{style}{body}</svg>\n",
            paint::FONT
        )
    }
}

/// Text that is safe inside HTML and SVG.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_out() {
        let mut svg = Svg::new(10.0, 10.0, "a < b");
        svg.text("label", 1.0, 2.0, "</text><script>");
        let drawn = svg.inline();
        assert!(drawn.contains("&lt;/text&gt;&lt;script&gt;"), "{drawn}");
        assert!(drawn.contains("<title>a &lt; b</title>"), "{drawn}");
    }
}
