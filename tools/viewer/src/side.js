// The panel beside the scene: what is shown, which body is followed, and variables with their present values.
import { make, slider, toggle } from "./elements.js";
import { short } from "./plots.js";
import { NAMES } from "./tags.js";

export function side(content, state, parent) {
  const { view, motion, plots, player } = state;
  const redraw = () => {
    view.dirty = true;
  };
  const switches = new Map();
  function add(key, text, checked, onchange) {
    const { label, input } = toggle(text, key, checked, (on) => {
      onchange(on);
      redraw();
    });
    switches.set(key.toLowerCase(), input);
    shown.append(label);
  }
  const shown = make("section", { className: "shown" });
  const has = (layer) => view.items.layers.has(layer);
  if (has("joint")) {
    add("J", "joints", true, (on) => {
      view.items.show("joint", on);
      view.items.show("ground", on);
    });
  }
  if (has("force") || has("load")) {
    add("S", "springs", true, (on) => {
      view.items.show("force", on);
      view.items.show("load", on);
    });
  }
  if (has("station") || has("sensor")) {
    add("O", "points", false, (on) => {
      view.items.show("station", on);
      view.items.show("sensor", on);
    });
  }
  add("X", "axes", false, (on) => {
    view.frames.group.visible = on;
  });
  add("T", "paths", false, (on) => view.traces.show(on));
  if (content.arrows.length) {
    add("A", "forces", false, (on) => {
      view.arrows.group.visible = on;
    });
  }
  add("G", "ground", true, (on) => {
    view.ground.group.visible = on;
  });
  add("P", "plots", true, (on) => document.body.classList.toggle("no-plots", !on));

  const names = make(
    "select",
    { title: "names (key L)" },
    ...NAMES.map((n) => make("option", { value: n, textContent: n })),
  );
  names.value = view.tags.mode;
  names.onchange = () => {
    view.tags.mode = names.value;
    redraw();
  };
  const follow = make(
    "select",
    { title: "follow a body (key F, or a double click on it)" },
    make("option", { value: -1, textContent: "nothing" }),
    ...motion.bodies.map((body, i) => make("option", { value: i, textContent: body.name })),
  );
  follow.onchange = () => {
    view.follow(Number(follow.value));
    redraw();
  };
  const path = make(
    "select",
    { title: "whose path is drawn" },
    make("option", { value: "", textContent: "all" }),
    ...content.traces.map(({ name }) => make("option", { value: name, textContent: name })),
  );
  path.onchange = () => {
    view.traces.choose(path.value);
    if (!switches.get("t").checked) switches.get("t").click();
    redraw();
  };
  shown.append(make("label", {}, "names ", names), make("label", {}, "follow ", follow));
  if (content.traces.length > 1) shown.append(make("label", {}, "path of ", path));

  if (motion.bodies.some((body) => body.modal.length)) {
    const factor = make("output", { textContent: "1 ×" });
    const exaggerate = slider(0, 3, 0.02, 0, "deformation, exaggerated", (power) => {
      motion.exaggeration = 10 ** power;
      factor.textContent = `${short(Number(motion.exaggeration.toPrecision(2)))} ×`;
      view.traces.forget();
      redraw();
    });
    exaggerate.setAttribute("aria-label", "deformation");
    shown.append(make("label", { className: "wide" }, "deformation ", exaggerate, factor));
  }
  if (content.arrows.length) {
    const scale = slider(-1, 2, 0.02, 0, "length of arrows", (power) => {
      view.arrows.scale = 10 ** power;
      redraw();
    });
    scale.setAttribute("aria-label", "arrows");
    shown.append(make("label", { className: "wide" }, "arrows ", scale));
  }

  const legend = make("section", { className: "legend" });
  const rows = motion.columns.map((column) => {
    const box = make("input", { type: "checkbox", checked: content.plotted.includes(column.name) });
    const swatch = make("i");
    const value = make("output");
    const label = make(
      "label",
      { title: column.name },
      box,
      swatch,
      make("span", {}, make("bdi", { textContent: column.name })),
      value,
      make("small", { textContent: column.unit }),
    );
    box.onchange = choose;
    legend.append(label);
    return { column, box, swatch, value };
  });
  const search = make("input", { type: "search", placeholder: "variables", ariaLabel: "variables" });
  search.oninput = () => {
    for (const { column, box } of rows) {
      box.parentElement.hidden = !column.name.toLowerCase().includes(search.value.toLowerCase());
    }
  };
  function choose() {
    const colors = plots.show(rows.filter(({ box }) => box.checked).map(({ column }) => column.name));
    for (const { column, swatch } of rows) swatch.style.background = colors.get(column.name) ?? "transparent";
  }
  view.items.show("station", false);
  view.items.show("sensor", false);
  // Those that are plotted first.
  rows.sort((a, b) => b.box.checked - a.box.checked);
  legend.append(...rows.map(({ box }) => box.parentElement));
  parent.append(shown, search, legend);
  choose();

  let written = 0;
  function update() {
    const now = performance.now();
    if (parent.offsetParent === null || (player.playing && now - written < 80)) return; // hidden, or just done
    written = now;
    for (const { column, value } of rows) value.textContent = short(motion.value(column.name));
  }
  player.listeners.push(update);
  update();
  return {
    switches,
    nextNames() {
      names.value = NAMES[(NAMES.indexOf(names.value) + 1) % NAMES.length];
      names.onchange();
    },
    follow(body) {
      follow.value = body;
      follow.onchange();
    },
    nextBody() {
      this.follow(((view.followed + 2) % (motion.bodies.length + 1)) - 1);
    },
  };
}
