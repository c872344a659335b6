// SPDX-License-Identifier: MIT
// The report: what it shows of a drive, and the one place along the drive that all its parts follow.
import { makeChart, type Chart, type ChartData } from './charts';
import { colourings, colourPath, css, rampColour, themeOf, type ColourBy, type Legend, type Theme } from './colours';
import { element, make } from './dom';
import { clock, closestIndex, decodeLandmarks, originText, placeText, scaleStateNames, trackingNames, type Report, type Thumbnail } from './report';
import { PathView, type Marker } from './view';

const kmhPerMps = 3.6;
/** With a minus sign as wide as the plus. */
const fixed = (value: number, digits: number) => value.toFixed(digits).replace('-', '\u2212');
const signed = (value: number, digits: number) => `${value > 0 ? '+' : ''}${fixed(value, digits)}`;

/** Ranges of points for which `holds`, each begun one point earlier so that a range of one point is a line. */
function ranges(count: number, holds: (i: number) => boolean): [number, number][] {
  const found: [number, number][] = [];
  for (let i = 0; i < count; i++) {
    if (!holds(i)) continue;
    const last = found.at(-1);
    if (last && last[1] === i - 1) last[1] = i;
    else found.push([Math.max(i - 1, 0), i]);
  }
  return found;
}

export class ReportPage {
  readonly view: PathView;
  private theme: Theme;
  private report: Report | null = null;
  private by: ColourBy | undefined = 'speed';
  private chosen = false; // the reader has chosen the colours
  private warnings = '';
  private charts: Chart[] = [];
  private place = 0;
  private live = false;
  /** Where the reader looks while the path grows, seconds; null: at its end. */
  private heldTime: number | null = null;
  private playing = 0;

  constructor(theme: Theme) {
    this.theme = theme;
    document.documentElement.classList.toggle('dark', theme.dark);
    this.view = new PathView(element('view'), theme);
    this.view.onHover = (index) => this.moveTo(index);
    this.view.onLeave = () => this.release();
    this.bindTools();
    // For tests and measurements.
    Object.assign(window, { turnscale: this });
  }

  get currentPlace(): number { return this.place; }

  show(report: Report): void {
    this.report = report;
    this.place = 0;
    document.title = `${report.title.split('/').filter(Boolean).pop() ?? 'report'} - turnscale`;
    this.showHeading();
    this.showWarnings(report.warnings);
    this.by = colourings(report)[0];
    this.view.setUnit(report.unit);
    this.view.setLandmarks(decodeLandmarks(report.landmarks));
    this.view.setTruth(report.truth);
    this.view.setOutlines(report.outlines);
    const { path } = report;
    const markers: Marker[] = report.turns.map((turn, i) => ({
      index: closestIndex(path.time, (turn.from + turn.to) / 2), label: String(i + 1), used: turn.used,
    }));
    const turns = report.turns.map((turn): [number, number] => [closestIndex(path.time, turn.from), closestIndex(path.time, turn.to)]);
    const predicted = ranges(path.time.length, (i) => 'bu'.includes(path.tracking[i]));
    const { colours } = colourPath(report, this.by, this.theme.dark);
    this.view.setPath({ places: path, colours, turns, predicted, markers });
    this.view.fit();
    const slider = element<HTMLInputElement>('time');
    slider.max = String(Math.max(path.time.length - 1, 0));
    element('landmarks').hidden = !report.landmarks;
    this.showColours();
    this.showTurns();
    this.showErrors();
    this.showSettings();
    this.showCharts();
    this.moveTo(0);
  }

  /** The path of a run that goes on: without charts and tables; the last point is the current one. */
  showLive(report: Report): void {
    this.report = report;
    if (!this.live) element('warnings').setAttribute('role', 'status');
    this.live = true;
    this.showHeading();
    this.view.setUnit(report.unit);
    const possible = colourings(report);
    if (!this.by || !possible.includes(this.by) || !this.chosen) this.by = possible[0];
    const { colours } = colourPath(report, this.by, this.theme.dark);
    this.view.setPath({ places: report.path, colours, turns: [], predicted: [], markers: [] });
    this.view.follow();
    this.showColours();
    const { time } = report.path;
    this.place = this.heldTime === null ? time.length - 1 : closestIndex(time, this.heldTime);
    this.view.setCurrent(this.place);
    document.documentElement.classList.add('following');
    if (this.place >= 0) this.showReadout();
  }

