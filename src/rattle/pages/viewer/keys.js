// The keyboard: only for the viewer that has the focus or lies under the mouse, or that is the page.

export function handleKeys(viewer) {
  let over = false;
  const enter = () => { over = true; };
  const leave = () => { over = false; };
  const press = (event) => {
    if (!viewer.motion || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    const inside = viewer.shadow.activeElement, elsewhere = document.activeElement;
    const free = !elsewhere || elsewhere === document.body || elsewhere === viewer.box;
    if (!(inside || (free && !viewer.host.inside && (over || viewer.host.page)))) return;
    if (viewer.host.inside && ["d", "D", "?"].includes(event.key)) return; // those of the page around it
    if (event.key === "Escape") return viewer.help(false);
    if (typing(inside, event.key)) return;
    if (act(viewer, event)) event.preventDefault();
  };
  const { box } = viewer;
  document.addEventListener("keydown", press);
  box.addEventListener("pointerenter", enter);
  box.addEventListener("pointerleave", leave);
  return () => {
    document.removeEventListener("keydown", press);
    box.removeEventListener("pointerenter", enter);
    box.removeEventListener("pointerleave", leave);
  };
}

// True if a key belongs to the element that has the focus: text in a field, space on a button, arrows in a list.
function typing(element, key) {
  if (!element) return false;
  const tag = element.tagName, { type } = element;
  if (tag === "TEXTAREA" || tag === "SELECT" || (tag === "INPUT" && !["range", "checkbox", "radio"].includes(type))) return true;
  if (tag === "INPUT" && type === "range" && !element.closest(".player")) return key !== " " && !/^[a-z?]$/i.test(key);
  if (key === " " || key === "Enter") return ["BUTTON", "SUMMARY"].includes(tag) || type === "checkbox" || type === "radio";
  return false;
}

function act(viewer, { key, shiftKey }) {
  const { clock, show } = viewer, { motion } = clock, far = shiftKey ? 10 : 1;
  const actions = {
    " ": () => (clock.playing ? viewer.pause() : viewer.play()),
    ArrowLeft: () => viewer.step(-far), ArrowRight: () => viewer.step(far),
    Home: () => viewer.seek(motion.start), End: () => viewer.seek(motion.end),
    "+": () => viewer.faster(1), "=": () => viewer.faster(1), "-": () => viewer.faster(-1), "−": () => viewer.faster(-1),
    l: () => viewer.setLoop(!clock.loop), t: () => viewer.turnTraces(), f: () => viewer.turn("forces", !show.forces),
    g: () => viewer.ghost && viewer.turn("ghost", !show.ghost), n: () => viewer.turn("names", !show.names),
    d: () => viewer.turnTheme(), 0: () => viewer.fit(), "?": () => viewer.help(true),
  };
  const action = actions[key.length === 1 ? key.toLowerCase() : key];
  action?.();
  return Boolean(action);
}
