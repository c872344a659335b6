// SPDX-License-Identifier: MIT
// What the program writes into the page (report/report_data.cpp), and how the page reads it.

/** One entry per point of the path; axes: x right, y ahead at the start, z up. */
export interface Path {
  time: number[];
  frame: number[];
  x: number[];
  y: number[];
  z: number[];
  /** Where the nose points, degrees clockwise from the y axis, and the length of the path so far. Pages of earlier versions lack both. */
  heading?: number[];
  driven?: number[];
  /** m/s with its standard deviation; empty if the drive has no metres. */
  speed: (number | null)[];
  speedSigma: (number | null)[];
  /** Relative standard deviation of the scale; null while it is pending. */
  sigma: (number | null)[];
  /** A letter per point: p pending, o observed, h held, r from the road; empty if it is not known. */
  scaleState: string;
  /** A letter per point: t tracked, r repeated, b bridged, u unreadable, i before the first map; empty likewise. */
  tracking: string;
}

export interface Turn {
  from: number;
  to: number;
  angle: number;
  speed: number | null;
  scale: number | null;
  sigma: number | null;
  smoothed: number | null;
  deviation: number | null;
  leverArm: number | null;
  used: boolean;
  reason: string;
}

export interface Thumbnail {
  time: number;
  frame: number;
  why: 'drive' | 'turn' | 'lost';
  /** The file in base64; its comments hold what was tracked (Features). */
  jpeg: string;
}

export interface Report {
  title: string;
  version: string;
  unit: 'm' | 'units';
  /** Else the times are the numbers of the poses. Pages of earlier versions lack this and the next. */
  timed?: boolean;
  /** Seconds that are time 0 of the page; since 1970 if they are large. */
  timeOrigin?: number;
  notes: string[];
  warnings: string[];
  facts: { name: string; value: string; note: string }[];
  path: Path;
  landmarks: { low: [number, number, number]; step: number; data: string } | null;
  turns: Turn[];
  scale: { time: number[]; value: number[]; sigma: (number | null)[] } | null;
  rotation: {
    time: number[];
    yaw: number[];
    pitch: number[];
    roll: number[];
    yawSigma: (number | null)[];
    pitchSigma: (number | null)[];
    rollSigma: (number | null)[];
  } | null;
  thumbnails: Thumbnail[];
  /** Errors are in metres. Of a path without metres: the truth is scaled by 1 / metresPerUnit and laid on the whole path. */
  truth: { metresPerUnit?: number | null; time: number[]; x: number[]; y: number[]; z: number[]; error: (number | null)[] } | null;
  errors: { name: string; value: string; note: string }[];
  outlines: number[][];
  settings: string;
}

/** Positions of landmarks, three numbers each. They are stored as 16-bit steps above their lowest corner. */
export function decodeLandmarks(landmarks: Report['landmarks']): Float32Array {
  if (!landmarks) return new Float32Array();
  const bytes = Uint8Array.from(atob(landmarks.data), (letter) => letter.charCodeAt(0));
  const steps = new DataView(bytes.buffer);
  const positions = new Float32Array(bytes.length / 2);
  for (let i = 0; i < positions.length; i++)
    positions[i] = landmarks.low[i % 3] + landmarks.step * steps.getUint16(2 * i, true);
  return positions;
}

/** Index of the point whose time is closest. */
export function closestIndex(times: readonly number[], time: number): number {
  let low = 0;
  let high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return high >= 0 && time - times[low] > times[high] - time ? high : low;
}

/** Where the scale comes from, in words; with the program's own term where that differs. */
export const scaleStateNames: Record<string, string> = {
  p: 'not known yet',
  o: 'the turn itself',
  h: 'carried over from turns',
  r: 'height above the road',
};
export const scaleStateTerms: Record<string, string> = { p: 'pending', o: 'observed', h: 'held', r: 'road' };
export const trackingNames: Record<string, string> = {
  t: 'tracked',
  r: 'repeated image',
  b: 'lost, pose not measured',
  u: 'no readable image, pose not measured',
  i: 'before the first map',
};

/** A place along the drive in words: its time, or the number of its pose. */
export const placeText = (report: Report, time: number): string => (report.timed === false ? `pose ${Math.round(time)}` : clock(time));

/** When the drive began, if its times tell; else the time stamp that the page counts from; empty if that is about 0. */
export function originText({ timeOrigin = 0 }: Report): string {
  const sinceEpoch = 3e8;
  const leastShown = 0.05;
  if (timeOrigin > sinceEpoch) return `Began ${new Date(1000 * timeOrigin).toISOString().slice(0, 19).replace('T', ' ')} UTC`;
  return timeOrigin >= leastShown ? `Time 0 is ${timeOrigin.toFixed(2)} s in the files` : '';
}

