// Colours: those of the Python plots (rattle/plots/curves.py, rattle/plots/scene.py), on light and on dark paper.

import { PALETTE } from "./palette.js";

const SHADES = PALETTE.named, CURVES = PALETTE.curves;
const LIGHT = {
  dark: false, paper: "#FFFFFF", ink: "#24292F", grey: "#6E7781", lines: "#DFE3E8", faint: "#EEF1F4", bore: "#F2F4F7",
  shade: "#ECEEF1", red: SHADES.red, metal: SHADES.metal, steel: SHADES.steel, black: SHADES.black,
};
const DARK = {
  dark: true, paper: "#12161C", ink: "#E6EAF0", grey: "#98A2AF", lines: "#2E3640", faint: "#1E242C", bore: "#1B2129",
  shade: "#1D232B", red: "#FF8A3D", metal: "#8C98A6", steel: "#3A444F", black: "#D5DBE3",
};
const CIVIDIS = [
  "#00224E", "#002E6C", "#1E3A6F", "#35456C", "#47516C", "#575D6D", "#666970", "#757575",
  "#848279", "#948E77", "#A59C74", "#B7A96E", "#C8B866", "#DBC75A", "#EED649", "#FEE838",
];

export function parts(colour) {
  return [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
}

// Between two colours: share 0 is the first.
export function mix(one, other, share) {
  const a = parts(one), b = parts(other);
  return `#${a.map((part, k) => Math.round(part + share * (b[k] - part)).toString(16).padStart(2, "0")).join("")}`;
}

// All colours of one theme; `curve(k)`, `body(name)`, `force(share)` give those of things.
export function themeOf(dark, bodies = {}) {
  const base = dark ? DARK : LIGHT;
  const own = (colour) => (dark ? mix(colour, "#FFFFFF", luminance(colour) < 0.25 ? 0.38 : 0.12) : colour);
  const shades = new Map(Object.entries(bodies).map(([name, colour]) => [name, own(colour)]));
  const curves = CURVES.map((colour) => (dark && colour === SHADES.black ? base.black : own(colour)));
  return {
    ...base, green: own(SHADES.green), pink: own(SHADES.pink), sky: own(SHADES.sky),
    curve: (k) => curves[k % curves.length],
    body: (name) => shades.get(name) ?? base.black,
    force: (share) => ramp(dark ? 0.3 + 0.7 * share : 1 - share), // the largest stands out on its paper
  };
}

function luminance(colour) {
  const [r, g, b] = parts(colour).map((part) => (part / 255) ** 2.2);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

// The cividis scale, 0 (dark blue) to 1 (yellow).
function ramp(share) {
  const place = Math.max(0, Math.min(1, share)) * (CIVIDIS.length - 1), k = Math.min(CIVIDIS.length - 2, Math.floor(place));
  return mix(CIVIDIS[k], CIVIDIS[k + 1], place - k);
}
