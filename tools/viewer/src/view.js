// The picture: camera, lights, ground, and what is drawn.
import {
  Box3,
  Color,
  DirectionalLight,
  HemisphereLight,
  PCFShadowMap,
  PerspectiveCamera,
  Raycaster,
  Scene,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Arrows } from "./arrows.js";
import { Frames } from "./frames.js";
import { Ground } from "./ground.js";
import { Items } from "./items.js";
import { Tags } from "./tags.js";
import { Traces } from "./traces.js";

const SAMPLES = 40; // times at which the extent of the motion is looked up
const FILLED = 1.06; // room around what is seen

export class View {
  constructor(content, bytes, motion, parent) {
    this.motion = motion;
    this.parent = parent;
    this.renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("aria-label", `${content.name} in motion`);
    parent.append(this.canvas);

    this.scene = new Scene();
    this.items = new Items(content, bytes, motion);
    this.arrows = new Arrows(content, motion);
    this.traces = new Traces(content, motion);
    this.frames = new Frames(content, motion);
    this.scene.add(this.items.group, this.arrows.group, this.traces.group, this.frames.group);
    this.tags = new Tags(content, motion, parent);

    this.up = new Vector3().fromArray(content.up);
    this.towards = new Vector3().fromArray(content.towards);
    if (Math.abs(this.towards.dot(this.up)) > 0.95) this.towards.add(new Vector3(0.5, 0.7, 0.3)).normalize();
    this.measure(content.size);
    this.light();
    this.camera = new PerspectiveCamera(32, 1, 0.02 * this.size, 40 * this.radius);
    this.camera.up.copy(this.up);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.zoomToCursor = true;
    this.followed = -1;
    this.dirty = true;
    this.controls.addEventListener("change", () => {
      this.dirty = true;
    });
    new ResizeObserver(() => this.resize()).observe(parent);
    this.resize();
    this.reset();
  }

  // Corners of all that moves, the sphere around them, and how low they come.
  measure(size) {
    const { motion } = this;
    this.corners = [];
    for (let k = 0; k <= SAMPLES; k++) {
      motion.moveTo(motion.start + (k / SAMPLES) * (motion.end - motion.start));
      this.items.update();
      for (const { mesh } of this.items.items) {
        mesh.updateMatrix();
        const { min, max } = mesh.geometry.boundingBox;
        for (let corner = 0; corner < 8; corner++) {
          const point = new Vector3(corner & 1 ? min.x : max.x, corner & 2 ? min.y : max.y, corner & 4 ? min.z : max.z);
          this.corners.push(point.applyMatrix4(mesh.matrix));
        }
      }
    }
    const box = new Box3().setFromPoints(this.corners);
    const sphere = box.getBoundingSphere(new Sphere());
    this.low = this.lowest(this.corners);
    // Feet that are the lowest parts at the start stand on the ground; other mechanisms move above it.
    this.first = this.corners.slice(0, 8 * this.items.items.length);
    const feet = this.first.filter((_, i) => this.items.items[i >> 3].layer === "ground");
    if (feet.length && this.lowest(feet) < this.lowest(this.first) + 0.05 * size) this.low = this.lowest(feet);
    this.centre = sphere.center.clone();
    this.size = size;
    this.radius = Math.max(sphere.radius, 0.3 * size);
    motion.moveTo(motion.start);
  }

  lowest(points) {
    return points.reduce((low, point) => Math.min(low, this.up.dot(point)), Number.POSITIVE_INFINITY);
  }