  moveTo(index: number): void {
    const path = this.report?.path;
    if (!path || path.time.length === 0) return;
    this.place = Math.min(Math.max(index, 0), path.time.length - 1);
    const time = path.time[this.place];
    this.view.setCurrent(this.place);
    if (this.live) {
      // The image stays that of the present: there is none of this place.
      this.heldTime = this.place < path.time.length - 1 ? time : null;
      this.showReadout();
      return;
    }
    element<HTMLInputElement>('time').value = String(this.place);
    const place = placeText(this.report!, time);
    element('time').setAttribute('aria-valuetext', place);
    element('clock').textContent = place;
    for (const chart of this.charts) chart.moveTo(time);
    this.showReadout();
    this.showThumbnail(time);
    element('turns').querySelectorAll('tbody tr').forEach((row, i) => {
      const turn = this.report?.turns[i];
      row.classList.toggle('current', turn !== undefined && time >= turn.from && time <= turn.to);
    });
  }

  /** Back to the end of a path that grows. */
  private release(): void {
    if (this.live) this.moveTo(Infinity);
  }

  moveToTime(time: number): void {
    if (this.report) this.moveTo(closestIndex(this.report.path.time, time));
  }

  private showHeading(): void {
    const report = this.report!;
    const title = element('title');
    title.textContent = report.title.split('/').filter(Boolean).pop() ?? report.title;
    title.title = report.title;
    element('notes').textContent = [...report.notes, originText(report)].filter(Boolean).join(' · ');
    element('facts').replaceChildren(...report.facts.map(factElement));
    element('footer').replaceChildren(
      make('span', `turnscale ${report.version}`),
      make('span', report.title),
      make('span', 'Bands, error bars and sigma: one standard deviation'),
    );
  }

  /** Only where they change: screen readers say them each time. */
  showWarnings(texts: string[]): void {
    const together = texts.join('\n');
    if (together === this.warnings) return;
    this.warnings = together;
    const warnings = element('warnings');
    warnings.hidden = texts.length === 0;
    warnings.replaceChildren(
      make('p', texts.length === 1 ? 'One thing to check' : `${texts.length} things to check`),
      make('ul', '', '', ...texts.map((text) => make('li', text))),
    );
  }

  private showColours(): void {
    const { colours, legend } = colourPath(this.report!, this.by, this.theme.dark);
    this.view.setColours(colours);
    const possible: string[] = colourings(this.report!);
    for (const button of element('colours').querySelectorAll('button')) {
      button.setAttribute('aria-pressed', String(button.dataset.by === this.by));
      button.hidden = !possible.includes(button.dataset.by!);
    }
    element('colours').hidden = possible.length < 2;
    this.showLegend(legend);
  }

  private showLegend(legend: Legend): void {
    const rows: Node[] = [make('b', legend.title)];
    if (legend.range) {
      const ramp = make('div', '', 'ramp');
      const stops = Array.from({ length: 9 }, (_, i) => css(rampColour(i / 8, this.theme.dark)));
      ramp.style.background = `linear-gradient(90deg,${stops.join(',')})`;
      rows.push(make('div', '', 'range', make('span', legend.range[0]), ramp, make('span', legend.range[1])));
    }
    const named = (name: string, colour: string) => {
      const line = make('i');
      line.style.background = colour;
      return make('div', '', 'name', line, make('span', name));
    };
    for (const { name, colour } of legend.names ?? []) rows.push(named(name, css(colour)));
    if (/[bu]/.test(this.report!.path.tracking)) rows.push(named('tracking lost', this.theme.bad));
    if (this.report!.truth) rows.push(named('ground truth', this.theme.truth));
    element('legend').hidden = !legend.range && !legend.names && rows.length === 1;
    element('legend').replaceChildren(...rows);
  }

  private showReadout(): void {
    const report = this.report!;
    const { path } = report;
    const i = this.place;
    const rows: [string, string, boolean?][] = report.timed === false ? [] : [['Time', clock(path.time[i])]];
    // Where there is no tracking there were no images.
    rows.push([path.tracking ? 'Frame' : 'Pose', String(path.frame[i])]);
    const speed = path.speed[i];
    const speedSigma = path.speedSigma[i];
    const band = speedSigma === null ? '' : ` ± ${(speedSigma * kmhPerMps).toFixed(1)}`;
    if (speed !== null) rows.push(['Speed', `${fixed(speed * kmhPerMps, 1)}${band} km/h`]);
    const sigma = path.sigma[i];
    if (path.scaleState) rows.push(['Scale', scaleStateNames[path.scaleState[i]] ?? '-']);
    if (sigma !== null) rows.push(['Sigma of the scale', `${(100 * sigma).toFixed(1)} %`]);
    const lost = 'bu'.includes(path.tracking[i]);
    if (path.tracking) rows.push(['Tracking', trackingNames[path.tracking[i]] ?? '-', lost]);
    rows.push(['Right, ahead, up', `${[path.x[i], path.y[i], path.z[i]].map((value) => fixed(value, 1)).join(', ')} ${report.unit}`]);
    if (report.truth) {
      const error = report.truth.error[closestIndex(report.truth.time, path.time[i])];
      if (error !== null) rows.push(['Distance to the truth', `${error.toFixed(2)} m`]);
    }
    element('readout').replaceChildren(
      ...rows.flatMap(([name, value, bad]) => [make('dt', name), make('dd', value, bad ? 'bad' : '')]),
    );
  }

