// SPDX-License-Identifier: MIT
// The page in a real browser: node --test web/test, with the program and a folder for results in TURNSCALE and SCRATCH,
// and a drive to run in DRIVE. scripts/test-page sets them.
import assert from 'node:assert/strict';
import { spawn, execFileSync } from 'node:child_process';
import { connect } from 'node:net';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, watchedPage } from '../browser.js';
import { loadTime, makeHour, panRate } from './hour_page.js';

const { TURNSCALE: program, SCRATCH: scratch, DRIVE: drive } = process.env;
const run = ['run', drive, '--lever-arm', '1.5'];
const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
let browser;
before(async () => { browser = await launch(); });
const children = [];
after(async () => {
  for (const child of children) child.kill('SIGKILL');
  await browser.close();
});

async function open(path, { dark = false, width = 1360, height = 900 } = {}) {
  const { page, problems } = await watchedPage(browser);
  await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: dark ? 'dark' : 'light' }]);
  await page.setViewport({ width, height });
  await page.goto(pathToFileURL(path).href);
  await page.waitForFunction(() => document.querySelector('#view canvas').width > 300 && window.turnscale.view.pictures > 1);
  return { page, problems };
}

/** Share of points along the path at which, or beside a dash of the truth above it, its colour is drawn. */
const drawnShare = (page) => page.evaluate(() => {
  const { view, report } = window.turnscale;
  view.drawNow();
  const canvas = document.querySelector('#view canvas');
  const context = canvas.getContext('2d');
  const ratio = canvas.width / canvas.clientWidth;
  const count = report.path.time.length;
  const near = 2;
  const coloured = ([r, g, b, a]) => a > 200 && Math.max(r, g, b) - Math.min(r, g, b) > 60;
  let drawn = 0;
  for (let k = 1; k < 50; k++) {
    const i = Math.floor((k / 50) * count);
    const side = 2 * near + 1;
    const { data } = context.getImageData(Math.round(view.screen[2 * i] * ratio) - near, Math.round(view.screen[2 * i + 1] * ratio) - near, side, side);
    if (Array.from({ length: side * side }, (_, at) => data.subarray(4 * at, 4 * at + 4)).some(coloured)) drawn++;
  }
  return drawn / 49;
});

/** Moves the pointer onto the path, at this share of its points; gives the point's number. */
async function pointAt(page, share) {
  const box = await (await page.$('#view')).boundingBox();
  const place = await page.evaluate((at) => {
    const { view, report } = window.turnscale;
    const index = Math.floor(report.path.time.length * at);
    return { index, x: view.screen[2 * index], y: view.screen[2 * index + 1] };
  }, share);
  await page.mouse.move(box.x + place.x, box.y + place.y);
  return place.index;
}

/** Of the path's points on the screen and the names of its ends, those that buttons hide. */
const hiddenPlaces = (page) => page.evaluate(() => {
  const { view } = window.turnscale;
  const frame = document.querySelector('#view').getBoundingClientRect();
  const buttons = document.querySelector('.zoom').getBoundingClientRect();
  const places = [...view.names];
  for (let i = 0; i < view.screen.length; i += 2) places.push([view.screen[i], view.screen[i + 1]]);
  return places.filter(([x, y]) => x + frame.left < buttons.right && y + frame.top > buttons.top || x < 0 || y < 0 || x > frame.width || y > frame.height);
});

/** Pixels between two points of the path on the screen. */
const apart = (page, i, k) => page.evaluate((a, b) => {
  const { screen } = window.turnscale.view;
  return Math.hypot(screen[2 * a] - screen[2 * b], screen[2 * a + 1] - screen[2 * b + 1]);
}, i, k);

/** What the tab key reaches, in order, and whether each shows that it has the focus. */
async function tabStops(page) {
  const stops = [];
  await page.evaluate(() => { document.body.tabIndex = -1; document.body.focus(); });
  for (let i = 0; i < 500; i++) {
    await page.keyboard.press('Tab');
    const stop = await page.evaluate(() => {
      const at = document.activeElement;
      return at === document.body ? null : { name: at.id || at.dataset.by || at.className || at.tagName.toLowerCase(), outline: getComputedStyle(at).outlineStyle };
    });
    if (!stop) break;
    stops.push(stop);
  }
  return stops;
}

const ground = (page) => page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);

