// The keyboard.
import { Vector3 } from "three";

export const HELP = [
  ["space", "play or pause"],
  ["← →", "a frame back or on; with shift ten"],
  ["home end", "to the start or the end"],
  ["+ −", "faster or slower"],
  ["F", "follow the next body"],
  ["L", "names: none, of bodies, all"],
  ["J S O", "joints; springs and loads; stations and sensors"],
  ["X T A", "axes; paths; forces and torques"],
  ["G P V", "ground; plots; the panel"],
  ["1 2 3", "look along x, y or z"],
  ["R", "see everything"],
  ["D", "light or dark"],
  ["H", "this help"],
];

export function keys({ player, view, pace, panel, theme, help, showPanel }) {
  const actions = {
    " ": () => player.play(),
    ArrowLeft: (event) => player.step(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => player.step(event.shiftKey ? 10 : 1),
    Home: () => player.seek(view.motion.start),
    End: () => player.seek(view.motion.end),
    "+": () => pace.faster(1),
    "=": () => pace.faster(1),
    "-": () => pace.faster(-1),
    f: () => panel.nextBody(),
    l: () => panel.nextNames(),
    v: () => showPanel(),
    r: () => view.reset(),
    d: () => theme.toggle(),
    h: () => help(),
    "?": () => help(),
    1: () => view.reset(new Vector3(1, 0, 0)),
    2: () => view.reset(new Vector3(0, -1, 0)),
    3: () => view.reset(new Vector3(0, -0.001, 1).normalize()),
  };
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.("input[type=search], select")) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (panel.switches.has(key)) panel.switches.get(key).click();
    else if (actions[key]) actions[key](event);
    else return;
    event.preventDefault();
  });
}