  private showThumbnail(time: number): void {
    const thumbnails = this.report!.thumbnails;
    const image = element<HTMLImageElement>('thumbnail');
    const shown: Thumbnail | undefined = thumbnails[closestIndex(thumbnails.map((t) => t.time), time)];
    image.hidden = !shown;
    element('no-picture').hidden = shown !== undefined;
    element('picture').hidden = thumbnails.length === 0;
    if (!shown) return;
    const source = `data:image/jpeg;base64,${shown.jpeg}`;
    if (image.src !== source) image.src = source;
    image.alt = `Frame ${shown.frame}`;
    const dot = (colour: string, text: string) => {
      const mark = make('span', '', 'dot');
      mark.style.background = colour;
      return [mark, document.createTextNode(text)];
    };
    const why = shown.why === 'lost' ? ', tracking lost' : shown.why === 'turn' ? ', in a turn' : '';
    element('caption').replaceChildren(
      document.createTextNode(`Frame ${shown.frame} at ${placeText(this.report!, shown.time)}${why} `),
      ...dot('#46e678', 'landmark'), ...dot('#ffaf28', 'without depth'),
    );
  }

  private showTurns(): void {
    const { turns } = this.report!;
    const panel = element('turns');
    panel.hidden = turns.length === 0;
    const { timed } = this.report!;
    const place = (time: number) => (timed === false ? String(Math.round(time)) : clock(time));
    const head = ['Turn', timed === false ? 'Poses' : 'Time', 'Angle', 'Speed', 'Own scale', 'Smoothed', 'Deviation', 'Lever arm', ''];
    const rows = turns.map((turn, i) => {
      const number = (value: number | null, text: (value: number) => string) => (value === null ? '-' : text(value));
      const go = make('button', String(i + 1));
      go.setAttribute('aria-label', `Show turn ${i + 1}`);
      const row = make('tr', '', turn.used ? '' : 'unused',
        make('td', '', '', go),
        make('td', `${place(turn.from)} – ${place(turn.to)}`),
        make('td', `${Math.abs(turn.angle).toFixed(0)}° ${turn.angle > 0 ? 'right' : 'left'}`),
        make('td', number(turn.speed, (v) => `${(v * kmhPerMps).toFixed(1)} km/h`)),
        make('td', number(turn.scale, (v) => `${v.toPrecision(4)}${turn.sigma ? ` ± ${((100 * turn.sigma) / v).toFixed(1)} %` : ''}`)),
        make('td', number(turn.smoothed, (v) => v.toPrecision(4))),
        make('td', number(turn.deviation, (v) => `${signed(v, 1)} σ`)),
        make('td', number(turn.leverArm, (v) => `${v.toFixed(2)} m`)),
        make('td', turn.used ? '' : turn.reason || 'not used', 'text'));
      row.addEventListener('click', () => this.moveToTime((turn.from + turn.to) / 2));
      return row;
    });
    const table = make('table', '', '',
      make('thead', '', '', make('tr', '', '', ...head.map(headOf))), make('tbody', '', '', ...rows));
    const scroll = make('div', '', 'scroll', table);
    scroll.tabIndex = 0;
    scroll.setAttribute('role', 'region');
    scroll.setAttribute('aria-label', 'Turns');
    panel.replaceChildren(make('h2', 'Turns'), scroll);
  }

  private showErrors(): void {
    const { errors, truth } = this.report!;
    const panel = element('errors');
    panel.hidden = errors.length === 0;
    const heading = make('h2', 'Compared with the ground truth');
    if (truth?.metresPerUnit) heading.append(make('small', `laid on the path, which is up to scale: one unit is ${truth.metresPerUnit.toPrecision(3)} m`));
    panel.replaceChildren(heading, make('div', '', 'facts', ...errors.map(factElement)));
  }

  private showSettings(): void {
    const { settings } = this.report!;
    element('settings').hidden = settings === '';
    element('settings').querySelector('pre')!.textContent = settings;
  }

