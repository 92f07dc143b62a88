//! Place of a mesh file that a URDF names.

use std::path::{Component, Path, PathBuf};

/// Folders above the URDF in which a package is looked up. Design choice: a URDF lies at most four
/// folders below the folder of packages.
const LEVELS: usize = 6;

/// Returns the file that `name` means in a URDF of this folder, if it exists.
///
/// Names: a path relative to the URDF, an absolute path, `file://PATH`, and `package://NAME/PATH`
/// (also `model://`). A package is a folder NAME in one of the folders above the URDF, or such a
/// folder itself.
#[must_use]
pub fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let in_package = ["package://", "model://"]
        .into_iter()
        .find_map(|scheme| name.strip_prefix(scheme));
    let candidates: Vec<PathBuf> = match in_package {
        None => vec![folder.join(name.strip_prefix("file://").unwrap_or(name))],
        Some(path) => {
            let inside: PathBuf = Path::new(path).components().skip(1).collect();
            let above = folder.ancestors().take(LEVELS);
            let package = Path::new(path).components().next()?;
            let named = |above: &&Path| above.components().next_back() == Some(package);
            let own = above.clone().filter(named).map(|it| it.join(&inside));
            above.clone().map(|it| it.join(path)).chain(own).collect()
        }
    };
    let leaves = in_package.is_some_and(|path| {
        let steps = Path::new(path).components();
        steps.clone().any(|step| step == Component::ParentDir)
    });
    candidates
        .into_iter()
        .find(|path| !leaves && path.is_file())
}
