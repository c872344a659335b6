// SPDX-License-Identifier: MIT
// Chromium as the tests and the screenshots use it.
import { existsSync } from 'node:fs';
import puppeteer from 'puppeteer-core';

const places = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];

/** Path of the browser; undefined if there is none. */
export const chromium = places.find((path) => path && existsSync(path));

export function launch() {
  return puppeteer.launch({
    executablePath: chromium,
    headless: true,
    args: ['--no-sandbox', '--disable-dev-shm-usage', '--disable-gpu', '--hide-scrollbars'],
  });
}

/** A page that records what must not happen: console errors, and requests other than to `allowed`. */
export async function watchedPage(browser, allowed = () => false) {
  const page = await browser.newPage();
  // Machines that build at the same time are slow.
  page.setDefaultTimeout(90000);
  const problems = [];
  page.on('console', (message) => { if (message.type() === 'error') problems.push(`console: ${message.text()}`); });
  page.on('pageerror', (error) => problems.push(`error: ${error.message}`));
  page.on('request', (request) => {
    const url = request.url();
    if (!/^(file|data|blob|about):/.test(url) && !allowed(url)) problems.push(`request: ${url}`);
  });
  return { page, problems };
}
