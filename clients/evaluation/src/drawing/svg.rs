//! SVG text of a drawing.

use std::fmt::Write;

use super::mark::{Drawing, EDGE, INK, Mark, Rgb};

impl Drawing {
    /// Returns the drawing as an SVG file.
    #[must_use]
    pub fn svg(&self, title: &str) -> String {
        let [width, height] = self.size_px;
        let title = escaped(title);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             font-family=\"sans-serif\" font-size=\"13\"><title>{title}</title>\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        for mark in &self.marks {
            // Writing into a string cannot fail.
            let _ = write_mark(&mut svg, mark);
        }
        svg.push_str("</svg>\n");
        svg
    }
}

fn write_mark(svg: &mut String, mark: &Mark) -> std::fmt::Result {
    let edge = |rgb: Rgb| {
        let stroke = colour(rgb);
        format!("stroke=\"{stroke}\" stroke-width=\"0.5\" stroke-linejoin=\"round\"")
    };
    match mark {
        Mark::Area {
            corners,
            fill,
            edge: rgb,
        } => {
            let points: Vec<String> = corners
                .iter()
                .map(|[x, y]| format!("{x:.1},{y:.1}"))
                .collect();
            let (points, fill, edge) = (points.join(" "), colour(*fill), edge(*rgb));
            writeln!(svg, "<polygon points=\"{points}\" fill=\"{fill}\" {edge}/>")
        }
        Mark::Disc {
            centre: [x, y],
            radius,
            fill,
        } => {
            let (fill, edge) = (colour(*fill), edge(EDGE));
            writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"{fill}\" {edge}/>"
            )
        }
        Mark::Line {
            ends: [[ax, ay], [bx, by]],
            width,
            colour: rgb,
            is_dashed,
        } => {
            let stroke = colour(*rgb);
            let style = if *is_dashed {
                "stroke-dasharray=\"5 3\""
            } else {
                "stroke-linecap=\"round\""
            };
            writeln!(
                svg,
                "<line x1=\"{ax:.1}\" y1=\"{ay:.1}\" x2=\"{bx:.1}\" y2=\"{by:.1}\" \
                 stroke=\"{stroke}\" stroke-width=\"{width:.1}\" {style}/>"
            )
        }
        Mark::Text {
            start: [x, y],
            text,
        } => {
            let (fill, text) = (colour(INK), escaped(text));
            writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"{fill}\">{text}</text>"
            )
        }
    }
}

fn colour([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
