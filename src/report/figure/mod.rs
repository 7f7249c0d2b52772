//! Figures as SVG, readable on light and on dark ground.

mod counterparts;
mod curves;
mod heat_map;
mod index;
mod overview;
mod panel;

pub use counterparts::{Figure, PaperRuns, counterparts};
pub use index::figures_page;
pub use overview::overview;

use super::marker::MARKER;
use std::fmt::Write;

/// An SVG under construction: coordinates in pixels, y downwards.
#[derive(Clone, Debug)]
struct Drawing {
    body: String,
    /// Height of letters.
    letters: f64,
}

/// Where a text stands relative to its point.
#[derive(Clone, Copy, Debug)]
enum Anchor {
    Start,
    Middle,
    End,
}

impl Drawing {
    /// A blank one with letters of this height.
    fn new(letters: f64) -> Self {
        let body = String::new();
        Self { body, letters }
    }

    /// `class` is one of the style sheet's below.
    fn text(&mut self, x: f64, y: f64, anchor: Anchor, class: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escaped(text);
        let _ = writeln!(
            self.body,
            r#"<text x="{x:.1}" y="{y:.1}" text-anchor="{anchor}" class="{class}">{text}</text>"#
        );
    }

    fn line(&mut self, from: (f64, f64), to: (f64, f64), class: &str) {
        let ((x1, y1), (x2, y2)) = (from, to);
        let _ = writeln!(
            self.body,
            r#"<line x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}" class="{class}"/>"#
        );
    }

    fn path(&mut self, points: impl Iterator<Item = (f64, f64)>, class: &str) {
        let mut d = String::new();
        for (x, y) in points {
            let command = if d.is_empty() { 'M' } else { 'L' };
            let _ = write!(d, "{command}{x:.1} {y:.1}");
        }
        let _ = writeln!(self.body, r#"<path d="{d}" class="{class}"/>"#);
    }

    /// The whole file.
    fn finish(self, width: f64, height: f64, title: &str, description: &str) -> String {
        let (title, description, body) = (escaped(title), escaped(description), self.body);
        let (letters, heading) = (self.letters, self.letters * 1.1);
        format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img">
{MARKER}
<title>{title}</title>
<desc>{description}</desc>
<style>
text{{font-size:{letters}px}}
.h{{font-size:{heading:.1}px;font-weight:600}}{STYLE}</style>
{body}</svg>
"#
        )
    }
}

/// Okabe–Ito blue and vermilion; a little lighter on dark ground.
const STYLE: &str = "
text{font-family:system-ui,-apple-system,'Segoe UI',Helvetica,Arial,sans-serif;fill:#59636e}
.h{fill:#1f2328}.on{font-weight:700;fill:#fff;stroke:#000;stroke-width:2.5px;paint-order:stroke}
.grid{stroke:#d1d9e0}.axis{stroke:#818b98}.wall{fill:#8c959f}.unseen{fill:#eaeef2}
.edge{stroke:#818b98;stroke-width:2}.state{fill:#e6eaef;stroke:#818b98}.start{fill:#0072b2}.goal{fill:#d55e00}.in{fill:#1f2328;font-weight:600}.start+.in,.goal+.in{fill:#fff}
.a{fill:none;stroke:#0072b2;stroke-width:2.5}.b{fill:none;stroke:#d55e00;stroke-width:2.5}
.ab{fill:#0072b2;fill-opacity:.2}.bb{fill:#d55e00;fill-opacity:.2}.at{fill:#0072b2;font-weight:600}.bt{fill:#d55e00;font-weight:600}
@media(prefers-color-scheme:dark){.state{fill:#30363d;stroke:#656c76}.in{fill:#f0f6fc}text{fill:#9198a1}.h{fill:#f0f6fc}.on{fill:#fff}.grid{stroke:#30363d}.axis{stroke:#656c76}
.wall{fill:#59616b}.unseen{fill:#1c2128}.a{stroke:#56b4e9}.ab{fill:#56b4e9}.at{fill:#56b4e9}.b{stroke:#f0803c}.bb{fill:#f0803c}.bt{fill:#f0803c}}
";

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
