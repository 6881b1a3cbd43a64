// Elements of the page: made in one call, with icons as SVG.

// An element with attributes (a function under "onclick" listens) and children: texts, elements or lists of them.
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value === true) element.setAttribute(key, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(key, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

const PATHS = {
  play: "M7 4.5v15l12.5-7.5z",
  pause: "M6.5 4.5h4v15h-4zM13.5 4.5h4v15h-4z",
  first: "M6 5h2.4v14H6zM19 5v14L9 12z",
  loop: "M7 7h9v-3l4.5 4.2L16 12.4V9.4H8.4v4H6V8a1 1 0 0 1 1-1zM17 17H8v3l-4.5-4.2L8 11.6v3h7.6v-4H18V16a1 1 0 0 1-1 1z",
  moon: "M20 14.5A8.5 8.5 0 0 1 9.5 4a8.5 8.5 0 1 0 10.5 10.5z",
  sun: "M12 7a5 5 0 1 0 0 10 5 5 0 0 0 0-10zM11 1h2v4h-2zM11 19h2v4h-2zM1 11h4v2H1zM19 11h4v2h-4zM4.2 5.6l1.4-1.4 2.8 2.8L7 8.4zM15.6 17l1.4-1.4 2.8 2.8-1.4 1.4zM4.2 18.4 7 15.6 8.4 17l-2.8 2.8zM15.6 7l2.8-2.8 1.4 1.4L17 8.4z",
  fit: "M4 9V4h5v2H6v3zM15 4h5v5h-2V6h-3zM4 15h2v3h3v2H4zM18 15h2v5h-5v-2h3z",
  search: "M10.5 4a6.5 6.5 0 1 0 4 11.6l4.7 4.7 1.4-1.4-4.7-4.7A6.5 6.5 0 0 0 10.5 4zm0 2a4.5 4.5 0 1 1 0 9 4.5 4.5 0 0 1 0-9z",
  close: "M6.4 5 12 10.6 17.6 5 19 6.4 13.4 12l5.6 5.6-1.4 1.4-5.6-5.6L6.4 19 5 17.6l5.6-5.6L5 6.4z",
  wide: "M3 5h18v14H3zm2 2v10h14V7z",
};

export function icon(name, paths = PATHS) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", paths[name]);
  svg.append(path);
  return svg;
}

// A button with an icon or a text, its name for screen readers and as a hint.
export function button(content, label, onclick, attributes = {}) {
  return make("button", { type: "button", "aria-label": label, title: label, onclick, ...attributes },
    content in PATHS ? icon(content) : content);
}

// A button that is on or off.
export function toggle(text, label, on, change) {
  const one = make("button", { type: "button", class: "chip", "aria-pressed": String(on), title: label, onclick: () => {
    const now = one.getAttribute("aria-pressed") !== "true";
    one.setAttribute("aria-pressed", String(now));
    change(now);
  } }, text);
  one.turn = (now) => one.setAttribute("aria-pressed", String(now));
  return one;
}

// Write a text only if it differs: a page that does not change costs nothing.
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
