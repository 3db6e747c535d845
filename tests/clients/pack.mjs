// What both judges share: reading a pack's manifest, reading a GLB's JSON, and keeping the score.

import { readFile } from 'node:fs/promises';
import path from 'node:path';

/** Reads `pack.json` of one pack folder. Throws where the folder is no pack. */
export async function readPack(dir) {
  const text = await readFile(path.join(dir, 'pack.json'), 'utf8');
  const manifest = JSON.parse(text);
  if (manifest.format !== 'pleach-pack') throw new Error('pack.json: format is not "pleach-pack"');
  if (!Array.isArray(manifest.lods) || manifest.lods.length === 0) {
    throw new Error('pack.json: lods is empty');
  }
  return { dir: path.resolve(dir), name: path.basename(path.resolve(dir)), manifest };
}

/** The JSON chunk of a binary glTF. */
export function readGlbJson(bytes) {
  const isGlb = bytes.length >= 20 && bytes.readUInt32LE(0) === 0x46546c67;
  if (!isGlb || bytes.readUInt32LE(16) !== 0x4e4f534a) throw new Error('not a binary glTF');
  return JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString('utf8'));
}

/** The score of a run: one line for each subject, its faults below it, a closing line. */
export class Score {
  passed = 0;
  failed = 0;

  judge(subject, faults, note = '') {
    if (faults.length === 0) this.passed += 1;
    else this.failed += 1;
    console.log(`${faults.length ? 'FAIL' : 'PASS'} ${subject}${note ? `  ${note}` : ''}`);
    for (const fault of faults) console.log(`       ${fault}`);
  }

  /** Prints the closing line and sets the exit code; a run that judged nothing has failed. */
  close() {
    console.log(`${this.passed} passed, ${this.failed} failed`);
    process.exitCode = this.failed > 0 || this.passed === 0 ? 1 : 0;
  }
}

/** Ends the program with the usage line where no pack was named. */
export function requirePacks(dirs, usage) {
  if (dirs.length > 0) return;
  console.error(`usage: ${usage}`);
  process.exit(2);
}
