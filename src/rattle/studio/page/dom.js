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
  play: "M8 5v14l11-7z",
  undo: "M9 14 4 9l5-5M4 9h10a6 6 0 0 1 0 12h-3",
  redo: "m15 14 5-5-5-5M20 9H10a6 6 0 0 0 0 12h3",
  moon: "M20 14.5A8.5 8.5 0 1 1 9.5 4a7 7 0 0 0 10.5 10.5z",
  sun: "M12 4V2m0 20v-2m8-8h2M2 12h2m13.7-5.7 1.4-1.4M4.9 19.1l1.4-1.4m0-11.4L4.9 4.9m14.2 14.2-1.4-1.4M12 7.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9z",
};

export const icon = (name) => iconOf(name, SVG);
