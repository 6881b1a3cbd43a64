// Mouse, pen and fingers on a canvas: taps, drags, wheel and pinch as a few calls.

const FAR = 5; // pixels from which on a press is a drag

// on: {tap(x, y), double(), start(x, y, pointer), drag(x, y, dx, dy), end(x, y), pinch(x, y, factor, dx, dy), wheel(x, y,
// factor, event) -> taken, hover(x, y), leave(pointer)}; all optional.  Returns a function that ends it.
export function gestures(element, on) {
  const down = new Map(); // pointers by id: {x, y}
  let moved = false, last = -Infinity; // when the last tap was: a page is young at its first one
  const place = (event) => {
    const box = element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const middle = () => {
    const [a, b] = [...down.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y) || 1 };
  };
  const press = (event) => {
    if (event.button > 0) return;
    down.set(event.pointerId, { ...place(event), from: place(event) });
    moved = down.size > 1;
    element.setPointerCapture?.(event.pointerId);
  };
  const move = (event) => {
    const at = place(event), one = down.get(event.pointerId);
    if (!one) return on.hover?.(at.x, at.y);
    if (down.size === 2) {
      const before = middle();
      Object.assign(one, at);
      const after = middle();
      return on.pinch?.(after.x, after.y, after.size / before.size, after.x - before.x, after.y - before.y);
    }
    if (!moved && Math.hypot(at.x - one.from.x, at.y - one.from.y) > FAR) {
      moved = true;
      on.start?.(one.from.x, one.from.y, event.pointerType);
    }
    if (moved) on.drag?.(at.x, at.y, at.x - one.x, at.y - one.y);
    Object.assign(one, at);
  };
  const release = (event) => {
    const one = down.get(event.pointerId), at = place(event);
    if (!one) return;
    down.delete(event.pointerId);
    if (down.size) return;
    if (moved) return event.type === "pointerup" ? on.end?.(at.x, at.y) : on.end?.(null, null);
    if (event.type !== "pointerup") return;
    const twice = event.timeStamp - last < 350;
    last = twice ? -Infinity : event.timeStamp;
    if (twice && on.double) on.double(at.x, at.y);
    else on.tap?.(at.x, at.y);
  };
  const wheel = (event) => {
    const at = place(event), factor = Math.exp(-Math.max(-80, Math.min(80, event.deltaY)) / (event.deltaMode ? 12 : 320));
    if (on.wheel?.(at.x, at.y, factor, event)) event.preventDefault();
  };
  const leave = (event) => on.leave?.(event.pointerType);
  const every = [["pointerdown", press], ["pointermove", move], ["pointerup", release], ["pointercancel", release], ["pointerleave", leave]];
  for (const [name, listen] of every) element.addEventListener(name, listen);
  element.addEventListener("wheel", wheel, { passive: false });
  return () => {
    for (const [name, listen] of every) element.removeEventListener(name, listen);
    element.removeEventListener("wheel", wheel);
  };
}
