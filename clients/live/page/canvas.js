// Canvas helpers: device resolution with CSS pixel coordinates, and the page's colours.

let colours = null;

/** Returns the page's colours by name; reloaded when the theme changes. */
export function palette() {
  if (!colours) {
    const style = getComputedStyle(document.documentElement);
    const read = (name) => style.getPropertyValue(`--${name}`).trim();
    const names = ["ground", "panel", "ink", "soft", "line", "a", "b", "c", "d", "e", "f", "ok", "warn", "bad"];
    colours = Object.fromEntries(names.map((name) => [name, read(name)]));
  }
  return colours;
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { colours = null; });

/** Clears a canvas; returns its context and size. */
export function begin(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "11px system-ui, sans-serif";
  return { context, width, height };
}

/** Draws an arrow between two points; omitted if shorter than its head. */
export function arrow(context, [x0, y0], [x1, y1], head) {
  const length = Math.hypot(x1 - x0, y1 - y0);
  if (length < head) return;
  const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1 - ux * head, y1 - uy * head);
  context.stroke();
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x1 - ux * head - uy * head * 0.6, y1 - uy * head + ux * head * 0.6);
  context.lineTo(x1 - ux * head + uy * head * 0.6, y1 - uy * head - ux * head * 0.6);
  context.closePath();
  context.fill();
}

/** Formats a number with fixed digits; a dash if it is not finite. */
export function number(value, digits) {
  return Number.isFinite(value) ? value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1") : "–";
}
