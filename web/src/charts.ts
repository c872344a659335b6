// SPDX-License-Identifier: MIT
import uPlot from 'uplot';
import type { Theme } from './colours';
import { minus } from './dom';
import { closestIndex } from './report';

export interface Band {
  label: string;
  values: (number | null)[];
  /** Standard deviations: the band is one of them to either side. */
  sigmas: (number | null)[];
  colour: string;
}

export interface ChartData {
  title: string;
  unit: string;
  time: number[];
  bands: Band[];
  /** Single readings with their standard deviations, as points with error bars. */
  readings?: { label: string; time: number[]; value: number[]; sigma: number[]; used: boolean[]; colour: string };
  /** The range of the horizontal axis, that of the drive. */
  range?: [number, number];
  /** Shaded: the turns. */
  spans?: [number, number][];
  /** Decimals of the value at the cursor. */
  digits: number;
  /** What is said where there is no value. */
  unknown?: string;
  /** A place on the horizontal axis in words. */
  place: (time: number) => string;
  /** The range of the vertical axis has to contain this. */
  include?: number;
  /** The axis covers at least this much, so that noise in the last digit does not fill it. */
  least?: number;
}

export interface Chart {
  moveTo(time: number): void;
  /** The values at a time, in words. */
  valueAt(time: number): string;
  /** After a change of the element's size; by itself only after the browser's next layout. */
  resize(): void;
  destroy(): void;
}

const font = '11px system-ui, sans-serif';

function drawReadings(plot: uPlot, readings: NonNullable<ChartData['readings']>, theme: Theme): void {
  const context = plot.ctx;
  const ratio = uPlot.pxRatio;
  const { left, top, width, height } = plot.bbox;
  context.save();
  context.beginPath();
  context.rect(left, top, width, height);
  context.clip();
  readings.time.forEach((time, i) => {
    const x = plot.valToPos(time, 'x', true);
    const y = (value: number) => plot.valToPos(value, 'y', true);
    const at = y(readings.value[i]);
    context.strokeStyle = readings.colour;
    context.globalAlpha = readings.used[i] ? 1 : 0.5;
    context.lineWidth = 1.5 * ratio;
    context.beginPath();
    context.moveTo(x, y(readings.value[i] - readings.sigma[i]));
    context.lineTo(x, y(readings.value[i] + readings.sigma[i]));
    context.stroke();
    context.beginPath();
    const beyond = at < top ? -1 : at > top + height ? 1 : 0;
    if (beyond === 0) {
      context.arc(x, at, 3.5 * ratio, 0, 2 * Math.PI);
    } else {
      // An arrow at the edge points to it.
      const edge = beyond < 0 ? top : top + height;
      context.moveTo(x, edge - beyond * ratio);
      context.lineTo(x - 4.5 * ratio, edge - beyond * 8.5 * ratio);
      context.lineTo(x + 4.5 * ratio, edge - beyond * 8.5 * ratio);
      context.closePath();
    }
    context.fillStyle = readings.used[i] ? readings.colour : theme.panel;
    context.fill();
    context.stroke();
  });
  context.restore();
}

function drawSpans(plot: uPlot, spans: [number, number][], theme: Theme): void {
  const context = plot.ctx;
  const { left, top, width, height } = plot.bbox;
  context.save();
  context.fillStyle = theme.muted;
  context.globalAlpha = theme.dark ? 0.16 : 0.11;
  for (const span of spans) {
    const [a, b] = span.map((time) => Math.min(Math.max(plot.valToPos(time, 'x', true), left), left + width));
    if (b > a) context.fillRect(a, top, b - a, height);
  }
  context.restore();
}

/** Numbers with as many decimals as their distance needs, all the same. */
function tickTexts(ticks: number[], step: number): string[] {
  let digits = 0;
  while (digits < 6 && Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) > 1e-6) digits++;
  return ticks.map((tick) => minus(tick.toFixed(digits)));
}

function verticalRange(data: ChartData): [number, number] {
  const values: number[] = [];
  for (const band of data.bands)
    band.values.forEach((value, i) => {
      if (value === null) return;
      const sigma = Math.min(band.sigmas[i] ?? 0, Math.abs(value) + 2);
      values.push(value - sigma, value + sigma);
    });
  data.readings?.value.forEach((value, i) => {
    // A turn that says little must not flatten the chart.
    if (data.readings!.used[i]) values.push(value);
  });
  if (data.include !== undefined) values.push(data.include);
  // The sigmas before the first turns are large: leave out the most extreme hundredth.
  values.sort((a, b) => a - b);
  const low = values[Math.floor(values.length * 0.005)] ?? 0;
  const high = values[Math.ceil(values.length * 0.995) - 1] ?? 1;
  const room = Math.max(0.08 * (high - low), 1e-6 + 1e-3 * Math.abs(high), 0.5 * ((data.least ?? 0) - (high - low)));
  return [data.include === low ? low : low - room, high + room];
}

