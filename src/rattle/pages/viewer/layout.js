// The page around the pictures: title, trust line, toolbar, tabs, help.

import { button, make, say, toggle } from "./dom.js";

const keysIn = (word) => [
  [word("Space"), word("play and pause")], ["← →", word("one instant back or on, with Shift ten")],
  [word("Home, End"), word("to the start, to the end")], ["+ −", word("faster, slower")], ["L", word("loop")], ["T", word("paths of points")],
  ["F", word("forces")], ["G", word("the mechanism without play")], ["N", word("names of bodies")], ["0", word("show everything again")],
  ["D", word("dark or light")], ["?", word("this help")],
];
const mouseIn = (word) => [
  [word("Mechanism"), word("point at a joint to read its name and force, drag to move, wheel or pinch to zoom, double-click to show everything")],
  [word("Curves"), word("click to go to a time, drag to zoom into a span, wheel or pinch to zoom, double-click to show everything")],
];

// Texts that have no other language.
const ENGLISH = { lang: "en" };

// All elements of one viewer by name; host: the viewer.
export function layout(host, scene) {
  const { word } = host, named = scene.title ?? word("Mechanism"), title = make("h1", {}, named);
  const theme = button("moon", word("Dark or light (D)"), () => host.turnTheme());
  const help = button("?", word("Help (?)"), () => host.help(true), { class: "round" });
  const trust = make("div", { class: "trust", role: "status", "aria-live": "polite" });
  const canvas = make("canvas", { class: "mechanism", role: "img", "aria-label": word("{title}, to scale", { title: named }) });
  const tools = make("div", { class: "tools", role: "toolbar", "aria-label": word("What is shown") });
  const insets = make("div", { class: "insets" });
  const busy = make("div", { class: "busy", role: "status", hidden: true });
  const late = make("div", { class: "late quiet", hidden: true }, word("after the horizon: statistics only"));
  const stage = make("section", { class: "stage", "aria-label": word("Mechanism") }, canvas, tools, insets);
  const knobs = make("section", { class: "knobs", "aria-label": word("Parameters"), hidden: true });
  const runs = make("div", { class: "runs", hidden: true });
  const tabs = make("div", { class: "tabs", role: "tablist" });
  const sheets = make("div", { class: "sheets" });
  const side = make("section", { class: "side", "aria-label": word("Curves and orbits") }, runs, knobs, tabs, sheets);
  const header = make("header", {}, title, make("span", { class: "grow" }), theme, help);
  const main = make("main", {}, stage, side);
  return { title, theme, header, trust, canvas, tools, insets, busy, late, stage, knobs, runs, tabs, sheets, side, main,
    help: helpSheet(host) };
}

function helpSheet(host) {
  const { word } = host;
  const rows = (list) => list.flatMap(([key, text]) => [make("dt", {}, key), make("dd", {}, text)]);
  const close = button("close", word("Close help (Escape)"), () => host.help(false));
  const sheet = make("div", { class: "help", role: "dialog", "aria-modal": "true", "aria-label": word("Help"), tabindex: -1, hidden: true },
    make("div", { class: "card" }, make("h2", {}, word("Keys")), close, make("dl", {}, ...rows(keysIn(word))), make("h2", {}, word("Mouse and fingers")),
      make("dl", {}, ...rows(mouseIn(word))), make("h2", {}, word("Colours")),
      make("p", {}, word("Black arrows are forces of joints on their second body; red where a massless link would have to pull, so that the pin would lift off.")),
      make("p", {}, word("Red ticks on the time line are impacts. The shaded time lies after the horizon: there only statistics can be trusted."))));
  sheet.addEventListener("click", (event) => { if (event.target === sheet) host.help(false); });
  return sheet;
}

