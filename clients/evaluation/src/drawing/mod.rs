//! Drawings of a robot with its fingertips and objects, without perspective, as SVG or pixels.
//!
//! ```text
//!  Skeleton, joint positions ─▶ bodies ─┐
//!  fingertips, closing axis  ─▶ hands  ─┼─▶ View ─▶ Drawing ─▶ SVG text
//!  objects, plates           ─▶ objects ┘                  └─▶ pixels (red, green, blue)
//! ```
//!
//! * **In:** a robot and its joint positions; for [`SceneView`] also a scene and its ground truth.
//!   **Out:** a [`Drawing`]: flat marks in pixel coordinates, from far to near.
//! * **Invariants:** equal inputs give equal bytes. Both outputs draw the same marks; the pixels
//!   leave out texts, because that needs no font.
//! * **Not included:** files, PNG and PDF (`atas-lab`), windows (`clients/python`).

mod bodies;
mod hands;
mod mark;
mod pixels;
mod robot_views;
mod scene_view;
mod svg;
mod view;

pub use bodies::Links;
pub use mark::Drawing;
pub use robot_views::robot_views;
pub use scene_view::{PictureSizeError, SceneView};
