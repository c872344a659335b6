// SPDX-License-Identifier: MIT
// The path from above and in 3-D, with landmarks, turns and the place that the reader points at. Drawn by hand on a
// canvas: tens of thousands of points take milliseconds also where there is no graphics card, and paper shows them.
import { Camera, type Places } from './camera';
import type { Rgb, Theme } from './colours';
import { css } from './colours';

export type { Places };

/** A turn's number, beside the middle of it. */
export interface Marker {
  index: number;
  first: number;
  last: number;
  label: string;
  used: boolean;
}

export interface PathContent {
  places: Places;
  colours: Rgb[];
  /** Ranges of points, first to last. */
  turns: [number, number][];
  predicted: [number, number][];
  reverse: [number, number][];
  markers: Marker[];
  /** Where the nose of the car points, degrees clockwise from the y axis; else it is where the path leads. */
  headings?: number[];
  /** What the last point is called. */
  last?: string;
}

const pathWidth = 4.5;
const hoverRadius = 48; // pixels within which the pointer takes hold of the path
const tilted = 0.62; // pitch of the 3-D view at first, rad
const flight = 450; // milliseconds from one view to the other

/** The largest of 1, 2 and 5 times a power of ten up to `length`. */
function roundLength(length: number): number {
  const decade = 10 ** Math.floor(Math.log10(length));
  return ([5, 2].find((factor) => factor * decade <= length) ?? 1) * decade;
}

/** The path, and the floor plan as far as it is not much larger. */
function withPlan(path: Places, outlines: number[][]): Places {
  const [low, high] = [[Infinity, Infinity], [-Infinity, -Infinity]];
  for (let i = 0; i < path.x.length; i++)
    [path.x[i], path.y[i]].forEach((value, k) => {
      low[k] = Math.min(low[k], value);
      high[k] = Math.max(high[k], value);
    });
  const room = 0.6 * Math.max(high[0] - low[0], high[1] - low[1]);
  const [x, y, z] = [Array.from(path.x), Array.from(path.y), Array.from(path.z)];
  for (const outline of outlines)
    for (let i = 0; i + 2 < outline.length; i += 3) {
      if ([0, 1].some((k) => outline[i + k] < low[k] - room || outline[i + k] > high[k] + room)) continue;
      x.push(outline[i]);
      y.push(outline[i + 1]);
      z.push(outline[i + 2]);
    }
  return { x, y, z };
}

export class PathView {
  onHover: (index: number) => void = () => {};
  onLeave: () => void = () => {};

  // Path and landmarks; above it what changes with every movement of the pointer.
  private readonly canvas = document.createElement('canvas');
  private readonly overlay = document.createElement('canvas');
  private readonly base: CanvasRenderingContext2D;
  // Landmarks are set pixel by pixel, which a canvas on a graphics card makes slow.
  private readonly dots = document.createElement('canvas').getContext('2d', { willReadFrequently: true })!;
  private readonly above: CanvasRenderingContext2D;
  private readonly camera = new Camera();
  private readonly pixel = new Float64Array(2);
  private in3d = false;
  private content: PathContent = { places: { x: [], y: [], z: [] }, colours: [], turns: [], predicted: [], reverse: [], markers: [] };
  private shown: Places = { x: [], y: [], z: [] }; // what has to be in view
  private sides = new Map<number, number>(); // of the turns' numbers, as found for the camera below
  private names: [number, number][] = []; // pixels of the ends' names
  private sidesOf = '';
  private screen = new Float64Array(); // pixels of the path's points
  private visible = new Uint8Array();
  private truth: Places | null = null;
  private outlines: number[][] = [];
  private landmarks = new Float32Array();
  private showLandmarks = true;
  private current = -1;
  private unit = 'm';
  private scheduled: 'nothing' | 'overlay' | 'moved' | 'all' = 'nothing';
  private settling = 0; // timer after which a picture that was only moved is drawn
  private baseCamera = { target: [0, 0, 0] as [number, number, number], scale: 1 };
  private baseTime = 0; // milliseconds that the base took
  private fitted = true; // nobody has moved the camera since
  private drawn = 0;
  private held = false; // the reader has clicked into the picture: the wheel zooms

