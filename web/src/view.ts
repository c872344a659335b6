// SPDX-License-Identifier: MIT
// The path from above and in 3-D, with landmarks, turns and the place that the reader points at.
import {
  BufferAttribute, BufferGeometry, Camera, Color, Group, OrthographicCamera, PerspectiveCamera, Points,
  PointsMaterial, Scene, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import type { Rgb, Theme } from './colours';

export interface Places {
  x: ArrayLike<number>;
  y: ArrayLike<number>;
  z: ArrayLike<number>;
}

export interface Marker {
  index: number;
  label: string;
  used: boolean;
}

interface Box {
  centre: Vector3;
  size: Vector3;
}

const pathWidth = 4.5;
const hoverRadius = 48; // pixels within which the pointer takes hold of the path

function boxOf({ x, y, z }: Places): Box {
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = new Vector3(-Infinity, -Infinity, -Infinity);
  const point = new Vector3();
  for (let i = 0; i < x.length; i++) {
    point.set(x[i], y[i], z[i]);
    low.min(point);
    high.max(point);
  }
  if (x.length === 0) return { centre: new Vector3(), size: new Vector3(1, 1, 0) };
  return { centre: low.clone().add(high).multiplyScalar(0.5), size: high.sub(low) };
}

// LineGeometry wants plain arrays: x, y, z of one point after another.
function flat({ x, y, z }: Places, first: number, last: number): number[] {
  const positions: number[] = [];
  for (let i = first; i <= last; i++) positions.push(x[i], y[i], z[i]);
  return positions;
}

/** Round lengths: the largest 1, 2 or 5 times a power of ten up to `length`. */
function roundLength(length: number): number {
  const decade = 10 ** Math.floor(Math.log10(length));
  return ([5, 2].find((factor) => factor * decade <= length) ?? 1) * decade;
}

export class PathView {
  onHover: (index: number) => void = () => {};

  private readonly overlay: HTMLCanvasElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly renderer: WebGLRenderer | null;
  private readonly scene = new Scene();
  private readonly above = new OrthographicCamera(-1, 1, 1, -1, -1e5, 1e5);
  private readonly around = new PerspectiveCamera(45, 1, 0.1, 1e5);
  private readonly controls: OrbitControls[] = [];
  private readonly content = new Group();
  private readonly lines: LineMaterial[] = [];
  private in3d = false;
  private theme: Theme;
  private places: Places = { x: [], y: [], z: [] };
  private colours: Rgb[] = [];
  private predicted: [number, number][] = [];
  private turns: [number, number][] = [];
  private markers: Marker[] = [];
  private truth: Places | null = null;
  private outlines: number[][] = [];
  private landmarks = new Float32Array();
  private showLandmarks = true;
  private current = -1;
  private unit = 'm';
  private scheduled = false;
  private box: Box = boxOf(this.places);
  private frames = 0;

  constructor(private readonly element: HTMLElement, theme: Theme) {
    this.theme = theme;
    this.canvas = document.createElement('canvas');
    this.overlay = document.createElement('canvas');
    this.overlay.className = 'overlay';
    element.append(this.canvas, this.overlay);
    this.renderer = this.makeRenderer();
    this.scene.add(this.content);
    this.above.up.set(0, 1, 0);
    this.around.up.set(0, 0, 1);
    if (this.renderer) this.makeControls();
    new ResizeObserver(() => this.resize()).observe(element);
    element.addEventListener('pointermove', (event) => this.hover(event));
    element.addEventListener('click', (event) => this.hover(event));
  }

  get hasWebGl(): boolean { return this.renderer !== null; }
  /** Pictures drawn so far, for tests and measurements. */
  get pictures(): number { return this.frames; }

  private makeRenderer(): WebGLRenderer | null {
    try {
      // The buffer is kept so that the picture can be printed.
      const renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
      renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      return renderer;
    } catch {
      this.canvas.remove();
      return null;
    }
  }

  private makeControls(): void {
    for (const camera of [this.above, this.around]) {
      const controls = new OrbitControls(camera, this.element);
      const is3d = camera === this.around;
      controls.enableRotate = is3d;
      controls.screenSpacePanning = !is3d;
      controls.zoomToCursor = true;
      controls.enabled = is3d === this.in3d;
      controls.maxPolarAngle = Math.PI * 0.495;
      if (!is3d) {
        controls.mouseButtons.LEFT = 2; // pan
        controls.touches.ONE = 1; // pan
      }
      controls.addEventListener('change', () => this.draw());
      this.controls.push(controls);
    }
    this.element.style.touchAction = 'pan-y';
    // The wheel scrolls the page until the reader has clicked into the picture.
    const zooms = (on: boolean) => this.controls.forEach((controls) => { controls.enableZoom = on; });
    zooms(false);
    this.element.addEventListener('pointerdown', () => zooms(true));
    this.element.addEventListener('focusin', () => zooms(true));
    this.element.addEventListener('pointerleave', () => zooms(false));
  }

  setUnit(unit: string): void { this.unit = unit; }
  setLandmarks(positions: Float32Array): void { this.landmarks = positions as Float32Array<ArrayBuffer>; }
  setTruth(truth: Places | null): void { this.truth = truth; }
  setOutlines(outlines: number[][]): void { this.outlines = outlines; }

  /** `turns` and `predicted` are ranges of points, first to last. */
  setPath(places: Places, colours: Rgb[], turns: [number, number][], markers: Marker[], predicted: [number, number][] = []): void {
    this.places = places;
    this.colours = colours;
    this.turns = turns;
    this.markers = markers;
    this.predicted = predicted;
    this.box = boxOf(places);
    this.build();
  }

  setColours(colours: Rgb[]): void {
    this.colours = colours;
    this.build();
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.build();
  }

  setShowLandmarks(show: boolean): void {
    this.showLandmarks = show;
    this.build();
  }

  setView(in3d: boolean): void {
    this.in3d = in3d;
    this.controls.forEach((controls, i) => { controls.enabled = (i === 1) === in3d; });
    this.draw();
  }

  setCurrent(index: number): void {
    this.current = index;
    this.draw();
  }

  /** The whole path, as large as the element allows. */
  fit(): void {
    const { centre, size } = this.box;
    const aspect = this.element.clientWidth / Math.max(this.element.clientHeight, 1);
    const room = 1.16;
    const half = 0.5 * room * Math.max(size.y, size.x / aspect, 2);
    this.above.position.set(centre.x, centre.y, centre.z + 1);
    this.above.zoom = 1;
    this.above.userData.half = half;
    const reach = 0.62 * Math.max(Math.hypot(size.x, size.y), 4) / Math.min(1, aspect * 0.8) / Math.tan((Math.PI * 45) / 360);
    this.around.position.set(centre.x - 0.28 * reach, centre.y - 0.68 * reach, centre.z + 0.56 * reach);
    this.around.near = reach / 500;
    this.around.far = reach * 20;
    this.controls.forEach((controls) => {
      controls.target.copy(centre);
      controls.update();
    });
    this.resize();
  }

  zoomBy(factor: number): void {
    if (this.in3d) {
      const target = this.controls[1]?.target ?? this.box.centre;
      this.around.position.sub(target).divideScalar(factor).add(target);
      this.controls[1]?.update();
    } else {
      this.above.zoom *= factor;
      this.above.updateProjectionMatrix();
    }
    this.draw();
  }

  private resize(): void {
    const width = this.element.clientWidth;
    const height = Math.max(this.element.clientHeight, 1);
    const ratio = Math.min(window.devicePixelRatio, 2);
    this.renderer?.setSize(width, height, false);
    this.overlay.width = width * ratio;
    this.overlay.height = height * ratio;
    const half = (this.above.userData.half as number | undefined) ?? 1;
    Object.assign(this.above, { left: (-half * width) / height, right: (half * width) / height, top: half, bottom: -half });
    this.above.updateProjectionMatrix();
    this.around.aspect = width / height;
    this.around.updateProjectionMatrix();
    for (const material of this.lines) material.resolution.set(width, height);
    this.drawNow();
  }

  private addLine(positions: number[], options: ConstructorParameters<typeof LineMaterial>[0], colours?: number[], order = 0): void {
    if (positions.length < 6) return;
    const geometry = new LineGeometry();
    geometry.setPositions(positions);
    if (colours) geometry.setColors(colours);
    this.addMesh(new Line2(geometry, this.lineMaterial(options, colours !== undefined)), order);
  }

  private lineMaterial(options: ConstructorParameters<typeof LineMaterial>[0], coloured: boolean): LineMaterial {
    const material = new LineMaterial({ ...options, vertexColors: coloured, depthTest: false, transparent: true });
    material.resolution.set(this.element.clientWidth, this.element.clientHeight);
    this.lines.push(material);
    return material;
  }

  private addMesh(mesh: Line2 | LineSegments2 | Points, order: number): void {
    mesh.renderOrder = order;
    mesh.frustumCulled = false;
    this.content.add(mesh);
  }

  private build(): void {
    if (this.renderer) {
      for (const child of this.content.children as (Points | Line2)[]) {
        child.geometry.dispose();
        (Array.isArray(child.material) ? child.material : [child.material]).forEach((material) => material.dispose());
      }
      this.content.clear();
      this.lines.length = 0;
      this.buildContent();
    }
    this.draw();
  }

  private buildContent(): void {
    const { theme } = this;
    const color = (text: string) => new Color(text);
    if (this.showLandmarks && this.landmarks.length) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(this.landmarks, 3));
      const material = new PointsMaterial({
        color: color(theme.landmark), size: 1.6, sizeAttenuation: false, transparent: true, opacity: theme.dark ? 0.75 : 0.55,
        depthTest: false,
      });
      this.addMesh(new Points(geometry, material), 0);
    }
    if (this.outlines.length) {
      const geometry = new LineSegmentsGeometry();
      const segments: number[] = [];
      for (const outline of this.outlines)
        for (let i = 0; i + 5 < outline.length; i += 3) segments.push(...outline.slice(i, i + 6));
      geometry.setPositions(segments);
      this.addMesh(new LineSegments2(geometry, this.lineMaterial({ color: color(theme.line), linewidth: 1.2 }, false)), 1);
    }
    if (this.truth)
      this.addLine(flat(this.truth, 0, this.truth.x.length - 1), { color: color(theme.truth), linewidth: 2.2 }, undefined, 2);
    for (const [first, last] of this.turns)
      this.addLine(flat(this.places, first, last), { color: color(theme.turn), linewidth: 13, opacity: 0.3 }, undefined, 3);
    const all = flat(this.places, 0, this.places.x.length - 1);
    this.addLine(all, { color: color(theme.panel), linewidth: pathWidth + 3 }, undefined, 4);
    const colour = new Color();
    const colours = this.colours.flatMap(([r, g, b]) => colour.setRGB(r / 255, g / 255, b / 255, 'srgb').toArray());
    this.addLine(all, { linewidth: pathWidth }, colours, 5);
    for (const [first, last] of this.predicted)
      this.addLine(flat(this.places, first, last), { color: color(theme.bad), linewidth: pathWidth + 1 }, undefined, 6);
  }

  private draw(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => this.drawNow());
  }

  drawNow(): void {
    this.scheduled = false;
    const camera: Camera = this.in3d ? this.around : this.above;
    camera.updateMatrixWorld();
    this.renderer?.render(this.scene, camera);
    this.drawOverlay();
    this.frames++;
  }

  private project(places: Places, i: number): [number, number, boolean] {
    const point = new Vector3(places.x[i], places.y[i], places.z[i]).project(this.in3d ? this.around : this.above);
    return [0.5 * (point.x + 1) * this.element.clientWidth, 0.5 * (1 - point.y) * this.element.clientHeight, point.z < 1];
  }

  private drawOverlay(): void {
    const context = this.overlay.getContext('2d');
    if (!context) return;
    const ratio = this.overlay.width / Math.max(this.element.clientWidth, 1);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.overlay.width, this.overlay.height);
    context.font = '600 11px system-ui, sans-serif';
    if (!this.renderer) this.drawFlat(context);
    this.drawMarkers(context);
    if (!this.in3d) this.drawScaleBar(context);
    if (this.current >= 0 && this.current < this.places.x.length) this.drawCurrent(context);
  }

  // Without WebGL: the path alone, from above.
  private drawFlat(context: CanvasRenderingContext2D): void {
    context.lineWidth = pathWidth;
    context.lineCap = 'round';
    for (let i = 1; i < this.places.x.length; i++) {
      const [r, g, b] = this.colours[i];
      context.strokeStyle = `rgb(${r | 0},${g | 0},${b | 0})`;
      context.beginPath();
      context.moveTo(...(this.project(this.places, i - 1).slice(0, 2) as [number, number]));
      context.lineTo(...(this.project(this.places, i).slice(0, 2) as [number, number]));
      context.stroke();
    }
  }

  private drawMarkers(context: CanvasRenderingContext2D): void {
    const { theme } = this;
    const taken: [number, number][] = [];
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    for (const { index, label, used } of this.markers) {
      const [x, y, visible] = this.project(this.places, index);
      // Away from the path: to the outer side, seen from the middle of the drive.
      if (!visible || taken.some(([a, b]) => Math.abs(a - x) < 20 && Math.abs(b - y) < 20)) continue;
      taken.push([x, y]);
      const radius = label.length > 2 ? 12 : 9.5;
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.fillStyle = used ? theme.turn : theme.panel;
      context.fill();
      context.lineWidth = 2;
      context.strokeStyle = used ? theme.panel : theme.turn;
      context.stroke();
      context.fillStyle = used ? (theme.dark ? '#1a1006' : '#fff') : theme.turn;
      context.fillText(label, x, y + 0.5);
    }
    const count = this.places.x.length;
    if (count === 0) return;
    this.flag(context, 0, 'start');
    if (count > 1) this.flag(context, count - 1, 'end');
  }

  private flag(context: CanvasRenderingContext2D, index: number, text: string): void {
    const [x, y, visible] = this.project(this.places, index);
    if (!visible) return;
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fillStyle = this.theme.panel;
    context.fill();
    context.lineWidth = 2.5;
    context.strokeStyle = this.theme.ink;
    context.stroke();
    this.label(context, text, x, y + (text === 'start' ? 17 : -17));
  }

  private label(context: CanvasRenderingContext2D, text: string, x: number, y: number): void {
    context.lineWidth = 4;
    context.lineJoin = 'round';
    context.strokeStyle = this.theme.panel;
    context.strokeText(text, x, y);
    context.fillStyle = this.theme.ink;
    context.fillText(text, x, y);
  }

  private drawScaleBar(context: CanvasRenderingContext2D): void {
    const perPixel = (this.above.top - this.above.bottom) / this.above.zoom / Math.max(this.element.clientHeight, 1);
    const length = roundLength(110 * perPixel);
    const width = length / perPixel;
    const x = this.element.clientWidth - 18 - width;
    const y = this.element.clientHeight - 18;
    for (const [colour, thickness] of [[this.theme.panel, 6], [this.theme.ink, 2]] as const) {
      context.beginPath();
      context.moveTo(x, y - 5);
      context.lineTo(x, y);
      context.lineTo(x + width, y);
      context.lineTo(x + width, y - 5);
      context.strokeStyle = colour;
      context.lineWidth = thickness;
      context.stroke();
    }
    const text = length >= 1000 && this.unit === 'm' ? `${length / 1000} km` : `${+length.toPrecision(3)} ${this.unit}`;
    this.label(context, text, x + width / 2, y - 12);
  }

  private drawCurrent(context: CanvasRenderingContext2D): void {
    const [x, y] = this.project(this.places, this.current);
    const last = this.places.x.length - 1;
    const [ax, ay] = this.project(this.places, Math.max(this.current - 2, 0));
    const [bx, by] = this.project(this.places, Math.min(this.current + 2, last));
    context.save();
    context.translate(x, y);
    context.rotate(Math.atan2(by - ay, bx - ax));
    context.beginPath();
    context.moveTo(13, 0);
    context.lineTo(-9, -8.5);
    context.lineTo(-5, 0);
    context.lineTo(-9, 8.5);
    context.closePath();
    context.fillStyle = this.theme.ink;
    context.strokeStyle = this.theme.panel;
    context.lineWidth = 3;
    context.lineJoin = 'round';
    context.stroke();
    context.fill();
    context.restore();
  }

  private hover(event: PointerEvent | MouseEvent): void {
    if (event.buttons > 0 && event.type !== 'click') return;
    const frame = this.element.getBoundingClientRect();
    const [px, py] = [event.clientX - frame.left, event.clientY - frame.top];
    let best = -1;
    let closest = hoverRadius ** 2;
    for (let i = 0; i < this.places.x.length; i++) {
      const [x, y, visible] = this.project(this.places, i);
      const distance = (x - px) ** 2 + (y - py) ** 2;
      if (!visible || distance >= closest) continue;
      closest = distance;
      best = i;
    }
    if (best >= 0) this.onHover(best);
  }
}
