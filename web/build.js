// SPDX-License-Identifier: MIT
// Bundles the page into one file without a reference to any other: dist/page.html, which the program embeds, and
// dist/LICENSES.txt, the licences of the libraries in it. `node build.js --check` only says whether both are up to date.
import { build } from 'esbuild';
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const read = (path) => readFileSync(here(path), 'utf8');

const libraries = ['uplot'];
const licences = libraries
  .map((name) => {
    const { version, license } = JSON.parse(read(`node_modules/${name}/package.json`));
    return `${name} ${version} (${license})\n\n${read(`node_modules/${name}/LICENSE`).trim()}\n`;
  })
  .join(`\n${'-'.repeat(80)}\n\n`);

const bundle = await build({
  entryPoints: [here('src/main.ts')],
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2022',
  charset: 'ascii',
  legalComments: 'none',
  write: false,
});
const styles = await build({
  stdin: { contents: `${read('node_modules/uplot/dist/uPlot.min.css')}\n${read('src/style.css')}`, loader: 'css' },
  minify: true,
  charset: 'ascii',
  write: false,
});
const script = bundle.outputFiles[0].text.trim().replaceAll('</script', '<\\/script');
const names = libraries.map((name) => JSON.parse(read(`node_modules/${name}/package.json`))).map(({ name, version }) => `${name} ${version}`);
const page = read('src/page.html')
  .replace('<!doctype html>', `<!doctype html>\n<!-- SPDX-License-Identifier: MIT. Contains ${names.join(", ")}, MIT licence: see web/dist/LICENSES.txt of turnscale. -->`)
  .replace('/*styles*/', () => styles.outputFiles[0].text.trim())
  .replace('/*script*/', () => script);

const results = { 'dist/page.html': page, 'dist/LICENSES.txt': licences };
if (process.argv.includes('--check')) {
  const stale = Object.keys(results).filter((path) => results[path] !== read(path));
  if (stale.length > 0) {
    console.error(`${stale.map((path) => `web/${path}`).join(', ')}: not made from the sources beside it; run scripts/build-page`);
    process.exit(1);
  }
} else {
  for (const [path, text] of Object.entries(results)) writeFileSync(here(path), text);
  console.log(`web/dist/page.html: ${Math.round(page.length / 1024)} KiB`);
}
