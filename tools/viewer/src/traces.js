// Paths of points up to the present time.
import { BufferGeometry, Float32BufferAttribute, Group, Line, LineBasicMaterial } from "three";

export class Traces {
  constructor(scene, motion) {
    this.motion = motion;
    this.group = new Group();
    this.group.visible = false;
    this.traces = scene.traces.map(({ name, point }) => ({ name, point, shown: true, line: null }));
  }

  // Only this one, or all for an empty name.
  choose(name) {
    for (const trace of this.traces) trace.shown = name === "" || trace.name === name;
  }

  // Lines are made when they are first asked for: they take a pass through all frames.
  show(visible) {
    this.group.visible = visible;
    if (!visible) return;
    const { motion } = this;
    const kept = motion.now;
    const missing = this.traces.filter((trace) => !trace.line);
    if (missing.length) {
      const paths = missing.map(() => new Float32Array(3 * motion.time.length));
      for (let i = 0; i < motion.time.length; i++) {
        motion.moveTo(motion.time[i]);
        for (const [k, trace] of missing.entries()) motion.place(trace.point).toArray(paths[k], 3 * i);
      }
      for (const [k, trace] of missing.entries()) {
        const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(paths[k], 3));
        const color = motion.bodies[trace.point.body]?.color ?? "#888888";
        trace.line = new Line(geometry, new LineBasicMaterial({ color }));
        trace.line.frustumCulled = false;
        this.group.add(trace.line);
      }
      motion.moveTo(kept);
    }
    this.update();
  }

  // Paths depend on how much deformations are exaggerated.
  forget() {
    for (const trace of this.traces) trace.line?.geometry.dispose();
    this.group.clear();
    for (const trace of this.traces) trace.line = null;
    this.show(this.group.visible);
  }

  update() {
    if (!this.group.visible) return;
    const [i] = this.motion.locate(this.motion.now);
    for (const { line, shown } of this.traces) {
      line.visible = shown;
      line.geometry.setDrawRange(0, i + 1);
    }
  }
}
