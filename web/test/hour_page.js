// SPDX-License-Identifier: MIT
// The report of an hour of driving in a browser: how large it is, how soon it is there, and how fast it moves.
// node web/test/hour_page.js PROGRAM FOLDER prints that as JSON, for benchmarks/report.
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch, watchedPage } from '../browser.js';
import { writeHour } from './hour.js';

/** An image of a street, as large as a thumbnail of a drive. */
async function thumbnail(browser) {
  const page = await browser.newPage();
  const url = await page.evaluate(() => {
    const canvas = document.createElement('canvas');
    canvas.width = 480;
    canvas.height = 270;
    const context = canvas.getContext('2d');
    for (let i = 0; i < 2500; i++) {
      context.fillStyle = `hsl(210 10% ${(i * 7919) % 100}%)`;
      context.fillRect((i * 104729) % 480, (i * 15485863) % 270, 7 + (i % 19), 6 + (i % 13));
    }
    return canvas.toDataURL('image/jpeg', 0.6);
  });
  await page.close();
  return Buffer.from(url.split(',')[1], 'base64');
}

/** Makes the report in the folder. Gives the bytes of the page without its thumbnails, and those of the thumbnails. */
export async function makeHour(browser, program, folder) {
  writeHour(folder, await thumbnail(browser));
  execFileSync(program, ['view', folder, '--truth', join(folder, 'truth.tum')]);
  const text = readFileSync(join(folder, 'report.html'), 'utf8');
  const thumbnails = [...text.matchAll(/"jpeg":"([^"]*)"/g)].reduce((sum, [, jpeg]) => sum + jpeg.length, 0);
  return { page: text.length - thumbnails, thumbnails };
}

/** Pictures per second while the path is moved. */
export const panRate = (page) => page.evaluate(() => new Promise((done) => {
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

/** Milliseconds from the request of the page to its end of loading, by when the path and the charts are drawn. */
export const loadTime = (page) => page.evaluate(() => performance.getEntriesByType('navigation')[0].loadEventEnd);

if (process.argv[1] === import.meta.filename) {
  const [, , program, folder] = process.argv;
  const browser = await launch();
  const sizes = await makeHour(browser, program, folder);
  const opened = [];
  const rates = [];
  for (let i = 0; i < 5; i++) {
    const { page, problems } = await watchedPage(browser);
    await page.setViewport({ width: 1360, height: 900 });
    await page.goto(pathToFileURL(join(folder, 'report.html')).href);
    await page.waitForFunction(() => window.turnscale.view.pictures > 1);
    opened.push(await loadTime(page));
    rates.push(await panRate(page));
    if (problems.length > 0) throw new Error(problems.join('\n'));
    await page.close();
  }
  await browser.close();
  console.log(JSON.stringify({ ...sizes, opened, rates }));
}
