// Puts the page together and runs it.
import { Vector3 } from "three";
import { bar } from "./bar.js";
import { button, make } from "./elements.js";
import { HELP, keys } from "./keys.js";
import { follow } from "./live.js";
import { Motion } from "./motion.js";
import { unpack } from "./packed.js";
import { Player } from "./player.js";
import { Plots } from "./plots.js";
import { side } from "./side.js";
import css from "./style.css";
import { Theme } from "./theme.js";
import { View } from "./view.js";

const SLOW = 0.07; // seconds: frames that take longer, so many in a row, cost the picture its shadows
const PATIENCE = 8;
const FAR = 6; // times its size: a mechanism that moves so far is followed
const NARROW = 720; // pixels: below, the panel is closed at first

async function start() {
  document.head.append(make("style", { textContent: css }));
  const content = JSON.parse(document.getElementById("scene").textContent);
  const bytes = await unpack(document.getElementById("numbers").textContent);
  const motion = new Motion(content, bytes);
  const player = new Player(motion);

  const stage = make("main", { className: "stage" });
  const panelBox = make("aside");
  const barBox = make("nav");
  const plotsBox = make("div", { className: "plots" });
  document.body.append(stage, panelBox, barBox, plotsBox);
  if (!content.plotted.length) document.body.classList.add("no-plots");
  if (innerWidth < NARROW) document.body.classList.add("no-panel");

  const view = new View(content, bytes, motion, stage);
  const plots = new Plots(motion, plotsBox, (t) => player.seek(t));
  const pace = bar(player, barBox);
  const panel = side(content, { view, motion, plots, player }, panelBox);
  if (view.radius > FAR * content.size) {
    panel.follow(0);
    view.reset();
  }
  const theme = new Theme(view, plots);
  const showPanel = () => document.body.classList.toggle("no-panel");
  const sheet = make(
    "dialog",
    { className: "help" },
    make(
      "table",
      {},
      ...HELP.map(([key, what]) => make("tr", {}, make("th", { textContent: key }), make("td", { textContent: what }))),
    ),
    make("p", {
      textContent: "Drag to turn, drag with the right button to move, wheel to zoom; a double click follows a body.",
    }),
  );
  sheet.onclick = () => sheet.close();
  const help = () => (sheet.open ? sheet.close() : sheet.showModal());
  document.body.append(sheet);
  stage.append(make("h1", { textContent: content.name }));
  barBox.append(
    button("◐", "light or dark (D)", () => theme.toggle()),
    button("☰", "panel (V)", showPanel),
    button("?", "keys (H)", help),
  );
  keys({ player, view, pace, panel, theme, help, showPanel });
  view.canvas.addEventListener("dblclick", (event) => panel.follow(view.bodyAt(event.clientX, event.clientY)));
  player.listeners.push(() => {
    view.dirty = true;
    plots.update();
  });

  let last = performance.now();
  let frames = 0;
  let slow = 0;
  const loop = (now) => {
    const passed = (now - last) / 1000;
    last = now;
    player.tick(passed);
    slow = player.playing && passed > SLOW && passed < 1 ? slow + 1 : 0; // longer: the page was hidden
    if (slow === PATIENCE) view.lighten();
    view.draw();
    frames++;
    requestAnimationFrame(loop);
  };
  requestAnimationFrame(loop);
  view.draw();
  if (content.live) follow(motion, player);
  else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) player.play(true);

  // For tests and for pages around this one.
  window.sigmafmu = {
    player,
    view,
    loaded: performance.now(), // ms from the opening of the page to the first picture
    get state() {
      const { followed, arrows, traces, frames: axes, tags, camera } = view;
      return {
        time: player.now,
        start: motion.start,
        end: motion.end,
        playing: player.playing,
        speed: player.speed,
        theme: theme.name,
        followed,
        names: tags.mode,
        arrows: arrows.group.visible,
        paths: traces.group.visible,
        axes: axes.group.visible,
        camera: {
          position: camera.position.toArray(),
          target: view.controls.target.toArray(),
          up: camera.up.toArray(),
          angle: camera.fov, // degrees, from the lower to the upper edge
        },
        frames,
      };
    },
    seek(t) {
      player.play(false);
      player.seek(t);
      view.dirty = true;
      view.draw();
    },
    // Pixels of the origin of a body's axes, as its mesh is drawn; of a moving frame, as its feet are: layer "ground".
    project(name, layer = "body") {
      const body = motion.bodies.findIndex((candidate) => candidate.name === name);
      const { mesh } = view.items.items.find((item) => item.layer === layer && item.point.body === body);
      return view.project(new Vector3().setFromMatrixPosition(mesh.matrixWorld));
    },
  };
}

start().catch((error) => {
  document.body.append(
    make("p", { className: "failed", textContent: `This browser cannot show the animation: ${error.message}` }),
  );
  throw error;
});