export function clock(seconds: number): string {
  const tenths = Math.round(Math.max(seconds, 0) * 10);
  const whole = Math.floor(tenths / 10);
  const pad = (n: number) => String(n).padStart(2, '0');
  const hours = Math.floor(whole / 3600);
  const minutes = Math.floor(whole / 60) % 60;
  return `${hours ? `${hours}:${pad(minutes)}` : minutes}:${pad(whole % 60)}.${tenths % 10}`;
}

/** Moments in a text as `clock` writes them. */
export const momentPattern = /\b(?:\d+:)?\d{1,2}:\d\d\.\d\b/g;

/** The seconds of such a moment. */
export const secondsOf = (moment: string): number => moment.split(':').reduce((sum, part) => 60 * sum + Number(part), 0);

/** What a title names: the file or folder, with the folder above where its own name says little. */
export function shortTitle(title: string): string {
  const parts = title.split('/').filter(Boolean);
  const name = parts.pop() ?? title;
  const usual = /^(drive|data|images?|image_?\d+|frames?|videos?|input|out|run|results?|sequence|cam(era)?_?\d*|trajectory(\.\w+)?)$/i;
  return usual.test(name) && parts.length > 0 ? `${parts.pop()}/${name}` : name;
}

/**
 * Where the path leads backwards, per point. Where there is no speed, from the direction of the steps. Empty if the
 * headings do not fit the path: the axes of a trajectory from elsewhere may lie otherwise.
 */
export function reversed(path: Path): boolean[] {
  const { x, y, time, speed, heading } = path;
  const count = time.length;
  if (!heading || heading.length !== count || count < 2) return [];
  const along = new Float64Array(count);
  const length = new Float64Array(count);
  let [fits, all] = [0, 0];
  for (let i = 0; i < count; i++) {
    const [a, b] = [Math.max(i - 1, 0), Math.min(i + 1, count - 1)];
    const angle = (heading[i] * Math.PI) / 180;
    along[i] = (x[b] - x[a]) * Math.sin(angle) + (y[b] - y[a]) * Math.cos(angle);
    length[i] = Math.hypot(x[b] - x[a], y[b] - y[a]);
    fits += Math.abs(along[i]);
    all += length[i];
  }
  if (fits < 0.8 * all) return [];
  const seconds = Math.max(time[count - 1] - time[0], 1e-9);
  const slow = 0.05 * (all / 2 / seconds);
  return along.reduce((found: boolean[], value, i) => {
    const rate = length[i] / Math.max(time[Math.min(i + 1, count - 1)] - time[Math.max(i - 1, 0)], 1e-9);
    const known = speed[i];
    found.push(known !== null && known !== undefined ? known < -0.1 : value < -0.5 * length[i] && rate > slow);
    return found;
  }, []);
}

/** What was tracked in a thumbnail, and the outlines of what was left out of it: shares of its width and height. */
export interface Features {
  points: { x: number; y: number; hasDepth: boolean }[];
  mask: [number, number][][];
}

const bytesOf = (jpeg: string) => Uint8Array.from(atob(jpeg), (letter) => letter.charCodeAt(0));

/** Pixels, from the start of the frame in the JPEG file; square where there is none. */
export function sizeOf(jpeg: string): { width: number; height: number } {
  const bytes = bytesOf(jpeg);
  const number = (at: number) => (bytes[at] << 8) | bytes[at + 1];
  for (let place = 2; place + 9 < bytes.length && bytes[place] === 0xff; place += 2 + number(place + 2))
    if (bytes[place + 1] >= 0xc0 && bytes[place + 1] <= 0xc2) return { width: number(place + 7), height: number(place + 5) };
  return { width: 1, height: 1 };
}

/** From the comments of the JPEG file (report/thumbnails.h). */
export function featuresOf(jpeg: string): Features {
  const found: Features = { points: [], mask: [] };
  const bytes = bytesOf(jpeg);
  const point = (at: number) => {
    const bits = (bytes[at] << 16) | (bytes[at + 1] << 8) | bytes[at + 2];
    return { x: (bits >> 12) / 4095, y: ((bits >> 1) & 2047) / 2047, hasDepth: (bits & 1) === 1 };
  };
  for (let place = 2; place + 4 < bytes.length && bytes[place] === 0xff && bytes[place + 1] !== 0xda; ) {
    const end = place + 2 + ((bytes[place + 2] << 8) | bytes[place + 3]);
    const zero = bytes.indexOf(0, place + 4);
    const name = bytes[place + 1] === 0xfe && zero > 0 && zero < end ? String.fromCharCode(...bytes.subarray(place + 4, zero)) : '';
    let at = zero + 1;
    if (name === 'turnscale features') for (; at + 3 <= end; at += 3) found.points.push(point(at));
    while (name === 'turnscale mask' && at + 2 <= end) {
      const corners = (bytes[at] << 8) | bytes[at + 1];
      found.mask.push(Array.from({ length: corners }, (_, i) => point(at + 2 + 3 * i)).map(({ x, y }) => [x, y]));
      at += 2 + 3 * corners;
    }
    place = end;
  }
  return found;
}