  constructor(private readonly element: HTMLElement, private theme: Theme) {
    this.base = this.canvas.getContext('2d')!;
    this.above = this.overlay.getContext('2d')!;
    // What they show is in the text beside them.
    for (const canvas of [this.canvas, this.overlay]) canvas.setAttribute('aria-hidden', 'true');
    element.append(this.canvas, this.overlay);
    new ResizeObserver(() => this.resize()).observe(element);
    this.bindPointer();
  }

  /** Pictures drawn so far, for tests and measurements. */
  get pictures(): number { return this.drawn; }

  setUnit(unit: string): void { this.unit = unit; }
  setLandmarks(positions: Float32Array): void { this.landmarks = positions as Float32Array<ArrayBuffer>; }
  setTruth(truth: Places | null): void { this.truth = truth; }
  setOutlines(outlines: number[][]): void { this.outlines = outlines; }

  setPath(content: PathContent): void {
    this.content = content;
    this.screen = new Float64Array(2 * content.places.x.length);
    this.visible = new Uint8Array(content.places.x.length);
    this.shown = withPlan(content.places, this.outlines);
    this.sidesOf = '';
    this.draw();
  }

  setColours(colours: Rgb[]): void {
    this.content.colours = colours;
    this.draw();
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.draw();
  }

  setShowLandmarks(show: boolean): void {
    this.showLandmarks = show;
    this.draw();
  }

  setCurrent(index: number): void {
    this.current = index;
    this.schedule('overlay');
  }

