//! Files of the page, embedded in the program.

/// Embedded file: URL path, media type, content.
pub(crate) struct Asset {
    pub(crate) path: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) text: &'static str,
}

macro_rules! assets {
    ($($path:literal as $kind:literal from $file:literal;)*) => {
        pub(crate) const ASSETS: &[Asset] = &[$(Asset {
            path: $path,
            kind: $kind,
            text: include_str!(concat!("../page/", $file)),
        }),*];
    };
}

assets! {
    "/" as "text/html; charset=utf-8" from "index.html";
    "/style.css" as "text/css; charset=utf-8" from "style.css";
    "/icon.svg" as "image/svg+xml" from "icon.svg";
    "/main.js" as "text/javascript; charset=utf-8" from "main.js";
    "/source.js" as "text/javascript; charset=utf-8" from "source.js";
    "/canvas.js" as "text/javascript; charset=utf-8" from "canvas.js";
    "/robot.js" as "text/javascript; charset=utf-8" from "robot.js";
    "/hand.js" as "text/javascript; charset=utf-8" from "hand.js";
    "/geometry.js" as "text/javascript; charset=utf-8" from "geometry.js";
    "/fingers.js" as "text/javascript; charset=utf-8" from "fingers.js";
    "/arena.js" as "text/javascript; charset=utf-8" from "arena.js";
    "/traces.js" as "text/javascript; charset=utf-8" from "traces.js";
    "/events.js" as "text/javascript; charset=utf-8" from "events.js";
    "/timing.js" as "text/javascript; charset=utf-8" from "timing.js";
    "/controls.js" as "text/javascript; charset=utf-8" from "controls.js";
}

#[cfg(test)]
mod tests {
    use super::ASSETS;

    #[test]
    fn page_is_small_and_loads_nothing_external() {
        let bytes: usize = ASSETS.iter().map(|asset| asset.text.len()).sum();
        assert!(bytes <= 1_500_000, "{bytes} bytes");
        for asset in ASSETS {
            let foreign = asset.text.split("http").skip(1).find(|rest| {
                let rest = rest.trim_start_matches('s');
                rest.starts_with("://") && !rest.starts_with("://www.w3.org/2000/svg")
            });
            assert!(foreign.is_none(), "{}: {foreign:?}", asset.path);
        }
    }
}
