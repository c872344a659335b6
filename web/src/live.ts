// SPDX-License-Identifier: MIT
// Follows a running program: asks it for its state a few times a second, and becomes its report at the end.
import { element, make } from './dom';
import { featureKeys, type ReportPage } from './page';
import { scaleStateNames, scaleStateTerms, type Report } from './report';

interface LiveState {
  /** What the program does other than to run over the frames; empty if it does that. */
  phase: string;
  /** The file of the report to come. */
  report: string;
  warnings: string[];
  frame: number;
  frames: number;
  rate: number;
  keyframes: number;
  scaleState: string;
  sigma: number | null;
  tracking: string;
  tracked: number;
  paused: boolean;
  finished: boolean;
  image: number;
  path: number;
}

/** The words of the report for the program's own. */
const scaleWords = Object.fromEntries(Object.entries(scaleStateTerms).map(([letter, term]) => [term, scaleStateNames[letter]]));

const interval = 250; // milliseconds between two requests

async function get<T>(path: string): Promise<T> {
  const answer = await fetch(path, { cache: 'no-store' });
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return (await answer.json()) as T;
}

export function followRun(page: ReportPage): void {
  let shownPath = -1;
  let shownImage = -1;
  let updates = 0;
  let failures = 0;
  let current: LiveState | null = null;
  const viewer = Math.random().toString(36).slice(2);
  const bar = element('live');
  bar.hidden = false;
  const text = make('span', 'Connecting');
  const pause = make('button', 'Pause');
  pause.id = 'pause';
  bar.append(make('span', '', 'pulse'), text, pause);
  pause.addEventListener('click', () => {
    void fetch(current?.paused ? 'resume' : 'pause', { method: 'POST', headers: { 'X-Turnscale': '1' } }).catch(() => {});
  });
  element('picture').hidden = false;
  element('feature-keys').replaceChildren(...featureKeys());
  element('no-picture').textContent = 'The first image follows';
  // At its end the program waits for those who are still there.
  window.addEventListener('pagehide', () => navigator.sendBeacon(`leave?viewer=${viewer}`));

  const showState = (state: LiveState) => {
    bar.className = `live${state.paused ? ' paused' : ''}`;
    const of = state.frames > 0 ? ` of ${state.frames}` : '';
    const parts: [string, string][] = [
      ...(state.paused ? [['', 'Paused'] as [string, string]] : []),
      ['frame', `${state.frame}${of}`],
      ['frames/s', state.rate.toFixed(1)],
      ['keyframes', String(state.keyframes)],
      ['scale from', (scaleWords[state.scaleState] ?? state.scaleState) + (state.sigma === null ? '' : ` ±${(100 * state.sigma).toFixed(1)} %`)],
      ['features', String(state.tracked)],
      ['tracking', state.tracking],
    ];
    if (state.phase) parts.splice(0, parts.length, ['', state.phase[0].toUpperCase() + state.phase.slice(1)]);
    text.replaceChildren(...parts.flatMap(([name, value]) => [make('span', '', 'pair', make('span', `${name} `), make('b', value)), document.createTextNode(' ')]));
    pause.hidden = state.phase !== '';
    page.showWarnings(state.warnings);
    pause.textContent = state.paused ? 'Resume' : 'Pause';
    Object.assign(window, { liveUpdates: ++updates, liveState: state });
  };

  const showImage = (number: number) => {
    if (number === shownImage || number === 0) return;
    shownImage = number;
    const image = element<HTMLImageElement>('thumbnail');
    const next = new Image();
    next.onload = () => {
      image.src = next.src;
      image.hidden = false;
      element('no-picture').hidden = true;
    };
    next.src = `image.jpg?${number}`;
  };

  const end = (message: string) => {
    bar.className = 'live gone';
    text.setAttribute('role', 'status');
    text.textContent = message;
    pause.hidden = true;
  };

  const becomeReport = async () => {
    const answer = await fetch(`report.html?viewer=${viewer}`, { cache: 'no-store' });
    if (!answer.ok) {
      end('The run has ended without a report; the program says why.');
      return;
    }
    const html = await answer.text();
    document.open();
    document.write(html);
    document.close();
  };

  const step = async () => {
    try {
      const state = await get<LiveState>(`state.json?viewer=${viewer}`);
      failures = 0;
      current = state;
      if (state.finished) return await becomeReport();
      showState(state);
      if (state.path !== shownPath) {
        shownPath = state.path;
        page.showLive(await get<Report>('path.json'));
      }
      showImage(state.image);
    } catch {
      if (++failures > 8) {
        end(`The program no longer answers. ${current?.report ? `If it has ended, its report is ${current.report}` : 'Its results are in its output folder.'}`);
        return;
      }
    }
    window.setTimeout(() => void step(), interval);
  };
  void step();
}
