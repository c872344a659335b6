// SPDX-License-Identifier: MIT
// The page in a real browser: node --test web/test, with the program and a folder for results in TURNSCALE and SCRATCH,
// and a drive to run in DRIVE. scripts/test-page sets them.
import assert from 'node:assert/strict';
import { spawn, execFileSync } from 'node:child_process';
import { connect } from 'node:net';
import { statSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, watchedPage } from '../browser.js';
import { writeHour } from './hour.js';

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

/** Share of the view's pixels that differ clearly in colour from gray: the path. */
const colouredShare = (page) => page.evaluate(() => {
  window.turnscale.view.drawNow();
  const canvas = document.querySelector('#view canvas');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let coloured = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b] = data.slice(i, i + 3);
    if (data[i + 3] > 128 && Math.max(r, g, b) - Math.min(r, g, b) > 60) coloured++;
  }
  return coloured / (data.length / 4);
});

const ground = (page) => page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);

async function checkReport(path) {
  const { page, problems } = await open(path);
  assert.ok(await colouredShare(page) > 0.002, 'the path is drawn');
  assert.ok(await page.$$eval('.chart canvas', (all) => all.length) >= 3, 'charts');
  assert.ok(await page.$$eval('#turns tbody tr', (all) => all.length) >= 1, 'turns');
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true, 'fits the width');

  // The pointer takes hold of the path, and all parts follow.
  const box = await (await page.$('#view')).boundingBox();
  const place = await page.evaluate(() => {
    const { view, report } = window.turnscale;
    const index = Math.floor(report.path.time.length * 0.6);
    return { index, x: view.screen[2 * index], y: view.screen[2 * index + 1], time: report.path.time[index] };
  });
  await page.mouse.move(box.x + place.x, box.y + place.y);
  await page.waitForFunction(() => window.turnscale.currentPlace > 0);
  const shown = await page.evaluate(() => ({ slider: Number(document.querySelector('#time').value), readout: document.querySelector('#readout').textContent }));
  const at = await page.evaluate(() => window.turnscale.currentPlace);
  assert.equal(shown.slider, at);
  assert.match(shown.readout, /km\/h/);

  // Keyboard.
  await page.focus('#view');
  await page.keyboard.press('ArrowRight');
  assert.equal(await page.evaluate(() => window.turnscale.currentPlace), at + 1);
  await page.keyboard.press('End');
  assert.equal(await page.evaluate(() => window.turnscale.currentPlace), await page.$eval('#time', (slider) => Number(slider.max)));

  // Other views.
  await page.click('#view-3d');
  await wait(700);
  assert.ok(await colouredShare(page) > 0.002, 'the path is drawn in 3-D');
  for (const by of ['sigma', 'state', 'speed']) await page.click(`[data-by=${by}]`);
  const light = await ground(page);
  await page.click('#theme');
  assert.notEqual(await ground(page), light, 'dark');
  assert.deepEqual(problems, []);
  await page.close();
}

test('the report of a rendered drive', async () => {
  execFileSync(program, [...run, '--out', join(scratch, 'run'), '--truth', join(drive, 'poses.txt'), '--quiet']);
  await checkReport(join(scratch, 'run/report.html'));
  const { page, problems } = await open(join(scratch, 'run/report.html'), { dark: true, width: 390, height: 844 });
  assert.equal(await ground(page), 'rgb(11, 16, 22)', 'dark where the system is');
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true, 'fits a phone');
  const picture = await page.$eval('#thumbnail', (image) => image.naturalWidth);
  assert.ok(picture > 200, 'a thumbnail is shown');
  const before = await page.$eval('#thumbnail', (image) => image.src);
  await page.evaluate(() => window.turnscale.moveTo(Infinity));
  assert.ok(await page.$eval('#thumbnail', (image) => image.src) !== before, 'thumbnails follow');
  assert.ok((await page.pdf()).length > 20000, 'prints');
  assert.deepEqual(problems, []);
  await page.close();
});

test('the report of an hour opens and pans', async (t) => {
  const folder = join(scratch, 'hour');
  writeHour(folder);
  execFileSync(program, ['view', folder]);
  const size = statSync(join(folder, 'report.html')).size;
  assert.ok(size < 2e6, `${size} bytes`);
  await checkReport(join(folder, 'report.html'));
  const { page, problems } = await open(join(folder, 'report.html'));
  const loaded = await page.evaluate(() => performance.getEntriesByType('navigation')[0].loadEventEnd);
  const rate = await page.evaluate(() => new Promise((done) => {
    const { view } = window.turnscale;
    const begin = performance.now();
    let pictures = 0;
    const step = () => {
      view.panBy(2, 1);
      if (++pictures < 60) requestAnimationFrame(step);
      else done((1000 * pictures) / (performance.now() - begin));
    };
    requestAnimationFrame(step);
  }));
  assert.match(await page.$eval('#warnings', (box) => box.textContent), /the lever arm <is> doubtful/);
  assert.deepEqual(problems, []);
  t.diagnostic(`${Math.round(size / 1024)} KiB, opens in ${Math.round(loaded)} ms, pans at ${Math.round(rate)} pictures/s`);
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
  await page.click('#pause');
  await page.waitForFunction((before) => window.liveState.frame > before, {}, frame);
  await page.waitForFunction(() => document.querySelector('#thumbnail').naturalWidth > 200);
  await page.waitForFunction(() => window.turnscale.currentPlace > 3);
  assert.equal(await ended, 0);
  await page.waitForSelector('.fact', { timeout: 10000 });
  assert.ok(await page.$$eval('.chart', (all) => all.length) >= 3, 'the page is the report');
  assert.deepEqual(problems, []);
  await page.close();
});

test('twenty viewers, stalled ones and ones that leave hurt nothing', async () => {
  const { address, ended } = liveRun('viewers');
  const url = new URL(await address);
  // They ask for the page and never read it, or leave at once.
  const stalled = Array.from({ length: 10 }, () => {
    const socket = connect(Number(url.port), url.hostname);
    socket.on('error', () => {});
    socket.write('GET /path.json HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n');
    socket.pause();
    return socket;
  });
  for (let i = 0; i < 10; i++) {
    const socket = connect(Number(url.port), url.hostname, () => socket.destroy());
    socket.on('error', () => {});
  }
  let answers = 0;
  let over = false;
  const viewer = async (name) => {
    while (!over) {
      try {
        const state = await (await fetch(`${url}state.json?viewer=${name}`)).json();
        answers++;
        if (state.finished) await (await fetch(`${url}report.html`)).text();
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
  assert.ok(answers > 40, `${answers} answers`);
});