  light() {
    this.sky = new HemisphereLight("#ffffff", "#8d8f94", 1.5);
    this.sky.position.copy(this.up);
    this.sun = new DirectionalLight("#ffffff", 2.4);
    const side = new Vector3().crossVectors(this.up, this.towards).normalize();
    const from = this.up.clone().multiplyScalar(1.6).addScaledVector(this.towards, 0.7).addScaledVector(side, -0.8);
    this.sun.position.copy(this.centre).addScaledVector(from.normalize(), 3 * this.radius);
    this.sun.target.position.copy(this.centre);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    const { camera } = this.sun.shadow;
    camera.left = camera.bottom = -1.5 * this.radius;
    camera.right = camera.top = 1.5 * this.radius;
    camera.near = 0.5 * this.radius;
    camera.far = 8 * this.radius;
    this.sun.shadow.normalBias = 0.004 * this.radius;
    this.sun.shadow.radius = 3;
    const fill = new DirectionalLight("#dfe8ff", 0.7);
    fill.position
      .copy(this.centre)
      .addScaledVector(side, 2 * this.radius)
      .addScaledVector(this.towards, this.radius);
    fill.target.position.copy(this.centre);
    const beneath = this.centre
      .clone()
      .addScaledVector(this.up, this.low - 0.02 * this.radius - this.up.dot(this.centre));
    this.ground = new Ground(this.up, beneath, this.radius);
    this.scene.add(this.sky, this.sun, this.sun.target, fill, fill.target, this.ground.group);
  }

  paint({ background, grid }) {
    this.scene.background = new Color(background);
    this.ground.material.uniforms.color.value.set(grid);
    this.dirty = true;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.parent;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  // The camera that just sees everything, from `towards` or another direction; around a body that is followed, what is
  // there at the start.
  reset(towards = this.towards) {
    const right = new Vector3().crossVectors(this.up, towards).normalize();
    const above = new Vector3().crossVectors(towards, right);
    const seen = this.followed >= 0 ? this.first : this.corners;
    const range = (axis) => {
      const values = seen.map((corner) => corner.dot(axis));
      return values.reduce(([low, high], x) => [Math.min(low, x), Math.max(high, x)], [Infinity, -Infinity]);
    };
    const target = new Vector3();
    for (const axis of [right, above, towards]) {
      const [low, high] = range(axis);
      target.addScaledVector(axis, (low + high) / 2);
    }
    if (this.followed >= 0) target.fromArray(this.motion.bodies[this.followed].position.map((x) => x[0]));
    const tall = Math.tan((Math.PI / 360) * this.camera.fov) / FILLED;
    const wide = tall * this.camera.aspect;
    let distance = this.size;
    const arm = new Vector3();
    for (const corner of seen) {
      arm.subVectors(corner, target);
      const reach = Math.max(Math.abs(arm.dot(right)) / wide, Math.abs(arm.dot(above)) / tall);
      distance = Math.max(distance, arm.dot(towards) + reach);
    }
    if (this.followed >= 0) {
      distance *= 1.6; // it may turn
      target.copy(this.motion.poses[this.followed].position);
    }
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(towards, distance);
    this.controls.update();
    this.dirty = true;
  }

  follow(body) {
    this.followed = body;
    if (body >= 0) this.shift(this.motion.poses[body].position);
  }

  // Moves the camera so that it looks at a point as it looked at its target.
  shift(to) {
    SHIFT.subVectors(to, this.controls.target);
    if (SHIFT.lengthSq() === 0) return;
    this.camera.position.add(SHIFT);
    this.controls.target.copy(to);
    this.controls.update();
    this.dirty = true;
  }

  // Without shadows, for machines without a graphics card.
  lighten() {
    this.sun.castShadow = false;
    this.ground.shadow.visible = false;
    this.dirty = true;
  }

  draw() {
    if (this.followed >= 0) this.shift(this.motion.poses[this.followed].position);
    if (!this.dirty) return;
    this.dirty = false;
    this.items.update();
    this.arrows.update();
    this.traces.update();
    this.frames.update();
    this.renderer.render(this.scene, this.camera);
    this.tags.update(this.camera, this.parent.clientWidth, this.parent.clientHeight);
  }

  // Which body is seen at a pixel; -1 if none.
  bodyAt(x, y) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const pointer = new Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height);
    const ray = new Raycaster();
    ray.setFromCamera(pointer, this.camera);
    const [hit] = ray.intersectObject(this.items.group, true);
    return hit?.object.userData.body ?? -1;
  }

  // Pixel of a point of W, from the picture's corner.
  project(point) {
    this.camera.updateMatrixWorld();
    const seen = point.clone().project(this.camera);
    return { x: ((seen.x + 1) / 2) * this.parent.clientWidth, y: ((1 - seen.y) / 2) * this.parent.clientHeight };
  }
}

const SHIFT = new Vector3();
