// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures in the page's worker, with decoders that take any time: an older one is never drawn over a newer one, the
// last is always seen, and each frame is acknowledged once.
//   node pictures_test.mjs PACKAGES
import assert from 'node:assert/strict';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const packages = process.argv[2];
const {build} = await import(pathToFileURL(path.join(packages, 'esbuild/lib/main.js')));
const {outputFiles} = await build({entryPoints: [path.join(packages, '../src/pictures.ts')], bundle: true, format: 'esm', write: false});
const {Painter} = await import('data:text/javascript;base64,' + Buffer.from(outputFiles[0].text).toString('base64'));

const JPEG = 1, ZSTD = 2, H264 = 3;
let seed = 1;
const random = (most) => (seed = (seed * 48271) % 2147483647) % most;
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

globalThis.createImageBitmap = async () => {
    await pause(random(3));
    return {width: 4, height: 4, close() {}};
};
globalThis.EncodedVideoChunk = class { constructor(chunk) { Object.assign(this, chunk); } };
/// Gives pictures in their order, each after some time.
globalThis.VideoDecoder = class {
    state = 'configured';
    line = Promise.resolve();
    constructor(events) { this.events = events; }
    configure() {}
    decode(chunk) {
        this.line = this.line.then(() => pause(random(8))).then(() =>
            this.state === 'closed' || this.events.output({timestamp: chunk.timestamp, close() {}}));
    }
    close() { this.state = 'closed'; }
};

for (let round = 0; round < 60; ++round) {
    let done = 0;
    const shown = [];
    const canvas = {width: 0, height: 0, getContext: () => ({drawImage() {}, putImageData() {}})};
    const painter = new Painter(canvas, Promise.resolve({decode: () => ({})}), {
        done: (frames) => done += frames, shown: (info, arrived) => shown.push(Number(arrived.frame.sequence)), failed: assert.fail,
    });
    const count = 2 + random(12);
    for (let i = 1; i <= count; ++i) {
        const encoding = i === count ? ZSTD : [JPEG, ZSTD, H264][random(3)];
        const frame = {encoding, key: true, sequence: BigInt(i), viewId: 1n, width: 4, height: 4, askedNs: 0n, pointsDrawn: 0n};
        painter.push({frame, payload: new Uint8Array(1), at: performance.now()});
        await pause(random(4));
    }
    await pause(120);
    assert.equal(done, count, `round ${round}: frames acknowledged`);
    assert.equal(shown.at(-1), count, `round ${round}: the last picture is seen`);
    assert.deepEqual(shown, [...shown].sort((a, b) => a - b), `round ${round}: in their order`);
}