export function makeChart(element: HTMLElement, data: ChartData, theme: Theme, onTime: (time: number) => void): Chart {
  const series: uPlot.Series[] = [{}];
  const columns: (number | null)[][] = [data.time];
  const bands: uPlot.Band[] = [];
  for (const band of data.bands) {
    const at = columns.length;
    const edge = (sign: number) => band.values.map((value, i) => {
      const sigma = band.sigmas[i];
      return value === null || sigma === null ? null : value + sign * sigma;
    });
    columns.push(band.values, edge(1), edge(-1));
    series.push(
      // uPlot shifts a line by (width % 2) / 2 pixels, but not the band around it.
      { label: band.label, stroke: band.colour, width: band.sigmas.some((sigma) => sigma !== null) ? 1.2 : 1.6, points: { show: false } },
      { label: 'high', width: 0, points: { show: false } },
      { label: 'low', width: 0, points: { show: false } },
    );
    bands.push({ series: [at + 1, at + 2], fill: colourWithAlpha(band.colour, (theme.dark ? 0.4 : 0.3) / Math.sqrt(data.bands.length)) });
  }
  const grid = { stroke: theme.line, width: 1 };
  let shownTime: number | null = null;
  const showTime = (self: uPlot) => {
    if (shownTime !== null) self.setCursor({ left: self.valToPos(shownTime, 'x'), top: 0 }, false);
  };
  const { readings, spans, range } = data;
  const ends = [data.time[0] ?? 0, data.time[data.time.length - 1] ?? 1];
  const size = () => ({ width: Math.max(element.clientWidth, 200), height: 168 });
  const plot: uPlot = new uPlot(
    {
      ...size(),
      legend: { show: false },
      padding: [8, 12, 0, 0],
      scales: { x: { time: false, range: (_, low, high) => (range && low <= ends[0] && high >= ends[1] ? range : [low, high]) }, y: { range: verticalRange(data) } },
      axes: [
        { stroke: theme.muted, grid, ticks: grid, font, size: 26, space: 70, values: (_, ticks) => ticks.map((t) => data.place(t).replace(/^pose /, '')).map((text, _, all) => (all.every((other) => other.endsWith('.0')) ? text.slice(0, -2) : text)) },
        { stroke: theme.muted, grid, ticks: grid, font, size: 52, space: 26, values: (_, ticks, __, ___, step) => tickTexts(ticks, step) },
      ],
      series,
      bands,
      cursor: { y: false, drag: { x: true, y: false }, points: { show: (_, i) => (i % 3 === 1 ? pointOf(theme) : document.createElement('i')) } },
      hooks: {
        // The reader's cursor, not one that follows the place shown elsewhere.
        setCursor: [(self) => {
          if (self.cursor.event && typeof self.cursor.idx === 'number') onTime(self.posToVal(self.cursor.left ?? 0, 'x'));
        }],
        ready: [showTime],
        drawClear: [(self) => { if (spans) drawSpans(self, spans, theme); }],
        draw: [(self) => { if (readings) drawReadings(self, readings, theme); }],
      },
    },
    columns as uPlot.AlignedData,
    element,
  );
  element.setAttribute('role', 'img');
  element.setAttribute('aria-label', inWords(data));
  const resizes = new ResizeObserver(() => plot.setSize(size()));
  resizes.observe(element);
  return {
    moveTo(time) {
      shownTime = time;
      if (plot.status === 1) showTime(plot);
    },
    valueAt(time) {
      const i = closestIndex(data.time, time);
      const texts = data.bands.map(({ label, values, sigmas }) => {
        const [value, sigma] = [values[i] ?? null, sigmas[i] ?? null];
        if (value === null) return '';
        const text = minus(value.toFixed(data.digits)) + (sigma === null ? '' : ` ±${sigma.toFixed(data.digits)}`);
        return data.bands.length > 1 ? `${label} ${text}` : text;
      });
      return texts.filter(Boolean).join(', ') || (data.unknown ?? '');
    },
    resize() {
      plot.setSize(size());
    },
    destroy() {
      resizes.disconnect();
      plot.destroy();
    },
  };
}

/** The chart for those who cannot see it. */
function inWords(data: ChartData): string {
  const known = data.time.length > 0 ? ` from ${data.place(data.time[0])} to ${data.place(data.time[data.time.length - 1])}` : '';
  const bands = data.bands.map(({ label, values }) => {
    const numbers = values.filter((value): value is number => value !== null);
    const [low, high] = numbers.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)], [Infinity, -Infinity]);
    return numbers.length > 0 ? `${label} between ${+low.toPrecision(3)} and ${+high.toPrecision(3)}` : `${label} not known`;
  });
  return `${data.title} in ${data.unit}${known}: ${bands.join(', ')}`;
}

function pointOf(theme: Theme): HTMLElement {
  const point = document.createElement('div');
  point.style.cssText = `width:9px;height:9px;border-radius:50%;background:${theme.ink};border:2px solid ${theme.panel};box-sizing:border-box`;
  return point;
}

function colourWithAlpha(colour: string, alpha: number): string {
  const value = parseInt(colour.slice(1), 16);
  return `rgba(${value >> 16},${(value >> 8) & 255},${value & 255},${alpha})`;
}
