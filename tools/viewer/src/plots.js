// Curves over time below the scene, a diagram for each unit, with a line at the present time.

export const COLORS = [
  "#4c86c6",
  "#e08a3c",
  "#4fa567",
  "#c9504a",
  "#8d6cc0",
  "#a3785f",
  "#d277b3",
  "#8a8f98",
  "#b7a53a",
  "#3fa7b5",
];
const MARGIN = { left: 56, right: 10, top: 8, bottom: 18 };

export class Plots {
  constructor(motion, parent, onSeek) {
    this.motion = motion;
    this.parent = parent;
    this.onSeek = onSeek;
    this.names = [];
    this.plots = [];
    new ResizeObserver(() => this.layout()).observe(parent);
  }

  // Show these variables; returns the colour of each.
  show(names) {
    this.names = names.filter((name) => this.motion.column.has(name));
    const units = new Map();
    this.colors = new Map();
    for (const name of this.names) {
      const column = this.motion.column.get(name);
      if (!units.has(column.unit)) units.set(column.unit, []);
      const curves = units.get(column.unit);
      const color = COLORS[curves.length % COLORS.length];
      curves.push({ ...column, color });
      this.colors.set(name, color);
    }
    this.parent.replaceChildren();
    this.plots = [...units].map(([unit, curves]) => this.add(unit, curves));
    this.layout();
    return this.colors;
  }

  add(unit, curves) {
    const canvas = document.createElement("canvas");
    canvas.className = "plot";
    canvas.title = curves.map((curve) => curve.name).join(", ");
    const seek = (event) => {
      const { left, width } = canvas.getBoundingClientRect();
      const share = (event.clientX - left - MARGIN.left) / (width - MARGIN.left - MARGIN.right);
      this.onSeek(this.motion.start + Math.min(Math.max(share, 0), 1) * (this.motion.end - this.motion.start));
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) seek(event);
    });
    this.parent.append(canvas);
    let low = Number.POSITIVE_INFINITY;
    let high = Number.NEGATIVE_INFINITY;
    for (const { values } of curves) {
      for (const value of values) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    if (high - low <= 1e-12 * Math.max(Math.abs(high), Math.abs(low))) {
      const room = 0.5 * Math.abs(high) || 1;
      [low, high] = [low - room, high + room];
    }
    const still = document.createElement("canvas"); // all but the line at the present time
    return { canvas, still, unit, curves, low, high };
  }

  layout() {
    for (const plot of this.plots) {
      const { clientWidth: width, clientHeight: height } = plot.canvas;
      if (!width || !height) continue;
      const ratio = window.devicePixelRatio;
      for (const canvas of [plot.canvas, plot.still]) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
      }
      this.paint(plot, width, height, ratio);
    }
    this.update();
  }

  paint(plot, width, height, ratio) {
    const style = getComputedStyle(this.parent);
    const pen = plot.still.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = style.getPropertyValue("--faint");
    pen.strokeStyle = style.getPropertyValue("--line");
    pen.lineWidth = 1;
    const x = (t) =>
      MARGIN.left +
      ((t - this.motion.start) / (this.motion.end - this.motion.start || 1)) * (width - MARGIN.left - MARGIN.right);
    const y = (v) => MARGIN.top + ((plot.high - v) / (plot.high - plot.low)) * (height - MARGIN.top - MARGIN.bottom);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of ticks(plot.low, plot.high, Math.max(2, height / 32))) {
      pen.beginPath();
      pen.moveTo(MARGIN.left, y(value));
      pen.lineTo(width - MARGIN.right, y(value));
      pen.stroke();
      pen.fillText(short(value), MARGIN.left - 5, y(value));
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const t of ticks(this.motion.start, this.motion.end, width / 90)) {
      pen.fillText(short(t), x(t), height - MARGIN.bottom + 4);
    }
    pen.textAlign = "left";
    pen.fillText(plot.unit === "1" ? "" : plot.unit, 4, 2);
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    for (const { values, color } of plot.curves) {
      pen.strokeStyle = color;
      pen.beginPath();
      for (const [t, v] of thinned(this.motion.time, values, width)) pen.lineTo(x(t), y(v));
      pen.stroke();
    }
    plot.x = x;
  }

  update() {
    for (const { canvas, still, x } of this.plots) {
      if (!x || !canvas.width) continue;
      const pen = canvas.getContext("2d");
      const ratio = window.devicePixelRatio;
      pen.setTransform(1, 0, 0, 1, 0, 0);
      pen.clearRect(0, 0, canvas.width, canvas.height);
      pen.drawImage(still, 0, 0);
      pen.fillStyle = getComputedStyle(this.parent).getPropertyValue("--accent");
      pen.fillRect(
        Math.round(ratio * x(this.motion.now)),
        ratio * MARGIN.top,
        Math.max(1, ratio),
        canvas.height - ratio * (MARGIN.top + MARGIN.bottom),
      );
    }
  }
}

// Of many samples, the extremes within each half pixel.
export function thinned(time, values, width) {
  const size = Math.max(1, Math.floor(time.length / (2 * width)));
  const points = [];
  for (let first = 0; first < time.length; first += size) {
    let low = first;
    let high = first;
    for (let i = first; i < Math.min(first + size, time.length); i++) {
      if (values[i] < values[low]) low = i;
      if (values[i] > values[high]) high = i;
    }
    for (const i of low === high ? [low] : [Math.min(low, high), Math.max(low, high)])
      points.push([time[i], values[i]]);
  }
  return points;
}

// About `count` round numbers from low to high.
export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  if (!(rough > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((k) => k * power >= rough);
  const result = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) result.push(k * step);
  return result;
}

// A number with four digits.
export function short(value) {
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) return value.toExponential(2).replace("e+", "e").replaceAll("-", "−");
  return Number(value.toPrecision(4)).toString().replace("-", "−");
}
