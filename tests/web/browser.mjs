// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the tests of the page share: data made on the spot, programs that end with the test, a browser, and what a
// picture on the page holds. Where the browser or the packages are missing, the test is skipped (77).
import {execFileSync, spawn} from 'node:child_process';
import crypto from 'node:crypto';
import fs from 'node:fs';
import net from 'node:net';
import os from 'node:os';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

export const [bin, packages] = process.argv.slice(2);
/// MOTE_BROWSER says which: chromium or firefox.
export const inFirefox = process.env.MOTE_BROWSER === 'firefox';
export const program = (name) => path.join(bin, name);

export function skip(why) {
    console.log(`skipped: ${why}`);
    process.exit(77);
}

const names = inFirefox ? ['firefox-esr', 'firefox'] : ['chromium', 'chromium-browser', 'google-chrome'];
const browserPath = names.map((name) => `/usr/bin/${name}`).find(fs.existsSync);
if (!browserPath) skip(`there is no ${names[0]} here`);
if (!fs.existsSync(path.join(packages, 'playwright-core'))) skip('the packages of the page are not installed');
const {chromium, firefox} = await import(pathToFileURL(path.join(packages, 'playwright-core/index.mjs')));
export const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'mote-page-'));
const downloads = path.join(folder, 'downloads');
/// Debian's Firefox speaks WebDriver BiDi, Chromium its own protocol.
export const launch = (...args) => inFirefox
    ? firefox.launch({executablePath: browserPath, channel: 'moz-firefox', downloadsPath: downloads,
                      // A panel of downloads takes the keys that the page should have.
                      firefoxUserPrefs: {'browser.download.alwaysOpenPanel': false}})
    : chromium.launch({executablePath: browserPath, args: ['--no-sandbox', ...args]});

/// Keeps what the page gives to be saved. BiDi tells nothing of what a page makes by itself: there the file is waited for.
export async function save(page, work, file) {
    if (!inFirefox) {
        const [given] = await Promise.all([page.waitForEvent('download'), work()]);
        return given.saveAs(file);
    }
    const there = () => fs.existsSync(downloads) ? fs.readdirSync(downloads) : [];
    const before = there();
    await work();
    for (let i = 0; i < 300; ++i) {
        const [given, more] = there().filter((name) => !before.includes(name));
        if (given && !more && !given.endsWith('.part') && fs.statSync(path.join(downloads, given)).size > 0)
            return fs.renameSync(path.join(downloads, given), file);
        await page.waitForTimeout(50);
    }
    throw new Error('nothing was saved');
}

const atEnd = [() => fs.rmSync(folder, {recursive: true, force: true})];
export const later = (work) => atEnd.unshift(work);
process.on('SIGTERM', async () => {
    await tidy();
    process.exit(143);
});
export async function tidy() {
    for (const work of atEnd) await work();
}

export const run = (name, ...words) => execFileSync(program(name), words.map(String), {stdio: ['ignore', 'pipe', 'pipe']});

/// A program that prints a line that begins so when it is ready: [the rest of that line, the process, all its lines].
export function start(begin, name, ...words) {
    return new Promise((resolve, reject) => {
        const child = spawn(program(name), words.map(String), {stdio: ['ignore', 'pipe', 'pipe']});
        let text = '';
        let errors = '';
        later(() => new Promise((ended) => {
            if (child.exitCode !== null || child.signalCode !== null) return ended();
            child.once('exit', ended);
            child.kill('SIGTERM');
        }));
        child.stderr.on('data', (data) => { errors += data; });
        child.stdout.on('data', (data) => {
            text += data;
            const found = text.split('\n').slice(0, -1).find((line) => line.startsWith(begin));
            if (found) resolve([found.slice(begin.length).trim(), child, () => text.trim().split('\n')]);
        });
        child.once('exit', (code) => reject(new Error(`${name} ended with ${code}: ${errors}`)));
    });
}

const packet = 1448;  // bytes, of TCP over Ethernet

