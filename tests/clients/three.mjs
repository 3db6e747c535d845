// Judges packs by their looks: every LOD is loaded by three.js in a headless browser, drawn, and
// measured from two sides against the manifest and against LOD0.

import { mkdir, mkdtemp, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { parseArgs } from 'node:util';
import { chromium } from 'playwright-core';
import { Score, readPack, requirePacks } from './pack.mjs';
import { serve } from './server.mjs';

/** Silhouette area of a LOD over that of LOD0, seen from the same side. */
const AREA_BAND = [0.75, 1.3];
/** Mean brightness of a LOD's foliage over that of LOD0's. */
const BRIGHTNESS_BAND = [0.6, 1.6];
/** Least share of the picture that a tree covers when it fills the frame. */
const LEAST_AREA = 0.02;
/** Least share of the picture that foliage covers, where a LOD has any. */
const LEAST_FOLIAGE = 0.002;
/** Most of the foliage that may be pure white, or pure black. */
const MOST_CLIPPED = 0.02;
/** A LOD that takes longer than this to load and draw has hung. */
const PATIENCE_MS = 120_000;

const BROWSER = process.env.CHROMIUM ?? '/usr/bin/chromium';
const BROWSER_ARGS = [
  '--headless',
  '--no-sandbox',
  '--use-gl=angle',
  '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];

const within = (value, [low, high]) => value >= low && value <= high;
const percent = (share) => `${(100 * share).toFixed(1)}%`;
const percents = (views, key) => views.map((view) => percent(view[key])).join(' ');
const firstLine = (error) => String(error.message ?? error).split('\n')[0];

const { values: options, positionals: dirs } = parseArgs({
  allowPositionals: true,
  options: { out: { type: 'string' } },
});
requirePacks(dirs, 'node three.mjs PACK_DIR... [--out DIR]');
if (options.out) await mkdir(options.out, { recursive: true });

const score = new Score();
const profile = await mkdtemp(path.join(tmpdir(), 'pleach-clients-'));
const server = await serve();
const context = await chromium.launchPersistentContext(profile, {
  executablePath: BROWSER,
  args: BROWSER_ARGS,
  viewport: { width: 1024, height: 512 },
});
try {
  for (const dir of dirs) await judgePack(dir);
} finally {
  await context.close();
  server.close();
  await rm(profile, { recursive: true, force: true });
}
score.close();

async function judgePack(dir) {
  let pack;
  try {
    pack = await readPack(dir);
  } catch (error) {
    score.judge(dir, [error.message]);
    return;
  }
  server.setPack(pack.dir);
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  const complaints = listen(page);
  try {
    await page.goto(`${server.origin}/page.html`);
    await page.waitForFunction(() => window.judge !== undefined);
    let first = null;
    for (const lod of pack.manifest.lods) {
      const { faults, note, seen } = await judgeLod(page, pack, lod, first);
      first ??= seen;
      score.judge(`${pack.name}/${lod.file}`, [...faults, ...complaints.splice(0)], note);
    }
    if (options.out) await savePicture(page, '#sheet', `${pack.name}_sheet.png`);
  } catch (error) {
    score.judge(pack.name, [firstLine(error), ...complaints]);
  } finally {
    await page.close();
  }
}

/** Collects what goes wrong in a page beside the judgement: errors, failed and foreign requests. */
function listen(page) {
  const complaints = [];
  page.on('console', (message) => {
    if (message.type() === 'error') complaints.push(`console error: ${message.text()}`);
  });
  page.on('pageerror', (error) => complaints.push(`uncaught: ${firstLine(error)}`));
  page.on('requestfailed', (request) => {
    complaints.push(`request failed: ${request.url()} (${request.failure()?.errorText})`);
  });
  page.on('response', (response) => {
    if (response.status() >= 400) complaints.push(`${response.status()} for ${response.url()}`);
  });
  page.on('request', (request) => {
    const url = request.url();
    const own = url.startsWith(server.origin) || /^(blob|data):/.test(url);
    if (!own) complaints.push(`request to another host: ${url}`);
  });
  return complaints;
}

async function judgeLod(page, pack, lod, first) {
  const url = `/pack/${lod.file.split('/').map(encodeURIComponent).join('/')}`;
  const label = `LOD${lod.index}: ${lod.triangles} triangles`;
  let seen;
  try {
    seen = await withDeadline(
      page.evaluate(([u, l]) => window.judge.lod(u, l), [url, label]),
      lod.file,
    );
  } catch (error) {
    return { faults: [firstLine(error)], note: '', seen: null };
  }
  if (options.out) await savePicture(page, '#view', `${pack.name}_LOD${lod.index}.png`);
  const faults = [...judgeMaterials(seen), ...judgeViews(seen, lod)];
  let note = `${seen.views[0].triangles} triangles, area ${percents(seen.views, 'area')}`;
  if (lod.index > 0 && first === null) faults.push('LOD0 did not load, nothing to compare with');
  else if (lod.index > 0) {
    const compared = compareWithFirst(seen, first);
    faults.push(...compared.faults);
    note += compared.note;
  }
  return { faults, note, seen };
}

function judgeMaterials({ materials }) {
  const faults = [];
  for (const { name, alphaTest, doubleSided, metalness } of materials) {
    if (name === 'foliage' && alphaTest !== 0.5) faults.push(`foliage: alphaTest ${alphaTest}`);
    if (name === 'foliage' && !doubleSided) faults.push('foliage is not double-sided');
    if (name === 'bark' && alphaTest !== 0) faults.push(`bark: alphaTest ${alphaTest}`);
    if (metalness !== 0) faults.push(`${name}: metalness ${metalness}`);
  }
  return faults;
}

function judgeViews({ views }, lod) {
  const faults = [];
  for (const { side, triangles, area, foliage } of views) {
    if (triangles !== lod.triangles) {
      faults.push(`${side}: ${triangles} triangles drawn, the manifest says ${lod.triangles}`);
    }
    if (area < LEAST_AREA) faults.push(`${side}: blank, only ${percent(area)} is covered`);
    if (foliage === null) continue;
    if (foliage.area < LEAST_FOLIAGE) faults.push(`${side}: foliage covers ${percent(foliage.area)}`);
    if (foliage.white > MOST_CLIPPED) faults.push(`${side}: ${percent(foliage.white)} of the foliage is white`);
    if (foliage.black > MOST_CLIPPED) faults.push(`${side}: ${percent(foliage.black)} of the foliage is black`);
  }
  return faults;
}

function compareWithFirst(seen, first) {
  const faults = [];
  const areas = [];
  const brightnesses = [];
  seen.views.forEach((view, i) => {
    const area = view.area / first.views[i].area;
    areas.push(area.toFixed(2));
    if (!within(area, AREA_BAND)) {
      faults.push(`${view.side}: silhouette is ${area.toFixed(2)} of LOD0's`);
    }
    const brightness = view.foliage?.brightness / first.views[i].foliage?.brightness;
    if (!Number.isFinite(brightness)) return;
    brightnesses.push(brightness.toFixed(2));
    if (!within(brightness, BRIGHTNESS_BAND)) {
      faults.push(`${view.side}: foliage is ${brightness.toFixed(2)} as bright as LOD0's`);
    }
  });
  const note = `, of LOD0's: area ${areas.join(' ')}, brightness ${brightnesses.join(' ') || '-'}`;
  return { faults, note };
}

async function savePicture(page, selector, name) {
  await writeFile(path.join(options.out, name), await page.locator(selector).screenshot());
}

async function withDeadline(promise, what) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`${what}: not drawn in time`)), PATIENCE_MS);
  });
  return Promise.race([promise, late]).finally(() => clearTimeout(timer));
}
