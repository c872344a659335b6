// SPDX-License-Identifier: MIT
// What the program writes into the page (report/report_data.cpp), and how the page reads it.

/** One entry per point of the path; axes: x right, y ahead at the start, z up. */
export interface Path {
  time: number[];
  frame: number[];
  x: number[];
  y: number[];
  z: number[];
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

export const scaleStateNames: Record<string, string> = { p: 'pending', o: 'observed in a turn', h: 'held', r: 'from the road' };
export const trackingNames: Record<string, string> = {
  t: 'tracked',
  r: 'repeated image',
  b: 'tracking lost, pose not measured',
  u: 'no readable image, pose not measured',
  i: 'before the first map',
};

/** A place along the drive in words: its time, or the number of its pose. */
export const placeText = (report: Report, time: number): string => (report.timed === false ? `pose ${Math.round(time)}` : clock(time));

/** When the drive began, if its times tell; else what they count from; empty if they count from the drive's start. */
export function originText({ timeOrigin = 0 }: Report): string {
  const sinceEpoch = 3e8;
  if (timeOrigin > sinceEpoch) return `Began ${new Date(1000 * timeOrigin).toISOString().slice(0, 19).replace('T', ' ')} UTC`;
  return timeOrigin > 0 ? `Time 0 is ${timeOrigin.toFixed(2)} s in the files` : '';
}

export function clock(seconds: number): string {
  const tenths = Math.round(seconds * 10);
  const whole = Math.floor(tenths / 10);
  const pad = (n: number) => String(n).padStart(2, '0');
  const hours = Math.floor(whole / 3600);
  const rest = `${pad(Math.floor(whole / 60) % 60)}:${pad(whole % 60)}`;
  return `${hours ? `${hours}:` : ''}${rest}.${tenths % 10}`;
}
