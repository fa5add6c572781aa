// A grid that fades out, and the shadow on it.
import { Color, Group, Mesh, PlaneGeometry, Quaternion, ShaderMaterial, ShadowMaterial, Vector3 } from "three";

const VERTEX = `
varying vec2 place;
void main() {
  place = position.xy;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const FRAGMENT = `
uniform vec3 color;
uniform float cell;
uniform float radius;
varying vec2 place;
float lines(float size) {
  vec2 x = place / size;
  vec2 width = fwidth(x);
  vec2 near = abs(fract(x - 0.5) - 0.5) / max(width, 1e-6);
  return (1.0 - min(min(near.x, near.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(width.x, width.y)));
}
void main() {
  float fade = 1.0 - smoothstep(0.25, 1.0, length(place) / radius);
  float strength = max(0.22 * lines(cell), 0.5 * lines(5.0 * cell)) * fade;
  if (strength < 0.01) discard;
  gl_FragColor = vec4(color, strength);
}`;

export class Ground {
  // centre: a point on the plane; radius: of what moves.
  constructor(up, centre, radius) {
    const far = 6 * radius;
    this.material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
      uniforms: { color: { value: new Color() }, cell: { value: nice(radius / 4) }, radius: { value: far } },
    });
    const plane = new PlaneGeometry(2 * far, 2 * far);
    const grid = new Mesh(plane, this.material);
    this.shadow = new Mesh(plane, new ShadowMaterial({ opacity: 0.22, depthWrite: false }));
    this.shadow.receiveShadow = true;
    grid.renderOrder = -1;
    this.shadow.renderOrder = -2;
    this.group = new Group().add(grid, this.shadow);
    this.group.position.copy(centre);
    this.group.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), up));
  }
}

// 1, 2 or 5 times a power of ten.
export function nice(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return [5, 2, 1].find((k) => k * power <= x) * power;
}
