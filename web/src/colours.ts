// SPDX-License-Identifier: MIT
import { closestIndex, type Report } from './report';

export type ColourBy = 'speed' | 'sigma' | 'state' | 'error';
// A ramp over less would make a difference of nothing look large.
const leastSigma = 0.05;
const leastError = 0.5; // metres
export type Rgb = [number, number, number];

export interface Theme {
  dark: boolean;
  ink: string;
  muted: string;
  line: string;
  panel: string;
  accent: string;
  accentSoft: string;
  turn: string;
  truth: string;
  outline: string;
  landmark: string;
  bad: string;
  good: string;
}

const light: Theme = {
  dark: false, ink: '#17202c', muted: '#5b6878', line: '#dfe4ea', panel: '#ffffff', accent: '#0a5cbf',
  accentSoft: 'rgba(10,92,191,.16)', turn: '#b93c0a', truth: '#17202c', outline: '#7d8998', landmark: '#98a4b3', bad: '#c92a2a', good: '#0a7d5a',
};
const dark: Theme = {
  dark: true, ink: '#e7edf4', muted: '#94a3b5', line: '#2a3441', panel: '#121921', accent: '#58a6ff',
  accentSoft: 'rgba(88,166,255,.2)', turn: '#ff9f5a', truth: '#ffffff', outline: '#66758a', landmark: '#546579', bad: '#ff7b72', good: '#3fd1a0',
};

export const themeOf = (isDark: boolean): Theme => (isDark ? dark : light);

// Equally spaced in lightness and readable for colour-blind people: as the plasma map, but at least 3:1 against the
// ground all along.
const ramps: Record<'light' | 'dark', Rgb[]> = {
  light: [[44, 5, 148], [106, 0, 168], [157, 24, 157], [198, 52, 118], [214, 84, 66], [217, 110, 24], [198, 133, 0]],
  dark: [[116, 72, 228], [150, 52, 205], [191, 62, 168], [221, 95, 124], [243, 137, 84], [252, 182, 52], [244, 233, 64]],
};

export function rampColour(share: number, isDark: boolean): Rgb {
  const ramp = ramps[isDark ? 'dark' : 'light'];
  const place = Math.min(Math.max(share, 0), 1) * (ramp.length - 1);
  const i = Math.min(Math.floor(place), ramp.length - 2);
  return ramp[i].map((low, k) => low + (place - i) * (ramp[i + 1][k] - low)) as Rgb;
}

const stateColours: Record<'light' | 'dark', Record<string, Rgb>> = {
  light: { o: [10, 125, 90], r: [138, 92, 0], h: [10, 92, 191], p: [135, 147, 161] },
  dark: { o: [63, 209, 160], r: [227, 179, 65], h: [88, 166, 255], p: [124, 138, 154] },
};

export const css = ([r, g, b]: Rgb): string => `rgb(${Math.round(r)},${Math.round(g)},${Math.round(b)})`;

export interface Legend {
  title: string;
  /** A ramp from low to high, or names with their colours. */
  range?: [string, string];
  names?: { name: string; colour: Rgb }[];
}

export interface Colouring {
  colours: Rgb[];
  legend: Legend;
}

function ranged(values: (number | null)[], low: number, high: number, isDark: boolean, unknown: Rgb): Rgb[] {
  const width = Math.max(high - low, 1e-9);
  return values.map((value) => (value === null ? unknown : rampColour((value - low) / width, isDark)));
}

const largest = (values: (number | null)[]) => values.reduce((a: number, b) => Math.max(a, b ?? 0), 0);

/** By what the path of a report can be coloured, the most telling first. */
export function colourings({ path, truth }: Report): ColourBy[] {
  const known: [ColourBy, boolean][] = [
    ['speed', path.speed.some((value) => value !== null)],
    ['error', truth !== null && truth.time.length > 0],
    ['sigma', path.scaleState !== '' && path.sigma.some((value) => value !== null)],
    ['state', path.scaleState !== ''],
  ];
  return known.filter(([, has]) => has).map(([by]) => by);
}

export function colourPath({ path, truth }: Report, by: ColourBy | undefined, isDark: boolean): Colouring {
  const states = stateColours[isDark ? 'dark' : 'light'];
  if (by === undefined) return { colours: path.time.map(() => states.h), legend: { title: 'Path' } };
  if (by === 'error' && truth) {
    const high = Math.max(largest(truth.error), leastError);
    return {
      colours: ranged(path.time.map((time) => truth.error[closestIndex(truth.time, time)]), 0, high, isDark, states.p),
      legend: { title: 'Distance to the ground truth', range: ['0', `${high.toFixed(2)}\u00a0m`] },
    };
  }
  if (by === 'speed') {
    const speeds = path.speed.map((value) => (value === null ? null : Math.abs(value)));
    const high = Math.max(1, Math.ceil(largest(speeds) * 3.6)) / 3.6;
    return {
      colours: ranged(speeds, 0, high, isDark, states.p),
      legend: { title: 'Speed', range: ['0', `${Math.round(high * 3.6)}\u00a0km/h`] },
    };
  }
  if (by === 'sigma') {
    const high = Math.max(largest(path.sigma), leastSigma);
    return {
      colours: ranged(path.sigma, 0, high, isDark, states.p),
      legend: { title: 'Uncertainty of the scale (1 sigma)', range: ['0', `${(100 * high).toFixed(high < 0.1 ? 1 : 0).replace('.0', '')}\u00a0%`] },
    };
  }
  const names = [
    { key: 'o', name: 'the turn itself' },
    { key: 'r', name: 'height above the road' },
    { key: 'h', name: 'carried over from turns' },
    { key: 'p', name: 'not known yet' },
  ].filter(({ key }) => path.scaleState.includes(key));
  return {
    colours: Array.from(path.scaleState, (letter) => states[letter] ?? states.p),
    legend: { title: 'Scale from', names: names.map(({ key, name }) => ({ name, colour: states[key] })) },
  };
}
