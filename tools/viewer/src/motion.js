// Where bodies and points are at any time: cubic between frames for what moves, slerp for what turns.
import { Quaternion, Vector3 } from "three";
import { columns } from "./packed.js";

export class Motion {
  constructor(scene, bytes) {
    this.time = columns(bytes, scene.time)[0];
    this.start = this.time[0];
    this.end = this.time.at(-1);
    this.exaggeration = 1;
    this.bodies = scene.bodies.map((body) => ({
      name: body.name,
      color: body.color,
      position: columns(bytes, body.position),
      quaternion: columns(bytes, body.quaternion),
      modal: body.modal ? columns(bytes, body.modal) : [],
    }));
    this.columns = scene.columns.map(({ name, unit, values }) => ({ name, unit, values: columns(bytes, values)[0] }));
    this.column = new Map(this.columns.map((column) => [column.name, column]));
    this.poses = this.bodies.map((body) => ({
      position: new Vector3(),
      quaternion: new Quaternion(),
      modal: new Float64Array(body.modal.length),
    }));
    this.moveTo(this.start);
  }

  // The largest mean angular velocity of a body [rad/s].
  fastest() {
    const turned = this.bodies.map(({ quaternion: [w, x, y, z] }) => {
      let angle = 0;
      for (let i = 1; i < w.length; i++) {
        const cosine = Math.abs(w[i] * w[i - 1] + x[i] * x[i - 1] + y[i] * y[i - 1] + z[i] * z[i - 1]);
        angle += 2 * Math.acos(Math.min(cosine, 1));
      }
      return angle;
    });
    return Math.max(...turned) / (this.end - this.start || 1);
  }

  // The frame before t, and the share of the way from it to the next one.
  locate(t) {
    let low = 0;
    let high = this.time.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.time[middle] <= t) low = middle;
      else high = middle;
    }
    const span = this.time[high] - this.time[low];
    return [low, span > 0 ? Math.min(Math.max((t - this.time[low]) / span, 0), 1) : 0];
  }

  moveTo(t) {
    this.now = Math.min(Math.max(t, this.start), this.end);
    const [i, s] = this.locate(this.now);
    for (const [b, body] of this.bodies.entries()) {
      const pose = this.poses[b];
      const [x, y, z] = body.position;
      pose.position.set(this.cubic(x, i, s), this.cubic(y, i, s), this.cubic(z, i, s));
      turned(body.quaternion, i, pose.quaternion);
      if (s > 0) pose.quaternion.slerp(turned(body.quaternion, i + 1, NEXT), s);
      for (const [f, values] of body.modal.entries()) pose.modal[f] = this.cubic(values, i, s);
    }
  }

  // From this frame on the bodies are so: of each the position, the quaternion and the modal coordinates.
  write(frame, poses) {
    for (const [b, { position, quaternion, modal }] of this.bodies.entries()) {
      for (const [k, values] of [...position, ...quaternion, ...modal].entries()) values.fill(poses[b][k], frame);
    }
  }

  // Hermite's interpolation with differences of neighbours as slopes.
  cubic(values, i, s) {
    if (s === 0) return values[i];
    const t = this.time;
    const h = t[i + 1] - t[i];
    const slope = (k) => {
      const a = Math.max(k - 1, 0);
      const b = Math.min(k + 1, t.length - 1);
      return (values[b] - values[a]) / (t[b] - t[a]);
    };
    const r = 1 - s;
    return (
      (1 + 2 * s) * r * r * values[i] +
      s * r * r * h * slope(i) +
      s * s * (3 - 2 * s) * values[i + 1] -
      s * s * r * h * slope(i + 1)
    );
  }

  // The present value of a recorded variable.
  value(name) {
    const column = this.column.get(name);
    if (!column) return Number.NaN;
    const [i, s] = this.locate(this.now);
    return s === 0 ? column.values[i] : (1 - s) * column.values[i] + s * column.values[i + 1];
  }

  // Where a point is now.
  place({ body, at, modes }, out = new Vector3()) {
    out.fromArray(at);
    if (body < 0) return out;
    const pose = this.poses[body];
    if (modes) {
      for (const [f, shift] of modes.entries())
        out.addScaledVector(SHIFT.fromArray(shift), this.exaggeration * pose.modal[f]);
    }
    return out.applyQuaternion(pose.quaternion).add(pose.position);
  }
}

const NEXT = new Quaternion();
const SHIFT = new Vector3();

function turned([w, x, y, z], i, out) {
  return out.set(x[i], y[i], z[i], w[i]).normalize();
}