async function checkReport(path) {
  const { page, problems } = await open(path);
  assert.ok(await drawnShare(page) > 0.8, 'the path is drawn where it is');
  assert.ok(await page.$$eval('.chart canvas', (all) => all.length) >= 3, 'charts');
  assert.ok(await page.$$eval('#turns tbody tr', (all) => all.length) >= 1, 'turns');
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true, 'fits the width');

  // The pointer takes hold of the path, and all parts follow.
  const pointed = await pointAt(page, 0.6);
  await page.waitForFunction(() => window.turnscale.currentPlace > 0);
  const shown = await page.evaluate(() => ({ slider: Number(document.querySelector('#time').value), readout: document.querySelector('#readout').textContent }));
  const at = await page.evaluate(() => window.turnscale.currentPlace);
  assert.ok(await apart(page, at, pointed) < 2, 'the place is the one that was pointed at');
  assert.equal(shown.slider, at);
  assert.match(shown.readout, /km\/h/);
  const time = await page.evaluate(() => window.turnscale.report.path.time[window.turnscale.currentPlace]);
  const moment = `${Math.floor(time / 60) % 60}:${String(Math.floor(time) % 60).padStart(2, '0')}`;
  assert.ok((await page.$eval('#clock', (clock) => clock.textContent)).startsWith(moment), 'the clock follows');

  // Moments are links.
  const linked = await page.$eval('.fact .moment', (button) => { button.click(); return button.textContent; });
  const seconds = (text) => text.split(':').reduce((sum, part) => 60 * sum + Number(part), 0);
  const led = seconds(await page.$eval('#clock', (clock) => clock.textContent));
  // The points of an hour are up to a second apart.
  assert.ok(Math.abs(led - seconds(linked)) < 1, `${linked} leads to ${led} s`);
  await page.evaluate((index) => window.turnscale.moveTo(index), at);

  // Keyboard.
  await page.focus('#view');
  await page.keyboard.press('ArrowRight');
  assert.equal(await page.evaluate(() => window.turnscale.currentPlace), at + 1);
  await page.keyboard.press('End');
  assert.equal(await page.evaluate(() => window.turnscale.currentPlace), await page.$eval('#time', (slider) => Number(slider.max)));

  await page.keyboard.press('Home');
  assert.equal(await page.evaluate(() => window.turnscale.currentPlace), 0);
  await page.keyboard.press(' ');
  await page.waitForFunction(() => window.turnscale.currentPlace > 0);
  await page.keyboard.press('Escape');
  const stopped = await page.evaluate(() => window.turnscale.currentPlace);
  await wait(300);
  assert.equal(await page.evaluate(() => window.turnscale.currentPlace), stopped, 'escape ends the play');
  // On a button, arrow keys move along the path too.
  await page.focus('#fit');
  await page.keyboard.press('End');
  await page.keyboard.press('ArrowLeft');
  assert.equal(await page.evaluate(() => window.turnscale.currentPlace), await page.$eval('#time', (slider) => Number(slider.max) - 1));
  // Elsewhere, keys are those of the browser.
  const held = await page.evaluate(() => [window.turnscale.currentPlace, document.documentElement.className]);
  for (const place of ['summary', '#turns .scroll', '#theme']) {
    await page.focus(place);
    for (const key of ['End', 'Home', 'ArrowLeft', 't', 'l', '3']) await page.keyboard.press(key);
  }
  assert.deepEqual(await page.evaluate(() => [window.turnscale.currentPlace, document.documentElement.className]), held, 'no keys outside of the picture');
  assert.equal(await page.$eval('#view-3d', (button) => button.getAttribute('aria-pressed')), 'false');
  const stops = await tabStops(page);
  for (const name of ['theme', 'view-above', 'view-3d', 'speed', 'sigma', 'state', 'error', 'landmarks', 'zoom-in', 'zoom-out', 'fit', 'view', 'play', 'time', 'summary'])
    assert.ok(stops.some((stop) => stop.name === name), `the tab key reaches ${name} (${stops.map((stop) => stop.name)})`);
  assert.deepEqual(stops.filter((stop) => stop.outline === 'none').map((stop) => stop.name), [], 'the focus is visible');

  // Other views.
  await page.evaluate(() => window.turnscale.view.fit());
  assert.deepEqual(await hiddenPlaces(page), [], 'no button is above the path');
  await page.click('#view-3d');
  await wait(700);
  assert.deepEqual(await hiddenPlaces(page), [], 'no button is above the path in 3-D');
  assert.ok(await drawnShare(page) > 0.8, 'the path is drawn in 3-D');
  const legends = [];
  for (const by of ['sigma', 'state', 'error', 'speed']) {
    await page.click(`[data-by=${by}]`);
    assert.ok(await drawnShare(page) > 0.8, `the path is drawn by ${by}`);
    legends.push(await page.$eval('#legend', (legend) => legend.textContent));
  }
  assert.equal(new Set(legends).size, 4);
  const light = await ground(page);
  await page.click('#theme');
  assert.notEqual(await ground(page), light, 'dark');
  assert.deepEqual(problems, []);
  await page.close();
}

