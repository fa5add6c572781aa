// Names beside what they name, as text over the picture; those that would cover others are left out.
import { Vector3 } from "three";

export const NAMES = ["none", "bodies", "all"];

export class Tags {
  constructor(scene, motion, parent) {
    this.motion = motion;
    this.mode = scene.bodies.length <= 10 ? "bodies" : "none";
    this.box = document.createElement("div");
    this.box.className = "tags";
    parent.append(this.box);
    this.tags = scene.tags.map((tag) => {
      const element = document.createElement("div");
      element.className = `tag ${tag.layer}`;
      element.textContent = tag.name;
      element.title = tag.detail;
      element.style.setProperty("--color", tag.layer === "body" ? motion.bodies[tag.point.body].color : tag.color);
      this.box.append(element);
      return { ...tag, element, width: 0 };
    });
  }

  update(camera, width, height) {
    const placed = [];
    for (const tag of this.tags) {
      const wanted = this.mode === "all" || (this.mode === "bodies" && tag.layer === "body");
      this.motion.place(tag.point, POINT).project(camera);
      const x = ((POINT.x + 1) / 2) * width + 10;
      const y = ((1 - POINT.y) / 2) * height - 22;
      if (!tag.width) tag.width = tag.element.offsetWidth;
      const inside = POINT.z < 1 && x > 0 && x + tag.width < width && y > 0 && y < height - 20;
      const free = placed.every(([a, b, w]) => Math.abs(b - y) > 19 || x > a + w + 4 || a > x + tag.width + 4);
      const shown = wanted && inside && free;
      tag.element.style.visibility = shown ? "visible" : "hidden";
      if (!shown) continue;
      placed.push([x, y, tag.width]);
      tag.element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
  }
}

const POINT = new Vector3();