  setView(in3d: boolean): void {
    if (this.in3d === in3d) return;
    this.in3d = in3d;
    const { camera } = this;
    const from = { ...camera };
    const to = new Camera();
    Object.assign(to, { width: camera.width, height: camera.height, perspective: in3d ? 1 : 0 });
    to.pitch = in3d ? tilted : Math.PI / 2;
    camera.margins = this.margins();
    to.yaw = camera.bestYaw(this.shown, this.content.places) - (in3d ? 0.35 : 0);
    this.fitAll(to);
    const jump = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
    const begin = performance.now();
    const step = (now: number) => {
      const passed = jump ? 1 : Math.min(Math.max((now - begin) / flight, 0), 1);
      const s = passed * passed * (3 - 2 * passed);
      for (const key of ['yaw', 'pitch', 'perspective'] as const) camera[key] = (1 - s) * from[key] + s * to[key];
      camera.scale = from.scale ** (1 - s) * to.scale ** s;
      camera.target = [0, 1, 2].map((k) => (1 - s) * from.target[k] + s * to.target[k]) as [number, number, number];
      this.drawNow();
      if (passed < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
    this.fitted = true;
  }

  /** Keeps the whole path in view as it grows, unless the reader has moved it. */
  follow(): void {
    if (this.fitted) this.fitAll();
    this.draw();
  }

  /** The whole path, as large as the element allows. */
  fit(): void {
    this.fitted = true;
    this.measure();
    this.camera.margins = this.margins();
    if (!this.in3d) this.camera.yaw = this.camera.bestYaw(this.shown, this.content.places);
    this.fitAll();
    this.draw();
  }

  /** Room for the numbers of turns and the names of the ends beside the path. */
  private margins(): [number, number, number] {
    const { width, height } = this.camera;
    const above = Math.min(36, 0.1 * height);
    return [Math.min(36, 0.1 * width), above, above];
  }

  /** With the path clear of the buttons and of the scale bar in the lower corners. */
  private fitAll(camera = this.camera): void {
    camera.margins = this.margins();
    camera.fit(this.shown);
    const { places: { x, y, z } } = this.content;
    const buttons = this.element.parentElement?.querySelector<HTMLElement>('.zoom');
    const [wide, high] = [Math.max(buttons?.offsetWidth ?? 0, 124) + 24, Math.max(buttons?.offsetHeight ?? 0, 28) + 34];
    camera.update();
    for (let i = 0; i < x.length; i++) {
      camera.project(x[i], y[i], z[i], this.pixel);
      const [px, py] = this.pixel;
      if (py < camera.height - high || (px > wide && px < camera.width - wide)) continue;
      camera.margins[2] = high;
      camera.fit(this.shown);
      return;
    }
  }

  zoomBy(factor: number): void {
    this.fitted = false;
    this.camera.zoom(factor);
    this.schedule('moved');
  }

  panBy(px: number, py: number): void {
    this.fitted = false;
    this.camera.pan(px, py);
    this.schedule('moved');
  }

  /** The wheel scrolls the page again. */
  letGo(): void {
    this.held = false;
    this.element.blur();
  }

  /** Paper shows what is clear in one canvas as white over the other: there, all is drawn into one. */
  private get top(): CanvasRenderingContext2D {
    return document.documentElement.classList.contains('paper') ? this.base : this.above;
  }

  private get ratio(): number { return Math.min(window.devicePixelRatio || 1, 2); }

  /** After a change of the element's size; by itself only after the browser's next layout. */
  resize(): void {
    const { camera } = this;
    this.measure();
    for (const canvas of [this.canvas, this.overlay, this.dots.canvas]) {
      canvas.width = Math.round(camera.width * this.ratio);
      canvas.height = Math.round(camera.height * this.ratio);
    }
    if (this.fitted) this.fitAll();
    this.drawNow();
  }

  private measure(): void {
    this.camera.width = Math.max(this.element.clientWidth, 1);
    this.camera.height = Math.max(this.element.clientHeight, 1);
  }

  private draw(): void { this.schedule('all'); }

  private schedule(what: 'overlay' | 'moved' | 'all'): void {
    const order = ['nothing', 'overlay', 'moved', 'all'];
    const before = this.scheduled;
    if (order.indexOf(what) > order.indexOf(before)) this.scheduled = what;
    if (before !== 'nothing') return;
    requestAnimationFrame(() => {
      const due = this.scheduled;
      if (due === 'all') this.drawNow();
      else if (due === 'moved') this.drawMoved();
      else if (due === 'overlay') this.drawOverlay();
    });
  }

  /** After the camera has moved: a picture that takes long is moved as it is, and drawn when the movement pauses. */
  private drawMoved(): void {
    const { camera, canvas, pixel } = this;
    const quick = 14;
    if (this.baseTime < quick || camera.perspective > 0) {
      this.drawNow();
      return;
    }
    camera.update();
    const { target, scale } = this.baseCamera;
    const factor = camera.scale / scale;
    camera.project(target[0], target[1], target[2], pixel);
    const shift = [pixel[0] - 0.5 * factor * camera.width, pixel[1] - 0.5 * factor * camera.height];
    canvas.style.transform = `translate(${shift[0]}px,${shift[1]}px) scale(${factor})`;
    this.drawOverlay();
    window.clearTimeout(this.settling);
    this.settling = window.setTimeout(() => this.draw(), 150);
  }

  /** Draws all at once. */
  drawNow(): void {
    const begin = performance.now();
    const { base: context, ratio, camera } = this;
    camera.update();
    this.baseCamera = { target: [...camera.target], scale: camera.scale };
    this.canvas.style.transform = '';
    window.clearTimeout(this.settling);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (this.showLandmarks) this.drawLandmarks();
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.lineCap = context.lineJoin = 'round';
    this.projectPath();
    this.drawOutlines();
    this.drawPath();
    this.drawTruth();
    this.baseTime = performance.now() - begin;
    this.drawOverlay();
  }

  private drawOverlay(): void {
    const { top: context, ratio, camera } = this;
    this.scheduled = 'nothing';
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (context !== this.base) context.clearRect(0, 0, camera.width, camera.height);
    context.font = '600 11px system-ui, sans-serif';
    context.lineCap = context.lineJoin = 'round';
    this.projectPath();
    this.drawMarkers();
    if (this.content.places.x.length > 0) this.drawScaleBar();
    if (this.current >= 0 && this.current < this.content.places.x.length) this.drawCurrent();
    this.drawn++;
  }

  private projectPath(): void {
    const { content: { places }, camera, pixel, screen, visible } = this;
    for (let i = 0; i < visible.length; i++) {
      visible[i] = camera.project(places.x[i], places.y[i], places.z[i], pixel) ? 1 : 0;
      screen[2 * i] = pixel[0];
      screen[2 * i + 1] = pixel[1];
    }
  }

  // Pixel by pixel: where many landmarks meet, the ground gets darker.
  private drawLandmarks(): void {
    const { landmarks, camera, pixel, ratio } = this;
    if (landmarks.length === 0) return;
    const { width, height } = this.canvas;
    const image = this.dots.createImageData(width, height);
    const values = new Uint32Array(image.data.buffer);
    const colour = parseInt(this.theme.landmark.slice(1), 16);
    const bgr = ((colour & 255) << 16) | (colour & 0xff00) | (colour >> 16);
    const dot = ratio > 1 ? 2 : 1;
    const step = this.theme.dark ? 110 : 90;
    for (let i = 0; i < landmarks.length; i += 3) {
      if (!camera.project(landmarks[i], landmarks[i + 1], landmarks[i + 2], pixel)) continue;
      const x = Math.round(pixel[0] * ratio);
      const y = Math.round(pixel[1] * ratio);
      if (x < 0 || y < 0 || x >= width - 1 || y >= height - 1) continue;
      for (let k = 0; k < dot * dot; k++) {
        const place = (y + (k >> 1)) * width + x + (k & 1);
        values[place] = (Math.min((values[place] >>> 24) + step, 235) << 24) | bgr;
      }
    }
    this.dots.putImageData(image, 0, 0);
    this.base.drawImage(this.dots.canvas, 0, 0);
  }

  // In pieces: a stroke of thousands of points that cross each other takes long.
  private stroke(places: Places, first: number, last: number): void {
    const { base: context, camera, pixel } = this;
    const piece = 200;
    for (let begin = first; begin < last; begin += piece) {
      let pen = false;
      context.beginPath();
      for (let i = begin; i <= Math.min(begin + piece, last); i++) {
        const visible = camera.project(places.x[i], places.y[i], places.z[i], pixel);
        if (visible && pen) context.lineTo(pixel[0], pixel[1]);
        else if (visible) context.moveTo(pixel[0], pixel[1]);
        pen = visible;
      }
      context.stroke();
    }
  }

  private drawOutlines(): void {
    const { base: context, camera, pixel, theme } = this;
    if (this.outlines.length === 0) return;
    context.beginPath();
    for (const outline of this.outlines) {
      let pen = false;
      for (let i = 0; i + 2 < outline.length; i += 3) {
        const visible = camera.project(outline[i], outline[i + 1], outline[i + 2], pixel);
        if (visible && pen) context.lineTo(pixel[0], pixel[1]);
        else if (visible) context.moveTo(pixel[0], pixel[1]);
        pen = visible;
      }
    }
    context.strokeStyle = theme.outline;
    context.lineWidth = 1.2;
    context.stroke();
  }

  // Thin, so that the colours of a path that is as good as the truth stay visible below.
  private drawTruth(): void {
    if (!this.truth) return;
    const { base: context, theme } = this;
    context.lineCap = 'butt';
    for (const [colour, width, dash, offset] of [[theme.panel, 2.8, [6, 10], 0], [theme.truth, 1.3, [4, 12], -1]] as const) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.setLineDash(dash);
      context.lineDashOffset = offset;
      this.stroke(this.truth, 0, this.truth.x.length - 1);
    }
    context.setLineDash([]);
    context.lineDashOffset = 0;
    context.lineCap = 'round';
  }

  private drawPath(): void {
    const { base: context, content, theme, screen, visible } = this;
    const { places } = content;
    const count = places.x.length;
    context.globalAlpha = 0.22;
    context.strokeStyle = theme.muted;
    context.lineWidth = 15;
    for (const [first, last] of content.turns) this.stroke(places, first, last);
    context.globalAlpha = 1;
    context.strokeStyle = theme.panel;
    context.lineWidth = pathWidth + 2.5;
    this.stroke(places, 0, count - 1);
    context.lineWidth = pathWidth;
    // As long as the colour stays the same to the eye, one stroke.
    const same = (a: Rgb, b: Rgb) => Math.abs(a[0] - b[0]) + Math.abs(a[1] - b[1]) + Math.abs(a[2] - b[2]) < 16;
    for (let i = 1; i < count; ) {
      const colour = content.colours[i];
      let j = i;
      context.beginPath();
      context.moveTo(screen[2 * i - 2], screen[2 * i - 1]);
      for (; j < count && same(colour, content.colours[j]); j++)
        if (visible[j] && visible[j - 1]) context.lineTo(screen[2 * j], screen[2 * j + 1]);
        else context.moveTo(screen[2 * j], screen[2 * j + 1]);
      context.strokeStyle = css(colour);
      context.stroke();
      i = j;
    }
    // Gaps make dashes of it.
    context.strokeStyle = theme.panel;
    context.lineWidth = pathWidth + 0.5;
    context.lineCap = 'butt';
    context.setLineDash([3, 7]);
    for (const [first, last] of content.reverse) this.stroke(places, first, last);
    context.setLineDash([]);
    context.lineCap = 'round';
    context.strokeStyle = theme.bad;
    context.lineWidth = pathWidth + 1;
    for (const [first, last] of content.predicted) this.stroke(places, first, last);
  }

  private drawMarkers(): void {
    const { top: context, content, theme, screen, visible } = this;
    const taken: [number, number][] = [];
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    // Overlapping markers are hidden until the user zooms in.
    const apart = content.markers.length > 40 ? 46 : 20;
    const count = content.places.x.length;
    this.names = [];
    if (count > 0) this.end(0, 'start');
    if (count > 1) this.end(count - 1, content.last ?? 'end');
    for (const { index, first, last, label, used } of content.markers) {
      const [px, py] = [screen[2 * index], screen[2 * index + 1]];
      if (!visible[index] || taken.some(([a, b]) => Math.abs(a - px) < apart && Math.abs(b - py) < apart)) continue;
      taken.push([px, py]);
      const [x, y] = this.besidePath(index, first, last);
      context.beginPath();
      context.arc(x, y, label.length > 2 ? 12 : 9.5, 0, 2 * Math.PI);
      context.lineWidth = 4.5;
      context.strokeStyle = theme.panel;
      context.stroke();
      context.fillStyle = used ? theme.ink : theme.panel;
      context.fill();
      context.lineWidth = 1.6;
      context.strokeStyle = theme.ink;
      context.stroke();
      context.fillStyle = used ? theme.panel : theme.ink;
      context.fillText(label, x, y + 0.5);
    }
  }

  /** Where the path leaves room for a number, and the arrow on the path does not hide it: outside of the curve if possible. */
  private besidePath(index: number, first: number, last: number): [number, number] {
    const { screen, visible } = this;
    const [x, y] = [screen[2 * index], screen[2 * index + 1]];
    const out = [x - 0.5 * (screen[2 * first] + screen[2 * last]), y - 0.5 * (screen[2 * first + 1] + screen[2 * last + 1])];
    const length = Math.hypot(out[0], out[1]);
    const beside = 22;
    const enough = 16 ** 2;
    const [u, v] = length > 2 ? [(beside * out[0]) / length, (beside * out[1]) / length] : [0, -beside];
    const offsets: [number, number][] = [[u, v], [-u, -v], [-v, u], [v, -u]];
    // The choice stays while the camera only shifts: it takes a look at the whole path.
    const { camera } = this;
    const look = `${camera.scale} ${camera.yaw} ${camera.pitch} ${camera.perspective}`;
    if (look !== this.sidesOf) this.sides.clear();
    this.sidesOf = look;
    let side = this.sides.get(index);
    if (side === undefined) {
      const clearances = offsets.map(([du, dv]) => {
        let clear = enough;
        for (let i = 0; i < visible.length; i += 2) clear = Math.min(clear, (screen[2 * i] - x - du) ** 2 + (screen[2 * i + 1] - y - dv) ** 2);
        for (const [a, b] of this.names) if (Math.abs(a - x - du) < 29 && Math.abs(b - y - dv) < 18) clear = 0;
        return clear;
      });
      side = clearances.indexOf(Math.max(...clearances));
      this.sides.set(index, side);
    }
    return [x + offsets[side][0], y + offsets[side][1]];
  }

  private end(index: number, text: string): void {
    const { top: context, screen, theme } = this;
    if (!this.visible[index]) return;
    const [x, y] = [screen[2 * index], screen[2 * index + 1]];
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fillStyle = theme.panel;
    context.fill();
    context.lineWidth = 2.5;
    context.strokeStyle = theme.ink;
    context.stroke();
    // On the side where the path is not.
    const step = index === 0 ? 1 : -1;
    let other = index + step;
    const { length } = this.visible;
    while (other > 0 && other < length - 1 && Math.hypot(screen[2 * other] - x, screen[2 * other + 1] - y) < 30) other += step;
    const beside = y + (screen[2 * other + 1] > y ? -17 : 17);
    this.names.push([x, beside]);
    this.label(text, x, beside);
  }

  private label(text: string, x: number, y: number): void {
    const { top: context, theme } = this;
    context.lineWidth = 4;
    context.strokeStyle = theme.panel;
    context.strokeText(text, x, y);
    context.fillStyle = theme.ink;
    context.fillText(text, x, y);
  }

  private drawScaleBar(): void {
    const { top: context, camera, theme } = this;
    const length = roundLength(110 / camera.scale);
    const width = length * camera.scale;
    const x = camera.width - 18 - width;
    const y = camera.height - 16;
    for (const [colour, thickness] of [[theme.panel, 6], [theme.ink, 2]] as const) {
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
    // In perspective, of what is in the middle of the picture.
    context.textAlign = camera.perspective > 0 ? 'right' : 'center';
    if (camera.perspective > 0) this.label(`${text} in the middle`, x + width, y - 12);
    else this.label(text, x + width / 2, y - 12);
  }

  private drawCurrent(): void {
    const { top: context, screen, theme, current } = this;
    if (!this.visible[current]) return;
    context.save();
    context.translate(screen[2 * current], screen[2 * current + 1]);
    context.rotate(this.directionOf(current));
    context.beginPath();
    context.moveTo(13, 0);
    context.lineTo(-9, -8.5);
    context.lineTo(-5, 0);
    context.lineTo(-9, 8.5);
    context.closePath();
    context.fillStyle = theme.ink;
    context.strokeStyle = theme.panel;
    context.lineWidth = 3;
    context.stroke();
    context.fill();
    context.restore();
  }

  /** Angle on the screen at which the car stands: its heading, which is not its direction of travel in reverse. */
  private directionOf(index: number): number {
    const { camera, content: { places, headings }, pixel, screen } = this;
    if (headings) {
      const angle = (headings[index] * Math.PI) / 180;
      const ahead = 12 / camera.scale;
      const [x, y, z] = [places.x[index] + ahead * Math.sin(angle), places.y[index] + ahead * Math.cos(angle), places.z[index]];
      if (camera.project(x, y, z, pixel)) return Math.atan2(pixel[1] - screen[2 * index + 1], pixel[0] - screen[2 * index]);
    }
    const last = places.x.length - 1;
    // Towards a point that is some pixels away, since a car that stands has no direction.
    let [a, b] = [index, index];
    const far = () => Math.hypot(screen[2 * b] - screen[2 * a], screen[2 * b + 1] - screen[2 * a + 1]) > 5;
    while (!far() && (a > 0 || b < last)) [a, b] = [Math.max(a - 1, 0), Math.min(b + 1, last)];
    return Math.atan2(screen[2 * b + 1] - screen[2 * a + 1], screen[2 * b] - screen[2 * a]);
  }

  private bindPointer(): void {
    const { element } = this;
    const pointers = new Map<number, { x: number; y: number }>();
    // The wheel scrolls the page until the reader has clicked into the picture, and one finger always does.
    element.style.touchAction = 'pan-y';
    element.addEventListener('contextmenu', (event) => event.preventDefault());
    element.addEventListener('pointerdown', (event) => {
      this.held = true;
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (event.pointerType === 'mouse') element.setPointerCapture(event.pointerId);
    });
    const release = (event: PointerEvent) => pointers.delete(event.pointerId);
    element.addEventListener('pointerup', release);
    element.addEventListener('pointercancel', release);
    element.addEventListener('pointerleave', () => {
      this.held = false;
      if (pointers.size === 0) this.onLeave();
    });
    element.addEventListener('click', (event) => this.hover(event));
    element.addEventListener('pointermove', (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) {
        this.hover(event);
        return;
      }
      const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const now = { x: event.clientX, y: event.clientY };
      pointers.set(event.pointerId, now);
      if (others.length > 0) this.pinch(others[0], before, now);
      else if (event.pointerType !== 'touch' || event.buttons > 0) this.drag(event, now.x - before.x, now.y - before.y);
    });
    element.addEventListener('wheel', (event) => {
      if (!this.held && !event.ctrlKey && document.activeElement !== element) return;
      event.preventDefault();
      const frame = element.getBoundingClientRect();
      this.fitted = false;
      this.camera.zoom(Math.exp(-event.deltaY * 0.0015), event.clientX - frame.left, event.clientY - frame.top);
      this.schedule('moved');
    }, { passive: false });
  }

  private drag(event: PointerEvent, px: number, py: number): void {
    this.fitted = false;
    const turns = this.in3d && !event.shiftKey && !(event.buttons & 2);
    if (turns) this.camera.orbit(px, py);
    else this.camera.pan(px, py);
    this.schedule('moved');
  }

  private pinch(other: { x: number; y: number }, before: { x: number; y: number }, now: { x: number; y: number }): void {
    const frame = this.element.getBoundingClientRect();
    const apart = (place: { x: number; y: number }) => Math.max(Math.hypot(place.x - other.x, place.y - other.y), 1);
    this.fitted = false;
    this.camera.zoom(apart(now) / apart(before), 0.5 * (now.x + other.x) - frame.left, 0.5 * (now.y + other.y) - frame.top);
    this.camera.pan(0.5 * (now.x - before.x), 0.5 * (now.y - before.y));
    this.schedule('moved');
  }

  private hover(event: MouseEvent): void {
    const frame = this.element.getBoundingClientRect();
    const [px, py] = [event.clientX - frame.left, event.clientY - frame.top];
    let best = -1;
    let closest = hoverRadius ** 2;
    for (let i = 0; i < this.visible.length; i++) {
      const distance = (this.screen[2 * i] - px) ** 2 + (this.screen[2 * i + 1] - py) ** 2;
      if (!this.visible[i] || distance >= closest) continue;
      closest = distance;
      best = i;
    }
    if (best >= 0) this.onHover(best);
  }
}
