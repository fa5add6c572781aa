// The meshes of the scene, and how they follow the motion.
import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  Mesh,
  MeshStandardMaterial,
  Sphere,
  Vector3,
} from "three";
import { rows } from "./packed.js";

export class Items {
  constructor(scene, bytes, motion) {
    this.motion = motion;
    this.group = new Group();
    this.layers = new Map();
    this.items = scene.items.map((item) => this.add(item, bytes));
  }

  add(item, bytes) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(rows(bytes, item.positions, Float32Array), 3));
    geometry.setAttribute("normal", new BufferAttribute(rows(bytes, item.normals, Float32Array), 3));
    geometry.setIndex(new BufferAttribute(rows(bytes, item.triangles, Uint32Array), 1));
    if (item.modes.length) {
      geometry.morphAttributes.position = item.modes.map(
        (mode) => new Float32BufferAttribute(rows(bytes, mode, Float32Array), 3),
      );
      geometry.morphTargetsRelative = true;
    }
    const material = new MeshStandardMaterial({ color: item.color, roughness: 0.55, metalness: 0.08 });
    if (item.layer === "mark") {
      material.polygonOffset = true;
      material.polygonOffsetFactor = -1;
    }
    const mesh = new Mesh(geometry, material);
    mesh.castShadow = mesh.receiveShadow = true;
    mesh.frustumCulled = item.modes.length === 0;
    mesh.userData.body = item.carrier.to ? -1 : item.carrier.point.body;
    mesh.updateMorphTargets();
    // Not of the modes: three.js would take each with a modal coordinate of 1.
    geometry.boundingBox = new Box3().setFromBufferAttribute(geometry.getAttribute("position"));
    geometry.boundingSphere = geometry.boundingBox.getBoundingSphere(new Sphere());
    if (!this.layers.has(item.layer)) {
      this.layers.set(item.layer, new Group());
      this.group.add(this.layers.get(item.layer));
    }
    this.layers.get(item.layer).add(mesh);
    return { ...item.carrier, layer: item.layer, mesh };
  }

  show(layer, visible) {
    const group = this.layers.get(layer);
    if (group) group.visible = visible;
  }

  update() {
    for (const { mesh, point, turns, to, length } of this.items) {
      this.motion.place(point, mesh.position);
      if (to) {
        this.motion.place(to, AHEAD).sub(mesh.position);
        const reach = AHEAD.length();
        if (reach > 0) mesh.quaternion.setFromUnitVectors(Z, AHEAD.divideScalar(reach));
        mesh.scale.set(1, 1, Math.max(reach / length, 1e-6));
      } else if (turns && point.body >= 0) {
        mesh.quaternion.copy(this.motion.poses[point.body].quaternion);
      }
      if (mesh.morphTargetInfluences) {
        const { modal } = this.motion.poses[point.body];
        for (let f = 0; f < modal.length; f++) mesh.morphTargetInfluences[f] = this.motion.exaggeration * modal[f];
      }
    }
  }
}

const Z = new Vector3(0, 0, 1);
const AHEAD = new Vector3();