/** The car of the picture: where its nose points, what it sees, and that nothing moves during the play. */
async function checkPicture(path) {
  const { page, problems } = await open(path, { width: 1360, height: 900 });
  const nose = await page.evaluate(() => {
    const { view, report: { path: { speed, x, y } } } = window.turnscale;
    const steps = speed.map((value, i) => ({ value, i })).filter(({ value, i }) => Math.abs(value) > 0.8 && i > 1 && i + 2 < speed.length);
    // Cosine between the arrow and the motion on the screen: it has the sign of the speed.
    return steps.map(({ value, i }) => {
      const angle = view.directionOf(i);
      const motion = [view.screen[2 * i + 4] - view.screen[2 * i - 4], view.screen[2 * i + 5] - view.screen[2 * i - 3]];
      return { value, along: (Math.cos(angle) * motion[0] + Math.sin(angle) * motion[1]) / Math.hypot(...motion), x: x[i], y: y[i] };
    });
  });
  assert.ok(nose.length > 50);
  assert.ok(nose.some(({ value }) => value < 0), 'the drive begins in reverse');
  assert.deepEqual(nose.filter(({ value, along }) => Math.sign(value) * along < 0.7), [], 'the arrow points where the nose does');
  assert.match(await page.$eval('#legend', (legend) => legend.textContent), /reverse.*ground truth.*turn used for the scale/);
  const layout = () => page.evaluate(() => ['#view', '#readout', '#charts'].map((name) => {
    const { top, height } = document.querySelector(name).getBoundingClientRect();
    return [name, Math.round(top), Math.round(height)];
  }));
  const before = await layout();
  const last = await page.$eval('#time', (slider) => Number(slider.max));
  for (let k = 0; k <= 40; k++) {
    await page.evaluate((index) => window.turnscale.moveTo(index), Math.floor((k / 40) * last));
    assert.deepEqual(await layout(), before, `nothing moves at ${k} of 40`);
  }
  // What was tracked is drawn on demand.
  const shown = () => page.$eval('#tracked', (canvas) => !canvas.hidden && canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some((value) => value > 0));
  assert.equal(await page.$eval('#tracked', (canvas) => canvas.hidden), true);
  await page.click('#features');
  await page.waitForFunction(() => !document.querySelector('#tracked').hidden);
  assert.ok(await shown(), 'features are drawn');
  await page.click('#enlarge');
  assert.ok(await page.$eval('#large #thumbnail', (image) => image.getBoundingClientRect().width > 700), 'the picture is enlarged');
  await page.keyboard.press('Escape');
  await page.waitForSelector('#picture #thumbnail');
  assert.deepEqual(problems, []);
  await page.close();
}

