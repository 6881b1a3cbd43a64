// What is said of a drawing: what each tool does, what is chosen, and what a newcomer may do next.

// Name, key, and what one does with it.
export const TOOLS = [
  ["Select", "V", "click chooses, Delete removes; drag a point to move it, a body to turn the mechanism"],
  ["Ground", "O", "click: a point of the ground, on the end of a bar also its pin"],
  ["Bar", "B", "drag from point to point, or click both; ends join what they touch"],
  ["Plate", "P", "click the corners; the first one again, Enter or a double click closes it"],
  ["Pin", "J", "click where two bodies cross, or a pin to give it play"],
  ["Slider", "L", "click the end of a bar; drag from it for another direction than along x"],
  ["Slot", "U", "drag along a bar, then click the point that slides in it"],
  ["Gear", "W", "click two centres"],
  ["Motor", "M", "click a pin on the ground, or a slider"],
  ["Spring", "S", "drag from point to point, or click both"],
  ["Force", "F", "drag from a point of a body: 1 N for each step of the grid"],
  ["Measure", "R", "click a point for its path, a bar for its centrodes, two points for their distance, three for an angle"],
  ["Picture", "I", "choose a photograph to lie below; two points of known distance scale it"],
];

export const toolWords = (name) => TOOLS.find(([tool]) => tool === name)[2];

// What is chosen, in words: "joint J3, coupler and rocker, play 0.2 mm".
export function titleOf(things, drawing) {
  const [kind, name] = (things[0] ?? "").split(/ (.*)/s);
  if (kind === "joint") {
    const joint = drawing.joints.find((other) => other.name === name), bodies = joint.ends.map((end) => end.split(".")[0]);
    const what = joint.type === "revolute" ? "joint" : `${joint.type} joint`;
    return `${what} ${name}, ${bodies.join(" and ")}${joint.play ? `, play ${joint.play}` : ""}`;
  }
  if (kind === "body") return `${drawing.bars[name] ? "bar" : "body"} ${name}`;
  if (kind === "driver") return `${name} drives ${drawing.joints.find((joint) => joint.driver === name)?.name ?? "a coordinate"}`;
  if (kind === "picture") return "picture below the drawing";
  return things[0] ?? "";
}

// Above the fields of each of several joints at one place; "" where there is one alone, and for all else.
export function headingOf(thing, things, drawing) {
  if (!thing.startsWith("joint ") || things.filter((other) => other.startsWith("joint ")).length < 2) return "";
  return titleOf([thing], drawing);
}

// What may come next in a drawing that was begun on an empty sheet; "" where its status says that already.
export function nextOf({ scene, joints, status }) {
  if (!scene) return "";
  const onGround = joints.filter(({ ends }) => ends.some((end) => end.startsWith("ground.")));
  if (!onGround.length) return "Next: hold it with Ground, clicked on the end of a bar.";
  if (/without a motor/.test(status) && !joints.some(({ driver }) => driver)) return "Next: Motor, clicked on a pin of the ground.";
  if (/: moves$/.test(status) && !joints.some(({ play }) => play)) return "Next: Select a pin and type its play.";
  return "";
}
