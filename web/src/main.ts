// SPDX-License-Identifier: MIT
import { themeOf } from './colours';
import { element } from './dom';
import { followRun } from './live';
import { ReportPage } from './page';
import type { Report } from './report';

const text = element('data').textContent?.trim() ?? '';
const dark = window.matchMedia('(prefers-color-scheme: dark)').matches;
const page = new ReportPage(themeOf(dark));
if (text) page.show(JSON.parse(text) as Report);
else followRun(page);
