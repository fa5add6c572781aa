// Axes of the bodies: x red, y green, z blue.
import { AxesHelper, Group } from "three";

export class Frames {
  constructor(scene, motion) {
    this.motion = motion;
    this.group = new Group();
    this.group.visible = false;
    this.axes = scene.bodies.map(() => {
      const axes = new AxesHelper(0.12 * scene.size);
      axes.material.depthTest = false;
      axes.renderOrder = 1;
      return axes;
    });
    this.world = new AxesHelper(0.2 * scene.size);
    this.group.add(this.world, ...this.axes);
  }

  update() {
    for (const [i, axes] of this.axes.entries()) {
      axes.position.copy(this.motion.poses[i].position);
      axes.quaternion.copy(this.motion.poses[i].quaternion);
    }
  }
}
