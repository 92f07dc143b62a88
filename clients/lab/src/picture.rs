//! Figure files: SVG as drawn; PNG and PDF are converted from it.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use atas_process::file_name::suffix;
use resvg::{tiny_skia, usvg};
use tracing::subscriber::{NoSubscriber, with_default};
use usvg::fontdb;

const SANS_SERIF: [&str; 5] = [
    "DejaVu Sans",
    "Liberation Sans",
    "Noto Sans",
    "Arial",
    "Helvetica",
];
/// PDF resolution: figures are drawn at twice their reading size, so 144 px are 72 pt.
const PDF_DPI: f32 = 144.0;

pub(crate) fn write(path: &Path, svg: &str) -> anyhow::Result<()> {
    // Converters warn of lines without length, which have no visible effect.
    let bytes = with_default(NoSubscriber::default(), || match suffix(path).as_str() {
        "png" => png(svg),
        "pdf" => pdf(svg),
        _ => Ok(svg.as_bytes().to_vec()),
    })?;
    std::fs::write(path, bytes).with_context(|| {
        let path = path.display();
        format!("could not write {path}; name a file in a writable folder")
    })
}

fn png(svg: &str) -> anyhow::Result<Vec<u8>> {
    let tree = tree(svg)?;
    let size = tree.size().to_int_size();
    let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height())
        .context("could not make a picture: the figure has no size; report this")?;
    resvg::render(
        &tree,
        tiny_skia::Transform::identity(),
        &mut pixels.as_mut(),
    );
    pixels.encode_png().context("could not write as PNG")
}

fn pdf(svg: &str) -> anyhow::Result<Vec<u8>> {
    let page = svg2pdf::PageOptions { dpi: PDF_DPI };
    svg2pdf::to_pdf(&tree(svg)?, svg2pdf::ConversionOptions::default(), page)
        .map_err(|error| anyhow::anyhow!("could not write as PDF: {error}"))
}

fn tree(svg: &str) -> anyhow::Result<usvg::Tree> {
    let mut fonts = fontdb::Database::new();
    fonts.load_system_fonts();
    let has = |family: &str| {
        let named = [fontdb::Family::Name(family)];
        let query = fontdb::Query {
            families: &named,
            ..fontdb::Query::default()
        };
        fonts.query(&query).is_some()
    };
    let first = SANS_SERIF.into_iter().find(|family| has(family));
    let family = first.with_context(|| {
        let known = SANS_SERIF.join(", ");
        format!(
            "could not draw the figure's text: this machine has none of the typefaces {known}; \
             install one (Debian: fonts-dejavu-core), or write SVG"
        )
    })?;
    fonts.set_sans_serif_family(family);
    let options = usvg::Options {
        fontdb: Arc::new(fonts),
        ..usvg::Options::default()
    };
    usvg::Tree::from_str(svg, &options).context("could not parse the drawn figure; report this")
}
