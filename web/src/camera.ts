// SPDX-License-Identifier: MIT
// How the world is seen: from above, in parallel projection, or around, in perspective. Between the two it is moved
// smoothly.

export interface Places {
  x: ArrayLike<number>;
  y: ArrayLike<number>;
  z: ArrayLike<number>;
}

export type Point3 = [number, number, number];

const above = Math.PI / 2;
const nearest = 0.08; // share of the camera's distance in front of which nothing is drawn

export class Camera {
  target: Point3 = [0, 0, 0];
  yaw = 0;
  pitch = above;
  /** Pixels per unit of length at the target. */
  scale = 1;
  /** 0: parallel projection, 1: perspective. */
  perspective = 0;
  width = 1;
  height = 1;
  /** Pixels to be left free at the edges when all places are shown: at the sides, at the top and at the bottom. */
  margins: Point3 = [0, 0, 0];

  // Rows of the rotation to the right, up and away from the camera.
  private right: Point3 = [1, 0, 0];
  private up: Point3 = [0, 1, 0];
  private away: Point3 = [0, 0, -1];

  /** After any change of the fields above. */
  update(): void {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    this.right = [cy, -sy, 0];
    this.up = [sy * sp, cy * sp, cp];
    this.away = [sy * cp, cy * cp, -sp];
  }

  /** Distance of the camera from its target, in units of length. */
  private get distance(): number { return (1.5 * Math.max(this.width, this.height)) / this.scale; }

  /** Projects a point; false if it is behind the camera. */
  project(x: number, y: number, z: number, to: Float64Array): boolean {
    const dx = x - this.target[0];
    const dy = y - this.target[1];
    const dz = z - this.target[2];
    const { right, up, away } = this;
    const depth = 1 + (this.perspective * (away[0] * dx + away[1] * dy + away[2] * dz)) / this.distance;
    if (depth < nearest) return false;
    const scale = this.scale / depth;
    to[0] = 0.5 * this.width + scale * (right[0] * dx + right[1] * dy);
    to[1] = 0.5 * this.height - scale * (up[0] * dx + up[1] * dy + up[2] * dz);
    return true;
  }

  /** Moves the target so that the picture follows the pointer, pixels. */
  pan(px: number, py: number): void {
    // Along the ground: a car's path is flat, and stays in view.
    const ahead = Math.max(Math.sin(this.pitch), 0.25);
    const u = -px / this.scale;
    const v = py / this.scale / ahead;
    const [c, s] = [Math.cos(this.yaw), Math.sin(this.yaw)];
    this.target = [this.target[0] + c * u + s * v, this.target[1] - s * u + c * v, this.target[2]];
  }

  orbit(px: number, py: number): void {
    this.yaw += px * 0.006;
    this.pitch = Math.min(Math.max(this.pitch + py * 0.006, 0.06), above);
  }

  /** Keeps what is at this pixel in its place. */
  zoom(factor: number, px = 0.5 * this.width, py = 0.5 * this.height): void {
    const [x, y] = [px - 0.5 * this.width, py - 0.5 * this.height];
    this.pan(-x, -y);
    this.scale *= factor;
    this.pan(x, y);
  }

