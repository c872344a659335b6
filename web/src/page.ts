// SPDX-License-Identifier: MIT
// The report: what it shows of a drive, and the one place along the drive that all its parts follow.
import { makeChart, type Band, type Chart, type ChartData } from './charts';
import { colourings, colourPath, css, rampColour, themeOf, type ColourBy, type Legend, type Theme } from './colours';
import { element, make, minus, typeset } from './dom';
import {
  clock, closestIndex, decodeLandmarks, featuresOf, momentPattern, originText, placeText, reversed, scaleStateNames, scaleStateTerms,
  secondsOf, shortTitle, sizeOf, trackingNames, type Report, type Thumbnail,
} from './report';
import { PathView, type Marker } from './view';

const kmhPerMps = 3.6;
const fixed = (value: number, digits: number) => minus(value.toFixed(digits));
const signed = (value: number, digits: number) => {
  const text = fixed(value, digits);
  return value > 0 && /[1-9]/.test(text) ? `+${text}` : text;
};
const landmarkColour = '#46e678';
const seenColour = '#ffaf28';

/** What the dots in a picture are. */
export function featureKeys(): HTMLElement[] {
  return ([[landmarkColour, 'landmark'], [seenColour, 'distance unknown']] as const).map(([colour, text]) => {
    const mark = make('span', '', 'dot');
    mark.style.background = colour;
    return make('span', '', '', mark, document.createTextNode(text));
  });
}

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
  private reverse: boolean[] = [];
  private showFeatures = false;
  private thumbnail: Thumbnail | null = null; // the one that is shown
  private readouts: HTMLElement[] = []; // of the charts

  constructor(theme: Theme) {
    this.theme = theme;
    this.view = new PathView(element('view'), theme);
    this.view.onHover = (index) => this.moveTo(index);
    this.view.onLeave = () => this.release();
    this.bindTools();
    this.showTheme();
    // For tests and measurements.
    Object.assign(window, { turnscale: this });
  }

  get currentPlace(): number { return this.place; }

  show(report: Report): void {
    this.report = report;
    this.place = 0;
    document.title = `${shortTitle(report.title) || 'report'} - turnscale`;
    this.showHeading();
    this.showWarnings(report.warnings);
    this.by = colourings(report)[0];
    this.view.setUnit(report.unit);
    this.view.setLandmarks(decodeLandmarks(report.landmarks));
    this.view.setTruth(report.truth);
    this.view.setOutlines(report.outlines);
    const { path } = report;
    const turns = report.turns.map((turn): [number, number] => [closestIndex(path.time, turn.from), closestIndex(path.time, turn.to)]);
    const markers: Marker[] = report.turns.map((turn, i) => ({
      index: closestIndex(path.time, (turn.from + turn.to) / 2), first: turns[i][0], last: turns[i][1], label: String(i + 1), used: turn.used,
    }));
    const predicted = ranges(path.time.length, (i) => 'bu'.includes(path.tracking[i]));
    this.reverse = reversed(path);
    const reverse = ranges(this.reverse.length, (i) => this.reverse[i]);
    const headings = this.reverse.length > 0 ? path.heading : undefined;
    const { colours } = colourPath(report, this.by, this.theme.dark);
    const { thumbnails } = report;
    this.thumbnail = null;
    element('picture').hidden = thumbnails.length === 0;
    const [first] = thumbnails;
    const { width, height } = first ? sizeOf(first.jpeg) : { width: 1, height: 1 };
    document.querySelector('.stage')!.classList.toggle('wide', width > 2.2 * height);
    this.view.setPath({ places: path, colours, turns, predicted, reverse, markers, headings });
    this.view.fit();
    const slider = element<HTMLInputElement>('time');
    slider.max = String(Math.max(path.time.length - 1, 0));
    element('landmarks').hidden = !report.landmarks;
    this.showColours();
    this.showTurns();
    this.showErrors();
    this.showSettings();
    // Those of earlier versions have their features in the picture.
    element('features').hidden = !thumbnails.some(({ jpeg }) => featuresOf(jpeg).points.length > 0);
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
    this.reverse = reversed(report.path);
    const reverse = ranges(this.reverse.length, (i) => this.reverse[i]);
    const headings = this.reverse.length > 0 ? report.path.heading : undefined;
    this.view.setPath({ places: report.path, colours, turns: [], predicted: [], reverse, markers: [], headings, last: 'now' });
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
    this.charts.forEach((chart, i) => {
      chart.moveTo(time);
      this.readouts[i].textContent = chart.valueAt(time);
    });
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
    title.textContent = shortTitle(report.title) || report.title;
    title.title = report.title;
    const notes = typeset([...report.notes, originText(report)].filter(Boolean).join(' · '));
    element('notes').textContent = notes;
    this.showFacts(element('facts'), report.facts);
    element('footer').replaceChildren(
      make('span', `turnscale ${report.version}`),
      make('span', report.title),
      make('span', notes, 'notes'),
      make('span', 'Bands, error bars and ±: one standard deviation (1 sigma)'),
    );
  }

  private showFacts(list: HTMLElement, facts: Report['facts']): void {
    // In two rows that are as long as each other.
    list.style.setProperty('--columns', String(facts.length > 4 ? Math.ceil(facts.length / 2) : Math.max(facts.length, 1)));
    list.replaceChildren(...facts.map((fact) => factElement(fact, this.linked(fact.note))));
  }

  /** A text whose moments move along the drive. */
  private linked(text: string): Node[] {
    const whole = typeset(text);
    if (this.live || this.report?.timed === false) return [document.createTextNode(whole)];
    const nodes: Node[] = [];
    let end = 0;
    for (const { 0: moment, index } of whole.matchAll(momentPattern)) {
      const button = make('button', moment, 'moment');
      button.setAttribute('aria-label', `Show ${moment}`);
      button.addEventListener('click', () => {
        this.moveToTime(secondsOf(moment));
        element('view').scrollIntoView({ block: 'nearest' });
      });
      nodes.push(document.createTextNode(whole.slice(end, index)), button);
      end = index + moment.length;
    }
    nodes.push(document.createTextNode(whole.slice(end)));
    return nodes;
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
      make('ul', '', '', ...texts.map((text) => make('li', '', '', ...this.linked(text)))),
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
    const named = (name: string, colour: string, kind = '') => {
      const line = make('i', '', kind);
      line.style.setProperty('--of', colour);
      return make('div', '', 'name', line, make('span', name));
    };
    const marked = (number: string, name: string, kind: string) => make('div', '', 'name', make('b', '', 'halo', make('b', number, `mark ${kind}`)), make('span', name));
    for (const { name, colour } of legend.names ?? []) rows.push(named(name, css(colour)));
    const { path, truth, turns } = this.report!;
    if (this.reverse.includes(true)) rows.push(named('reverse', this.theme.muted, 'gaps'));
    if (/[bu]/.test(path.tracking)) rows.push(named('tracking lost', this.theme.bad));
    if (truth) rows.push(named('ground truth', this.theme.truth, 'dashed'));
    const [used, unused] = [turns.findIndex((turn) => turn.used), turns.findIndex((turn) => !turn.used)];
    if (used >= 0) rows.push(marked(String(used + 1), 'turn used for the scale', ''));
    if (unused >= 0) rows.push(marked(String(unused + 1), 'turn not used', 'hollow'));
    element('legend').hidden = !legend.range && !legend.names && rows.length === 1;
    element('legend').replaceChildren(...rows);
  }

  private showReadout(): void {
    const report = this.report!;
    const { path, unit } = report;
    const i = this.place;
    // Where there is no tracking there were no images.
    const number = `${path.tracking ? 'frame' : 'pose'} ${path.frame[i]}`;
    const rows: [string, string, boolean?][] = [[report.timed === false ? 'Pose' : 'Time', report.timed === false ? number : `${clock(path.time[i])}, ${number}`]];
    // A row that is known anywhere is there everywhere, so that nothing moves during the play.
    const anywhere = (values: (number | null)[]) => values.some((value) => value !== null);
    const speed = path.speed[i];
    const sigmaOfSpeed = path.speedSigma[i];
    const band = sigmaOfSpeed === null ? '' : ` ±${(sigmaOfSpeed * kmhPerMps).toFixed(1)}`;
    if (anywhere(path.speed))
      rows.push([this.reverse[i] ? 'Speed, reverse' : 'Speed', speed === null ? '-' : `${fixed(speed * kmhPerMps, 1)}${band} km/h`]);
    if (path.driven) rows.push(['Driven so far', lengthText(path.driven[i], unit)]);
    const side = (value: number, positive: string, negative: string) => {
      const length = unit === 'm' ? lengthText(Math.abs(value), unit, 10) : Math.abs(value).toFixed(1);
      return `${length} ${value < 0 ? negative : positive}`;
    };
    rows.push(['From the start', `${side(path.x[i], 'right', 'left')}, ${side(path.y[i], 'ahead', 'behind')}`]);
    const lengths = [path.x, path.y, path.z].map((values) => values.reduce((most, value) => Math.max(most, Math.abs(value)), 0));
    if (lengths[2] > 0.05 * Math.max(lengths[0], lengths[1])) rows.push(['Height', side(path.z[i], 'up', 'down')]);
    const sigma = path.sigma[i];
    if (path.scaleState) rows.push(['Scale from', scaleStateNames[path.scaleState[i]] ?? '-']);
    if (anywhere(path.sigma)) rows.push(['Uncertainty', sigma === null ? '-' : `±${(100 * sigma).toFixed(1)} % (1 sigma)`]);
    const lost = 'bu'.includes(path.tracking[i]);
    if (/[bu]/.test(path.tracking)) rows.push(['Tracking', trackingNames[path.tracking[i]] ?? '-', lost]);
    if (report.truth) {
      const error = report.truth.error[closestIndex(report.truth.time, path.time[i])];
      rows.push(['To the truth', error === null ? '-' : `${error.toFixed(2)} m`]);
    }
    element('readout').replaceChildren(
      ...rows.map(([name, value, bad]) => make('div', '', '', make('dt', name), make('dd', typeset(value), bad ? 'bad' : ''))),
    );
    const state = rows.findIndex(([name]) => name === 'Scale from');
    const term = scaleStateTerms[path.scaleState[i]];
    if (state >= 0 && term) element('readout').querySelectorAll('dd')[state].title = `scale state: ${term}`;
  }

  private showThumbnail(time: number): void {
    const thumbnails = this.report!.thumbnails;
    const shown = thumbnails[closestIndex(thumbnails.map((t) => t.time), time)] ?? null;
    if (shown === this.thumbnail) return;
    this.thumbnail = shown;
    const image = element<HTMLImageElement>('thumbnail');
    image.hidden = !shown;
    element('no-picture').hidden = shown !== null;
    element('tracked').hidden = true;
    if (!shown) return;
    image.src = `data:image/jpeg;base64,${shown.jpeg}`;
    image.alt = `Frame ${shown.frame}`;
    const why = shown.why === 'lost' ? 'tracking lost' : shown.why === 'turn' ? 'in a turn' : '';
    element('caption').textContent = `Frame ${shown.frame} at ${placeText(this.report!, shown.time)}${why && `, ${why}`}`;
    this.drawFeatures();
  }

  /** What was tracked, and what of the picture was left out. */
  private drawFeatures(): void {
    const image = element<HTMLImageElement>('thumbnail');
    const canvas = element<HTMLCanvasElement>('tracked');
    const { thumbnail } = this;
    canvas.hidden = true;
    if (!this.showFeatures || !thumbnail) return;
    if (!image.complete || image.naturalWidth === 0) {
      image.addEventListener('load', () => this.drawFeatures(), { once: true });
      return;
    }
    const { points, mask } = featuresOf(thumbnail.jpeg);
    const fine = 2;
    canvas.width = fine * image.naturalWidth;
    canvas.height = fine * image.naturalHeight;
    canvas.hidden = false;
    const context = canvas.getContext('2d')!;
    const [width, height] = [canvas.width - fine, canvas.height - fine];
    context.beginPath();
    for (const corners of mask) {
      corners.forEach(([x, y], i) => context[i ? 'lineTo' : 'moveTo'](x * width + fine / 2, y * height + fine / 2));
      context.closePath();
    }
    context.fillStyle = 'rgba(200,40,40,.45)';
    context.fill('evenodd');
    // Many dots are small ones, so that the picture stays visible between them.
    const radius = Math.min(Math.max(Math.sqrt((0.03 * width * height) / (Math.PI * Math.max(points.length, 1))), 2.2), 4);
    for (const { x, y, hasDepth } of points) {
      context.beginPath();
      context.arc(x * width + fine / 2, y * height + fine / 2, radius, 0, 2 * Math.PI);
      context.fillStyle = hasDepth ? landmarkColour : seenColour;
      context.fill();
    }
  }

  private toggleFeatures(): void {
    if (element('features').hidden) return;
    this.showFeatures = !this.showFeatures;
    element('features').setAttribute('aria-pressed', String(this.showFeatures));
    element('feature-keys').replaceChildren(...(this.showFeatures ? featureKeys() : []));
    this.drawFeatures();
  }

  private enlarge(): void {
    const large = element<HTMLDialogElement>('large');
    if (large.open) {
      large.close();
      return;
    }
    large.append(element('enlarge'));
    large.showModal();
  }

  private showTurns(): void {
    const { turns } = this.report!;
    const panel = element('turns');
    panel.hidden = turns.length === 0;
    const { timed, unit, path } = this.report!;
    const place = (time: number) => (timed === false ? String(Math.round(time)) : clock(time));
    const perUnit = unit === 'm' ? 'm/unit' : 'per unit';
    const allUsed = turns.every((turn) => turn.used);
    const names = [timed === false ? 'Poses' : 'Time', 'Angle', 'Mean speed', `Own scale, ${perUnit}`, `Smoothed, ${perUnit}`, 'Deviation', 'Effective lever arm', ...(allUsed ? [] : ['Why not used'])];
    const texts = turns.map((turn) => {
      const number = (value: number | null, text: (value: number) => string) => (value === null ? '-' : typeset(text(value)));
      return [
        `${place(turn.from)} – ${place(turn.to)}`,
        `${Math.abs(turn.angle).toFixed(0)}° ${turn.angle > 0 ? 'right' : 'left'}`,
        number(meanSpeed(path, turn.from, turn.to) ?? turn.speed, (v) => `${(v * kmhPerMps).toFixed(1)} km/h`),
        number(turn.scale, (v) => `${v.toPrecision(4)}${turn.sigma ? ` ±${((100 * turn.sigma) / v).toFixed(1)} %` : ''}`),
        number(turn.smoothed, (v) => v.toPrecision(4)),
        number(turn.deviation, (v) => `${signed(v, 1)} σ`),
        number(turn.leverArm, (v) => `${v.toFixed(2)} m`),
        ...(allUsed ? [] : [turn.used ? '' : turn.reason || 'not used']),
      ];
    });
    // What is known of no turn has no column.
    const known = names.map((_, k) => texts.some((row) => row[k] !== '-'));
    const head = ['Turn', ...names.filter((_, k) => known[k])];
    const rows = turns.map((turn, i) => {
      const go = make('button', String(i + 1));
      go.setAttribute('aria-label', `Show turn ${i + 1}`);
      const cells = texts[i].flatMap((text, k) => {
        if (!known[k]) return [];
        const cell = make('td', text, names[k] === 'Why not used' ? 'text' : '');
        cell.dataset.name = names[k];
        cell.setAttribute('role', 'cell');
        return [cell];
      });
      const first = make('td', '', '', go);
      first.setAttribute('role', 'cell');
      const row = make('tr', '', turn.used ? '' : 'unused', first, ...cells);
      row.setAttribute('role', 'row');
      row.addEventListener('click', () => this.moveToTime((turn.from + turn.to) / 2));
      return row;
    });
    const titles = make('tr', '', '', ...head.map(headOf));
    titles.setAttribute('role', 'row');
    const table = make('table', '', '', make('thead', '', '', titles), make('tbody', '', '', ...rows));
    // Styled as cards, a table would lose what it is to screen readers.
    table.setAttribute('role', 'table');
    const scroll = make('div', '', 'scroll', table);
    scroll.tabIndex = 0;
    scroll.setAttribute('role', 'region');
    scroll.setAttribute('aria-label', 'Turns');
    const note = turns.some((turn) => turn.leverArm !== null)
      ? 'Effective lever arm: the given lever arm less the side slip of the tyres at the speed of the turn.' : '';
    panel.replaceChildren(make('h2', 'Turns'), scroll, make('p', note, 'footnote'));
  }

  private showErrors(): void {
    const { errors, truth } = this.report!;
    const panel = element('errors');
    panel.hidden = errors.length === 0;
    const heading = make('h2', 'Compared with the ground truth');
    if (truth?.metresPerUnit) heading.append(make('small', `laid on the path, which is up to scale: one unit is ${truth.metresPerUnit.toPrecision(3)} m`));
    const facts = make('div', '', 'facts');
    this.showFacts(facts, errors);
    panel.replaceChildren(heading, facts);
  }

  private showSettings(): void {
    const { settings } = this.report!;
    element('settings').hidden = settings === '';
    element('settings').querySelector('pre')!.textContent = settings;
  }

  private chartData(): Omit<ChartData, 'place' | 'range' | 'spans'>[] {
    const { path, scale, rotation, truth, turns } = this.report!;
    const { theme } = this;
    const charts: ReturnType<ReportPage['chartData']> = [];
    const kmh = (values: (number | null)[]) => values.map((value) => (value === null ? null : value * kmhPerMps));
    if (path.speed.some((value) => value !== null))
      charts.push({ title: 'Speed', unit: 'km/h', digits: 1, time: path.time, include: 0, least: 2,
        bands: [{ label: 'speed', values: kmh(path.speed), sigmas: kmh(path.speedSigma), colour: theme.accent }] });
    if (scale) {
      const own = turns.filter((turn) => turn.scale !== null && turn.sigma !== null);
      charts.push({ title: 'Scale', unit: 'metres per unit of the map', digits: scale.value[0] ? Math.max(0, 3 - Math.floor(Math.log10(scale.value[0]))) : 3, time: scale.time,
        bands: [{ label: 'smoothed', values: scale.value, sigmas: scale.value.map((value, i) => value * (scale.sigma[i] ?? 0)), colour: theme.accent }],
        readings: { label: 'from one turn alone', time: own.map((turn) => (turn.from + turn.to) / 2), value: own.map((turn) => turn.scale!),
          sigma: own.map((turn) => turn.sigma!), used: own.map((turn) => turn.used), colour: theme.turn } });
    }
    // A rotation that was given was not learned.
    if (rotation?.yawSigma.some((value) => value !== null)) {
      // What was assumed before it was learned has no sigma.
      const band = (label: string, values: number[], sigmas: (number | null)[], colour: string) =>
        ({ label, values: values.map((value, i) => (sigmas[i] === null ? null : value)), sigmas, colour });
      charts.push({ title: 'Rotation of the camera in the car', unit: 'degrees', digits: 2, least: 0.5, unknown: 'not known yet', ...steps(rotation.time, [
        band('yaw', rotation.yaw, rotation.yawSigma, theme.accent), band('pitch', rotation.pitch, rotation.pitchSigma, theme.good),
        band('roll', rotation.roll, rotation.rollSigma, theme.turn)]) });
    }
    if (truth)
      charts.push({ title: 'Distance to the ground truth', unit: 'm', digits: 2, time: truth.time, include: 0,
        bands: [{ label: 'distance', values: truth.error, sigmas: truth.error.map(() => null), colour: theme.muted }] });
    return charts;
  }

  private showCharts(): void {
    this.charts.forEach((chart) => chart.destroy());
    this.charts = [];
    this.readouts = [];
    const { path, turns } = this.report!;
    const range: [number, number] | undefined = path.time.length > 1 ? [path.time[0], path.time[path.time.length - 1]] : undefined;
    const spans = turns.map((turn): [number, number] => [turn.from, turn.to]);
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
      if (spans.length > 0 && data === all[0]) {
        key(this.theme.muted, 'turn');
        keys.lastElementChild!.classList.add('span');
      }
      const title = make('h2', data.title);
      title.append(make('small', this.report!.timed === false ? `${data.unit}, over the number of the pose` : data.unit));
      const plot = make('div');
      const value = make('output', '', data.bands.length > 1 ? 'value several' : 'value');
      this.readouts.push(value);
      section.append(make('div', '', 'panel chart', make('header', '', '', title, value, keys), plot));
      this.charts.push(makeChart(plot, { ...data, range, spans, place: (time) => placeText(this.report!, time) }, this.theme, (time) => this.moveToTime(time)));
    }
  }

  private showTheme(): void {
    const { dark } = this.theme;
    document.documentElement.classList.toggle('dark', dark);
    const text = dark ? 'Dark; switch to light' : 'Light; switch to dark';
    element('theme').title = text;
    element('theme').setAttribute('aria-label', text);
  }

  private setTheme(dark: boolean): void {
    this.theme = themeOf(dark);
    this.showTheme();
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
    button.classList.toggle('playing', this.playing !== 0);
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
    click('features', () => this.toggleFeatures());
    click('enlarge', () => this.enlarge());
    // Back to its place, before the text below it.
    element('large').addEventListener('close', () => element('picture').prepend(element('enlarge')));
    click('large', () => element<HTMLDialogElement>('large').close());
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
      f: () => this.toggleFeatures(),
      ' ': () => (this.live ? element('pause').click() : this.togglePlay()),
    };
    const action = keys[event.key];
    const forControl = (onControl && event.key === ' ') || (onSlider && ['ArrowLeft', 'ArrowRight', 'Home', 'End'].includes(event.key));
    if (!action || forControl) return;
    event.preventDefault();
    action();
  }
}