// How far a run can be trusted, in one word that opens; a run that stopped says why at once.
// The reasons are sentences of rattle, which are English.  lines: false where the page was asked to show no more than the word.
export function sayTrust(element, motion, remarks, word, lines) {
  const { run, trust } = motion, pulled = Object.values(trust.pulled ?? {}).some((share) => share > 0);
  const limited = pulled || motion.horizon !== null || (trust.limits ?? []).length > 0;
  const level = run.success === false ? "bad" : limited ? "mind" : "good";
  const said = { bad: word("Stopped"), mind: word("With limits"), good: word("Trusted") }[level];
  const stopped = run.success === false ? [make("p", ENGLISH, `The run stopped: ${run.message || "no reason was given"}`)] : [];
  const badge = make("span", { class: "badge" }, said);
  element.className = `trust ${level}`;
  if (lines === false) return void element.replaceChildren(badge, ...stopped);
  const open = element.querySelector("details")?.open ?? (level === "mind" && !isSmall());
  const [solved = "", more = ""] = trust.text ?? [], reach = solved.split("; ").slice(1).join("; "); // behind the errors
  const first = level === "mind" ? trust.limits?.[0] ?? trust.word ?? (pulled ? more : reach || more) : ""; // the reason in one line, while it is closed
  const count = remarks.length, notes = count ? ` · ${count > 1 ? word("{count} notes", { count }) : word("1 note")}` : "";
  const head = trust.word ? [trust.word] : trust.limits ?? [], repeated = (part) => head.some((line) => line.includes(part));
  const rest = (trust.text ?? []).map((line) => line.split("; ").filter((part) => !repeated(part)).join("; ")).filter((line) => line);
  const all = [...head, ...(trust.contacts ?? []), ...rest]; // as `rattle run`
  element.replaceChildren(make("details", { open }, make("summary", {}, badge, make("span", { class: "why quiet" }, `${word("why?")}${notes}`),
    ...(first ? [make("span", { class: "first quiet", ...ENGLISH }, first)] : [])),
    make("div", { class: "lines", ...ENGLISH }, ...all.map((line) => make("p", {}, line)),
      make("ul", { class: "notes" }, ...remarks.map((line) => make("li", {}, line))))), ...stopped);
}

// whether a screen is so small that every line counts, as that of a phone
const isSmall = () => Boolean(globalThis.matchMedia?.("(max-height: 520px), (max-width: 819px)").matches);

// Tabs with their sheets: {tab(name, text, sheet), choose(name), current}; arrows move between them.
export function tabbed(tabs, sheets, changed) {
  const every = new Map();
  const choose = (name) => {
    for (const [one, { tab, sheet }] of every) {
      tab.setAttribute("aria-selected", String(one === name));
      tab.tabIndex = one === name ? 0 : -1;
      sheet.hidden = one !== name;
    }
    tools.current = name;
    changed(name);
  };
  const move = (event) => {
    const shown = [...every].filter(([, one]) => !one.tab.hidden).map(([name]) => name), way = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!way) return;
    const next = shown[(shown.indexOf(tools.current) + way + shown.length) % shown.length];
    choose(next);
    every.get(next).tab.focus();
    event.stopPropagation();
    event.preventDefault();
  };
  tabs.addEventListener("keydown", move);
  const tools = {
    current: null,
    add(name, text, sheet) {
      const tab = make("button", { type: "button", role: "tab", onclick: () => choose(name) }, text);
      sheet.setAttribute("role", "tabpanel");
      sheet.setAttribute("aria-label", text);
      every.set(name, { tab, sheet });
      tabs.append(tab);
      sheets.append(sheet);
    },
    show(name, on, text) {
      const { tab } = every.get(name);
      tab.hidden = !on;
      if (text) say(tab, text);
      if (!on && tools.current === name) choose([...every].find(([, one]) => !one.tab.hidden)[0]);
    },
    choose,
  };
  return tools;
}

// Chips of the toolbar, and the list of points whose paths can be drawn.
export function toolbar(host, scene) {
  const { word } = host, forces = toggle(word("Forces"), word("Forces at joints (F)"), host.show.forces, (on) => host.turn("forces", on));
  const ghost = toggle(word("Without play"), word("The mechanism without play, dotted (G)"), host.show.ghost, (on) => host.turn("ghost", on));
  const names = toggle(word("Names"), word("Names of bodies (N)"), host.show.names, (on) => host.turn("names", on));
  const list = make("div", { class: "menu", role: "group", "aria-label": word("Points"), hidden: true,
    onkeydown: (event) => { if (event.key === "Escape") { event.stopPropagation(); host.openTraces(false); } } });
  const traces = make("button", { type: "button", class: "chip", "aria-expanded": "false", title: word("Paths of points (T)"),
    onclick: () => host.openTraces(list.hidden) }, word("Paths"));
  const fit = button("fit", word("Show everything (0)"), () => host.fit(), { class: "chip icon" });
  ghost.hidden = !scene.ideal;
  return { forces, ghost, names, traces, list, fit, all: [forces, traces, ghost, names, fit, list] };
}