  private chartData(): Omit<ChartData, 'place'>[] {
    const { path, scale, rotation, truth, turns } = this.report!;
    const { theme } = this;
    const charts: Omit<ChartData, 'place'>[] = [];
    const kmh = (values: (number | null)[]) => values.map((value) => (value === null ? null : value * kmhPerMps));
    if (path.speed.some((value) => value !== null))
      charts.push({ title: 'Speed', unit: 'km/h', time: path.time, include: 0, least: 2,
        bands: [{ label: 'speed', values: kmh(path.speed), sigmas: kmh(path.speedSigma), colour: theme.accent }] });
    if (scale) {
      const own = turns.filter((turn) => turn.scale !== null && turn.sigma !== null);
      charts.push({ title: 'Scale', unit: 'metres per unit of the map', time: scale.time,
        bands: [{ label: 'smoothed', values: scale.value, sigmas: scale.value.map((value, i) => value * (scale.sigma[i] ?? 0)), colour: theme.accent }],
        readings: { label: 'from one turn alone', time: own.map((turn) => (turn.from + turn.to) / 2), value: own.map((turn) => turn.scale!),
          sigma: own.map((turn) => turn.sigma!), used: own.map((turn) => turn.used), colour: theme.turn } });
    }
    // A rotation that was given was not learned.
    if (rotation?.yawSigma.some((value) => value !== null)) {
      const band = (label: string, values: number[], sigmas: (number | null)[], colour: string) => ({ label, values, sigmas, colour });
      charts.push({ title: 'Rotation of the camera in the car', unit: 'degrees', least: 0.5, ...steps(rotation.time, [
        band('yaw', rotation.yaw, rotation.yawSigma, theme.accent), band('pitch', rotation.pitch, rotation.pitchSigma, theme.good),
        band('roll', rotation.roll, rotation.rollSigma, theme.turn)]) });
    }
    if (truth)
      charts.push({ title: 'Distance to the ground truth', unit: 'm', time: truth.time, include: 0,
        bands: [{ label: 'distance', values: truth.error, sigmas: truth.error.map(() => null), colour: theme.bad }] });
    return charts;
  }

  private showCharts(): void {
    this.charts.forEach((chart) => chart.destroy());
    this.charts = [];
    const section = element('charts');
    const all = this.chartData();
    section.replaceChildren();
    for (const data of all) {
      const keys = make('span', '', 'keys');
      const key = (colour: string, name: string, dot = false) => {
        const mark = make('i', '', dot ? 'dot' : '');
        mark.style.background = colour;
        keys.append(make('span', '', '', mark, document.createTextNode(name)));
      };
      if (data.bands.length > 1 || data.readings) data.bands.forEach((band) => key(band.colour, band.label));
      if (data.readings?.time.length) key(data.readings.colour, data.readings.label, true);
      const title = make('h2', data.title);
      title.append(make('small', this.report!.timed === false ? `${data.unit}, over the number of the pose` : data.unit));
      const plot = make('div');
      section.append(make('div', '', 'panel chart', make('header', '', '', title, keys), plot));
      this.charts.push(makeChart(plot, { ...data, place: (time) => placeText(this.report!, time) }, this.theme, (time) => this.moveToTime(time)));
    }
  }

  private setTheme(dark: boolean): void {
    this.theme = themeOf(dark);
    document.documentElement.classList.toggle('dark', dark);
    this.view.setTheme(this.theme);
    if (!this.report) return;
    this.showColours();
    if (!this.live) this.showCharts();
    this.moveTo(this.place);
  }

  private setView(in3d: boolean): void {
    this.view.setView(in3d);
    element('view-above').setAttribute('aria-pressed', String(!in3d));
    element('view-3d').setAttribute('aria-pressed', String(in3d));
  }

  private setColourBy(by: ColourBy): void {
    this.by = by;
    this.chosen = true;
    if (this.report) this.showColours();
  }

  private toggleLandmarks(): void {
    const button = element('landmarks');
    const show = button.getAttribute('aria-pressed') !== 'true';
    button.setAttribute('aria-pressed', String(show));
    this.view.setShowLandmarks(show);
  }

  private togglePlay(): void {
    const button = element('play');
    if (this.playing) {
      cancelAnimationFrame(this.playing);
      this.playing = 0;
    } else if (this.report && this.report.path.time.length > 1) {
      const { time } = this.report.path;
      if (this.place >= time.length - 1) this.moveTo(0);
      // The whole drive in half a minute, a short one in its own time.
      const rate = Math.max(1, (time[time.length - 1] - time[0]) / 30);
      let last = performance.now();
      let at = time[this.place];
      const step = (now: number) => {
        at += ((now - last) / 1000) * rate;
        last = now;
        this.moveToTime(at);
        if (this.place >= time.length - 1) this.togglePlay();
        else this.playing = requestAnimationFrame(step);
      };
      this.playing = requestAnimationFrame(step);
    }
    button.textContent = this.playing ? '❚❚' : '▶';
    button.setAttribute('aria-label', this.playing ? 'Pause' : 'Play');
  }