/** With a decimal below `fine`. */
function lengthText(length: number, unit: string, fine = 1000): string {
  if (unit === 'm' && length >= 1000) return `${(length / 1000).toFixed(2)} km`;
  return `${length.toFixed(length < fine ? 1 : 0)} ${unit}`;
}

/** Mean over a part of the drive, whichever way the car goes; null where it is not known. */
function meanSpeed({ time, speed }: Report['path'], from: number, to: number): number | null {
  let [driven, seconds] = [0, 0];
  for (let i = 1; i < time.length; i++) {
    const [a, b] = [speed[i - 1], speed[i]];
    if (time[i] <= from || time[i - 1] >= to || a === null || b === null) continue;
    const step = Math.min(time[i], to) - Math.max(time[i - 1], from);
    driven += 0.5 * (Math.abs(a) + Math.abs(b)) * step;
    seconds += step;
  }
  return seconds > 0 ? driven / seconds : null;
}

function headOf(name: string): HTMLElement {
  const head = make('th', name, name === 'Why not used' ? 'text' : '');
  head.setAttribute('scope', 'col');
  head.setAttribute('role', 'columnheader');
  return head;
}

/** The number large, what follows it small. */
function factElement({ name, value }: { name: string; value: string }, note: Node[]): HTMLElement {
  const [, number, unit] = /^(\S+)\s*(.*)$/.exec(value) ?? ['', value, ''];
  // A break is allowed before a standard deviation and before long units only.
  const gap = unit.length > 4 ? ' ' : '\u00a0';
  return make('dl', '', unit.startsWith('±') ? 'fact uncertain' : 'fact', make('dt', name),
    make('dd', '', '', document.createTextNode(minus(number) + (unit ? gap : '')), ...(unit ? [make('small', typeset(unit))] : [])), make('dd', '', 'note', ...note));
}

/** A value that holds until the next: each change becomes a step. */
function steps(time: number[], bands: Band[]) {
  const doubled = <T>(values: T[]): T[] => values.flatMap((value, i) => (i + 1 < values.length ? [value, value] : [value]));
  return {
    time: time.flatMap((t, i) => (i + 1 < time.length ? [t, Math.max(t, time[i + 1] - 1e-3)] : [t])),
    bands: bands.map((band) => ({ ...band, values: doubled(band.values), sigmas: doubled(band.sigmas) })),
  };
}
