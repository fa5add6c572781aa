// Forces and torques as arrows, in proportion to the largest of their kind.
import { ConeGeometry, CylinderGeometry, Group, Mesh, MeshStandardMaterial, Vector3 } from "three";

const FORCE = "#d8453a";
const TORQUE = "#9a5bd0";
const LONGEST = 0.45; // of the mechanism's size

export class Arrows {
  constructor(scene, motion) {
    this.motion = motion;
    this.group = new Group();
    this.group.visible = false;
    this.length = LONGEST * scene.size;
    this.scale = 1;
    const t = scene.thickness;
    this.arrows = scene.arrows.map(({ variable, torque, point }) => {
      const material = new MeshStandardMaterial({ color: torque ? TORQUE : FORCE, roughness: 0.6, depthTest: false });
      const shaft = new Mesh(SHAFT, material);
      const heads = (torque ? [0, 1] : [0]).map(() => new Mesh(HEAD, material));
      // Over all else: many of them begin within bodies.
      shaft.renderOrder = 2;
      for (const head of heads) head.renderOrder = 2;
      const group = new Group().add(shaft, ...heads);
      this.group.add(group);
      const names = [1, 2, 3].map((i) => `${variable}[${i}]`);
      return { names, torque, point, group, shaft, heads };
    });
    this.thickness = 0.7 * t;
    this.most = [false, true].map((kind) => this.largest(kind));
  }

  // The largest magnitude over time of forces, or of torques.
  largest(torque) {
    let most = 0;
    for (const arrow of this.arrows.filter((a) => a.torque === torque)) {
      const [x, y, z] = arrow.names.map((name) => this.motion.column.get(name)?.values ?? []);
      for (let i = 0; i < x.length; i++) most = Math.max(most, Math.hypot(x[i], y[i], z[i]));
    }
    return most;
  }

  update() {
    if (!this.group.visible) return;
    for (const { names, torque, point, group, shaft, heads } of this.arrows) {
      VALUE.fromArray(names.map((name) => this.motion.value(name)));
      const most = this.most[torque ? 1 : 0];
      const reach = most > 0 ? (this.scale * this.length * VALUE.length()) / most : 0;
      group.visible = reach > 0.02 * this.length;
      if (!group.visible) continue;
      this.motion.place(point, group.position);
      group.quaternion.setFromUnitVectors(Y, VALUE.normalize());
      const radius = this.thickness;
      const head = Math.min(6 * radius, 0.5 * reach);
      shaft.scale.set(radius, Math.max(reach - head, 1e-9), radius);
      for (const [i, cone] of heads.entries()) {
        cone.position.y = reach - head * (1 + 0.7 * i);
        cone.scale.set(2.4 * radius, head, 2.4 * radius);
      }
    }
  }
}

const SHAFT = new CylinderGeometry(1, 1, 1, 16).translate(0, 0.5, 0);
const HEAD = new ConeGeometry(1, 1, 24).translate(0, 0.5, 0);
const Y = new Vector3(0, 1, 0);
const VALUE = new Vector3();