/// A line of so many bytes a second that takes so long each way, ms, before the gateway: its port.
export function thinLine(port, rate, delay) {
    const server = net.createServer((near) => {
        const far = net.connect(port, '127.0.0.1');
        const carry = (from, to) => {
            let free = 0;
            let held = 0;
            const way = [];
            // In their order: timers of nearly the same time may fire the other way round.
            const arrive = () => {
                while (way.length > 0 && way[0].at <= performance.now()) to.write(way.shift().bytes);
                if (way.length > 0) setTimeout(arrive, Math.max(1, way[0].at - performance.now()));
            };
            from.on('data', (bytes) => {
                const now = performance.now();
                free = Math.max(free, now);
                const waits = way.length > 0;
                // Packet by packet: the first byte of many is there before the last.
                for (let begin = 0; begin < bytes.length; begin += packet) {
                    const piece = bytes.subarray(begin, begin + packet);
                    free += piece.length / rate * 1000;
                    way.push({bytes: piece, at: free + delay});
                }
                held += bytes.length;
                // A short queue, as of a router: then it is not read from any more.
                if (held > rate * 0.05) from.pause();
                setTimeout(() => {
                    held -= bytes.length;
                    from.resume();
                }, free - now);
                if (!waits) setTimeout(arrive, way[0].at - now);
            });
            from.on('close', () => setTimeout(() => to.destroy(), delay));
            from.on('error', () => to.destroy());
        };
        carry(near, far);
        carry(far, near);
    });
    later(() => server.close());
    return new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(server.address().port)));
}

/// A beam of 100000 particles and 3 steps, a ball as a volume, a box as a mesh.
export function makeData() {
    const data = path.join(folder, 'data');
    fs.mkdirSync(data);
    run('mote-prep', 'synth', 'beam', '--particles', 100000, '--steps', 3, '--seed', 1, '--out', path.join(folder, 'run.h5'), '--quiet');
    run('mote-prep', 'particles', path.join(folder, 'run.h5'), '--axes', 'x,px,y', '--out', path.join(data, 'beam.mote'), '--quiet');
    const size = 24;
    const ball = Buffer.alloc(size ** 3);
    for (let z = 0; z < size; ++z) for (let y = 0; y < size; ++y) for (let x = 0; x < size; ++x)
        ball[(z * size + y) * size + x] = Math.max(0, 255 - 20 * Math.hypot(x - 11.5, y - 11.5, z - 11.5));
    fs.writeFileSync(path.join(folder, 'ball.raw'), ball);
    run('mote-prep', 'volume', path.join(folder, 'ball.raw'), '--dimensions', size, size, size, '--low', 12, '--threshold', 0.02,
        '--out', path.join(data, 'ball.mote'), '--quiet');
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => `v ${i & 1} ${(i >> 1) & 1} ${i >> 2}`);
    const sides = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
    fs.writeFileSync(path.join(folder, 'box.obj'), [...corners, ...sides.map((side) => `f ${side.join(' ')}`)].join('\n') + '\n');
    run('mote-prep', 'mesh', path.join(folder, 'box.obj'), '--out', path.join(data, 'box.mote'), '--quiet');
    return data;
}

/// The pixels that the page shows: {width, height, hash, lit}; `lit`: the part of them that is not the commonest colour.
export async function picture(page) {
    // What a worker draws is on Firefox's screen a little later, and it tells nobody when.
    if (inFirefox) await page.waitForTimeout(150);
    const {width, height, bytes} = await page.evaluate(() => {
        const shown = document.getElementById('picture');
        const copy = new OffscreenCanvas(shown.width, shown.height);
        const context = copy.getContext('2d');
        context.drawImage(shown, 0, 0);
        const {data} = context.getImageData(0, 0, copy.width, copy.height);
        let text = '';
        for (let i = 0; i < data.length; i += 32768) text += String.fromCharCode(...data.subarray(i, i + 32768));
        return {width: copy.width, height: copy.height, bytes: btoa(text)};
    });
    const pixels = Buffer.from(bytes, 'base64');
    const background = pixels.readUInt32LE(0);
    let lit = 0;
    for (let i = 0; i < pixels.length; i += 4) lit += pixels.readUInt32LE(i) !== background ? 1 : 0;
    return {width, height, pixels, hash: crypto.createHash('sha1').update(pixels).digest('hex'), lit: lit / (width * height)};
}

/// Waits for the exact picture of what is wanted now, and until it is on the screen.
export async function exact(page) {
    await page.waitForFunction(() => document.getElementById('stage').dataset.final === 'true', null, {timeout: 20000, polling: 30});
    await page.evaluate(() => new Promise((seen) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(seen)))));
}
