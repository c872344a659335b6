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
    // In perspective, what is near the reader takes more room.
    const room = 0.86 - 0.15 * this.perspective;
    const least = 1e-9;
    this.scale = Math.min((room * this.width) / Math.max(high[0] - low[0], least), (room * this.height) / Math.max(high[1] - low[1], least));
  }

  /**
   * The yaw at which a path seen from above is largest; among nearly equal ones the smallest. Where the path mostly runs
   * in one direction or across it, as streets and aisles do, and that yaw nearly has it upright, exactly upright.
   */
  bestYaw(places: Places, path: Places = places): number {
    const trial = new Camera();
    Object.assign(trial, { width: this.width, height: this.height });
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