  /** Shows all places, as large as possible. */
  fit({ x, y, z }: Places): void {
    this.update();
    const { right, up, away } = this;
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < x.length; i++) {
      [right, up, away].forEach((axis, k) => {
        const value = axis[0] * x[i] + axis[1] * y[i] + axis[2] * z[i];
        low[k] = Math.min(low[k], value);
        high[k] = Math.max(high[k], value);
      });
    }
    if (x.length === 0) [low, high].forEach((corner, k) => corner.fill(k));
    const middle = low.map((value, k) => 0.5 * (value + high[k]));
    this.target = [0, 1, 2].map((k) => middle[0] * right[k] + middle[1] * up[k] + middle[2] * away[k]) as Point3;
    const [left, top, bottom] = this.margins;
    const [wide, tall] = [Math.max(this.width - 2 * left, 10), Math.max(this.height - top - bottom, 10)];
    const least = 1e-9;
    this.scale = Math.min(wide / Math.max(high[0] - low[0], least), tall / Math.max(high[1] - low[1], least));
    this.shift(0, 0.5 * (bottom - top));
    // In perspective, what is near the reader takes more room.
    for (let i = 0; this.perspective > 0 && i < 6; i++) {
      const [x0, y0, x1, y1] = this.extent({ x, y, z });
      const factor = Math.min(wide / Math.max(x1 - x0, 1), tall / Math.max(y1 - y0, 1));
      this.shift(0.5 * (x0 + x1 - this.width), 0.5 * (y0 + y1 - top - (this.height - bottom)));
      this.scale *= Math.min(Math.max(factor, 0.5), 2);
    }
  }

  /** Moves the target by pixels to the right and down on the screen. */
  private shift(px: number, py: number): void {
    const { right, up, scale } = this;
    this.target = this.target.map((value, k) => value + (px * right[k] - py * up[k]) / scale) as Point3;
  }

  /** Least and greatest pixels of the places. */
  private extent({ x, y, z }: Places): [number, number, number, number] {
    const pixel = new Float64Array(2);
    let [x0, y0, x1, y1] = [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 0; i < x.length; i++) {
      if (!this.project(x[i], y[i], z[i], pixel)) return [-this.width, -this.height, 2 * this.width, 2 * this.height];
      [x0, y0, x1, y1] = [Math.min(x0, pixel[0]), Math.min(y0, pixel[1]), Math.max(x1, pixel[0]), Math.max(y1, pixel[1])];
    }
    return x.length > 0 ? [x0, y0, x1, y1] : [0, 0, this.width, this.height];
  }

  /**
   * The yaw at which a path seen from above is largest; among nearly equal ones the smallest. Where the path mostly runs
   * in one direction or across it, as streets and aisles do, and that yaw nearly has it upright, exactly upright.
   */
  bestYaw(places: Places, path: Places = places): number {
    const trial = new Camera();
    Object.assign(trial, { width: this.width, height: this.height, margins: this.margins });
    let best = 0;
    let largest = 0;
    for (let step = 0; step <= 18; step++) {
      for (const sign of [1, -1]) {
        trial.yaw = (sign * step * Math.PI) / 36;
        trial.fit(places);
        if (trial.scale < 1.03 * largest) continue;
        largest = trial.scale;
        best = trial.yaw;
      }
    }
    const direction = commonDirection(path);
    if (direction === null) return best;
    const off = quarter(best + direction);
    const within = (10 * Math.PI) / 180;
    return Math.abs(off) <= within ? best - off : best;
  }
}

/** The angle's distance from the nearest quarter of a turn. */
const quarter = (angle: number): number => angle - Math.round(angle / (Math.PI / 2)) * (Math.PI / 2);

/** The direction, to a quarter of a turn, along which much of the path runs; null if there is none. */
function commonDirection({ x, y }: Places): number | null {
  const count = Math.max(x.length - 1, 0);
  const angles = new Float64Array(count);
  const lengths = new Float64Array(count);
  const bins = new Float64Array(45); // of two degrees
  let all = 0;
  for (let i = 0; i < count; i++) {
    lengths[i] = Math.hypot(x[i + 1] - x[i], y[i + 1] - y[i]);
    angles[i] = quarter(Math.atan2(y[i + 1] - y[i], x[i + 1] - x[i]));
    bins[Math.min(Math.floor((angles[i] / (Math.PI / 2) + 0.5) * bins.length), bins.length - 1)] += lengths[i];
    all += lengths[i];
  }
  let best = ((bins.indexOf(Math.max(...bins)) + 0.5) / bins.length - 0.5) * (Math.PI / 2);
  let together = 0;
  // The mean of what is near, twice: a bin cuts it off.
  for (const near of [3, 1.5]) {
    let sum = 0;
    together = 0;
    for (let i = 0; i < count; i++) {
      const off = quarter(angles[i] - best);
      if (Math.abs(off) > (near * Math.PI) / 180) continue;
      sum += lengths[i] * off;
      together += lengths[i];
    }
    best += sum / Math.max(together, 1e-12);
  }
  return together < 0.3 * all || all === 0 ? null : best;
}