test('the report of a rendered drive', async () => {
  execFileSync(program, [...run, '--out', join(scratch, 'run'), '--truth', join(drive, 'poses.txt'), '--quiet']);
  await checkReport(join(scratch, 'run/report.html'));
  await checkPicture(join(scratch, 'run/report.html'));
  const { page, problems } = await open(join(scratch, 'run/report.html'), { dark: true, width: 390, height: 844 });
  assert.equal(await ground(page), 'rgb(11, 16, 22)', 'dark where the system is');
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true, 'fits a phone');
  assert.ok(await drawnShare(page) > 0.8, 'the path is drawn in the dark');
  const clipped = await page.$$eval('.fact dd', (all) => all.filter((dd) => dd.scrollWidth > dd.clientWidth).map((dd) => dd.textContent));
  assert.deepEqual(clipped, [], 'all numbers fit');
  assert.deepEqual(await hiddenPlaces(page), [], 'no button is above the path on a phone');
  const [slider, view] = await page.evaluate(() => ['#time', '#thumbnail'].map((name) => document.querySelector(name).getBoundingClientRect()).map(({ top, bottom }) => [top, bottom]));
  assert.ok(view[1] - slider[0] < 600, 'the slider and the picture are on one screen');
  assert.ok(slider[1] < 844, 'the path and its slider are on the first screen');
  const picture = await page.$eval('#thumbnail', (image) => image.naturalWidth);
  assert.ok(picture > 200, 'a thumbnail is shown');
  const before = await page.$eval('#thumbnail', (image) => image.src);
  await page.evaluate(() => window.turnscale.moveTo(Infinity));
  assert.ok(await page.$eval('#thumbnail', (image) => image.src) !== before, 'thumbnails follow');
  // Paper: light, of its own width, and all of the path in one canvas (paper shows a clear one above it as white).
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  assert.equal(await ground(page), 'rgb(255, 255, 255)');
  assert.ok(await drawnShare(page) > 0.8, 'the path is drawn on paper');
  assert.equal(await page.$eval('#view canvas + canvas', (canvas) => getComputedStyle(canvas).display), 'none');
  const tooWide = await page.$$eval('.chart canvas', (all) => all.filter((canvas) => canvas.getBoundingClientRect().right > 700).length);
  assert.equal(tooWide, 0, 'charts fit the paper');
  await page.evaluate(() => window.dispatchEvent(new Event('afterprint')));
  assert.equal(await ground(page), 'rgb(11, 16, 22)', 'dark again');
  assert.ok((await page.pdf()).length > 100000, 'prints');
  assert.deepEqual(problems, []);
  await page.close();
});

test('the page of a comparison, without pictures', async () => {
  const path = join(scratch, 'comparison.html');
  execFileSync(program, ['evaluate', join(scratch, 'run/trajectory.tum'), join(drive, 'poses.txt'), '--report', path]);
  const { page, problems } = await open(path);
  assert.ok(await drawnShare(page) > 0.8, 'the path is drawn');
  assert.deepEqual(await hiddenPlaces(page), [], 'no button is above the path');
  const [stage, view] = await page.evaluate(() => ['.stage', '#view'].map((name) => document.querySelector(name).getBoundingClientRect().width));
  assert.ok(view > stage - 4, 'the path has the whole width');
  assert.deepEqual(problems, []);
  await page.close();
});

test('the report of an hour opens and pans', async (t) => {
  const folder = join(scratch, 'hour');
  const sizes = await makeHour(browser, program, folder);
  assert.ok(sizes.page < 2e6, `${sizes.page} bytes`);
  assert.ok(sizes.thumbnails > 2e6 && sizes.thumbnails < 3e6, `${sizes.thumbnails} bytes of thumbnails`);
  await checkReport(join(folder, 'report.html'));
  const { page, problems } = await open(join(folder, 'report.html'));
  const loaded = await loadTime(page);
  const rate = await panRate(page);
  assert.match(await page.$eval('#warnings', (box) => box.textContent), /the lever arm <is> doubtful/);
  assert.deepEqual(problems, []);
  t.diagnostic(`${Math.round(sizes.page / 1024)} KiB and ${Math.round(sizes.thumbnails / 1024)} KiB of thumbnails, opens in ${Math.round(loaded)} ms, pans at ${Math.round(rate)} pictures/s`);
  await page.close();
});

/** Starts a live run; gives its address and its end. */
function liveRun(name) {
  const child = spawn(program, [...run, '--out', join(scratch, name), '--live', '--quiet']);
  children.push(child);
  const ended = new Promise((done) => child.on('close', done));
  const address = new Promise((done, fail) => {
    let text = '';
    child.stdout.on('data', (data) => {
      text += data;
      const found = text.match(/live\s+(http:\/\/127\.0\.0\.1:\d+\/)/);
      if (found) done(found[1]);
    });
    child.on('close', () => fail(new Error('no address')));
  });
  return { address, ended };
}

