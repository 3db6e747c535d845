// Judges the judges: a whole sample pack must pass both, and each planted fault must be found by
// the judge that is meant to find it, with the word that names it.

import { execFile } from 'node:child_process';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { Score } from './pack.mjs';
import { FAULTS, writeSample } from './sample.mjs';

/** Fault -> judge -> what its output must say. A judge that is not named is not asked. */
const EXPECTED = {
  truncated: { validate: /GLB_|IO_ERROR/, three: /FAIL .*LOD1/ },
  'wrong-bounds': { validate: /ACCESSOR_MAX_MISMATCH/ },
  'wrong-count': { validate: /808 triangles, the manifest says 809/, three: /808 triangles drawn/ },
  'missing-texture': { validate: /IO_ERROR .*foliage\.png/, three: /404 .*foliage\.png/ },
  unlisted: { validate: /left-over\.png: not listed/ },
  'wrong-hash': { validate: /bark\.png: sha256 differs/ },
  opaque: { validate: /foliage is OPAQUE/, three: /foliage: alphaTest 0/ },
  'single-sided': { validate: /not double-sided/, three: /not double-sided/ },
  shrunk: { three: /silhouette is 0\.\d+ of LOD0's/ },
  black: { three: /foliage is black/ },
  white: { three: /foliage is white/ },
  empty: { three: /foliage covers 0\.0%/ },
};

const score = new Score();
const folder = await mkdtemp(path.join(tmpdir(), 'pleach-selftest-'));
try {
  for (const embed of [false, true]) {
    const dir = await writeSample(path.join(folder, embed ? 'embedded' : 'whole'), { embed });
    for (const judge of ['validate', 'three']) {
      const { code, text } = await ask(judge, dir);
      const faults = code === 0 ? [] : [`exit code ${code}`, ...text.split('\n')];
      score.judge(`${judge} accepts a whole pack${embed ? ' with embedded textures' : ''}`, faults);
    }
  }
  for (const fault of Object.keys(FAULTS)) {
    const dir = await writeSample(path.join(folder, fault), { fault });
    for (const [judge, pattern] of Object.entries(EXPECTED[fault])) {
      const { code, text } = await ask(judge, dir);
      const faults = [];
      if (code !== 1) faults.push(`exit code ${code}, not 1`);
      if (!pattern.test(text)) faults.push(`no ${pattern} in:`, ...text.split('\n'));
      score.judge(`${judge} finds: ${FAULTS[fault]}`, faults);
    }
  }
} finally {
  await rm(folder, { recursive: true, force: true });
}
score.close();

function ask(judge, dir) {
  const program = path.join(import.meta.dirname, `${judge}.mjs`);
  return new Promise((resolve) => {
    execFile(process.execPath, [program, dir], (error, stdout, stderr) => {
      resolve({ code: error ? error.code : 0, text: stdout + stderr });
    });
  });
}
