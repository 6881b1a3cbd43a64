// What a hand is about to do, before it is told: ghosts of bars and points, rings about what is caught, the cross hair.

import { lengthText } from "./board.js";

export function drawGhosts({ act, board, catcher, cross, over, told }, p) {
  const { theme } = board, soft = { colour: theme.sky, width: 2.5 }, dot = { colour: theme.sky, fill: theme.paper, width: 2.5 };
  const ring = (caught) => { if (caught?.point || caught?.line) p.dot(caught.at, 9, { ...soft, fill: null }); };
  ring(over);
  if (over?.at && !over.point && !over.line && told.tool !== "Select") p.dot(over.at, 3, { colour: theme.sky, fill: theme.sky });
  if (cross) crossHair(p, cross);
  if (!act) return;
  if (act.drags && act.to) {
    for (const name of catcher.joined(act.drags)) {
      for (const ends of Object.values(board.drawing.bars)) {
        if (ends.includes(name)) p.line([board.position(ends.find((end) => end !== name)), act.to.at], { ...soft, dash: [7, 5] });
      }
    }
    p.dot(act.to.at, 6, dot);
  }
  if (act.from && act.to) p.line([act.from.at, act.to.at], { ...soft, width: act.tool === "Bar" ? 5 : 2.5, opacity: 0.7, dash: act.tool === "Slot" ? [8, 5] : null });
  if (act.from) p.dot(act.from.at, 5, dot);
  if (act.corners) p.line([...act.corners.map((corner) => corner.at), act.to.at, act.corners[0].at], { ...soft, dash: [7, 5] });
  for (const spot of act.spots ?? []) p.dot(spot.at, 6, { ...dot, colour: theme.pink });
  if (act.spots?.length > 1) p.line(act.spots.map((spot) => spot.at), { colour: theme.pink, width: 1.6, dash: [5, 4] });
  if (act.along !== undefined) {
    const [c, s] = [Math.cos(act.along), Math.sin(act.along)], long = p.metres(70), [x, y] = act.to.at;
    p.line([[x - c * long, y - s * long], [x + c * long, y + s * long]], { ...soft, dash: [8, 5] });
  }
  ring(act.to);
  if (act.from && act.to && act.tool === "Bar") {
    const middle = [0, 1].map((k) => (act.from.at[k] + act.to.at[k]) / 2);
    p.tag(lengthText(Math.hypot(act.to.at[0] - act.from.at[0], act.to.at[1] - act.from.at[1])), middle, { dy: -14 });
  }
}

function crossHair(p, [x, y]) {
  const r = p.metres(14);
  p.line([[x - r, y], [x + r, y], null, [x, y - r], [x, y + r]], { colour: p.theme.ink, width: 1.6 });
}
