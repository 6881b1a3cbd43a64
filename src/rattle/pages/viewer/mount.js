// mount(root, scene, host): the viewer in an element, and what scripts can do with it.  docs/scene.md describes a scene.

import { make } from "./dom.js";
import { unpack } from "./data.js";
import { HostSource, LiveSource } from "./live.js";
import { Knobs } from "./knobs.js";
import { differing } from "./measured.js";
import { unpackedText } from "./unpack.js";
import { Viewer } from "./viewer.js";

// host: {page: true} for a page of its own, {inside: true} in one that has title and trust, {autoplay: false}, {theme: "dark"}; returns the app of the page.
export function mount(root, scene, host = {}) {
  if (!String(scene.format).startsWith("rattle-scene 1")) throw new Error(`this viewer shows scenes of format 1, not ${scene.format}`);
  const viewer = new Viewer(root, scene, host), app = appOf(viewer);
  const runs = (scene.runs ?? []).map(unpack);
  if (runs.length) viewer.setRun(runs[0], { others: runs.length === 2 ? [runs[1]] : [] });
  if (runs.length > 1) chooseRuns(viewer, runs);
  if (scene.live || host.compute) computeMotions(viewer, scene, host, runs[0] ?? null);
  return app;
}

function appOf(viewer) {
  const { scene } = viewer;
  const given = Object.fromEntries((scene.knobs ?? []).map((knob) => [knob.name, knob.value]));
  return {
    viewer,
    mount,
    get names() { return viewer.motion ? [...viewer.motion.names] : []; },
    get parameters() { return { ...given, ...viewer.motion?.run.parameters, ...viewer.parameters }; },
    set: (name, value) => viewer.turnKnob(name, value),
    curve(name) {
      const { motion } = viewer;
      if (!motion) return { t: [], y: [], unit: "", peak: null, line: { t: [], y: [] } };
      const { t, y } = motion.line(name);
      return { t: Array.from(motion.t), y: Array.from(motion.curve(name)), unit: motion.unit(name), peak: motion.peak(name),
        line: { t: Array.from(t), y: Array.from(y) } };
    },
    get time() { return viewer.clock.time; },
    get playing() { return viewer.clock.playing; },
    play: () => viewer.play(),
    pause: () => viewer.pause(),
    seek: (t) => viewer.seek(t),
    get speed() { return viewer.clock.speed; },
    set speed(value) { viewer.setSpeed(value); },
    get live() { return viewer.live ?? false; },
    get error() { return viewer.refusal?.() ?? null; },
    get events() { return (viewer.motion?.events ?? []).map(({ t, joint, kind, speed, impulse, duration, force, lost, contact }) =>
      ({ t, joint, kind, normal_speed: speed, impulse, duration, peak_force: force, energy_lost: lost, contact })); },
    get statistics() {
      const { steps, rejected, evaluations } = viewer.motion?.run.stats ?? {};
      return steps === undefined ? null : { steps, rejected, evaluations };
    },
    get measured() { return viewer.motion ? viewer.measured.filter((one) => viewer.motion.has(one.curve)).map((one) => ({ curve: one.curve, label: one.label, ...differing(one, viewer.motion) })) : []; },
    get trust() { return viewer.motion?.trust ?? null; },
    get run() { return viewer.motion?.run ?? null; },
    setRun: (run, options) => viewer.setRun(run, options),
    choose: (names) => viewer.choose(names),
    on: (event, call) => viewer.on(event, call),
    destroy: () => viewer.destroy(),
  };
}

// Motions for other parameters: computed by the page itself, or by the host of the viewer.
function computeMotions(viewer, scene, host, first) {
  let knobs = null;
  const heard = (slot, trust) => knobs.heard(slot, trust);
  const source = scene.live ? new LiveSource(scene.live, heard, (share) => knobs.progress(share)) : new HostSource(host, heard);
  knobs = new Knobs(viewer, source, { ideal: Boolean(scene.live?.ideal), model: scene.live?.model ?? "", first });
  viewer.turnKnob = (name, value) => knobs.turned(name, value);
  viewer.refusal = () => knobs.error ?? null;
  source.ready?.then(() => { viewer.live = true; }, ({ message }) => showReplay(viewer, scene.live.replay, message));
  viewer.ends.push(() => knobs.destroy());
}

// A browser that cannot compute shows the motion that was computed when the page was written, and says so.
async function showReplay(viewer, replay, why) {
  viewer.scene.notes = [...(viewer.scene.notes ?? []), `this page replays the motion of its bodies that was computed when it was written: ${why}`];
  if (replay) viewer.setRun(unpack(JSON.parse(await unpackedText(replay))), { ghost: null });
}

// Number of the run with this value of a parameter, of several the one in which least else changes.
function runWith(runs, now, name, value) {
  const found = runs.map((run, k) => [Object.keys(now).filter((one) => one !== name && run.parameters?.[one] !== now[one]).length, k])
    .filter(([, k]) => Math.abs(runs[k].parameters?.[name] - value) <= 1e-9 * Math.abs(value)).sort((a, b) => a[0] - b[0]);
  if (found.length) return found[0][1];
  const known = [...new Set(runs.map((run) => run.parameters?.[name]).filter((one) => one !== undefined))];
  throw new Error(`no motion of this page has ${name} = ${value}; ${known.length ? `there are ${known.join(", ")}` : `it has no parameter ${name}`}`);
}

// Which of several runs is shown, and which one is dashed beside it.
function chooseRuns(viewer, runs) {
  const { word } = viewer, options = (none) => [...(none ? [make("option", { value: "" }, word("nothing"))] : []),
    ...runs.map((run, k) => make("option", { value: k }, run.label ? word(run.label) : word("run {number}", { number: k + 1 })))];
  const shown = make("select", {}, ...options(false)), beside = make("select", {}, ...options(true));
  if (runs.length === 2) beside.value = "1";
  const change = () => {
    const other = beside.value === "" || beside.value === shown.value ? [] : [runs[Number(beside.value)]];
    viewer.setRun(runs[Number(shown.value)], { others: other });
  };
  shown.addEventListener("change", change);
  beside.addEventListener("change", change);
  viewer.turnKnob = async (name, value) => {
    shown.value = String(runWith(runs, runs[Number(shown.value)].parameters ?? {}, name, value));
    change();
  };
  viewer.parts.runs.append(make("label", {}, word("Motion"), shown), make("label", {}, word("dashed beside it"), beside));
  viewer.parts.runs.hidden = false;
}