  private bindTools(): void {
    const click = (id: string, action: () => void) => element(id).addEventListener('click', action);
    click('theme', () => this.setTheme(!this.theme.dark));
    click('view-above', () => this.setView(false));
    click('view-3d', () => this.setView(true));
    click('landmarks', () => this.toggleLandmarks());
    click('zoom-in', () => this.view.zoomBy(1.4));
    click('zoom-out', () => this.view.zoomBy(1 / 1.4));
    click('fit', () => this.view.fit());
    click('play', () => this.togglePlay());
    for (const button of element('colours').querySelectorAll('button'))
      button.addEventListener('click', () => this.setColourBy(button.dataset.by as ColourBy));
    element<HTMLInputElement>('time').addEventListener('input', (event) => this.moveTo(Number((event.target as HTMLInputElement).value)));
    // Keys of a letter or a sign only where the reader is at the picture (WCAG 2.1.4).
    document.querySelector<HTMLElement>('.stage')!.addEventListener('keydown', (event) => this.onKey(event));
    document.addEventListener('keydown', (event) => { if (event.key === 'Escape') this.escape(); });
    let darkOnScreen = false;
    const toPaper = (printing: boolean) => {
      if (printing) darkOnScreen = this.theme.dark;
      document.documentElement.classList.toggle('paper', printing);
      this.setTheme(!printing && darkOnScreen);
      this.view.resize();
      for (const chart of this.charts) chart.resize();
    };
    window.addEventListener('beforeprint', () => toPaper(true));
    window.addEventListener('afterprint', () => toPaper(false));
  }

  /** Ends what goes on: playing, a place that is held, the wheel's hold on the picture. */
  private escape(): void {
    if (this.playing) this.togglePlay();
    this.release();
    this.view.letGo();
  }

  private onKey(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { target } = event;
    const onControl = target instanceof HTMLButtonElement || target instanceof HTMLInputElement || (target as Element).tagName === 'SUMMARY';
    const onSlider = target instanceof HTMLInputElement;
    const step = event.shiftKey ? 20 : 1;
    const keys: Record<string, () => void> = {
      ArrowRight: () => this.moveTo(this.place + step),
      ArrowLeft: () => this.moveTo(this.place - step),
      Home: () => this.moveTo(0),
      End: () => this.moveTo(Infinity),
      '+': () => this.view.zoomBy(1.4),
      '=': () => this.view.zoomBy(1.4),
      '-': () => this.view.zoomBy(1 / 1.4),
      '0': () => this.view.fit(),
      '1': () => this.setView(false),
      '3': () => this.setView(true),
      t: () => this.setTheme(!this.theme.dark),
      l: () => this.toggleLandmarks(),
      ' ': () => (this.live ? element('pause').click() : this.togglePlay()),
    };
    const action = keys[event.key];
    const forControl = (onControl && event.key === ' ') || (onSlider && ['ArrowLeft', 'ArrowRight', 'Home', 'End'].includes(event.key));
    if (!action || forControl) return;
    event.preventDefault();
    action();
  }
}

function headOf(name: string): HTMLElement {
  const head = make(name ? 'th' : 'td', name);
  if (name) head.setAttribute('scope', 'col');
  return head;
}

/** The number large, what follows it small. */
function factElement({ name, value, note }: { name: string; value: string; note: string }): HTMLElement {
  const [, number, unit] = /^(\S+)\s*(.*)$/.exec(value) ?? ['', value, ''];
  return make('dl', '', 'fact', make('dt', name), make('dd', '', '', document.createTextNode(number), make('small', unit ? ` ${unit}` : '')), make('p', note));
}

/** A value that holds until the next: each change becomes a step. */
function steps(time: number[], bands: { label: string; values: number[]; sigmas: (number | null)[]; colour: string }[]) {
  const doubled = <T>(values: T[]): T[] => values.flatMap((value, i) => (i + 1 < values.length ? [value, value] : [value]));
  return {
    time: time.flatMap((t, i) => (i + 1 < time.length ? [t, Math.max(t, time[i + 1] - 1e-3)] : [t])),
    bands: bands.map((band) => ({ ...band, values: doubled(band.values), sigmas: doubled(band.sigmas) })),
  };
}
