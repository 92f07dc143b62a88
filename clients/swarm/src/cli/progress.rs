//! Style of progress bars.

use indicatif::ProgressStyle;

pub(super) fn style(unit: &str) -> ProgressStyle {
    let template =
        format!("{{bar:30}} {unit} {{human_pos}} of {{human_len}}  {{msg}}  {{eta}} left");
    ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
