// Keys of the whole page; those of a field that is written into stay with the field.

import { TABS } from "./tabs.js";

function writes(target) {
  return target.matches?.("input:not([type=range]), textarea, select");
}

export function listen(page) {
  addEventListener("keydown", (event) => {
    const target = event.composedPath()[0], command = event.ctrlKey || event.metaKey;
    if (command && !event.altKey) {
      const act = withCommand(page, event);
      if (act) { event.preventDefault(); act(); }
      return;
    }
    if (event.altKey || event.defaultPrevented || writes(target) || page.dialogs.open) return;
    const act = plainKey(page, event.key, target);
    if (act) { event.preventDefault(); act(); }
  });
}

function withCommand(page, event) {
  const key = event.key.toLowerCase();
  if (key === "s") return () => page.tell({ do: event.shiftKey ? "save-as" : "save" });
  if (key === "o") return () => page.tell({ do: "files" });
  if (key === "z") return () => page.step(event.shiftKey ? "redo" : "undo");
  if (key === "y") return () => page.step("redo");
  return null;
}

function plainKey(page, key, target) {
  if (/^[0-9]$/.test(key)) return () => page.choose(TABS[(Number(key) + 9) % 10][0]);
  if (key === "?") return () => page.dialogs.keys();
  if (key === "e") return () => page.draw();
  if (key === "g") return () => page.tell({ do: "files", gallery: true });
  if (key === "d") return () => page.theme.next();
  if (key === "t") return () => { page.choose("text"); page.editor.focus(); };
  if (key === "k") return () => page.knobs.el.querySelector("input[type=range]")?.focus();
  if (key === " " && !target.matches?.("button, a, summary") && page.shown === "motion") return () => page.show.toggle();
  return null;
}