test('the live page follows a run and becomes its report', async () => {
  const { address, ended } = liveRun('live');
  const url = await address;
  const command = (name) => fetch(url + name, { method: 'POST', headers: { 'X-Turnscale': '1' } });
  // A browser may take longer to start than the run has left.
  await command('pause');
  const { page, problems } = await watchedPage(browser, (request) => request.startsWith(url));
  await page.goto(url);
  await page.waitForFunction(() => window.liveUpdates >= 3 && window.liveState.paused);
  const frame = await page.evaluate(() => window.liveState.frame);
  await wait(500);
  assert.equal(await page.evaluate(() => window.liveState.frame), frame, 'paused');
  assert.equal(await page.evaluate(() => window.liveState.report), join(scratch, 'live/report.html'));
  // A viewer who leaves says so, and is not waited for.
  const told = await page.evaluate(async () => {
    const asked = [];
    navigator.sendBeacon = (name) => asked.push(name);
    window.dispatchEvent(new PageTransitionEvent('pagehide'));
    return { name: asked[0], status: (await fetch(asked[0], { method: 'POST' })).status };
  });
  assert.match(told.name, /^leave\?viewer=\w+/);
  assert.equal(told.status, 200);
  // The space key does what the button does.
  await page.focus('#view');
  await page.keyboard.press(' ');
  await page.waitForFunction((before) => window.liveState.frame > before, {}, frame);
  await page.waitForFunction(() => document.querySelector('#thumbnail').naturalWidth > 200);
  await page.waitForFunction(() => window.turnscale.currentPlace > 8);
  // A place that the reader points at stays; the image stays that of the present.
  const pointed = await pointAt(page, 0.5);
  await page.waitForFunction((index) => Math.abs(window.turnscale.currentPlace - index) <= 2, {}, pointed);
  const path = await page.evaluate(() => window.liveState.path);
  await page.waitForFunction((before) => window.liveState.path > before, {}, path);
  assert.ok(await page.evaluate(() => !document.querySelector('#thumbnail').hidden), 'the image stays');
  assert.ok(await page.evaluate(() => window.turnscale.currentPlace < window.turnscale.report.path.time.length - 1), 'the place is held');
  await page.mouse.move(2, 2);
  await page.waitForFunction(() => window.turnscale.currentPlace === window.turnscale.report.path.time.length - 1);
  await page.waitForFunction(() => window.turnscale.report.path.speed.some((speed) => speed !== null && speed < -0.5)); // it begins in reverse
  assert.equal(await ended, 0);
  await page.waitForSelector('.fact');
  assert.ok(await page.$$eval('.chart', (all) => all.length) >= 3, 'the page is the report');
  assert.deepEqual(problems, []);
  await page.close();
});

test('twenty viewers, stalled ones and ones that leave hurt nothing', async () => {
  const { address, ended } = liveRun('viewers');
  const url = new URL(await address);
  // They ask and never read, or send half of a request, or leave at once. (An answer that is longer than what the system
  // keeps for the viewer is in live_page_test.)
  const requests = ['GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n', 'GET /image.jpg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n', 'GET /path.json HTTP/1.1\r\nHo'];
  const stalled = Array.from({ length: 30 }, (_, i) => {
    const socket = connect(Number(url.port), url.hostname);
    socket.on('error', () => {});
    socket.write(requests[i % requests.length]);
    socket.pause();
    return socket;
  });
  for (let i = 0; i < 10; i++) {
    const socket = connect(Number(url.port), url.hostname, () => socket.destroy());
    socket.on('error', () => {});
  }
  const answers = new Map();
  let over = false;
  const viewer = async (name) => {
    while (!over) {
      try {
        const state = await (await fetch(`${url}state.json?viewer=${name}`)).json();
        answers.set(name, (answers.get(name) ?? 0) + 1);
        if (state.finished) await (await fetch(`${url}report.html?viewer=${name}`)).text();
        else await (await fetch(`${url}image.jpg?${state.image}`)).arrayBuffer();
      } catch { /* the run has ended */ }
      await wait(250);
    }
  };
  const viewers = Array.from({ length: 20 }, (_, i) => viewer(`v${i}`));
  assert.equal(await ended, 0);
  over = true;
  await Promise.all(viewers);
  stalled.forEach((socket) => socket.destroy());
  assert.equal(answers.size, 20, 'every viewer was answered');
  assert.ok(Math.min(...answers.values()) >= 2, `${[...answers.values()]} answers`);
  const trajectory = (name) => readFileSync(join(scratch, name, 'trajectory.tum'), 'utf8');
  assert.ok(trajectory('viewers') === trajectory('run'), 'the results are those of a run without viewers');
});
