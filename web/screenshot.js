// SPDX-License-Identifier: MIT
// node screenshot.js REPORT PICTURE [--size WIDTHxHEIGHT] [--dark] [--3d] [--at SHARE] [--full] [--by speed|sigma|state] [--features]
// A picture of a report, as the README shows it.
import { parseArgs } from 'node:util';
import { pathToFileURL } from 'node:url';
import { launch, watchedPage } from './browser.js';

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    size: { type: 'string', default: '1360x1020' }, dark: { type: 'boolean' }, '3d': { type: 'boolean' },
    at: { type: 'string', default: '0.5' }, full: { type: 'boolean' }, by: { type: 'string', default: 'speed' },
    ratio: { type: 'string', default: '1' }, features: { type: 'boolean' },
  },
});
const [report, picture] = positionals;
const [width, height] = values.size.split('x').map(Number);
const browser = await launch();
const { page, problems } = await watchedPage(browser);
await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: values.dark ? 'dark' : 'light' }]);
await page.setViewport({ width, height, deviceScaleFactor: Number(values.ratio) });
await page.goto(pathToFileURL(report).href);
await page.evaluate((by, in3d, at, features) => {
  document.querySelector(`[data-by=${by}]`).click();
  if (features) document.querySelector('#features').click();
  if (in3d) document.querySelector('#view-3d').click();
  const slider = document.querySelector('#time');
  slider.value = String(Math.round(at * Number(slider.max)));
  slider.dispatchEvent(new Event('input'));
}, values.by, values['3d'], Number(values.at), values.features);
await new Promise((done) => setTimeout(done, 600));
await page.screenshot({ path: picture, fullPage: values.full });
await browser.close();
if (problems.length > 0) {
  console.error(problems.join('\n'));
  process.exit(1);
}
