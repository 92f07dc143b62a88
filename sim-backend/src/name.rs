//! Hints for misspelt names.

/// Returns ` (did you mean "…"?)` with the nearest known name; empty if none is near.
pub(crate) fn nearest_hint(name: &str, known: &[&str]) -> String {
    let nearest = known
        .iter()
        .map(|known| (edit_distance(known, name), known))
        .min();
    match nearest {
        Some((distance, known)) if distance <= known.len() / 2 => {
            format!(" (did you mean {known:?}?)")
        }
        _ => String::new(),
    }
}

/// Levenshtein distance in characters.
fn edit_distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = core::mem::replace(&mut row[0], i + 1);
        for (j, to) in b.chars().enumerate() {
            let cheapest = (diagonal + usize::from(from != to))
                .min(row[j] + 1)
                .min(row[j + 1] + 1);
            diagonal = core::mem::replace(&mut row[j + 1], cheapest);
        }
    }
    row.last().copied().unwrap_or(0)
}
