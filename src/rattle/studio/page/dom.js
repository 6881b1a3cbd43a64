// Elements in one call, as in the viewer: h("button", { class: "quiet", onclick: f }, "Save").

import { icon as iconOf } from "./viewer.js";

export { make as h } from "./viewer.js";

export function replace(el, ...children) {
  el.replaceChildren(...children.flat().filter((one) => one != null));
}

// What is kept between visits; a browser may refuse to keep anything.
export function kept(key, value) {
  try {
    if (value === undefined) return localStorage.getItem(`rattle-studio-${key}`);
    localStorage.setItem(`rattle-studio-${key}`, value);
  } catch { /* the page works without */ }
  return null;
}

const SVG = {
  Select: "M6 3l12 9-6 1 4 7-3 1-3-7-4 4z",
  Ground: "M12 4l5 8H7zM4 12h16M6 12l-3 4m8-4-3 4m8-4-3 4m8-4-3 4",
  Bar: "M6 18 18 6M4.5 19.5a2 2 0 1 0 3-3 2 2 0 0 0-3 3zM16.5 7.5a2 2 0 1 0 3-3 2 2 0 0 0-3 3z",
  Plate: "M5 18 12 5l8 9z",
  Pin: "M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8zM3 12h5m8 0h5",
  Slider: "M3 17h18M7 9h10v6H7zM12 12h.01",
  Slot: "M7 8h10a4 4 0 0 1 0 8H7a4 4 0 0 1 0-8zM8 12h.01",
  Gear: "M8 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8zM17 6.5a5.5 5.5 0 1 0 0 11 5.5 5.5 0 0 0 0-11z",
  Motor: "M19 12a7 7 0 1 1-3-5.7M19 3v4.5h-4.5M12 12h.01",
  Spring: "M3 12h3l1.5-5 3 10 3-10 3 10L18 12h3",
  Force: "M4 20 19 5M11 5h8v8",
  Measure: "M3 16 16 3l5 5L8 21zM7 12l2 2m1-5 3 3m0-6 2 2",
  Picture: "M4 5h16v14H4zM4 16l5-5 4 4 3-3 4 4M15.5 9h.01",
  fit: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",
  play: "M8 5v14l11-7z",
  undo: "M9 14 4 9l5-5M4 9h10a6 6 0 0 1 0 12h-3",
  redo: "m15 14 5-5-5-5M20 9H10a6 6 0 0 0 0 12h3",
  moon: "M20 14.5A8.5 8.5 0 1 1 9.5 4a7 7 0 0 0 10.5 10.5z",
  sun: "M12 4V2m0 20v-2m8-8h2M2 12h2m13.7-5.7 1.4-1.4M4.9 19.1l1.4-1.4m0-11.4L4.9 4.9m14.2 14.2-1.4-1.4M12 7.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9z",
};

export const icon = (name) => iconOf(name, SVG);
